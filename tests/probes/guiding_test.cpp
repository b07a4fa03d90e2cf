// Path guiding and what it stands on, learning over epochs of samples: guided pictures have the mean of unguided ones in
// rooms of every kind of light and surface; bits do not depend on threads, widths, groups, parts or crops, since what a
// part leaves out is followed for the lesson, nor where samples are adaptive; a density that is not that of the directions
// is noticed; a picture of one pixel and one without light are drawn. Misses: how much guiding helps
// (docs/integrators.md).
#include <cmath>
#include <string>
#include <vector>

#include "tests/probes/probe_support.h"
#include "tests/probes/rooms.h"

namespace kinora {
const Descriptor* kinoraStock_WrongGuides();
}

namespace kinora::probes {
namespace {

constexpr int kGuidedSide = 32, kGuidedTile = 8, kGuidedSeeds = 16;
const char* const kGuided = "Integrator \"PxrPathTracer\" \"g\" \"int risPathGuiding\" [1]\n";

TileMoments tilesOf(Workshop& stage, const std::string& text, const char* integrator, uint32_t firstSeed,
                    std::vector<std::pair<std::string, std::string>> sets) {
  TileMoments r;
  render::Settings s;
  s.samplesPerPixel = 64;
  s.sets = std::move(sets);
  s.integrator = integrator;
  forSeeds(stage, text, s, firstSeed, kGuidedSeeds,
           [&](render::Renderer& renderer) { r.add(pictureOf(renderer), kGuidedSide, kGuidedSide, kGuidedTile); });
  return r;
}
TileMoments guidedTiles(const std::string& text, bool guided) {
  Workshop stage;
  return tilesOf(stage, text, "PxrPathTracer", guided ? 900 : 300,
                 {{"integrator.clampLuminance", "1e30"},
                  {"integrator.allowCaustics", "1"},
                  {"integrator.risPathGuiding", guided ? "1" : "0"},
                  {"integrator.guidingSamples", "16"}});
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

// What the tests above are worth: densities that are not those of the sampled directions.
TEST(Guiding, WrongDensityIsCaught) {
  const std::string text = room(std::string(kRect) + kSphere, kGrey);
  const TileMoments plain = guidedTiles(text, false);
  const auto withFactor = [&](const char* factor) {
    Workshop stage({kinoraStock_WrongGuides()});
    return compareTiles(tilesOf(stage, text, "WrongGuides", 900, {{"integrator.factor", factor}}), plain, 0.01);
  };
  const TileTest right = withFactor("1"), wrong = withFactor("1.5");
  EXPECT_TRUE(right.agrees()) << "worst z " << right.worstZ;
  EXPECT_FALSE(wrong.agrees()) << "worst z " << wrong.worstZ;
}

// Blocks that are done teach no more: what is learned follows from samples alone all the same.
TEST(Guiding, SameBitsWhereSamplesAreAdaptive) {
  const std::string text = room(std::string(kRect) + kSun, kGlass, kGuided);
  const auto filmOf = [&](int threads, uint32_t width, uint32_t groupSize, const char* guides = "1") {
    Workshop stage;
    render::Settings s;
    s.threads = threads;
    s.width = width;
    s.groupSize = groupSize;
    s.pixelVariance = 0.1f;
    s.mostSamples = 64;
    s.sets = {{"integrator.risPathGuiding", guides}, {"integrator.guidingSamples", "16"}};
    const auto r = stage.load(sceneOf(text, stage.messages), s);
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
    return stateOf(r->film());
  };
  const std::vector<int64_t> expected = filmOf(1, 8, 1024);
  EXPECT_NE(filmOf(1, 8, 1024, "0"), expected) << "guiding is on";
  EXPECT_EQ(filmOf(2, 4, 1024), expected);
  EXPECT_EQ(filmOf(2, 16, 256), expected);
}

TEST(Guiding, SameBits) {
  const std::string text = room(kRect, kGrey, kGuided);
  EXPECT_NE(stateWith(text, "risPathGuiding", "1"), stateWith(text, "risPathGuiding", "0")) << "guiding is on";
  expectSameBits({}, room(std::string(kRect) + kSun + kDome, kGlass, std::string(kLens) + kGuided), "");
}

// In a closed bright room paths have far more vertices than teach, and groups of few paths have few of them.
TEST(Guiding, SameBitsOfLongPaths) {
  const std::string text = std::string(kShown) + kGuided + R"(
Projection "perspective" "fov" [60]
Translate 0 0 1.5
WorldBegin
AttributeBegin Translate 0 1.9 0 Rotate 90 1 0 0 Scale .3 .3 .3 Light "PxrRectLight" "r" "float intensity" [8] AttributeEnd
Bxdf "PxrDiffuse" "d" "color diffuseColor" [0.9 0.9 0.9]
PointsPolygons [4 4 4 4 4 4] [0 1 2 3 1 5 6 2 3 2 6 7 0 4 7 3 4 5 1 0 4 5 6 7]
  "P" [-2 -2 2 2 -2 2 2 2 2 -2 2 2 -2 -2 -2 2 -2 -2 2 2 -2 -2 2 -2]
WorldEnd
)";
  expectSameBits({}, text, "");
}

// What lies beside a window, or was taken before a part, teaches all the same.
TEST(Guiding, CropsAreWhatTheyAreInTheWhole) {
  const std::string text = room(kRect, kGrey, kGuided);
  expectCropIsPartOfWhole(text, {0.3f, 0.7f, 0.25f, 0.6f});
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
