// Path guiding and what it stands on, learning over epochs of samples: guided pictures have the mean of unguided ones in
// rooms of every kind of light and surface; bits do not depend on threads, widths, groups, parts or crops, since what a
// part leaves out is followed for the lesson; a picture of one pixel and one without light are drawn. Misses: how much
// guiding helps (docs/integrators.md).
#include <cmath>
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

constexpr int kGuidedSide = 32, kGuidedTile = 8, kGuidedSeeds = 16;
const char* const kGuided = "Integrator \"PxrPathTracer\" \"g\" \"int risPathGuiding\" [1]\n";

TileMoments guidedTiles(const std::string& text, bool guided) {
  Workshop stage;
  TileMoments r;
  for (uint32_t seed = 0; seed < kGuidedSeeds; ++seed) {
    render::Settings s;
    s.threads = 1;
    s.seed = (guided ? 900 : 300) + seed;
    s.samplesPerPixel = 64;
    s.sets = {{"integrator.clampLuminance", "1e30"},
              {"integrator.allowCaustics", "1"},
              {"integrator.risPathGuiding", guided ? "1" : "0"},
              {"integrator.guidingSamples", "16"}};
    s.integrator = "PxrPathTracer";
    const auto renderer = stage.load(sceneOf(text, stage.messages), s);
    r.add(pictureOf(*renderer), kGuidedSide, kGuidedSide, kGuidedTile);
  }
  return r;
}
void expectUnbiased(const std::string& text) {
  const TileMoments guided = guidedTiles(text, true), plain = guidedTiles(text, false);
  const TileTest t = compareTiles(guided, plain, 0.01);
  EXPECT_TRUE(t.agrees()) << "worst z " << t.worstZ << ", means " << guided.mean() << " and " << plain.mean();
  EXPECT_LT(t.meanError, 0.05) << "too few samples to judge";
  EXPECT_GT(plain.mean(), 0.01);
}
TEST(Guiding, UnbiasedUnderPointAndSun) { expectUnbiased(room(std::string(kPoint) + kSun, kGrey)); }
TEST(Guiding, UnbiasedUnderAreaLights) { expectUnbiased(room(std::string(kRect) + kSphere, kGrey)); }
TEST(Guiding, UnbiasedUnderDome) { expectUnbiased(room(kDome, kGrey)); }
TEST(Guiding, UnbiasedBesideGlass) { expectUnbiased(room(kRect, kGlass)); }

TEST(Guiding, SameBits) {
  const auto stateWith = [](const char* guiding) {
    Workshop stage;
    render::Settings s;
    s.threads = 1;
    s.sets = {{"integrator.risPathGuiding", guiding}};
    auto r = stage.load(sceneOf(room(kRect, kGrey, kGuided), stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete);
    return stateOf(r->film());
  };
  EXPECT_NE(stateWith("1"), stateWith("0")) << "guiding is on";
  expectSameBits({}, room(std::string(kRect) + kSun + kDome, kGlass, std::string(kLens) + kGuided), "");
}

// What lies beside a window, or was taken before a part, teaches all the same.
TEST(Guiding, CropsAreWhatTheyAreInTheWhole) {
  const std::string text = room(kRect, kGrey, kGuided);
  const auto render = [&](std::array<float, 4> crop) {
    Workshop stage;
    render::Settings s;
    s.threads = 2;
    s.crop = crop;
    auto r = stage.load(sceneOf(text, stage.messages), s);
    return pictureOf(*r);
  };
  const image::Image whole = render({-1, -1, -1, -1}), part = render({0.3f, 0.7f, 0.25f, 0.6f});
  ASSERT_GT(part.width(), 4);
  ASSERT_LT(part.width(), whole.width());
  int compared = 0, differ = 0;
  for (int y = part.data.y0; y < part.data.y1; ++y)
    for (int x = part.data.x0; x < part.data.x1; ++x, ++compared)
      for (int k = 0; k < 3; ++k) differ += part.at(x, y)[k] != whole.at(x, y)[k];
  EXPECT_GT(compared, 40);
  EXPECT_EQ(differ, 0);
}

TEST(Guiding, OnePixelAndNoLight) {
  for (const bool lit : {true, false}) {
    Workshop stage;
    render::Settings s;
    s.threads = 1;
    s.samplesPerPixel = 64;
    s.resolution = {1, 1};
    auto r = stage.load(sceneOf(room(lit ? kRect : "", kGrey, kGuided), stage.messages), s);
    const image::Image picture = pictureOf(*r);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(picture.at(0, 0)[k]));
    EXPECT_EQ(picture.at(0, 0)[0] > 0, lit);
  }
}

}  // namespace
}  // namespace kinora::probes
