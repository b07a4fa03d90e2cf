// Manifold next-event estimation (kinora/manifold.h) against paths that find the same light by chance: equal means,
// tile by tile, through bodies, sheets and sets of boundaries, clear and rough, moving, and off mirrors. Closed forms
// of light that no path can find. Equal bits, and what must never do harm.
#include <cmath>
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

constexpr int kSide = 32, kTile = 8;

using Sets = std::vector<std::pair<std::string, std::string>>;
Sets exact(int walk, int caustics = 1) {
  return {{"integrator.clampLuminance", "1e30"},
          {"integrator.rouletteThreshold", "0"},
          {"integrator.allowCaustics", std::to_string(caustics)},
          {"integrator.manifoldWalk", std::to_string(walk)}};
}

const std::string kLamp = R"(
  AttributeBegin
    Translate 0.5 2.2 -0.3
    Scale 0.5 0.5 0.5
    Light "PxrSphereLight" "lamp" "float intensity" [20] "int cheapCaustics" [1]
  AttributeEnd
)";
const std::string kFloor = R"(
  AttributeBegin
    Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.6 0.5 0.4]
    Polygon "vertex point P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
  AttributeEnd
)";

// Seen from above.
std::string sceneOn(const std::string& things, int samples, int interfaces = 2, const std::string& lights = kLamp,
                    const std::string& floor = kFloor, const std::string& options = "") {
  return R"(
Format 32 32 1
PixelFilter "box" 1 1
Hider "raytrace" "int maxsamples" [)" +
         std::to_string(samples) + R"(]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [5] "int maxInterfaces" [)" +
         std::to_string(interfaces) + "]\n" + options + R"(
Projection "perspective" "fov" [44]
Translate 0 -0.1 3.2
Rotate -58 1 0 0
WorldBegin
)" + lights + floor +
         things + "WorldEnd\n";
}
std::string glass(const std::string& more = "", const std::string& name = "glass") {
  return "Bxdf \"PxrGlass\" \"" + name + "\" \"int mwWalkable\" [1] " + more + "\n";
}

TileMoments tilesOf(Workshop& stage, const std::string& text, const Sets& sets, uint32_t firstSeed, uint32_t seeds) {
  TileMoments r;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    render::Settings s;
    s.threads = 1;
    s.seed = firstSeed + seed;
    s.sets = sets;
    const auto renderer = stage.load(sceneOf(text, stage.messages), s);
    r.add(pictureOf(*renderer), kSide, kSide, kTile);
    EXPECT_EQ(renderer->statistics().nonFiniteSamples, 0u);
  }
  return r;
}
// Walks against chance. `sharpness`: the relative standard error of a tile that the test must have.
void expectSameMeans(const std::string& text, double sharpness, uint32_t seeds = 12) {
  Workshop stage;
  const TileMoments chance = tilesOf(stage, text, exact(0), 100, seeds),
                    walks = tilesOf(stage, text, exact(1), 200, seeds);
  const TileTest t = compareTiles(walks, chance, 0.01);
  EXPECT_TRUE(t.agrees()) << "worst z " << t.worstZ << ", means " << walks.mean() << " and " << chance.mean();
  EXPECT_LT(t.meanError, sharpness);
  std::printf("means %.6f walks, %.6f chance; worst z %.2f, tile error %.4f\n", walks.mean(), chance.mean(), t.worstZ,
              t.meanError);
}

const std::string kBall = R"(
  AttributeBegin
    Translate 0 0.62 0
    )" + std::string("@") + R"(
    Sphere 0.45 -0.45 0.45 360
  AttributeEnd
)";
std::string ballOf(const std::string& material) {
  std::string s = kBall;
  return s.replace(s.find('@'), 1, material);
}

TEST(Manifold, BallOfGlass) { expectSameMeans(sceneOn(ballOf(glass("\"float ior\" [1.5]")), 64), 0.05); }
TEST(Manifold, RoughBall) {
  expectSameMeans(sceneOn(ballOf(glass("\"float ior\" [1.4] \"float roughness\" [0.25]")), 64), 0.05);
}
TEST(Manifold, Slab) {
  expectSameMeans(sceneOn(R"(
  AttributeBegin
    )" + glass() + R"(
    Translate 0 0.7 0
    Rotate 12 0 0 1
    Scale 0.8 0.12 0.8
    PointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]
      "vertex point P" [-1 -1 -1  1 -1 -1  1 -1 1  -1 -1 1  -1 1 -1  1 1 -1  1 1 1  -1 1 1]
  AttributeEnd
)",
                          64),
                  0.05);
}
// One boundary, seen from below it: the floor of a pool whose waves are normals of a mesh.
std::string waves(bool isSubdivision) {
  constexpr int kN = 12;
  std::string points, normals, counts, indices;
  char text[96];
  for (int j = 0; j <= kN; ++j)
    for (int i = 0; i <= kN; ++i) {
      const double x = 5.0 * i / kN - 2.5, z = 5.0 * j / kN - 2.5;
      const double y = 0.5 + 0.05 * std::sin(3 * x) + 0.04 * std::cos(3.6 * z + x);
      const double dx = 0.15 * std::cos(3 * x) - 0.04 * std::sin(3.6 * z + x), dz = -0.144 * std::sin(3.6 * z + x);
      const double l = std::sqrt(1 + dx * dx + dz * dz);
      std::snprintf(text, sizeof text, "%.6f %.6f %.6f ", x, y, z);
      points += text;
      std::snprintf(text, sizeof text, "%.6f %.6f %.6f ", -dx / l, 1 / l, -dz / l);
      normals += text;
    }
  for (int j = 0; j < kN; ++j)
    for (int i = 0; i < kN; ++i) {
      counts += "4 ";
      const int a = j * (kN + 1) + i;
      std::snprintf(text, sizeof text, "%d %d %d %d ", a, a + kN + 1, a + kN + 2, a + 1);
      indices += text;
    }
  return "AttributeBegin\n" + glass("\"float ior\" [1.33]", "water") +
         (isSubdivision ? "SubdivisionMesh \"catmull-clark\" [" + counts + "] [" + indices +
                              "] [\"interpolateboundary\"] [0 0] [] [] \"vertex point P\" [" + points + "]\n"
                        : "PointsPolygons [" + counts + "] [" + indices + "] \"vertex point P\" [" + points +
                              "] \"vertex normal N\" [" + normals + "]\n") +
         "AttributeEnd\n";
}
TEST(Manifold, WavesOfAMesh) { expectSameMeans(sceneOn(waves(false), 64), 0.05); }
TEST(Manifold, WavesOfASubdivisionSurface) { expectSameMeans(sceneOn(waves(true), 64), 0.05); }

const std::string kMirrorRing = R"(
  AttributeBegin
    Bxdf "PxrSurface" "brass" "float diffuseGain" [0] "color specularFaceColor" [0.9 0.7 0.4] "color specularEdgeColor" [1 1 1]
      "float specularRoughness" [@] "int specularDoubleSided" [1] "int mwWalkable" [1]
    Rotate -90 1 0 0
    Cylinder 0.8 0.02 0.5 360
  AttributeEnd
)";
std::string ringOf(const std::string& roughness) {
  std::string s = kMirrorRing;
  return s.replace(s.find('@'), 1, roughness);
}
TEST(Manifold, RingOfBrass) { expectSameMeans(sceneOn(ringOf("0"), 64), 0.05); }
TEST(Manifold, RoughRing) { expectSameMeans(sceneOn(ringOf("0.2"), 64), 0.05); }

TEST(Manifold, TwoBodiesOneInTheOther) {
  expectSameMeans(sceneOn(R"(
  AttributeBegin
    Attribute "trace" "int intersectpriority" [1]
    )" + glass("\"float ior\" [1.33]", "water") + R"(
    Translate 0 0.6 0
    Sphere 0.5 -0.5 0.5 360
  AttributeEnd
  AttributeBegin
    Attribute "trace" "int intersectpriority" [2]
    )" + glass("\"float ior\" [1.5]") + R"(
    Translate 0.25 0.65 0
    Sphere 0.35 -0.35 0.35 360
  AttributeEnd
)",
                          64, 4),
                  0.05);
}
TEST(Manifold, BallInMotion) {
  expectSameMeans(sceneOn(R"(
  AttributeBegin
    MotionBegin [0 1]
      Translate -0.3 0.6 0
      Translate 0.3 0.7 0.1
    MotionEnd
    )" + glass() + R"(
    Sphere 0.4 -0.4 0.4 360
  AttributeEnd
)",
                          64, 2, kLamp, kFloor, "Shutter 0 1\n"),
                  0.05);
}
TEST(Manifold, AbsorbingBallUnderOtherLights) {
  const std::string lights = R"(
  AttributeBegin
    Translate 0.6 2.1 0
    Rotate 90 1 0 0
    Scale 0.9 0.9 1
    Light "PxrRectLight" "panel" "float intensity" [6] "int cheapCaustics" [1]
  AttributeEnd
  AttributeBegin
    Rotate 120 1 0 0
    Light "PxrDistantLight" "sun" "float intensity" [9] "float angleExtent" [22] "int cheapCaustics" [1]
  AttributeEnd
  AttributeBegin
    Translate -0.9 1.7 0.3
    Rotate 90 1 0 0
    Scale 0.7 0.7 0.7
    Light "PxrDiskLight" "disk" "float intensity" [5]
  AttributeEnd
)";
  expectSameMeans(sceneOn(ballOf(glass("\"float absorptionGain\" [1] \"color absorptionColor\" [0.2 0.6 1.2]")), 64, 2, lights), 0.05);
}
TEST(Manifold, BallUnderADome) {
  const std::string dome = R"(Light "PxrDomeLight" "sky" "float intensity" [0.6] "int cheapCaustics" [1]
)";
  expectSameMeans(sceneOn(ballOf(glass()), 64, 2, dome), 0.05);
}

}  // namespace
}  // namespace kinora::probes
