// Proves: the rays of patterns, through PxrDirt and PxrCurvature: what is closed off against closed forms for each distribution,
// direction, bias and limit of distance; they obey visibility, subsets and presence, and a pattern that decides
// presence ends them; equal bits for any threads, width and group. Misses: time (motion) and media.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

// A plane at z = 1, seen at one point from z = 0, that shows what its PxrDirt finds among `around`, which the camera
// does not see.
std::string dirtOf(const std::string& parameters, const std::string& around, const std::string& seen, int samples) {
  return orthographic(16, 1e-4, samples) + unbiased(0) +
         "WorldBegin\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [0]\n" +
         "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"grey\"\n" + around +
         "AttributeEnd\nPattern \"PxrDirt\" \"dirt\" " + parameters +
         "\nBxdf \"PxrConstant\" \"shown\" \"reference color emitColor\" [\"dirt:resultRGB\"]\nAttributeBegin\n" +
         seen + "AttributeEnd\nWorldEnd\n";
}
const std::string kPlane =
    "Translate 0 0 1 Polygon \"vertex point P\" [-50 -50 0  -50 50 0  50 50 0  50 -50 0] \"st\" [0 0 0 1 1 1 1 0]\n";

void expectClosed(const std::string& parameters, const std::string& around, double expected,
                  const std::string& seen = kPlane) {
  RenderRequest r;
  r.rib = dirtOf(parameters, around, seen, 64);
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const testing::Moments m = overPixels(render.channel("Ci"));
  EXPECT_NEAR(m.mean(), expected, 3e-3 * expected + 4 * m.standardError()) << parameters << "\n" << around;
  EXPECT_LE(m.standardError(), 2e-3) << parameters;
}

// Radius 0.8 at distance 0.6: 53.13 degrees off the normal, cosine 0.6.
const std::string kDisk = "Translate 0 0 0.4 Disk 0 0.8 360\n";
const std::string kWall =
    "Polygon \"vertex point P\" [1 -3000 1  1 3000 1  1 3000 0  1 -3000 0]\n";  // 1 away, 1 high
const std::string kHighWall = "Polygon \"vertex point P\" [1 -9000 1  1 9000 1  1 9000 -9000  1 -9000 -9000]\n";
const std::string kBall = "Translate 0 0 1 Sphere 0.7 -0.7 0.7 360\n";  // about the point

TEST(PatternRays, OfAPlaneAreOpenAndInABallClosed) {
  for (const char* distribution : {"[0]", "[1]", "[2]"}) {
    const std::string parameters = std::string("\"int distribution\" ") + distribution;
    expectClosed(parameters, "", 0);
    expectClosed(parameters, kBall, 1);
    expectClosed(parameters + " \"int direction\" [1]", "", 0);
    expectClosed(parameters + " \"int direction\" [2]", kBall, 1);
  }
}

TEST(PatternRays, OfADiskOverhead) {
  expectClosed("\"int distribution\" [1]", kDisk, 0.64);
  expectClosed("\"int distribution\" [0]", kDisk, 0.4);
  expectClosed("\"int distribution\" [1] \"float cosineSpread\" [4]", kDisk, 1 - std::pow(0.6, 5));
  expectClosed("\"int distribution\" [2]", kDisk, 0.64);  // the view is along the normal, and so is its mirror image
  expectClosed("\"int numSamples\" [1]", kDisk, 0.64);
  // the farthest that rays go: none to the disk, then to the cap within 0.75, whose cosine is 0.8
  expectClosed("\"float maxDistance\" [0.5]", kDisk, 0);
  expectClosed("\"float maxDistance\" [0.75]", kDisk, 0.36);
  expectClosed("\"int direction\" [1]", kDisk, 0);
  expectClosed("\"int direction\" [2]", kDisk, 0.32);
}

TEST(PatternRays, InACorner) {
  expectClosed("", kHighWall, 0.5);                         // half of the cosine's weight
  expectClosed("", kWall, 0.5 * (1 - 1 / std::sqrt(2.0)));  // a strip up to 45 degrees
  expectClosed("\"int distribution\" [0]", kHighWall, 0.5);
  expectClosed("\"vector biasDirection\" [10000 0 0]", kHighWall, 1);  // all towards the wall, mirrored at the plane
  expectClosed("\"vector biasDirection\" [-10000 0 0]", kHighWall, 0);
  expectClosed("\"vector biasDirection\" [0 10000 0] \"string biasDirectionCoordsys\" [\"turned\"]",
               "TransformBegin Rotate -90 0 0 1 CoordinateSystem \"turned\" TransformEnd\n" + kHighWall, 1);
  expectClosed("\"vector biasDirection\" [0 0 1]", kDisk, 0.64);  // cancels the normal: as without
}

TEST(PatternRays, FallOffWithDistance) {
  expectClosed("\"float falloff\" [2]", kBall, std::exp(-1.4));
  expectClosed("\"float falloff\" [2] \"float maxDistance\" [0.71]", kBall, std::exp(-1.4));
}

// The inside of a ball of radius R: evenly spread rays of length r end at the other side below the cosine r / (2 R).
TEST(PatternRays, InsideABallTellItsCurvature) {
  const std::string ball = "Translate 0 0 2 Sphere 0.5 -0.5 0.5 360\n";
  const std::string inside = "\"int distribution\" [0] \"int direction\" [1] ";
  expectClosed(inside, "", 1, ball);
  expectClosed(inside + "\"float maxDistance\" [0.5]", "", 0.5, ball);
  expectClosed(inside + "\"float maxDistance\" [0.2]", "", 0.2, ball);
  expectClosed("\"int distribution\" [0]", "", 0, ball);
}

// A point on the top of a step whose edge is .3 off, with rays of length 1 spread evenly: those meet the riser that go
// towards it by a cosine above .3, half of a cap of height .7; with a bias of .5 each counts as 1 - .3 / cosine.
// Behind the surface the same riser of a step down is met from inside.
void expectCurved(const std::string& parameters, const char* output, double z, const double (&expected)[3]) {
  const std::string step = "Polygon \"vertex point P\" [.3 -90 1  .3 90 1  .3 90 " + std::to_string(z) + "  .3 -90 " +
                           std::to_string(z) + "]\n";
  RenderRequest r;
  r.rib = orthographic(16, 1e-4, 64) + unbiased(0) +
          "WorldBegin\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [0]\n" +
          "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\nBxdf \"PxrDiffuse\" \"grey\"\n" + step +
          "AttributeEnd\nPattern \"PxrCurvature\" \"bent\" \"float maxDistance\" [1] " + parameters +
          "\nPattern \"PxrToFloat3\" \"f\" \"reference float input\" [\"bent:resultF\"]\n"
          "Pattern \"PxrToFloat3\" \"v\" \"reference float input\" [\"bent:resultConvex\"]\n"
          "Pattern \"PxrToFloat3\" \"c\" \"reference float input\" [\"bent:resultConcave\"]\n"
          "Bxdf \"PxrConstant\" \"shown\" \"reference color emitColor\" [\"" +
          output + "\"]\n" + kPlane + "WorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  for (int k = 0; k < 3; ++k) EXPECT_MEAN(overPixels(render.channel("Ci"), k), expected[k], 6e-3);
}

TEST(PatternRays, FindEdgesAndCreases) {
  const double all = 0.35, linear = 0.5 * (0.7 + 0.3 * std::log(0.3));
  // with a bias of .25 hits count as 1 - 3 t: those of cosines above .9
  const double near = 0.5 * (0.1 + 0.9 * std::log(0.9));
  // by the cosine about the normal, a plane's share of those that go by a cosine above .3 towards one side
  const double cosine = 0.5 * (std::acos(0.3) - 0.3 * std::sqrt(1 - 0.09)) / (std::acos(-1) / 2);
  const double convex = 50, concave = -50;
  const char* rgb = "bent:resultRGB";
  expectCurved("\"float bias\" [1]", rgb, convex, {all, all, all});
  expectCurved("\"float bias\" [1]", rgb, concave, {all, all, all});
  expectCurved("", rgb, convex, {linear, linear, linear});
  expectCurved("\"float bias\" [.25]", rgb, concave, {near, near, near});
  expectCurved("\"float bias\" [0]", rgb, concave, {0, 0, 0});
  expectCurved("\"int distribution\" [1] \"float bias\" [1]", rgb, convex, {cosine, cosine, cosine});
  expectCurved("\"int outputType\" [0] \"float bias\" [1]", rgb, convex, {0, 0, 0});
  expectCurved("\"int outputType\" [1] \"float bias\" [1]", rgb, convex, {all, all, all});
  expectCurved("\"int outputType\" [1] \"float bias\" [1]", rgb, concave, {0, 0, 0});
  expectCurved("\"int monochrome\" [0] \"float bias\" [1]", rgb, convex, {all, 0, 0});
  expectCurved("\"int monochrome\" [0] \"float bias\" [1]", rgb, concave, {0, all, 0});
  expectCurved("\"float bias\" [1] \"float outputGain\" [2]", rgb, concave, {2 * all, 2 * all, 2 * all});
  expectCurved("\"float bias\" [1] \"float convexThreshold\" [1]", rgb, convex, {0, 0, 0});
  expectCurved("\"float bias\" [1] \"float concaveThreshold\" [1]", rgb, convex, {all, all, all});
  expectCurved("\"float bias\" [1]", "f:resultRGB", concave, {all, all, all});
  expectCurved("\"float bias\" [1]", "v:resultRGB", convex, {all, all, all});
  expectCurved("\"float bias\" [1]", "v:resultRGB", concave, {0, 0, 0});
  expectCurved("\"float bias\" [1]", "c:resultRGB", concave, {all, all, all});
  // gains above 1 are cut by the clamp, or not
  expectCurved("\"float bias\" [1] \"int numSamples\" [64] \"float outputGain\" [200]", rgb, concave, {1, 1, 1});
  expectCurved("\"float bias\" [1] \"float outputGain\" [2] \"int clampOutput\" [0]", rgb, concave,
               {2 * all, 2 * all, 2 * all});
}

TEST(PatternRays, ColoursAreMixed) {
  RenderRequest r;
  r.rib = dirtOf("\"color occluded\" [0.2 0.4 1] \"color unoccluded\" [1 0 0.5]", kDisk, kPlane, 64);
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const double expected[3] = {1 - 0.64 * 0.8, 0.64 * 0.4, 0.5 + 0.64 * 0.5};
  for (int c = 0; c < 3; ++c) EXPECT_MEAN(overPixels(render.channel("Ci"), c), expected[c], 6e-3);
}

TEST(PatternRays, ObeyVisibilityAndSubsets) {
  const auto in = [](const std::string& group, const std::string& what) {
    return "AttributeBegin Attribute \"grouping\" \"string membership\" [\"" + group + "\"]\n" + what +
           "AttributeEnd\n";
  };
  expectClosed("", "Attribute \"visibility\" \"int indirect\" [0]\n" + kBall, 0);
  expectClosed("", "Attribute \"visibility\" \"int transmission\" [0]\n" + kBall, 1);
  const std::string two = in("low other", kDisk) + in("high", kBall);
  expectClosed("", two, 1);
  expectClosed("\"string traceSet\" [\"low\"]", two, 0.64);
  expectClosed("\"string traceSet\" [\"low, high\"]", two, 1);
  expectClosed("", two, 0.64, "Attribute \"trace\" \"string reflectsubset\" [\"low\"]\n" + kPlane);
  // the pattern's own choice comes before the object's
  expectClosed("\"string traceSet\" [\"high\"]", two, 1,
               "Attribute \"trace\" \"string reflectsubset\" [\"low\"]\n" + kPlane);
}

TEST(PatternRays, AGroupWithoutMembersIsTold) {
  RenderRequest r;
  r.rib = dirtOf("\"string traceSet\" [\"nobody\"]", kBall, kPlane, 4);
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(overPixels(render.channel("Ci")).mean(), 0);
  int told = 0;
  for (const std::string& m : render.messages())
    told += m.find("RENDER-TRACE-SET") != std::string::npos && m.find("'dirt'") != std::string::npos &&
            m.find("'nobody'") != std::string::npos;
  EXPECT_EQ(told, 1);
}

TEST(PatternRays, PassWhatIsNotPresent) {
  expectClosed("", "Bxdf \"PxrDiffuse\" \"veil\" \"float presence\" [0.5]\n" + kDisk, 0.32);
  // What a pattern decides by rays of its own is asked for by the first ones, whose rays go no further: the disk's
  // pattern answers 1 - unoccluded, whatever is around it.
  const std::string decided =
      "Pattern \"PxrDirt\" \"near\" \"color unoccluded\" [0.25 0.25 0.25] \"color occluded\" [1 1 1]\n"
      "Pattern \"PxrToFloat\" \"there\" \"reference color input\" [\"near:resultRGB\"]\n"
      "Bxdf \"PxrDiffuse\" \"veil\" \"reference float presence\" [\"there:resultF\"]\n" +
      kDisk;
  expectClosed("", decided, 0.25 * 0.64);
}

TEST(PatternRays, BadNumbersAreTamed) {
  RenderRequest r;
  r.rib = dirtOf(
      "\"int numSamples\" [-3] \"float maxDistance\" [-1] \"float falloff\" [-5] \"float cosineSpread\" [-2] "
      "\"int distribution\" [77] \"int direction\" [-4] \"vector biasDirection\" [1e38 1e38 1e38]",
      kBall, kPlane, 4);
  EXPECT_EQ(overSeeds(r, 1).mean(), 1);
}

TEST(PatternRays, HaveTheSameBits) {
  const auto render = [](int threads, uint32_t width, uint32_t group) {
    RenderRequest r;
    r.rib =
        "Format 40 24 1\nHider \"raytrace\" \"int maxsamples\" [2]\nProjection \"perspective\" \"float fov\" [40]\n" +
        unbiased(2) +
        R"(WorldBegin
Light "PxrDomeLight" "sky"
Pattern "PxrDirt" "dirt" "color occluded" [0.1 0.2 0.3] "color unoccluded" [0.8 0.7 0.6] "int direction" [2]
  "float falloff" [0.3] "float cosineSpread" [2] "vector biasDirection" [0.2 0.3 0.1]
Bxdf "PxrDiffuse" "a" "reference color diffuseColor" ["dirt:resultRGB"]
AttributeBegin Translate -0.4 0 3 Attribute "grouping" "string membership" ["one"] Sphere 0.7 -0.7 0.7 360 AttributeEnd
Pattern "PxrToFloat" "there" "reference color input" ["dirt:resultRGB"]
Bxdf "PxrDiffuse" "b" "reference float presence" ["there:resultF"]
AttributeBegin Attribute "trace" "string reflectsubset" ["one"] Translate 0.5 0.1 3 Sphere 0.6 -0.6 0.6 360 AttributeEnd
Bxdf "PxrGlass" "c"
AttributeBegin Translate 0.2 -0.5 2 Sphere 0.3 -0.3 0.3 360 AttributeEnd
WorldEnd
)";
    r.settings.threads = threads;
    r.settings.width = width;
    r.settings.groupSize = group;
    SceneRender s(r);
    EXPECT_TRUE(s.ok());
    return s.ok() ? stateOf(s.film()) : std::vector<int64_t>();
  };
  const auto want = render(1, 8, 0);
  EXPECT_EQ(want, render(2, 8, 0));
  EXPECT_EQ(want, render(1, 1, 0));
  EXPECT_EQ(want, render(1, 4, 64));
  EXPECT_EQ(want, render(1, 16, 1024));
}

}  // namespace
}  // namespace kinora::tests
