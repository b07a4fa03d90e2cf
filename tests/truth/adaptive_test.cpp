// Proves: adaptive sampling. Its estimate of a block's error against closed form, of a picture's against two seeds;
// decisions that no thread, width, group, bucket order, cut pass or (block by block) crop changes; samples where the
// noise is, fewer where objects tolerate it, and where they help the picture most; means that stay; how scenes and
// settings ask for it. Misses: light stages beside it, error of channels other than the first colour.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/adaptive.h"
#include "render/frame.h"
#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

using render::ActivePixels;
using render::NoiseEstimate;

TEST(Adaptive, BlocksCoverTheWindow) {
  ActivePixels b(image::Window{5, 3, 18, 9});
  EXPECT_EQ(b.blocks(), 12u);  // columns 1 to 4, rows 0 to 2
  EXPECT_EQ(b.count(), 78u);
  EXPECT_EQ(b.activeIn(4, 0), ActivePixels::kAll) << "pixels beside the window too, in a block that touches it";
  EXPECT_EQ(b.activeIn(0, 4), 0);
  EXPECT_EQ(b.activeIn(20, 4), 0);
  EXPECT_EQ(b.activeIn(-1, 4), 0);
  const auto corner = size_t(b.indexOf(4, 0));
  EXPECT_EQ(b.inWindow(corner), 0xe000) << "three of the last row";
  b.stop(corner, 0x4001);
  b.stop(corner, 0x4001);
  EXPECT_EQ(b.count(), 77u) << "the other pixel is beside the window";
  EXPECT_EQ(b.active(corner), 0xbffe);
  b.stop(corner);
  EXPECT_EQ(b.count(), 75u) << "3 x 1 pixels of the corner, once";
  EXPECT_FALSE(b.anyIn(4, 0, 8, 4));
  EXPECT_TRUE(b.anyIn(4, 0, 12, 4));
  EXPECT_EQ(ActivePixels(image::Window{}).blocks(), 0u);
}

TEST(Adaptive, DecisionsFallOnPowersOfTwoAndHalfway) {
  std::vector<int> at;
  for (int n = -3; n <= 100; ++n)
    if (render::isDecisionPoint(n)) at.push_back(n);
  EXPECT_EQ(at, (std::vector<int>{1, 2, 4, 8, 16, 32, 48, 64, 96}));
  // where cut passes end is no matter, where whole ones end is: each decision is the end of one
  for (const int n : at) {
    bool isEnd = false;
    for (const auto& [from, to] : render::Frame::passes(0, 100)) isEnd |= to == n;
    EXPECT_TRUE(isEnd || n > 96) << n;
  }
}

// Samples of known variance: the mean over many blocks of the squared estimate is that of the mean of all samples,
// also where the halves have different counts.
TEST(Adaptive, EstimateIsTheErrorOfTheMean) {
  constexpr size_t kBlocks = 2000;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.f, 2.f);  // mean 1, variance 1/3
  for (const int samples : {2, 5, 16, 33}) {
    NoiseEstimate noise(kBlocks);
    const int earlier = (samples + 1) / 2;
    for (int s = 0; s < samples; ++s) {
      if (s == earlier) noise.endPart();
      for (size_t b = 0; b < kBlocks; ++b)
        for (int pixel = 0; pixel < 16; ++pixel) {
          const float rgb[3] = {uniform(random), uniform(random), uniform(random)};
          noise.add(b, pixel, rgb, 1);
        }
    }
    testing::Moments squares;
    int taken[ActivePixels::kPixels];
    std::fill_n(taken, ActivePixels::kPixels, samples);
    for (size_t b = 0; b < kBlocks; ++b) {
      // far above the level, the floor makes the deviation absolute
      double e[ActivePixels::kPixels], mean = 0;
      noise.squaredDeviations(b, earlier, samples - earlier, taken, 1e6f, e);
      for (const double x : e) mean += x * (1e6 + 1) * (1e6 + 1) / ActivePixels::kPixels;
      squares.add(mean);
    }
    EXPECT_NEAR(squares.mean() * samples * 3, 1, 4 * squares.standardError() * samples * 3 + 1e-4) << samples;
    EXPECT_LT(squares.standardError() * samples * 3, 0.02);
  }
  NoiseEstimate odd(1);
  const float bad[3] = {NAN, INFINITY, -INFINITY};
  const int taken[ActivePixels::kPixels] = {2};
  double e[ActivePixels::kPixels];
  odd.add(0, 0, bad, 1);
  odd.endPart();
  odd.add(0, 0, bad, 1);
  odd.squaredDeviations(0, 1, 1, taken, 0.1f, e);
  EXPECT_TRUE(std::isfinite(e[0]));
  odd.squaredDeviations(0, 1, 0, taken, 0.1f, e);
  EXPECT_TRUE(std::isinf(e[0])) << "one part alone says nothing";
}

// Pixels of one block that ended at other times: their level counts by the samples that each has.
TEST(Adaptive, PixelsOfABlockHaveSamplesOfTheirOwn) {
  NoiseEstimate noise(1);
  int taken[ActivePixels::kPixels];
  const float two[3] = {2, 2, 2}, four[3] = {4, 4, 4};
  for (int pixel = 0; pixel < ActivePixels::kPixels; ++pixel) {
    taken[pixel] = pixel < 8 ? 4 : 8;
    for (int s = 0; s < 4; ++s) noise.add(0, pixel, two, 1);
  }
  noise.endPart();
  for (int pixel = 8; pixel < ActivePixels::kPixels; ++pixel)
    for (int s = 0; s < 4; ++s) noise.add(0, pixel, four, 1);
  double e[ActivePixels::kPixels];
  noise.squaredDeviations(0, 4, 4, taken, 0.5f, e);
  // parts of 2 and 4: half their difference is 1; levels of 2 and 3, and the floor
  EXPECT_NEAR(e[12], 1 / (3.0 * 3.0), 1e-6);
}

// Left half a lamp seen directly, without noise; right half a floor in a soft shadow.
std::string scene(const std::string& options) {
  return "Format 32 24 1\n" + options +
         "Projection \"perspective\" \"fov\" [50]\nIntegrator \"PxrPathTracer\" \"i\"\nWorldBegin\n"
         "AttributeBegin\nTranslate 0 3 4\nRotate 90 1 0 0\nLight \"PxrRectLight\" \"l\" \"float intensity\" [4]\n"
         "AttributeEnd\nAttributeBegin\nBxdf \"PxrConstant\" \"c\" \"color emitColor\" [.5 .4 .3]\n"
         "Polygon \"P\" [-9 -9 3  -9 9 3  0 9 3  0 -9 3]\nAttributeEnd\n"
         "Bxdf \"PxrDiffuse\" \"d\"\nPolygon \"P\" [-20 -1 0  -20 -1 40  20 -1 40  20 -1 0]\n"
         "Translate .8 .4 4\nSphere .5 -.5 .5 360\nWorldEnd\n";
}
RenderRequest request(float variance, int most = 128) {
  RenderRequest r;
  r.rib = scene("");
  r.channels = "Ci,a,sampleCount";
  r.settings.pixelVariance = variance;
  r.settings.mostSamples = most;
  return r;
}

TEST(Adaptive, NothingButTheSamplesDecides) {
  SceneRender base(request(0.05f));
  ASSERT_TRUE(base.ok());
  const std::vector<int64_t> state = stateOf(base.film());
  std::vector<std::pair<const char*, RenderRequest>> others;
  const auto other = [&](const char* name) -> render::Settings& {
    others.emplace_back(name, request(0.05f));
    return others.back().second.settings;
  };
  other("threads").threads = 2;
  other("width 1").width = 1;
  other("width 8").width = 8;
  other("groups").groupSize = 64;
  other("buckets").bucketOrder = "random";
  other("cut passes").snapshotSeconds = 1e-6;
  for (auto& [name, r] : others) {
    SceneRender render(r);
    ASSERT_TRUE(render.ok()) << name;
    EXPECT_EQ(stateOf(render.film()), state) << name;
  }
  // windows that cut blocks
  for (const std::array<float, 4>& crop :
       {std::array<float, 4>{0.3f, 0.8f, 0.15f, 0.65f}, std::array<float, 4>{0.f, 0.53f, 0.4f, 0.47f}}) {
    RenderRequest r = request(0.05f);
    r.settings.crop = crop;
    SceneRender part(r);
    ASSERT_TRUE(part.ok());
    const image::Window w = part.film().window();
    for (int y = w.y0; y < w.y1; ++y)
      for (int x = w.x0; x < w.x1; ++x)
        EXPECT_TRUE(std::equal(part.film().pixel(x, y), part.film().pixel(x, y) + part.film().slots(),
                               base.film().pixel(x, y)))
            << x << ' ' << y;
  }
}

TEST(Adaptive, SamplesGoWhereTheNoiseIs) {
  SceneRender render(request(0.03f, 256));
  ASSERT_TRUE(render.ok());
  int64_t total = 0;
  int most = 0;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x) {
      const int n = int(render.film().sampleCount(x, y));
      total += n;
      most = std::max(most, n);
      EXPECT_TRUE(n >= 16 && n <= 256 && (n == 256 || render::isDecisionPoint(n))) << n;
      if (x < 12 && y < 12) {
        EXPECT_EQ(n, 16) << x << ' ' << y << ": a lamp has no noise";
      }
    }
  EXPECT_GT(most, 16);
  EXPECT_EQ(render.renderer().statistics().samples, uint64_t(total));
  EXPECT_GT(render.renderer().statistics().donePixels, 12u * 12);
  // the count is a channel too
  const image::Image counts = render.channel("sampleCount");
  EXPECT_NEAR(overPixels(counts).mean() * 32 * 24, double(total), 1e-6);
}

// Blocks that end where few samples happen to agree take the mean with them: the bias stays small beside the error
// that was asked for.
TEST(Adaptive, MeansStay) {
  RenderRequest fixed;
  fixed.rib = scene("");
  fixed.settings.samplesPerPixel = 64;
  const testing::Moments truth = overSeeds(fixed, 8);
  for (const float variance : {0.2f, 0.05f}) {
    const testing::Moments m = overSeeds(request(variance), 16);
    const double bias = m.mean() / truth.mean() - 1,
                 error = std::hypot(m.standardError(), truth.standardError()) / truth.mean();
    RecordProperty("bias_" + std::to_string(variance), std::to_string(bias));
    EXPECT_LE(std::abs(bias), 4 * error + 0.05 * double(variance)) << "standard error " << error;
    EXPECT_LE(error, 0.02 * double(variance)) << "too few samples to judge";
  }
}

// The relative error of a picture in two renders that know nothing of each other, as Convergence::error() means it.
double errorOf(SceneRender& a, SceneRender& b) {
  const image::Image x = a.channel("Ci"), y = b.channel("Ci");
  double squares = 0;
  for (int by = 0; by < 24; by += 4)
    for (int bx = 0; bx < 32; bx += 4) {
      double difference = 0, level = 0;
      for (int p = 0; p < 16; ++p)
        for (int c = 0; c < 3; ++c) {
          const double u = double(x.at(bx + p % 4, by + p / 4)[c]), v = double(y.at(bx + p % 4, by + p / 4)[c]);
          difference += (u - v) * (u - v) / 2 / 48;
          level += (std::fabs(u) + std::fabs(v)) / 2 / 48;
        }
      squares += difference / ((level + 0.025) * (level + 0.025)) / 48;
    }
  return std::sqrt(squares);
}
RenderRequest withError(float error, uint32_t seed = 0) {
  RenderRequest r = request(-1, 0);
  r.settings.pictureError = error;
  r.settings.seed = seed;
  return r;
}

TEST(Adaptive, APictureHasTheErrorAskedFor) {
  for (const float wanted : {0.1f, 0.04f, 0.02f}) {
    SceneRender one(withError(wanted, 5)), two(withError(wanted, 6));
    ASSERT_TRUE(one.ok() && two.ok());
    const double truth = errorOf(one, two), said = one.renderer().statistics().noise;
    EXPECT_LE(said, double(wanted) * 1.0001);
    // 1.5 is what a user may rely on; 48 blocks of two pictures tell the root within some 10 %
    EXPECT_GT(said, truth / 1.5);
    EXPECT_LT(said, truth * 1.5);
    EXPECT_GT(truth, double(wanted) / 3) << "so many samples were not asked for";
    EXPECT_TRUE(one.messages().empty());
  }
}

TEST(Adaptive, SamplesForAPictureAreSpentBest) {
  SceneRender one(withError(0.03f, 7)), two(withError(0.03f, 8));
  ASSERT_TRUE(one.ok() && two.ok());
  const auto samples = int(one.renderer().statistics().samples / (32 * 24));
  RenderRequest evenly = request(-1, 0);
  evenly.settings.samplesPerPixel = samples;
  evenly.settings.seed = 9;
  SceneRender a(evenly);
  evenly.settings.seed = 10;
  SceneRender b(evenly);
  ASSERT_TRUE(a.ok() && b.ok());
  const double adaptive = errorOf(one, two), fixed = errorOf(a, b);
  EXPECT_LT(adaptive, 0.8 * fixed) << samples << " samples a pixel; half of the picture has no noise";
}

TEST(Adaptive, ThePicturesErrorDecidesByTheSamplesAlone) {
  SceneRender base(withError(0.05f));
  ASSERT_TRUE(base.ok());
  const std::vector<int64_t> state = stateOf(base.film());
  for (int k = 0; k < 5; ++k) {
    RenderRequest r = withError(0.05f);
    if (k == 0) r.settings.threads = 2;
    if (k == 1) r.settings.width = 1;
    if (k == 2) r.settings.groupSize = 64;
    if (k == 3) r.settings.bucketOrder = "random";
    if (k == 4) r.settings.snapshotSeconds = 1e-6;
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_EQ(stateOf(render.film()), state) << k;
  }
}

TEST(Adaptive, AnErrorThatIsNotReachedIsTold) {
  RenderRequest r = withError(0.001f);
  r.settings.mostSamples = 40;
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  ASSERT_EQ(render.messages().size(), 1u);
  EXPECT_NE(render.messages()[0].find("RENDER-NOISE"), std::string::npos) << render.messages()[0];
  EXPECT_EQ(render.film().sampleCount(16, 20), 40);
  RenderRequest colourless = withError(0.1f);
  colourless.channels = "z,a";
  SceneRender other(colourless);
  ASSERT_TRUE(other.ok());
  ASSERT_EQ(other.messages().size(), 1u);
  EXPECT_NE(other.messages()[0].find("RENDER-ADAPTIVE"), std::string::npos) << other.messages()[0];
  EXPECT_EQ(other.film().sampleCount(16, 20), 64);
}

// The floor may have more noise than the ball.
TEST(Adaptive, ObjectsTolerateNoise) {
  const auto floorSamples = [](const std::string& attribute) {
    RenderRequest r = request(0.03f, 512);
    const size_t at = r.rib.find("Bxdf \"PxrDiffuse\"");
    r.rib.insert(at, attribute);
    SceneRender render(r);
    int64_t total = 0;
    for (int y = 20; render.ok() && y < 24; ++y)
      for (int x = 0; x < 32; ++x) total += render.film().sampleCount(x, y);
    return double(total);
  };
  const double usual = floorSamples(""),
               more = floorSamples("Attribute \"shade\" \"float relativepixelvariance\" [3]\n");
  EXPECT_LT(more, 0.4 * usual) << "about a ninth, down to the least number of samples";
  EXPECT_EQ(floorSamples("Attribute \"shade\" \"float relativepixelvariance\" [1]\n"), usual);
  EXPECT_EQ(floorSamples("Attribute \"shade\" \"float relativepixelvariance\" [-1]\n"), usual) << "no tolerance";
}

int64_t countAt(const RenderRequest& r, int x, int y) {
  SceneRender render(r);
  return render.ok() ? render.film().sampleCount(x, y) : -1;
}

TEST(Adaptive, WhoAsksForIt) {
  const auto ofScene = [](const std::string& options) {
    RenderRequest r;
    r.rib = scene(options);
    return r;
  };
  EXPECT_EQ(countAt(ofScene("Hider \"raytrace\" \"int maxsamples\" [40]\n"), 2, 2), 40) << "nobody";
  EXPECT_EQ(countAt(ofScene("Hider \"raytrace\" \"int maxsamples\" [40]\nPixelVariance .05\n"), 2, 2), 16);
  EXPECT_EQ(countAt(ofScene("Hider \"raytrace\" \"int maxsamples\" [40]\nPixelVariance 0\n"), 2, 2), 40);
  EXPECT_EQ(
      countAt(ofScene("Hider \"raytrace\" \"int maxsamples\" [40] \"int minsamples\" [24] \"float pixelvariance\" "
                      "[.05]\n"),
              2, 2),
      32)
      << "the first decision from the least on";
  EXPECT_EQ(
      countAt(ofScene("Hider \"raytrace\" \"int maxsamples\" [40] \"int minsamples\" [20]\nPixelVariance .05\n"), 2,
              2),
      32)
      << "the decision after the least";
  RenderRequest r = ofScene("Hider \"raytrace\" \"int maxsamples\" [40]\nPixelVariance .05\n");
  r.settings.samplesPerPixel = 20;
  EXPECT_EQ(countAt(r, 2, 2), 20) << "--spp";
  r.settings.samplesPerPixel = 0;
  r.settings.firstSample = 8;
  r.settings.lastSample = 40;
  SceneRender part(r);
  ASSERT_TRUE(part.ok());
  EXPECT_EQ(part.film().sampleCount(2, 2), 32) << "a part of the samples";
  ASSERT_EQ(part.messages().size(), 1u);
  EXPECT_NE(part.messages()[0].find("RENDER-ADAPTIVE"), std::string::npos) << part.messages()[0];
  SceneRender above(
      ofScene("Hider \"raytrace\" \"int maxsamples\" [20] \"int minsamples\" [30]\nPixelVariance .05\n"));
  ASSERT_TRUE(above.ok());
  EXPECT_EQ(above.film().sampleCount(2, 2), 20);
  ASSERT_EQ(above.messages().size(), 1u);
  EXPECT_NE(above.messages()[0].find("RENDER-ADAPTIVE"), std::string::npos) << above.messages()[0];
}

}  // namespace
}  // namespace kinora::tests
