// The example of a bidirectional integrator against PxrPathTracer: equal means in rooms with every kind of light,
// glass, motion and a lens, for the picture and for channels by path; equal bits for threads, widths, groups and
// splits. It is the first user of stored vertices, connections and densities of lights through the whole renderer.
// What only connections to the camera find (caustics of lights that nothing can hit) is in neither picture.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_OneConnection();
namespace probes {
namespace {

constexpr int kSide = 32, kTile = 8, kSeeds = 24;

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
TEST(OneConnection, EqualsPathTracerBehindGlass) { expectSamePicture(roomBehindGlass(), 0.05); }
TEST(OneConnection, EqualsPathTracerInMotionThroughALens) { expectSamePicture(roomInMotionThroughALens(), 0.03); }

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
