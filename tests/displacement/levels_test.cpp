// Surfaces that are diced where rays ask, from the scene to the picture: no ray passes closed ones at any mixture of
// resolutions, the picture is that of the surface diced at once, and the same bits come of any cache, thread and width.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <optional>

#include "rib/reader.h"
#include "shade/ray_listener.h"
#include "tests/support/render_scene.h"

namespace kinora::tests {
namespace {

const std::string kBumps =
    "Pattern \"PxrFractal\" \"f\" \"float frequency\" [2] \"int layers\" [6]\n"
    "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.3] \"reference float dispScalar\" [\"f:resultF\"]\n";
const std::string kCorners = "\"P\" [-2 -2 -2  -2 -2 2  -2 2 -2  -2 2 2  2 -2 -2  2 -2 2  2 2 -2  2 2 2]";
const std::string kFaces = "[4 4 4 4 4 4] [0 1 3 2  4 6 7 5  0 4 5 1  2 3 7 6  0 2 6 4  1 5 7 3] ";

std::string levels(int asked, const std::string& length) {
  return "Attribute \"dice\" \"int levels\" [" + std::to_string(asked) + "] \"float micropolygonlength\" [" + length +
         "]\n";
}

RenderRequest requestOf(const std::string& objects, int size, int samples, int bounces, const std::string& camera,
                        const std::string& channels = "Ci,a") {
  RenderRequest r;
  r.rib =
      "Format " + std::to_string(size) + " " + std::to_string(size) +
      " 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" + std::to_string(samples) +
      "]\nIntegrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [" + std::to_string(bounces) + "]\n" +
      camera +
      "\nWorldBegin\nAttributeBegin\nAttribute \"visibility\" \"int camera\" [0]\nLight \"PxrDomeLight\" \"sky\"\n"
      "AttributeEnd\nBxdf \"PxrDiffuse\" \"m\" \"color diffuseColor\" [.6 .6 .6]\n" +
      objects + "\nWorldEnd\n";
  r.channels = channels;
  return r;
}

double mean(const image::Image& x) {
  double sum = 0;
  for (const float p : x.pixels) sum += double(p);
  return sum / double(x.pixels.size());
}

// From inside. An instance that the camera does not see comes near to it, larger: its rates are those of the one that is
// seen, where footprints are of many micropolygons here and of few there, so that rays see mixtures.
TEST(GeometryLevels, ClosedSurfacesLetNoRayThrough) {
  const std::string shapes[] = {
      "Sphere 2 -2 2 360",
      "SubdivisionMesh \"catmull-clark\" " + kFaces + "[\"interpolateboundary\"] [1 0] [2] [] " + kCorners,
      "PointsPolygons " + kFaces + kCorners,
      "PointsPolygons [3 3 3 3] [0 1 2 0 3 1 1 3 2 2 3 0] \"P\" [2.5 2.5 2.5 -2.5 -2.5 2.5 -2.5 2.5 -2.5 2.5 -2.5 "
      "-2.5]",
      "Rotate 90 1 0 0 Scale .8 .8 1.5 Torus 2 1.5 0 360 360"};
  double level = 0;
  for (const std::string& shape : shapes) {
    const std::string place =
        shape.find("Torus") == std::string::npos ? "Translate .3 .2 .1\n" : "Translate 1.6 0 0\n";
    SceneRender r(requestOf(levels(1, "1") + kBumps + "ObjectBegin \"o\"\n" + shape + "\nObjectEnd\n" + place +
                                "ObjectInstance \"o\"\nAttribute \"visibility\" \"int camera\" [0]\n"
                                "Translate 8 4 -14\nScale 8 8 8\nObjectInstance \"o\"",
                            64, 8, 0, "Projection \"perspective\" \"fov\" [110]", "a,geometryLevel"));
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(mean(r.channel("a")), 1) << shape;
    level += mean(r.channel("geometryLevel"));
    EXPECT_GT(r.renderer().statistics().geometry.made, 20u) << shape;
  }
  EXPECT_GT(level, 0.1);  // some are mixtures
}

// Means of 8 x 8 pixels over some seeds, diced where rays ask against all at once.
struct Blocks {
  double t2 = 0,
         difference = 0;  // of the means of a block, squared: over its variance; relative to the picture's mean
  int count = 0, seeds = 0;
  void compare(const std::string& object, int bounces, int samples, double* seen = nullptr) {
    constexpr int kSize = 64, kBlocks = 64;
    double sum[2][kBlocks] = {}, squares[2][kBlocks] = {}, all = 0;
    for (int asked = 0; asked < 2; ++asked)
      for (int seed = 0; seed < seeds; ++seed) {
        RenderRequest request = requestOf(levels(asked, ".4") + object, kSize, samples, bounces,
                                          "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 7");
        request.settings.seed = uint32_t(1 + seed + 100 * asked);
        SceneRender r(request);
        ASSERT_TRUE(r.ok());
        EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
        EXPECT_EQ(r.renderer().statistics().geometry.made > 0, asked == 1);
        if (seen) seen[asked] += mean(r.channel("a")) / seeds;
        const image::Image picture = r.channel("Ci");
        for (int b = 0; b < kBlocks; ++b) {
          double block = 0;
          for (int i = 0; i < 64; ++i)
            block +=
                double(picture.pixels[3 * (size_t(b / 8 * 8 + i / 8) * kSize + size_t(b % 8 * 8 + i % 8)) + 1]) / 64;
          sum[asked][b] += block;
          squares[asked][b] += block * block;
        }
      }
    for (int b = 0; b < kBlocks; ++b) {
      double d = 0, variance = 0;
      for (int asked = 0; asked < 2; ++asked) {
        const double m = sum[asked][b] / seeds;
        d += (asked ? 1 : -1) * m;
        variance += (squares[asked][b] - seeds * m * m) / (seeds - 1) / seeds;
      }
      if (!(variance > 1e-12)) continue;  // the sky
      t2 += d * d / variance;
      difference += d * d;
      all += sum[0][b] / seeds;
      ++count;
    }
    difference = std::sqrt(difference / count) / (all / count);
  }
};
const std::string kBumpyCube = kBumps + "Rotate 40 1 1 0\nSubdivisionMesh \"catmull-clark\" " + kFaces +
                               "[\"interpolateboundary\"] [1 0] [2] [] " + kCorners;

// What differs is their noise. It misses what both ways of dicing have in common.
TEST(GeometryLevels, ShowThePictureOfTheSurfaceDicedAtOnce) {
  Blocks blocks;
  blocks.seeds = 6;
  double seen[2] = {};
  blocks.compare(kBumpyCube, 3, 8, seen);
  EXPECT_NEAR(seen[0], seen[1], 1.5e-3);
  // the square of Student's t with 10 degrees of freedom: mean 1.25, standard deviation 2.17
  ASSERT_GT(blocks.count, 20);
  EXPECT_LT(blocks.t2 / blocks.count, 1.25 + 4 * 2.17 / std::sqrt(double(blocks.count)));
}

// Crevices keep their shade: rays to the sky see what is near nearly as finely as the camera does. The bound lies between
// what noise and the other rate of the whole mesh (not of powers of two) make, .64 %, and what rays make whose
// footprints are taken as they are, 1.2 %.
TEST(GeometryLevels, LightOfTheSkyIsThatOfTheSurfaceDicedAtOnce) {
  Blocks blocks;
  blocks.seeds = 10;
  blocks.compare(kBumpyCube, 0, 16);
  ASSERT_GT(blocks.count, 20);
  EXPECT_LT(blocks.difference, 0.009);
}

// A cliff behind the camera lights a floor: what bounces and shadow rays see of it is coarse.
TEST(GeometryLevels, DiffuseLightNeedsFewMicropolygons) {
  SceneRender r(
      requestOf("PointsPolygons [4] [0 1 2 3] \"P\" [-3 -1 0  -3 -1 4  3 -1 4  3 -1 0]\n"
                "Attribute \"dice\" \"int levels\" [1] \"float micropolygonlength\" [.1] \n" +
                    kBumps +
                    "AttributeBegin\nAttribute \"visibility\" \"int camera\" [0]\nTranslate 0 0 3\n"
                    "PointsPolygons [4] [0 1 2 3] \"P\" [-3 0 3  -3 5 3  3 5 3  3 0 3]\nAttributeEnd",
                128, 16, 3, "Projection \"perspective\" \"fov\" [60]\nTranslate 0 0 2"));
  ASSERT_TRUE(r.ok());
  const auto& g = r.renderer().statistics().geometry;
  uint64_t byKind[3] = {};
  for (const auto& level : g.micropolygons)
    for (size_t k = 0; k < 3; ++k) byKind[k] += level[k];
  EXPECT_EQ(byKind[0], 0u);
  EXPECT_GT(byKind[1], 0u);
  EXPECT_LT(20 * (byKind[1] + byKind[2]), g.whole);
}

TEST(GeometryLevels, EditsGiveTheBitsOfAFreshLoad) {
  const auto sceneWith = [](const char* amount) {
    RenderRequest request =
        requestOf(levels(1, "1") +
                      "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.1]\nSphere 1 -1 1 360\n"
                      "Translate 1.5 0 0\nDisplace \"PxrDisplace\" \"d\" \"float dispScalar\" [" +
                      std::string(amount) + "]\nSphere .5 -.5 .5 360",
                  32, 4, 2, "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 5");
    request.settings.geometryCacheBytes = 300'000;
    return request;
  };
  SceneRender edited(sceneWith(".1")), fresh(sceneWith(".3"));
  ASSERT_TRUE(edited.ok() && fresh.ok());
  const auto before = stateOf(edited.film());
  edited.renderer().scene() = fresh.renderer().scene();
  ASSERT_TRUE(edited.renderer().update());
  ASSERT_EQ(edited.renderer().renderFilm(), render::Outcome::Complete);
  EXPECT_NE(stateOf(edited.film()), before);
  EXPECT_EQ(stateOf(edited.film()), stateOf(fresh.film()));
}

TEST(GeometryLevels, ADisplacedSphereIsALargerOne) {
  const std::string camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 5";
  SceneRender a(
      requestOf(levels(1, ".5") +
                    "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.4]\nRotate 70 1 1 0\nSphere 1 -1 1 360",
                48, 16, 1, camera, "Ci,a,z,Nn")),
      b(requestOf("Rotate 70 1 1 0\nSphere 1.4 -1.4 1.4 360", 48, 16, 1, camera, "Ci,a,z,Nn"));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_NEAR(mean(a.channel("a")), mean(b.channel("a")), 4e-4);
  EXPECT_NEAR(mean(a.channel("Ci")), mean(b.channel("Ci")), 2e-3);
  const image::Image n = a.channel("Nn"), m = b.channel("Nn");
  double off = 0;
  for (size_t i = 0; i < n.pixels.size(); ++i) off += std::fabs(double(n.pixels[i]) - double(m.pixels[i]));
  EXPECT_LT(off / double(n.pixels.size()), 3e-3);
}

// Moving instances of two sizes and a medium between: all that a footprint is scaled by.
TEST(GeometryLevels, BitsAreTheSameForAnyCacheThreadWidthAndGroup) {
  const std::string object = levels(1, ".15") + kBumps +
                             "ObjectBegin \"o\"\nSphere 1 -1 1 360\nObjectEnd\n"
                             "AttributeBegin\nTranslate -1.2 0 0\nObjectInstance \"o\"\nAttributeEnd\n"
                             "AttributeBegin\nMotionBegin [0 1]\nTranslate 1 0 0\nTranslate 1 .5 0\nMotionEnd\n"
                             "Scale .6 .6 .6\nObjectInstance \"o\"\nAttributeEnd";
  RenderRequest request =
      requestOf(object, 32, 4, 3, "Shutter 0 1\nProjection \"perspective\" \"fov\" [40]\nTranslate 0 0 5");
  request.settings.threads = 1;
  request.settings.width = 8;
  SceneRender first(request);
  ASSERT_TRUE(first.ok());
  ASSERT_GT(first.renderer().statistics().geometry.made, 50u);
  const auto hash = hashOf(first.film());
  for (const uint64_t cache : {uint64_t(1), uint64_t(200'000), uint64_t(500'000)}) {
    RenderRequest other = request;
    other.settings.geometryCacheBytes = cache;
    other.settings.threads = 2;
    SceneRender r(other);
    EXPECT_EQ(hashOf(r.film()), hash) << cache;
    EXPECT_GT(r.renderer().statistics().geometry.evicted, 0u) << cache;
    EXPECT_EQ(says(r, "GEOMETRY-CACHE-SMALL"), cache == 1) << cache;
  }
  for (const uint32_t width : {1u, 4u, 16u}) {
    RenderRequest other = request;
    other.settings.width = width;
    other.settings.groupSize = 64 * width;
    EXPECT_EQ(hashOf(SceneRender(other).film()), hash) << width;
  }
}

// Surfaces that deform while the shutter is open: shutter and camera, and one shape that becomes another.
const std::string kShutter = "Shutter 0 1\nProjection \"perspective\" \"fov\" [40]\n";
std::string becomes(const std::string& open, const std::string& close) {
  return "MotionBegin [0 1]\n" + open + "\n" + close + "\nMotionEnd\n";
}
const std::string kOtherCorners =
    "\"P\" [-2 -2 -2  -2 -2 2.6  -2 2.3 -2  -2 2 2  2 -2 -2  2.8 -2 2  2 2 -2  2 2.5 2]";
const std::string kPolygons = "PointsPolygons " + kFaces;
const std::string kSubdivision =
    "SubdivisionMesh \"catmull-clark\" " + kFaces + "[\"interpolateboundary\"] [1 0] [2] [] ";
std::string curved(const char* height) {
  const std::string h = height, knots = "4 4 [0 0 0 0 1 1 1 1] 0 1 ";
  return "NuPatch " + knots + knots + "\"P\" [-2 -2 0  -1 -2 0  1 -2 0  2 -2 0  -2 -1 0  -1 -1 " + h + "  1 -1 " + h +
         "  2 -1 0  -2 1 0  -1 1 " + h + "  1 1 " + h + "  2 1 0  -2 2 " + h + "  -1 2 0  1 2 0  2 2 " + h + "]";
}

TEST(GeometryLevels, DeformingSurfacesAreThoseDicedAtOnce) {
  const std::string shapes[] = {becomes(kPolygons + kCorners, kPolygons + kOtherCorners),
                                becomes(kSubdivision + kCorners, kSubdivision + kOtherCorners),
                                becomes("Patch \"bilinear\" \"P\" [-2 -2 0 2 -2 0 -2 2 0 2 2 0]",
                                        "Patch \"bilinear\" \"P\" [-2 -2 0 2 -2 1 -2 2 1 2.5 2 0]"),
                                becomes(curved("1"), curved("2")),
                                becomes("Sphere 1.5 -1.5 1.5 360", "Sphere 2 -2 2 360")};
  for (const std::string& shape : shapes) {
    const std::string object = "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.2]\nRotate 30 1 1 0\n" + shape;
    const auto requestWith = [&](int asked) {
      return requestOf(levels(asked, ".5") + object, 48, 16, 1, kShutter + "Translate 0 0 8", "Ci,a,dPdtime");
    };
    SceneRender a(requestWith(1)), b(requestWith(0));
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_GT(a.renderer().statistics().geometry.made, 0u) << shape;
    EXPECT_EQ(b.renderer().statistics().geometry.made, 0u) << shape;
    EXPECT_TRUE(a.messages().empty()) << a.messages()[0];
    ASSERT_GT(mean(b.channel("a")), 0.05) << shape;
    EXPECT_NEAR(mean(a.channel("a")), mean(b.channel("a")), 1e-3) << shape;
    EXPECT_NEAR(mean(a.channel("Ci")), mean(b.channel("Ci")), 4e-3) << shape;
    EXPECT_NEAR(mean(a.channel("dPdtime")), mean(b.channel("dPdtime")), 4e-3) << shape;
  }
}

// Two ways: growing from 1 to 1.5 and displaced by .2, with a bound and without, and from 1.2 to 1.7.
TEST(GeometryLevels, AGrowingSphereThatIsDisplacedIsALargerOne) {
  const std::string camera = kShutter + "Translate 0 0 5",
                    displaced = "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.2]\nRotate 70 1 1 0\n" +
                                becomes("Sphere 1 -1 1 360", "Sphere 1.5 -1.5 1.5 360");
  SceneRender plain(requestOf("Rotate 70 1 1 0\n" + becomes("Sphere 1.2 -1.2 1.2 360", "Sphere 1.7 -1.7 1.7 360"), 48,
                              16, 1, camera, "Ci,a,Nn"));
  ASSERT_TRUE(plain.ok());
  for (const std::string bound : {"", "Attribute \"displacementbound\" \"float sphere\" [.2]\n"}) {
    SceneRender r(requestOf(levels(1, ".5") + bound + displaced, 48, 16, 1, camera, "Ci,a,Nn"));
    ASSERT_TRUE(r.ok());
    EXPECT_GT(r.renderer().statistics().geometry.made, 0u);
    EXPECT_FALSE(says(r, "DISPLACEMENT-BOUND"));
    EXPECT_NEAR(mean(r.channel("a")), mean(plain.channel("a")), 5e-4) << bound;
    EXPECT_NEAR(mean(r.channel("Ci")), mean(plain.channel("Ci")), 2e-3) << bound;
    const image::Image n = r.channel("Nn"), m = plain.channel("Nn");
    double off = 0;
    for (size_t i = 0; i < n.pixels.size(); ++i) off += std::fabs(double(n.pixels[i]) - double(m.pixels[i]));
    EXPECT_LT(off / double(n.pixels.size()), 4e-3) << bound;
  }
  SceneRender small(requestOf(levels(1, ".5") + "Attribute \"displacementbound\" \"float sphere\" [.1]\n" + displaced,
                              32, 1, 0, camera));
  EXPECT_TRUE(says(small, "DISPLACEMENT-BOUND"));
}

// Relief stays with the surface: points that all go the same way show the picture of the placement that goes it.
TEST(GeometryLevels, ADeformationThatOnlyMovesIsAMovingPlacement) {
  const auto cube = [&](double by) {
    std::string at = "\"P\" [";
    for (int k = 0; k < 8; ++k)
      at += std::to_string((k & 4 ? 2 : -2) + by) + (k & 2 ? " 2 " : " -2 ") + (k & 1 ? "2  " : "-2  ");
    return kSubdivision + at + "]";
  };
  const auto requestWith = [&](const std::string& motion) {
    return requestOf(levels(1, "1") + kBumps + motion, 64, 16, 2, kShutter + "Translate 0 0 8\nRotate 30 1 1 0",
                     "Ci,a,dPdtime");
  };
  SceneRender deforms(requestWith(becomes(cube(0), cube(1)))),
      goes(requestWith(becomes("Translate 0 0 0", "Translate 1 0 0") + cube(0)));
  ASSERT_TRUE(deforms.ok() && goes.ok());
  EXPECT_GT(deforms.renderer().statistics().geometry.made, 0u);
  EXPECT_NEAR(mean(deforms.channel("a")), mean(goes.channel("a")), 1e-3);
  EXPECT_NEAR(mean(deforms.channel("Ci")), mean(goes.channel("Ci")), 4e-3);
  EXPECT_NEAR(mean(deforms.channel("dPdtime")), mean(goes.channel("dPdtime")), 2e-3);
  EXPECT_GT(mean(goes.channel("dPdtime")), 0.05);  // one unit a shutter, where the cube is
}

// As ClosedSurfacesLetNoRayThrough.
TEST(GeometryLevels, ClosedSurfacesThatDeformLetNoRayThrough) {
  for (const std::string& shape : {becomes(kPolygons + kCorners, kPolygons + kOtherCorners),
                                   becomes(kSubdivision + kCorners, kSubdivision + kOtherCorners),
                                   becomes("Sphere 2 -2 2 360", "Sphere 2.5 -2.5 2.5 360")}) {
    SceneRender r(requestOf(levels(1, "1") + kBumps + "ObjectBegin \"o\"\n" + shape +
                                "ObjectEnd\nTranslate .3 .2 .1\n"
                                "ObjectInstance \"o\"\nAttribute \"visibility\" \"int camera\" [0]\n"
                                "Translate 8 4 -14\nScale 8 8 8\nObjectInstance \"o\"",
                            48, 8, 0, "Shutter 0 1\nProjection \"perspective\" \"fov\" [110]", "a"));
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(mean(r.channel("a")), 1) << shape;
    EXPECT_GT(r.renderer().statistics().geometry.made, 10u) << shape;
  }
}

// Three keys, in an instance that moves and one that stands.
TEST(GeometryLevels, BitsOfDeformingSurfacesAreTheSameForAnyCacheThreadWidthAndGroup) {
  const std::string object =
      levels(1, ".3") + kBumps +
      "ObjectBegin \"o\"\nMotionBegin [0 .5 1]\nSphere 1 -1 1 360\nSphere 1.2 -1.2 1.2 360\nSphere .9 -.9 .9 360\n"
      "MotionEnd\nObjectEnd\n"
      "AttributeBegin\nTranslate -1.2 0 0\nObjectInstance \"o\"\nAttributeEnd\n"
      "AttributeBegin\nMotionBegin [0 1]\nTranslate 1 0 0\nTranslate 1 .5 0\nMotionEnd\n"
      "Scale .6 .6 .6\nObjectInstance \"o\"\nAttributeEnd";
  RenderRequest request = requestOf(object, 32, 4, 3, kShutter + "Translate 0 0 5");
  request.settings.threads = 1;
  request.settings.width = 8;
  SceneRender first(request);
  ASSERT_TRUE(first.ok());
  ASSERT_GT(first.renderer().statistics().geometry.made, 30u);
  const auto hash = hashOf(first.film());
  for (const uint64_t cache : {uint64_t(1), uint64_t(500'000)}) {
    RenderRequest other = request;
    other.settings.geometryCacheBytes = cache;
    other.settings.threads = 2;
    SceneRender r(other);
    EXPECT_EQ(hashOf(r.film()), hash) << cache;
    EXPECT_GT(r.renderer().statistics().geometry.evicted, 0u) << cache;
  }
  for (const uint32_t width : {1u, 16u}) {
    RenderRequest other = request;
    other.settings.width = width;
    other.settings.groupSize = 64 * width;
    EXPECT_EQ(hashOf(SceneRender(other).film()), hash) << width;
  }
}

// Seven more samples come in one pass, which makes what it needs about as often as the first one; passes of 1, 2 and 4
// would make it once each.
TEST(GeometryLevels, PassesAreLongWhereTheCacheIsCrowded) {
  const std::string floor =
      levels(1, ".15") + kBumps + "PointsPolygons [4] [0 1 2 3] " + "\"P\" [-3 -1 0  -3 -1 6  3 -1 6  3 -1 0]";
  const auto requestWith = [&](int samples, uint64_t cache) {
    RenderRequest r = requestOf(floor, 64, samples, 0, "Projection \"perspective\" \"fov\" [60]\nTranslate 0 0 2");
    r.settings.threads = 1;
    r.settings.geometryCacheBytes = cache;
    return r;
  };
  SceneRender one(requestWith(1, 3 << 20)), eight(requestWith(8, 3 << 20)), large(requestWith(8, 1 << 30));
  ASSERT_TRUE(eight.ok());
  const auto made = [](SceneRender& r) { return r.renderer().statistics().geometry.made; };
  ASSERT_GT(made(one), 50u);
  EXPECT_LT(double(made(eight)), 3.3 * double(made(one)));
  EXPECT_GT(double(made(eight)), 1.3 * double(made(one)));  // the cache is crowded
  EXPECT_EQ(hashOf(eight.film()), hashOf(large.film()));
  EXPECT_GT(eight.renderer().statistics().geometry.passed, large.renderer().statistics().geometry.passed);
}

// Told to stop, rays dice no more: groups with rays that would have are dropped, at the camera or further on, and what is
// in the picture is what would be there. Nothing of it is in the way of another render.
TEST(GeometryLevels, StoppingDicesNoMoreAndDropsWhatItCutShort) {
  struct Stops final : shade::RayListener {
    RayKind at = RayKind::Camera;
    int buckets = 0;
    std::atomic<bool> stop{false};
    void closest(RayKind kind, uint32_t, const Rays&, uint32_t, const uint32_t*) override {
      buckets += kind == RayKind::Camera;
      if (buckets == 2 && kind == at) stop = true;
    }
    void shadow(uint32_t, const ShadowRays&) override {}
  };
  RenderRequest request = requestOf(levels(1, "1") + kBumps + "Translate .3 .2 .1\n" + kPolygons + kCorners, 32, 1, 1,
                                    "Projection \"perspective\" \"fov\" [110]");
  request.settings.threads = 1;
  request.settings.geometryCacheBytes = 1;  // of which nothing stays
  SceneRender whole(request);
  ASSERT_TRUE(whole.ok());
  const auto hash = hashOf(whole.film());
  const image::Image expected = whole.channel("Ci");
  const uint64_t made = whole.renderer().statistics().geometry.made;
  for (const RayKind kind : {RayKind::Camera, RayKind::Indirect}) {
    const int at = int(kind);
    Stops stops;
    stops.at = kind;
    request.settings.stop = &stops.stop;
    request.settings.rayListener = &stops;
    std::optional<scene::Scene> scene;
    Diagnostics diagnostics([](const std::string&, Severity) {});
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    ASSERT_TRUE(reader.readString("test.rib", request.rib));
    reader.finish();
    ASSERT_TRUE(scene);
    scene::Display display;
    display.file = "test.exr";
    display.driver = "openexr";
    display.mode = request.channels;
    scene->displays = {display};
    Registry registry;
    render::Renderer renderer(registry, diagnostics, request.settings);
    ASSERT_TRUE(renderer.load(std::move(*scene)));
    EXPECT_EQ(renderer.renderFilm(), render::Outcome::Interrupted) << at;
    ASSERT_TRUE(stops.stop) << at;
    EXPECT_LT(renderer.statistics().geometry.made, made * 3 / 4) << at;
    const film::Film& film = renderer.film();
    const image::Image picture = film.resolve(film.layout().find("Ci"));
    int there = 0, others = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const int64_t n = film.sampleCount(x, y);
        EXPECT_LE(n, 1);
        there += n == 1;
        const size_t i = (size_t(y) * 32 + size_t(x)) * picture.channels.size();
        for (size_t c = 0; n && c < picture.channels.size(); ++c)
          others += picture.pixels[i + c] != expected.pixels[i + c];
      }
    EXPECT_EQ(there, 256) << "the bucket before; at " << at;
    EXPECT_EQ(others, 0) << at;
    stops.stop = false;
    ASSERT_TRUE(renderer.update());
    EXPECT_EQ(renderer.renderFilm(), render::Outcome::Complete) << at;
    EXPECT_EQ(hashOf(renderer.film()), hash) << at;
  }
}

TEST(GeometryLevels, BadInputIsTold) {
  const std::string camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 5", ball = "Sphere 1 -1 1 360";
  SceneRender plain(requestOf(ball, 32, 4, 0, camera));
  const auto expect = [&](const std::string& before, const char* code, double tolerance) {
    SceneRender r(requestOf(levels(1, ".15") + before + ball, 32, 4, 0, camera));
    EXPECT_TRUE(r.ok());
    EXPECT_TRUE(says(r, code)) << before;
    EXPECT_TRUE(says(r, "Sphere")) << before;  // the object
    EXPECT_NEAR(mean(r.channel("a")), mean(plain.channel("a")), tolerance) << before;
  };
  const auto by = [](const char* amount, const char* scalar) {
    return std::string("Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [") + amount +
           "] \"float dispScalar\" [" + scalar + "]\n";
  };
  expect(by("10", "1e38"), "DISPLACEMENT-NOT-FINITE", 1e-3);
  expect(by("1", "1e20"), "DISPLACEMENT-NOT-FINITE", 1e-3);
  // a bound that is too small is where points end; one of 0 is none
  expect("Attribute \"displacementbound\" \"float sphere\" [1e-4]\n" + by("1", ".3"), "DISPLACEMENT-BOUND", 2e-3);
  SceneRender zero(
      requestOf(levels(1, ".15") + "Attribute \"displacementbound\" \"float sphere\" [0]\n" + by("1", ".3") + ball,
                32, 4, 0, camera)),
      larger(requestOf("Sphere 1.3 -1.3 1.3 360", 32, 4, 0, camera));
  EXPECT_TRUE(says(zero, "DISPLACEMENT-BOUND"));
  EXPECT_NEAR(mean(zero.channel("a")), mean(larger.channel("a")), 2e-3);
}

// Patches that are single micropolygons are no patches: what asks for levels with them is diced at once, and shown as it
// is without them.
TEST(GeometryLevels, SmallQuadricsAreDicedAtOnce) {
  const std::string camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 5",
                    ball = "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.1]\nSphere .2 -.2 .2 360";
  SceneRender asked(requestOf(levels(1, "1") + ball, 32, 4, 0, camera)),
      atOnce(requestOf(levels(0, "1") + ball, 32, 4, 0, camera));
  ASSERT_TRUE(asked.ok() && atOnce.ok());
  EXPECT_EQ(asked.renderer().statistics().geometry.made, 0u);
  EXPECT_EQ(hashOf(asked.film()), hashOf(atOnce.film()));
}

// The corners of a box move farther than its faces: a bound that holds what the displacement says holds them, too. With
// a sharp edge, where they would go beyond any multiple of it, it is told.
TEST(GeometryLevels, ABoundHoldsTheCornersOfABox) {
  const std::string camera = "Projection \"perspective\" \"fov\" [50]\nTranslate 0 0 9\nRotate 35 1 .3 0",
                    by = "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.5]\n",
                    bound = "Attribute \"displacementbound\" \"float sphere\" [.5]\n",
                    box = "PointsPolygons " + kFaces + kCorners;
  SceneRender bounded(requestOf(levels(1, "1") + bound + by + box, 64, 16, 0, camera)),
      whole(requestOf(levels(0, "1") + by + box, 64, 16, 0, camera));
  ASSERT_TRUE(bounded.ok() && whole.ok());
  EXPECT_GT(bounded.renderer().statistics().geometry.made, 0u);
  EXPECT_FALSE(says(bounded, "DISPLACEMENT-BOUND"));
  EXPECT_NEAR(mean(bounded.channel("a")), mean(whole.channel("a")), 2e-4);
  const std::string wedge =
      "PointsPolygons [4 4] [0 1 2 3  1 0 4 5] \"P\" [0 -2 0  0 2 0  .9 2 3  .9 -2 3  -.9 -2 3  -.9 2 3]";
  SceneRender sharp(requestOf(levels(1, "1") + bound + by + wedge, 64, 4, 0, camera));
  EXPECT_TRUE(says(sharp, "DISPLACEMENT-BOUND"));
}

}  // namespace
}  // namespace kinora::tests
