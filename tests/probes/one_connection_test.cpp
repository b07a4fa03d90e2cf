// The example of a bidirectional integrator against PxrPathTracer: equal means in rooms with every kind of light,
// glass, motion and a lens, for the picture and for channels by path; equal bits for threads, widths, groups and
// splits. It is the first user of stored vertices, connections and densities of lights through the whole renderer.
// What only connections to the camera find (caustics of lights that nothing can hit) is in neither picture.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_OneConnection();
namespace probes {
namespace {

// `sharpness`: the relative standard error that a tile of Ci may have, on average, for the test to say something.
void expectEqualsPathTracer(const std::string& text, double sharpness) {
  Workshop stage{kinoraStock_OneConnection()};
  const Method oneConnection{"OneConnection", {{"integrator.maxIndirectBounces", "4"}}};
  Pictures both = renderAll(stage, text, oneConnection, 500), one = renderAll(stage, text, pathTracer(), 100);
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
  expectEqualsPathTracer(room(std::string(kPoint) + kSun, kGrey), 0.03);
}
TEST(OneConnection, EqualsPathTracerUnderAreaLights) {
  expectEqualsPathTracer(room(std::string(kRect) + kSphere, kGrey), 0.03);
}
TEST(OneConnection, EqualsPathTracerUnderDome) { expectEqualsPathTracer(room(kDome, kGrey), 0.03); }
TEST(OneConnection, EqualsPathTracerUnderMeshLight) { expectEqualsPathTracer(room(kMesh, kGrey), 0.03); }
TEST(OneConnection, EqualsPathTracerBehindGlass) { expectEqualsPathTracer(roomBehindGlass(), 0.05); }
TEST(OneConnection, EqualsPathTracerInMotionThroughALens) {
  expectEqualsPathTracer(roomInMotionThroughALens(), 0.03);
}

// What only takes light away for an integrator that does not say that it scatters in media.
TEST(OneConnection, MediaDimForIntegratorsThatKnowNoScattering) {
  Workshop stage{kinoraStock_OneConnection()};
  render::Settings s;
  s.integrator = "OneConnection";
  const auto r = stage.load(sceneOf(R"(
Hider "raytrace" "int maxsamples" [64]
Format 32 32 1
PixelFilter "box" 1 1
Projection "orthographic"
ScreenWindow -0.5 0.5 -0.5 0.5
WorldBegin
  Light "PxrDomeLight" "sky" "float intensity" [1]
  Bxdf "PxrVolume" "m" "color diffuseColor" [1 1 1] "int multiScatter" [1] "color densityColor" [0.2 0.7 2]
  Volume "box" [-3 3 -3 3 2 3.5] [0 0 0]
WorldEnd
)",
                                    stage.messages),
                            s);
  const image::Image seen = pictureOf(*r);
  EXPECT_NE(stage.said.find("MEDIUM-INTEGRATOR"), std::string::npos) << stage.said;
  const double sigma[3] = {0.2, 0.7, 2};
  for (size_t c = 0; c < 3; ++c) {
    testing::Moments mean;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) mean.add(double(seen.at(x, y)[c]));
    EXPECT_NEAR(mean.mean(), std::exp(-1.5 * sigma[c]), 2e-5);
  }
}

TEST(OneConnection, SameBits) { expectSameBits({kinoraStock_OneConnection()}, roomOfEverything(), "OneConnection"); }

}  // namespace
}  // namespace probes
}  // namespace kinora
