// The example of a bidirectional integrator against PxrPathTracer: equal means in rooms with every kind of light,
// glass, motion and a lens, for the picture and for channels by path; equal bits for threads, widths, groups and
// splits. It is the first user of stored vertices, connections and densities of lights through the whole renderer.
// What only connections to the camera find (caustics of lights that nothing can hit) is in neither picture.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"

namespace kinora {
const Descriptor* kinoraStock_OneConnection();
namespace probes {
namespace {

constexpr int kSide = 32, kTile = 8, kSeeds = 24;

// A corner of a room with a floor, a wall, a ball and whatever a test adds.
std::string room(const std::string& lights, const std::string& ball, const std::string& camera = "",
                 const std::string& more = "") {
  return R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,a,indirect,ball,key"
DisplayChannel "color ball" "string source" ["lpe:C.*<.[DS]'ball'>.*L"]
DisplayChannel "color key" "string source" ["lpe:C.+<L.'key'>"]
Format 32 32 1
PixelFilter "box" 1 1
Shutter 0 1
)" + camera +
         R"(
Projection "perspective" "fov" [40]
Translate 0 -0.8 3.2
WorldBegin
  AttributeBegin
    Attribute "visibility" "int camera" [0]
)" + lights +
         R"(
  AttributeEnd
  AttributeBegin
    Bxdf "PxrSurface" "floor" "color diffuseColor" [0.4 0.4 0.45] "int specularFresnelMode" [1]
      "color specularEdgeColor" [1 1 1] "color specularIor" [1.6 1.6 1.6] "int specularModelType" [1] "float specularRoughness" [0.4]
    Polygon "vertex point P" [-1.5 0 0  1.5 0 0  1.5 0 2  -1.5 0 2]
  AttributeEnd
  Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.7 0.6 0.5]
  Polygon "vertex point P" [-1.5 0 2  1.5 0 2  1.5 2 2  -1.5 2 2]
  Polygon "vertex point P" [-1.5 0 0  -1.5 0 2  -1.5 2 2  -1.5 2 0]
  AttributeBegin
    Attribute "identifier" "string lpegroup" ["ball"]
    )" + ball +
         R"(
    Translate 0.4 0.45 1.1
    Sphere 0.4 -0.4 0.4 360
  AttributeEnd
)" + more +
         "WorldEnd\n";
}
const char* const kGrey = R"(Bxdf "PxrDiffuse" "grey" "color diffuseColor" [0.6 0.6 0.7])";
const char* const kGlass = R"(Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1]
    "float reflectionGain" [1] "float glassRoughness" [0] "float glassIor" [1.5] "color refractionColor" [0.9 1 0.9])";
const char* const kRoughGlass = R"(Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1]
    "float reflectionGain" [1] "float glassRoughness" [0.35] "float glassIor" [1.4])";
const char* const kRect = R"(
    AttributeBegin
      ConcatTransform [0.8 0 0 0  0 0 0.6 0  0 -1 0 0  -0.2 1.9 1 1]
      Light "PxrRectLight" "lamp" "float intensity" [6] "color lightColor" [1 0.9 0.7] "string lightGroup" ["key"]
    AttributeEnd)";
const char* const kSphere = R"(
    AttributeBegin
      Translate -0.8 0.9 0.6
      Scale 0.3 0.3 0.3
      Light "PxrSphereLight" "bulb" "float intensity" [12] "color lightColor" [0.6 0.8 1]
    AttributeEnd)";
const char* const kSun = R"(
    AttributeBegin
      Rotate 70 1 0.3 0
      Light "PxrDistantLight" "sun" "float intensity" [2] "float angleExtent" [0] "string lightGroup" ["key"]
    AttributeEnd)";
const char* const kPoint = R"(
    LightSource "pointlight" 1 "point from" [-0.7 1.2 0.5] "float intensity" [3]
)";
const char* const kDome = R"(Light "PxrDomeLight" "sky" "float intensity" [0.5] "string lightGroup" ["key"])";
const char* const kMesh = R"(
    AttributeBegin
      Translate -0.7 1.1 0.9
      Light "PxrMeshLight" "shade" "float intensity" [4] "string lightGroup" ["key"]
      PointsPolygons [3 3 3 3] [0 1 2  0 2 3  0 3 1  1 3 2] "vertex point P" [0 0.3 0  -0.2 -0.1 0.1  0.2 -0.1 0.1  0 -0.1 -0.2]
    AttributeEnd)";

const std::vector<std::string> kChannels{"Ci", "indirect", "ball", "key"};

std::map<std::string, TileMoments> renderAll(Workshop& stage, const std::string& text, bool bidirectional,
                                             const std::string& integrator) {
  std::map<std::string, TileMoments> r;
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    render::Settings s;
    s.threads = 1;
    s.seed = (bidirectional ? 500 : 100) + seed;
    s.integrator = integrator;
    s.sets = {{"integrator.maxIndirectBounces", "4"}};
    if (!bidirectional)
      s.sets.insert(s.sets.end(), {{"integrator.clampLuminance", "1e30"},
                                   {"integrator.rouletteThreshold", "0"},
                                   {"integrator.allowCaustics", "1"}});
    const auto renderer = stage.load(sceneOf(text, stage.messages), s);
    EXPECT_EQ(renderer->renderFilm(), render::Outcome::Complete) << stage.said;
    for (const std::string& name : kChannels) {
      const image::Image picture = renderer->film().resolve(renderer->film().layout().find(name));
      r[name].add(picture, kSide, kSide, kTile);
      r[name + ", whole"].add(picture, kSide, kSide, kSide);
    }
  }
  return r;
}

// `sharpness`: the relative standard error that a tile of Ci may have, on average, for the test to say something.
void expectSamePicture(const std::string& text, double sharpness) {
  Workshop stage{kinoraStock_OneConnection()};
  auto both = renderAll(stage, text, true, "OneConnection"), one = renderAll(stage, text, false, "PxrPathTracer");
  for (auto& [name, moments] : both) {
    const TileTest t = compareTiles(moments, one[name]);
    EXPECT_TRUE(t.agrees()) << name << ": worst z " << t.worstZ << ", means " << moments.mean() << " and "
                            << one[name].mean() << "\n"
                            << stage.said;
    if (name == "Ci") {
      EXPECT_LT(t.meanError, sharpness);
    }
  }
  EXPECT_GT(one["Ci"].mean(), 0.01);
  EXPECT_GT(one["indirect"].mean(), 0.001);
}

TEST(OneConnection, EqualsPathTracerUnderPointAndSun) {
  expectSamePicture(room(std::string(kPoint) + kSun, kGrey), 0.03);
}
TEST(OneConnection, EqualsPathTracerUnderAreaLights) {
  expectSamePicture(room(std::string(kRect) + kSphere, kGrey), 0.03);
}
TEST(OneConnection, EqualsPathTracerUnderDome) { expectSamePicture(room(kDome, kGrey), 0.03); }
TEST(OneConnection, EqualsPathTracerUnderMeshLight) { expectSamePicture(room(kMesh, kGrey), 0.03); }
TEST(OneConnection, EqualsPathTracerBehindGlass) {
  expectSamePicture(room(kSphere, kGlass, "", R"(
  AttributeBegin )" + std::string(kRoughGlass) + R"(
    Translate -0.6 0.3 0.6
    Sphere 0.25 -0.25 0.25 360
  AttributeEnd
)"),
                    0.05);
}
TEST(OneConnection, EqualsPathTracerInMotionThroughALens) {
  expectSamePicture(room(kRect, kGrey, "DepthOfField 2 0.4 4\n", R"(
  AttributeBegin
    Bxdf "PxrDiffuse" "red" "color diffuseColor" [0.8 0.3 0.2]
    MotionBegin [0 1]
      Translate -0.9 0.3 0.7
      Translate -0.3 0.6 0.9
    MotionEnd
    Sphere 0.25 -0.25 0.25 360
  AttributeEnd
)"),
                    0.03);
}

TEST(OneConnection, SameBits) {
  const std::string text = room(std::string(kRect) + kSun + kDome, kGlass, "DepthOfField 2 0.4 4\n");
  std::vector<int64_t> expected;
  const auto filmOf = [&](int threads, uint32_t width, uint32_t groupSize, int first = -1, int last = -1) {
    Workshop stage{kinoraStock_OneConnection()};
    render::Settings s;
    s.threads = threads;
    s.width = width;
    s.groupSize = groupSize;
    s.firstSample = first;
    s.lastSample = last;
    s.integrator = "OneConnection";
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    return stateOf(r->film());
  };
  expected = filmOf(1, 8, 1024);
  for (const uint32_t width : {1u, 4u, 16u}) EXPECT_TRUE(filmOf(2, width, 1024) == expected) << "width " << width;
  for (const uint32_t size : {64u, 256u, 4096u}) EXPECT_TRUE(filmOf(2, 8, size) == expected) << "groups of " << size;
  // the film's numbers are sums
  std::vector<int64_t> parts = filmOf(2, 8, 1024, 0, 5);
  const std::vector<int64_t> rest = filmOf(1, 4, 256, 5, 16);
  ASSERT_EQ(parts.size(), rest.size());
  for (size_t i = 0; i < parts.size(); ++i) parts[i] += rest[i];
  EXPECT_TRUE(parts == expected) << "in two parts";
}

}  // namespace
}  // namespace probes
}  // namespace kinora
