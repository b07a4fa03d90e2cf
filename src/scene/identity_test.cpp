// Every field of every type counts, or is listed as one that does not; differences are named; nothing else counts: no
// pointer, no id, no order of hashing. Misses what the renderer takes from elsewhere than the description
// (render/frame_identity.h), and whether a field that counts really changes a picture.
#include "scene/identity.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <random>
#include <set>

#include "scene/edits_testing.h"
#include "scene/fields.h"

namespace kinora::scene {
namespace {

using test::Edits;
using test::EditSite;
using test::filledScene;

// The id of an area light's geometry says which object it is as well.
bool isLinkOfAreaLight(const EditSite& s) { return s.path.find("geometry: id") != std::string::npos; }

TEST(Identity, EveryFieldOfEveryTypeCounts) {
  const Scene base = filledScene();
  Edits edits(base);
  const std::vector<EditSite>& sites = edits.sites();
  ASSERT_GT(sites.size(), 3000u);
  const Digest before = digestOf(base);
  const Inventory inventory = inventoryOf(base);
  std::map<Digest, size_t> seen{{before, ~size_t(0)}};
  size_t counted = 0;
  for (size_t i = 0; i < sites.size(); ++i) {
    const Digest d = digestOf(edits.edited(i));
    if (!sites[i].counts && !isLinkOfAreaLight(sites[i])) {
      EXPECT_EQ(d, before) << sites[i].path;
      continue;
    }
    ++counted;
    // some of them by name: inventories take longer
    if (i % 7 == 0) {
      EXPECT_NE(firstDifference(inventory, inventoryOf(edits.edited(i))), "") << sites[i].path;
    }
    const auto [it, isNew] = seen.try_emplace(d, i);
    EXPECT_TRUE(isNew) << sites[i].path << " and " << (~it->second ? sites[it->second].path : "no edit");
  }
  // what is said not to count, said a second time: a slip in a list is seen
  static const std::set<std::string> kNotes{"id",       "place file", "place line",     "file",
                                            "file cut", "frame",      "inside a frame", "next id"};
  for (const EditSite& s : sites)
    if (!s.counts) {
      const size_t colon = s.path.rfind(": ");
      EXPECT_TRUE(kNotes.contains(s.path.substr(colon == std::string::npos ? 0 : colon + 2))) << s.path;
    }
  EXPECT_GT(counted, sites.size() / 2);
  EXPECT_LT(counted, sites.size());
}

// What finds a field that a list forgot: the number of a type's members, whatever they are.
struct Sample {
  int number;
  std::array<float, 3> triple;
  std::optional<std::array<double, 2>> maybe;
  std::optional<Primitive> primitive;
  Shape shape;
  std::map<std::string, Transform> spaces;
  std::shared_ptr<const std::vector<uint32_t>> ids;
  std::vector<std::string> names;
  bool last;
};
static_assert(detail::fieldCount<Sample>() == 9);
static_assert(detail::fieldCount<Attributes>() == 20);

// Of pairs of edits none gives one scene, and the difference is found from the inventories alone, whole and short.
// (src/film/shard_identity_test.cpp merges parts of such scenes.)
TEST(Identity, PairsOfEditsAreToldApart) {
  const Scene base = filledScene(2);
  Edits edits(base);
  const std::vector<EditSite>& sites = edits.sites();
  std::mt19937 rng(5);
  for (int pair = 0; pair < 60; ++pair) {
    size_t i, j;
    do i = rng() % sites.size();
    while (!sites[i].counts);
    do j = rng() % sites.size();
    while (!sites[j].counts || i == j);
    const Scene a = edits.edited(i), b = edits.edited(j);
    SCOPED_TRACE(sites[i].path + " and " + sites[j].path);
    EXPECT_NE(digestOf(a), digestOf(b));
    for (const InventorySize& size : {InventorySize{}, InventorySize{3, 4}}) {
      const Inventory x = inventoryOf(a, {}, size), y = inventoryOf(b, {}, size);
      EXPECT_NE(firstDifference(x, y), "");
      EXPECT_EQ(firstDifference(x, x), "");
    }
    // the same edit once more is the same scene
    EXPECT_EQ(digestOf(edits.edited(i)), digestOf(a));
  }
}

SourcePos at(uint32_t line) { return {FileName("scene.rib"), line}; }

Primitive named(const std::string& name, uint32_t line, Shape shape = Quadric{}) {
  Primitive p;
  auto a = std::make_shared<Attributes>();
  Parameter n;
  n.name = "identifier:name";
  n.type = ValueType::String;
  n.strings = {name};
  if (!name.empty()) a->named.set(n);
  p.attributes = a;
  p.shape = std::move(shape);
  p.pos = at(line);
  return p;
}

std::string difference(const Scene& a, const Scene& b) { return firstDifference(inventoryOf(a), inventoryOf(b)); }

TEST(Identity, TheFirstDifferenceIsNamedByObject) {
  SubdivisionMesh mesh;
  mesh.scheme = "catmull-clark";
  mesh.tags = {{"crease", {0, 1}, {3.5f}, {}}};
  Scene a;
  for (uint32_t i = 0; i < 5; ++i) a.add(named("ball" + std::to_string(i), 10 + i));
  const uint32_t cube = a.add(named("cube", 20, mesh));
  a.add(named("", 30));
  Scene b = a;
  EXPECT_EQ(difference(a, b), "");
  Primitive p = named("cube", 21, mesh);
  std::get<SubdivisionMesh>(p.shape).tags[0].floats[0] = 4;
  b.replacePrimitive(cube, p);
  EXPECT_EQ(difference(a, b), "object \"cube\" (scene.rib:20, scene.rib:21) differs in tag \"crease\": floats");
  p = named("cube", 20, mesh);
  auto turned = std::make_shared<Attributes>(*p.attributes);
  turned->sides = 1;
  p.attributes = turned;
  b.replacePrimitive(cube, p);
  EXPECT_EQ(difference(a, b), "object \"cube\" (scene.rib:20) differs in sides");
  auto network = std::make_shared<Network>();
  auto bxdf = std::make_shared<Node>();
  bxdf->kind = "Bxdf";
  bxdf->plugin = "PxrSurface";
  bxdf->handle = "paint";
  Parameter gain;
  gain.name = "diffuseGain";
  gain.floats = {1};
  bxdf->params.set(gain);
  network->terminal = bxdf;
  turned = std::make_shared<Attributes>(*named("cube", 20).attributes);
  turned->bxdf = network;
  p.attributes = turned;
  b.replacePrimitive(cube, p);
  Scene c = b;
  EXPECT_EQ(difference(a, b), "object \"cube\" (scene.rib:20) differs in Bxdf \"paint\"");
  auto other = std::make_shared<Node>(*bxdf);
  other->params.find("diffuseGain")->floats[0] = 0.5f;
  auto painted = std::make_shared<Attributes>(*turned);
  painted->bxdf = std::make_shared<Network>(Network{other, {}});
  p.attributes = painted;
  c.replacePrimitive(cube, p);
  EXPECT_EQ(difference(b, c), "object \"cube\" (scene.rib:20) differs in Bxdf \"paint\": parameter \"diffuseGain\"");
  // left out, put in
  b = a;
  b.removePrimitive(b.primitives[2]->id);
  EXPECT_EQ(difference(a, b), "object \"ball2\" (scene.rib:12) is in the first only");
  EXPECT_EQ(difference(b, a), "object \"ball2\" (scene.rib:12) is in the second only");
  b = a;
  b.primitives.push_back(std::make_shared<Primitive>(named("last", 99)));
  EXPECT_EQ(difference(a, b), "object \"last\" (scene.rib:99) is in the second only");
  b = a;
  std::swap(b.primitives[6], b.primitives[5]);
  EXPECT_EQ(difference(a, b), "object \"cube\" (scene.rib:20) stands where the second has Sphere (scene.rib:30)");
  // not of an object
  b = a;
  b.pixelFilterWidth[1] = 3;
  EXPECT_EQ(difference(a, b), "width of the pixel filter differs");
  b = a;
  b.coordinateSystems["mark"] = Transform();
  EXPECT_EQ(difference(a, b), "coordinate system \"mark\" is in the second only");
  b = a;
  b.options.set(gain);
  EXPECT_EQ(difference(a, b), "option \"diffuseGain\" is in the second only");
}

TEST(Identity, ManyThingsShareAnEntry) {
  Scene a;
  for (uint32_t i = 0; i < 1000; ++i) a.add(named("ball" + std::to_string(i), i));
  Scene b = a;
  auto p = std::make_shared<Primitive>(*b.primitives[777]);
  Parameter st;
  st.name = "st";
  p->primvars.set(st);
  b.primitives[777] = p;
  const InventorySize few{64, 100};
  const Inventory x = inventoryOf(a, {}, few), y = inventoryOf(b, {}, few);
  EXPECT_LT(x.things.size(), 64u + 40u);
  EXPECT_EQ(firstDifference(x, y),
            "one of 16 things from object \"ball768\" to object \"ball783\" (scene.rib:768) differs");
  EXPECT_EQ(difference(a, b), "object \"ball777\" (scene.rib:777) differs in primvar \"st\"");
}

// What the scene does not mean: copies instead of shared pointers, other ids, places, names of files, and who hashes.
TEST(Identity, WhatDoesNotCount) {
  Scene a = filledScene(3);
  const Digest d = digestOf(a);
  // every pointer anew
  Scene copy = a;
  for (PrimitivePtr& p : copy.primitives) {
    auto own = std::make_shared<Primitive>(*p);
    own->attributes = std::make_shared<Attributes>(*p->attributes);
    p = own;
  }
  EXPECT_EQ(digestOf(copy), d);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(digestOf(a), d);
  }
  for (const char* name : {"searchpath:texture", "statistics:endofframe", "bucket:order", "limits:threads",
                           "limits:rendertime", "checkpoint:interval", "ribparse:varsubst", "shader:cache"}) {
    Parameter p;
    p.name = name;
    p.strings = {"anything"};
    copy.options.set(p);
  }
  EXPECT_EQ(digestOf(copy), d);
  Parameter gridsize;
  gridsize.name = "limits:gridsize";
  copy.options.set(gridsize);
  EXPECT_NE(digestOf(copy), d);
}

// Which samples are taken is written beside the digest, so that parts of one frame have one digest; what samples are is
// in it.
TEST(Identity, TheHidersChoiceOfSamplesDoesNotCount) {
  const auto with = [](const char* kind, const char* name) {
    Scene s;
    auto n = std::make_shared<Node>();
    n->kind = kind;
    Parameter p;
    p.name = name;
    p.type = ValueType::Int;
    p.ints = {3};
    n->params.set(p);
    s.hider = n;
    return s;
  };
  for (const char* name : {"sampleoffset", "samplestride"}) {
    EXPECT_EQ(digestOf(with("Hider", name)), digestOf(with("Hider", "sampleoffset")));
    EXPECT_NE(digestOf(with("Pattern", name)), digestOf(with("Pattern", "other"))) << "anyone else's parameter";
    EXPECT_EQ(firstDifference(inventoryOf(with("Hider", name)), inventoryOf(with("Hider", "sampleoffset"))), "");
  }
  EXPECT_NE(digestOf(with("Hider", "samplemotion")), digestOf(with("Hider", "sampleoffset")));
}

// Objects name the light sources that shine on them by id; the same lights under other ids are the same lights.
TEST(Identity, IdsCountByWhatTheyName) {
  const auto lit = [](uint32_t firstId, std::vector<uint32_t> which) {
    Scene s;
    s.nextId = firstId;
    for (int i = 0; i < 3; ++i) {
      Light l;
      auto node = std::make_shared<Node>();
      node->kind = "LightSource";
      node->handle = std::to_string(i);
      l.node = node;
      l.id = s.nextId++;
      s.classicLights.push_back(l);
    }
    for (uint32_t& w : which) w += firstId;
    Primitive p = named("lit", 1);
    auto a = std::make_shared<Attributes>(*p.attributes);
    a->lightSources = std::make_shared<const std::vector<uint32_t>>(which);
    p.attributes = a;
    s.add(std::move(p));
    return s;
  };
  EXPECT_EQ(digestOf(lit(1, {0, 2})), digestOf(lit(50, {0, 2})));
  EXPECT_NE(digestOf(lit(1, {0, 2})), digestOf(lit(1, {0, 1})));
  EXPECT_EQ(difference(lit(1, {0, 2}), lit(50, {1, 2})), "object \"lit\" (scene.rib:1) differs in light sources");
  // an area light is an object as well
  Scene area = lit(1, {0});
  area.classicLights[1].geometry = *area.primitives[0];
  Scene apart = area;
  apart.classicLights[1].geometry->id = 99;
  EXPECT_NE(digestOf(area), digestOf(apart));
}

// A string that names a file counts as what the file holds: the same picture from another folder is the same picture.
TEST(Identity, FilesCountByContent) {
  const auto textured = [](const std::string& file) {
    Scene s;
    Primitive p = named("wall", 1);
    auto network = std::make_shared<Network>();
    auto texture = std::make_shared<Node>();
    texture->kind = "Pattern";
    texture->handle = "tex";
    Parameter name;
    name.name = "filename";
    name.type = ValueType::String;
    name.strings = {file};
    texture->params.set(name);
    network->patterns = {texture};
    network->terminal = texture;
    auto a = std::make_shared<Attributes>(*p.attributes);
    a->bxdf = network;
    p.attributes = a;
    s.add(std::move(p));
    return s;
  };
  const Scene here = textured("/here/wood.tex"), there = textured("/there/wood.tex");
  EXPECT_NE(digestOf(here), digestOf(there));
  const Digest wood = kinora::digestOf("wood"), oak = kinora::digestOf("oak");
  EXPECT_EQ(digestOf(here, {{"/here/wood.tex", wood}}), digestOf(there, {{"/there/wood.tex", wood}}));
  EXPECT_NE(digestOf(here, {{"/here/wood.tex", wood}}), digestOf(here, {{"/here/wood.tex", oak}}));
  EXPECT_EQ(
      firstDifference(inventoryOf(here, {{"/here/wood.tex", wood}}), inventoryOf(there, {{"/there/wood.tex", oak}})),
      "object \"wall\" (scene.rib:1) differs in Pattern \"tex\": parameter \"filename\"");
}

}  // namespace
}  // namespace kinora::scene
