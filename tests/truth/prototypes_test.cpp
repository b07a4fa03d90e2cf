// Proves that what an object's primitives are in instances is what they are by themselves, whether they share a part of
// the world or not: materials, colours of instances, object space, primvars, presence, glass inside glass, mirrored and
// sheared transforms, strands, deformation, displacement at once and where rays ask; for any threads, widths and groups, in swarms, with sight that differs from
// instance to instance, and through edits. Both roads take the same samples, so pictures agree but for rounding. It
// misses media, which never share a part.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

const std::string kHead =
    "Format 48 36 1\nHider \"raytrace\" \"int maxsamples\" [16] \"int minsamples\" [16]\nPixelVariance 0\n"
    "Projection \"perspective\" \"fov\" [40]\nShutter 0 1\nTranslate 0 -.3 6\nRotate -20 1 0 0\nWorldBegin\n"
    "Light \"PxrDomeLight\" \"dome\" \"float intensity\" [.6]\nLight \"PxrDistantLight\" \"sun\"\n"
    "Polygon \"P\" [-9 -.8 -9  -9 -.8 9  9 -.8 9  9 -.8 -9]\n";

struct Piece {
  const char *what, *text;
};
const Piece kPieces[] = {
    {"trunk",
     "Bxdf \"PxrDiffuse\" \"a\" \"color diffuseColor\" [.5 .3 .1]\nRotate -90 1 0 0\nCylinder .1 -.8 .3 360\n"},
    {"object space",
     "Pattern \"PxrManifold3D\" \"m\" \"string coordsys\" [\"object\"]\n"
     "Pattern \"PxrChecker\" \"c\" \"color colorA\" [.1 .2 .9] \"color colorB\" [.9 .8 .1] \"reference struct "
     "manifold\" "
     "[\"m:result\"]\n"
     "Bxdf \"PxrDiffuse\" \"b\" \"reference color diffuseColor\" [\"c:resultRGB\"]\nTranslate 0 .6 0\n"
     "Scale .5 .3 .5\nSphere 1 -1 1 360\n"},
    {"glass", "Bxdf \"PxrGlass\" \"g\"\nTranslate .6 -.4 -.3\nScale 1 -1 1\nSphere .3 -.3 .3 360\n"},
    {"glass within", "Bxdf \"PxrGlass\" \"h\"\nTranslate .6 -.4 -.3\nSphere .15 -.15 .15 360\n"},
    {"presence and a primvar",
     "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"tone\"] \"string type\" [\"color\"]\n"
     "Bxdf \"PxrSurface\" \"s\" \"reference color diffuseColor\" [\"p:resultRGB\"] \"float presence\" [.5]\n"
     "Translate -.5 .3 -.3\nRotate 30 0 1 0\n"
     "Polygon \"P\" [-.4 -.4 0  -.4 .4 0  .4 .4 0  .4 -.4 0] \"vertex color tone\" [1 0 0  0 1 0  0 0 1  1 1 0]\n"},
    {"a colour of the instance",
     "Translate -.55 -.5 -.4\nScale .3 .3 .3\nPointsPolygons [4] [0 1 2 3] \"P\" "
     "[-1 -1 0  -1 1 0  1 1 0  1 -1 0] \"vertex normal N\" "
     "[-.3 -.3 -1  -.3 .3 -1  .3 .3 -1  .3 -.3 -1]\n"},
    {"strands",
     "Bxdf \"PxrDiffuse\" \"t\" \"color diffuseColor\" [.8 .1 .1]\nTranslate .3 .8 0\nScale .5 .5 .5\n"
     "Curves \"linear\" [3] \"nonperiodic\" \"P\" [0 0 0  .2 .5 0  .5 .8 .2] \"constantwidth\" [.1]\n"},
    {"deformation",
     "Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [.1 .8 .7]\nTranslate 0 -.6 -.8\n"
     "MotionBegin [0 1]\nPolygon \"P\" [-.3 0 0  -.3 .3 0  .3 .3 0  .3 0 0]\n"
     "Polygon \"P\" [-.3 .1 0  -.3 .6 0  .3 .3 0  .3 .2 0]\nMotionEnd\n"},
    {"displaced at once",
     "Pattern \"PxrFractal\" \"f\" \"float frequency\" [2]\n"
     "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.4] \"reference float dispScalar\" [\"f:resultF\"]\n"
     "Bxdf \"PxrDiffuse\" \"e\" \"color diffuseColor\" [.7 .7 .2]\nTranslate -.3 .1 .5\nRotate 20 1 0 1\n"
     "Scale -.25 .15 .2\nSphere 1 -1 1 360\n"},
    {"displaced where rays ask",
     "Pattern \"PxrFractal\" \"f\" \"float frequency\" [2]\n"
     "Pattern \"PxrChecker\" \"c\" \"color colorA\" [.1 .6 .9] \"color colorB\" [.9 .3 .1]\n"
     "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.4] \"reference float dispScalar\" [\"f:resultF\"]\n"
     "Bxdf \"PxrDiffuse\" \"e\" \"reference color diffuseColor\" [\"c:resultRGB\"]\n"
     "Attribute \"dice\" \"int levels\" [1] \"float micropolygonlength\" [.1]\n"
     "Translate .4 .2 .4\nRotate 30 0 1 1\nScale .2 -.3 .25\n"
     "SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2  4 6 7 5  0 4 5 1  2 3 7 6  0 2 6 4  1 5 7 3] "
     "[\"interpolateboundary\"] [1 0] [2] [] \"P\" [-1 -1 -1  -1 -1 1  -1 1 -1  -1 1 1  1 -1 -1  1 -1 1  1 1 -1  1 1 "
     "1]\n"},
    {"displaced where rays ask, and deforming",
     "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.1]\n"
     "Bxdf \"PxrDiffuse\" \"e\" \"color diffuseColor\" [.3 .7 .3]\n"
     "Attribute \"dice\" \"int levels\" [1] \"float micropolygonlength\" [.1]\n"
     "Translate -.2 -.5 .8\nScale .4 .5 .4\n"
     "MotionBegin [0 1]\nPatch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n"
     "Patch \"bilinear\" \"P\" [-1 -.9 0 1 -.9 .3 -1 1.1 .3 1 1.1 0]\nMotionEnd\n"},
};
const char* const kPlaces[] = {"Color [.9 .2 .9]\nTranslate -1.6 0 0\n",
                               "Color [.2 .2 .9]\nRotate 50 0 1 0\nScale 1 1 -1\n",
                               "Color [.2 .9 .9]\nTranslate 1.6 0 0\nScale 1 1.4 1\nSkew 20 0 1 0 1 0 0\n"};

std::string block(const std::string& text) { return "AttributeBegin\n" + text + "AttributeEnd\n"; }

// Of all pieces; where they are apart each object holds one.
std::string forest(bool areApart, const std::string& besides = "") {
  std::string objects, placed;
  for (const char* where : kPlaces) {
    placed += "AttributeBegin\n" + std::string(where) + (where == kPlaces[2] ? besides : "");
    for (size_t i = 0; i < (areApart ? std::size(kPieces) : 1); ++i)
      placed += "ObjectInstance \"" + std::to_string(i) + "\"\n";
    placed += "AttributeEnd\n";
  }
  for (size_t i = 0; i < std::size(kPieces); ++i) {
    if (areApart || i == 0) objects += "ObjectBegin \"" + std::to_string(i) + "\"\n";
    objects += block(kPieces[i].text);
    if (areApart || i + 1 == std::size(kPieces)) objects += "ObjectEnd\n";
  }
  return kHead + objects + placed + "WorldEnd\n";
}

struct Rendered {
  image::Image picture;
  uint64_t hash = 0, placements = 0, diced = 0;  // tessellations where rays asked
};
Rendered render(const std::string& rib, const std::function<void(RenderRequest&)>& change = {}) {
  RenderRequest r;
  r.rib = rib;
  if (change) change(r);
  SceneRender s(r);
  EXPECT_TRUE(s.ok());
  if (!s.ok()) return {};
  return {s.channel("Ci"), hashOf(s.film()), s.renderer().statistics().instances,
          s.renderer().statistics().geometry.made};
}

// Rounding turns some paths, through glass and between bumps most of all: few pixels, and by what a sample is of sixteen.
void expectAlike(const image::Image& a, const image::Image& b, const std::string& what) {
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  size_t differ = 0;
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = std::fabs(double(a.pixels[i]) - double(b.pixels[i]));
    differ += d > 2e-3;
    sum += d;
  }
  EXPECT_LE(differ, a.pixels.size() / 20)
      << what << ' ' << SceneRender::keep(a, "one") << ' ' << SceneRender::keep(b, "other");
  EXPECT_LE(sum / double(a.pixels.size()), 5e-4) << what;
}

TEST(Prototypes, PrimitivesOfOneObjectLookAsObjectsOfTheirOwn) {
  const Rendered together = render(forest(false)), apart = render(forest(true));
  EXPECT_EQ(together.placements, 3 + 1u);
  EXPECT_EQ(apart.placements, 3 * std::size(kPieces) + 1);
  EXPECT_GT(together.diced, 0u);
  EXPECT_GT(apart.diced, 0u);
  expectAlike(together.picture, apart.picture, "all");
}

// Which rays see a primitive may differ from instance to instance: parts of their own.
TEST(Prototypes, SightOfOneInstance) {
  for (const char* hidden :
       {"Attribute \"visibility\" \"int camera\" [0]\n", "Attribute \"visibility\" \"int transmission\" [0]\n",
        "Attribute \"visibility\" \"int indirect\" [0]\n"})
    expectAlike(render(forest(false, hidden)).picture, render(forest(true, hidden)).picture, hidden);
}

TEST(Prototypes, SameBitsForAnyThreadsWidthsAndGroups) {
  const uint64_t expected = render(forest(false)).hash;
  for (const auto& [threads, width, group] : {std::array{2, 8, 256}, std::array{1, 1, 256}, std::array{2, 16, 512}})
    EXPECT_EQ(render(forest(false),
                     [&](RenderRequest& r) {
                       r.settings.threads = threads;
                       r.settings.width = uint32_t(width);
                       r.settings.groupSize = uint32_t(group);
                     })
                  .hash,
              expected)
        << threads << ' ' << width << ' ' << group;
}

// Primitives that may not share a part keep one of their own, beside the part of the others.
TEST(Prototypes, WhatSharesNoPart) {
  const std::string two = block(kPieces[0].text) + block(kPieces[5].text);
  const auto placed = [&](const std::string& third) {
    return render(kHead + "ObjectBegin \"o\"\n" + two + block(third) + "ObjectEnd\nObjectInstance \"o\"\nWorldEnd\n")
        .placements;
  };
  const std::string ball = "Sphere .3 -.3 .3 360\n";
  EXPECT_EQ(placed(ball), 2u);
  EXPECT_EQ(placed("MotionBegin [0 1]\nTranslate 0 0 0\nTranslate .1 0 0\nMotionEnd\n" + ball), 3u) << "moves";
  EXPECT_EQ(placed("Scale 1 1 .000001\n" + ball), 3u) << "is nearly flat";
  EXPECT_EQ(placed("Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.1]\n" + ball), 2u);
  EXPECT_EQ(
      placed("Scale 1 2 1\nCurves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0  1 1 1] \"constantwidth\" [.1]\n"), 3u)
      << "widths would not be kept";
  EXPECT_EQ(placed("Translate 100 0 0\n" + ball), 2u);
  EXPECT_EQ(placed("Translate 100000 0 0\n" + ball), 3u) << "lies where floats are coarse for its size";
  EXPECT_EQ(render(kHead + "ObjectBegin \"o\"\nTranslate 100000 0 0\n" + two +
                   "ObjectEnd\nTranslate -100000 0 0\n"
                   "ObjectInstance \"o\"\nWorldEnd\n")
                .placements,
            3u)
      << "modelled far from the object's origin, where floats are coarse";
}

// Ten objects in one another, each with two of the one before, are a thousand of the first.
TEST(Prototypes, ObjectsInObjects) {
  const auto step = [](int level) { return "Translate " + std::to_string(.0005 * (1 << level)) + " 0 0\n"; };
  std::string nested = "ObjectBegin \"o0\"\n" + block(kPieces[0].text) + block(kPieces[5].text) + "ObjectEnd\n",
              flat = nested;
  for (int i = 1; i <= 10; ++i) {
    const std::string below = "ObjectInstance \"o" + std::to_string(i - 1) + "\"\n";
    nested += "ObjectBegin \"o" + std::to_string(i) + "\"\n" + below + "TransformBegin\n" + step(i) + below +
              "TransformEnd\nObjectEnd\n";
  }
  for (int k = 0; k < 1024; ++k)
    flat += "TransformBegin\nTranslate " + std::to_string(.001 * k) + " 0 0\nObjectInstance \"o0\"\nTransformEnd\n";
  const Rendered deep = render(kHead + nested + "ObjectInstance \"o10\"\nWorldEnd\n"),
                 wide = render(kHead + flat + "WorldEnd\n");
  EXPECT_EQ(deep.placements, 1025u);
  EXPECT_EQ(wide.placements, 1025u);
  expectAlike(deep.picture, wide.picture, "ten deep");
}

TEST(Prototypes, EditsGiveThePictureOfAFreshLoad) {
  RenderRequest r;
  r.rib = forest(false);
  SceneRender s(r);
  ASSERT_TRUE(s.ok());
  const auto recolour = [](scene::Scene& scene) {
    auto changed = std::make_shared<scene::Primitive>(*scene.prototypes[0].primitives[1]);
    scene::Matrix m = changed->toWorld.matrices[0];
    m[3][0] += .2;
    changed->toWorld = scene::Transform::fixed(m);
    scene.prototypes[0].primitives[1] = changed;
    auto attributes = std::make_shared<scene::Attributes>(*scene.instances.attributesOf(0));
    attributes->color = {.1f, .9f, .1f};
    scene.instances.edit(0, [&](scene::Instance& i) { i.attributes = attributes; });
  };
  recolour(s.renderer().scene());
  ASSERT_TRUE(s.renderer().update());
  ASSERT_EQ(s.renderer().renderFilm(), render::Outcome::Complete);
  const uint64_t fresh = render(forest(false), [&](RenderRequest& q) { q.edit = recolour; }).hash;
  EXPECT_EQ(hashOf(s.film()), fresh);
}

// So many that the description packs them (scene/instance_list.h).
TEST(Prototypes, EditsAmongManyGiveThePictureOfAFreshLoad) {
  RenderRequest r;
  r.rib =
      std::string(kHead) + "ObjectBegin \"0\"\n" + block(kPieces[0].text) + block(kPieces[1].text) + "ObjectEnd\n";
  for (int i = 0; i < 900; ++i)
    r.rib += "TransformBegin\nTranslate " + std::to_string(.15 * (i % 30) - 2.2) + " " +
             std::to_string(.1 * (i / 30) - 1.5) + " 0\nScale .08 .08 .08\nObjectInstance \"0\"\nTransformEnd\n";
  r.rib += "WorldEnd\n";
  const auto change = [](scene::Scene& scene) {
    scene.instances.edit(300, [](scene::Instance& i) {
      scene::Matrix m = i.toWorld.matrices[0];
      m[0][0] = m[1][1] = .4;
      i.toWorld = scene::Transform::fixed(m);
    });
    scene.instances.erase(700);
    EXPECT_TRUE(scene.setInstanceTransform(scene.instances[800].id, scene::Transform()));
  };
  SceneRender s(r);
  ASSERT_TRUE(s.ok());
  const uint64_t before = hashOf(s.film());
  change(s.renderer().scene());
  ASSERT_TRUE(s.renderer().update());
  ASSERT_EQ(s.renderer().renderFilm(), render::Outcome::Complete);
  EXPECT_NE(hashOf(s.film()), before);
  const uint64_t fresh = render(r.rib, [&](RenderRequest& q) { q.edit = change; }).hash;
  EXPECT_EQ(hashOf(s.film()), fresh);
}

}  // namespace
}  // namespace kinora::tests
