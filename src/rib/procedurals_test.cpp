// Proves: what an archive says does not depend on when it is read; which procedurals wait, and that they are known by
// their requests. Misses: archives that change in between.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <set>

#include "rib/test_support.h"
#include "scene/digests.h"
#include "scene/swept_box.h"

namespace kinora::rib {
namespace {

using namespace scene;

struct World {
  Scene scene;
  ProceduralSources sources;
  std::string said;
};

World readFile(const std::string& file, bool delays) {
  World out;
  Diagnostics messages([&](const std::string& line, Severity) { out.said += line + "\n"; });
  ReadOptions options;
  options.delaysProcedurals = delays;
  RibReader reader(messages, options, [&](Scene&& s) {
    out.scene = std::move(s);
    if (reader.procedurals()) out.sources = *reader.procedurals();
  });
  EXPECT_TRUE(reader.readFile(file));
  reader.finish();
  return out;
}

// Digests of all that stands in the world, in its order.
struct Told {
  std::vector<std::string> things;
  size_t delayed = 0;
  std::string said;
};

std::string toldOf(const Primitive& p) {
  const Attributes& a = *p.attributes;
  Hasher h;
  h.digest(ownDigestOf(p));
  h.digest(digestOf(a.named));
  if (a.bxdf) h.digest(digestOf(*a.bxdf));
  if (a.color) h.bytes(a.color->data(), sizeof *a.color);
  h.word(uint64_t(a.orientation) | uint64_t(a.reverseOrientation) << 8);
  return std::string(requestName(p.shape)) + " " + h.result().str();
}

void tell(const std::vector<PrimitivePtr>& primitives, const InstanceList& instances,
          const std::vector<Prototype>& prototypes, const ProceduralSources& sources, Told& out) {
  for (const PrimitivePtr& p : primitives) {
    const auto source = sources.find(p->id);
    if (source == sources.end()) {
      out.things.push_back(toldOf(*p));
      continue;
    }
    ++out.delayed;
    Diagnostics messages([&](const std::string& line, Severity) { out.said += line + "\n"; });
    const Expansion e = source->second->expand(*p, messages, false);
    tell(e.primitives, e.instances, e.prototypes, e.nested, out);
  }
  for (size_t k = 0; k < instances.size(); ++k) {
    Hasher h;
    h.digest(digestOf(instances.toWorldOf(k)));
    const Prototype& of = prototypes.at(instances.prototypeOf(k));
    out.things.push_back("instance " + of.name + " " + h.result().str());
    tell(of.primitives, of.instances, prototypes, {}, out);
  }
}

void write(const std::string& folder, const std::string& name, const std::string& text) {
  std::ofstream(folder + name) << text;
}

TEST(DelayedArchives, SayLaterWhatTheyWouldHaveSaidAtOnce) {
  const std::string folder = ::testing::TempDir() + "delayed-" + std::to_string(::getpid()) + "/";
  std::filesystem::create_directories(folder + "more");
  write(folder, "scene.rib", R"(Declare "mine" "vertex color"
Option "user" "float o" [3]
WorldBegin
Pattern "PxrFractal" "outer"
ArchiveBegin "inline"
Sphere .25 -.25 .25 360
ArchiveEnd
ObjectBegin "thing"
Sphere 2 -2 2 360
ObjectEnd
ObjectBegin "mesh"
PointsPolygons [3 3] [0 1 2 1 2 3] "P" [0 0 0 1 0 0 0 1 0 1 1 0]
ObjectEnd
AttributeBegin
Translate 7 7 7
ScopedCoordinateSystem "over"
AttributeEnd
AttributeBegin
Translate 1 2 3
CoordinateSystem "here"
Attribute "user" "string name" ["ann"]
Attribute "identifier" "string name" ["around"]
ReverseOrientation
Pattern "PxrFractal" "inner"
Procedural "DelayedReadArchive" ["a.rib"] [-1 1 -1 1 -1 1]
Pattern "PxrFractal" "inner" "float frequency" [99]
Attribute "user" "string name" ["other"]
AttributeEnd
CoordinateSystem "here"
Declare "mine" "uniform string"
Pattern "PxrFractal" "outer" "float frequency" [77]
ArchiveBegin "inline"
Cone 1 1 360
ArchiveEnd
ObjectBegin "thing"
Cylinder 2 -2 2 360
ObjectEnd
WorldEnd
)");
  write(folder, "a.rib", R"(Bxdf "PxrDiffuse" "b" "reference color diffuseColor" ["inner:resultRGB"]
Attribute "user" "string seen" ["${user:name} ${Option:user:o}"]
Polygon "P" [0 0 0 1 0 0 1 1 0] "mine" [1 0 0 0 1 0 0 0 1]
ReadArchive "inline"
ObjectInstance "thing"
AttributeBegin
CoordSysTransform "here" CoordSysTransform "over"
Translate 0 0 1
Sphere 1 -1 1 360
Procedural "DelayedReadArchive" ["more/b.rib"] [-1 1 -1 1 -1 1]
AttributeEnd
ObjectBegin "own"
Disk 0 1 360
ObjectInstance "thing"
ObjectEnd
ObjectInstance "own"
AttributeBegin
Translate 5 5 5
Attribute "shade" "int[1] faceset" [1]
ObjectInstance "mesh"
)");
  write(folder, "more/b.rib", R"(Bxdf "PxrDiffuse" "c" "reference color diffuseColor" ["outer:resultRGB"]
Torus 1 .5 0 360 360
ReadArchive "c.rib"
ObjectInstance "thing"
)");
  write(folder, "more/c.rib", "Paraboloid 1 0 1 360\n");
  const World now = readFile(folder + "scene.rib", false), later = readFile(folder + "scene.rib", true);
  Told atOnce, delayed;
  tell(now.scene.primitives, now.scene.instances, now.scene.prototypes, now.sources, atOnce);
  tell(later.scene.primitives, later.scene.instances, later.scene.prototypes, later.sources, delayed);
  EXPECT_EQ(atOnce.delayed, 0u);
  EXPECT_EQ(delayed.delayed, 2u);
  // an archive of its own stands where its request does, instances behind all primitives
  std::sort(atOnce.things.begin(), atOnce.things.end());
  std::sort(delayed.things.begin(), delayed.things.end());
  EXPECT_EQ(delayed.things, atOnce.things);
  EXPECT_EQ(atOnce.things.size(), 15u);
  EXPECT_NE(delayed.said.find("a.rib:7: error RIB-COORDSYS"), std::string::npos) << delayed.said;
  // the block that a.rib leaves open ends with it, and is named
  EXPECT_NE(delayed.said.find("a.rib:17: error RIB-NESTING"), std::string::npos) << delayed.said;
  std::filesystem::remove_all(folder);
}

// What others ask for by name is found, and the rest of the archive still waits.
TEST(DelayedArchives, HoldObjectsForOthers) {
  const std::string folder = ::testing::TempDir() + "objects-" + std::to_string(::getpid()) + "/";
  std::filesystem::create_directories(folder);
  write(folder, "scene.rib", R"(WorldBegin
ObjectBegin "early"
Cone 1 1 360
ObjectEnd
Procedural "DelayedReadArchive" ["empty.rib"] [-1 1 -1 1 -1 1]
Procedural "DelayedReadArchive" ["a.rib"] [-1 1 -1 1 -1 1]
ObjectInstance "late"
ObjectInstance "inner"
ObjectInstance "early"
ObjectInstance "no"
WorldEnd
)");
  write(folder, "empty.rib", "Sphere 3 -3 3 360\n");
  write(folder, "a.rib", R"(Sphere 1 -1 1 360
ObjectBegin "part"
Disk 0 1 360
ObjectInstance "early"
ObjectEnd
ObjectBegin "late"
Sphere 2 -2 2 360
ObjectInstance "part"
ObjectEnd
Procedural "DelayedReadArchive" ["b.rib"] [-1 1 -1 1 -1 1]
)");
  write(folder, "b.rib", "ObjectBegin \"inner\"\nTorus 1 .5 0 360 360\nObjectEnd\n");
  const World later = readFile(folder + "scene.rib", true);
  EXPECT_EQ(later.scene.primitives.size(), 2u);
  EXPECT_EQ(later.sources.size(), 2u);
  ASSERT_EQ(later.scene.instances.size(), 3u);
  EXPECT_NE(later.said.find("scene.rib:10: error RIB-HANDLE"), std::string::npos) << later.said;
  const auto nameOf = [&](const InstanceList& list, size_t k) {
    return later.scene.prototypes.at(list.prototypeOf(k)).name;
  };
  ASSERT_EQ(nameOf(later.scene.instances, 0), "late");
  EXPECT_EQ(nameOf(later.scene.instances, 1), "inner");
  EXPECT_EQ(nameOf(later.scene.instances, 2), "early");
  const InstanceList& in = later.scene.prototypes[later.scene.instances.prototypeOf(0)].instances;
  ASSERT_EQ(in.size(), 1u);
  EXPECT_EQ(nameOf(in, 0), "part");
  EXPECT_EQ(nameOf(later.scene.prototypes[in.prototypeOf(0)].instances, 0), "early");
  std::filesystem::remove_all(folder);
}

TEST(DelayedArchives, AreKnownByTheirRequests) {
  ReadOptions options;
  options.delaysProcedurals = true;
  const char* const kRequests = R"(Procedural "DelayedReadArchive" ["no.rib"] [-1 1 -2 2 -3 3]
Translate 1 0 0
Procedural2 "DelayedReadArchive2" "SimpleBound" "string filename" ["no.rib"] "float[6] bound" [-1 1 -2 2 -3 3])";
  const Read r = readWorld(kRequests, options);
  EXPECT_TRUE(r.messages.empty()) << r.all();
  ASSERT_EQ(r.world().primitives.size(), 2u);
  for (size_t k = 0; k < 2; ++k) {
    const auto bound = boundOf(r.primitive(k));
    ASSERT_TRUE(bound);
    EXPECT_EQ(bound->min, Imath::V3d(-1, -2, -3));
    EXPECT_EQ(bound->max, Imath::V3d(1, 2, 3));
  }
  EXPECT_EQ(sweptBox(*boundOf(r.primitive(1)), r.primitive(1).toWorld).max, Imath::V3d(2, 2, 3));
  EXPECT_NE(ownDigestOf(r.primitive(0)).str(), ownDigestOf(r.primitive(1)).str());
  std::set<std::string> digests;
  const std::string request = "Procedural \"DelayedReadArchive\" [\"no.rib\"] [-1 1 -2 2 -3 3]\n",
                    pattern = "Pattern \"PxrFractal\" \"f\" \"float frequency\" ";
  // what an archive may name of the scene counts as well
  for (const std::string& text :
       {request, std::string("Procedural \"DelayedReadArchive\" [\"other.rib\"] [-1 1 -2 2 -3 3]\n"),
        pattern + "[1]\n" + request, pattern + "[2]\n" + request,
        "AttributeBegin\n" + pattern + "[3]\nAttributeBegin\n" + request + "AttributeEnd\nAttributeEnd\n",
        "ArchiveBegin \"a\"\nSphere 1 -1 1 360\nArchiveEnd\n" + request,
        "ArchiveBegin \"a\"\nSphere 2 -2 2 360\nArchiveEnd\n" + request}) {
    const Read other = readWorld(text, options);
    ASSERT_EQ(other.world().primitives.size(), 1u) << text;
    EXPECT_TRUE(digests.insert(ownDigestOf(other.primitive(0)).str()).second) << text;
    EXPECT_EQ(ownDigestOf(other.primitive(0)), ownDigestOf(readWorld(text, options).primitive(0)));
  }
}

// What stands in an object, a solid or a light is all there, and so is what must be read at once.
TEST(DelayedArchives, ThatDoNotWait) {
  ReadOptions options;
  options.delaysProcedurals = true;
  const std::string request = "Procedural \"DelayedReadArchive\" [\"no.rib\"] [-1 1 -1 1 -1 1]\n";
  for (const std::string& text :
       {"ObjectBegin \"o\"\n" + request + "ObjectEnd\n", "SolidBegin \"primitive\"\n" + request + "SolidEnd\n",
        "Light \"PxrMeshLight\" \"l\"\n" + request,
        "Attribute \"procedural\" \"int immediatesubdivide\" [1]\n" + request,
        std::string("Procedural \"DelayedReadArchive\" [\"no.rib\"] [-1e30 1e30 -1 1 -1 1]\n"),
        std::string("Procedural \"DelayedReadArchive\" [\"no.rib\"] [1 -1 -1 1 -1 1]\n"),
        std::string("Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"no.rib\"]\n"),
        std::string("Procedural2 \"DelayedReadArchive2\" \"SimpleBound\" \"string filename\" [\"no.rib\"] \"float[6] "
                    "bound\" [-1 1 -2 2 -3 3] \"int __immediatesubdivide\" [1]\n")})
    EXPECT_EQ(readWorld(text, options).count("ASSET-MISSING-ARCHIVE"), 1u) << text;
}

}  // namespace
}  // namespace kinora::rib
