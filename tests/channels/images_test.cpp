// Proves, end to end through files: exposure, quantisation and dither in the written pictures; a channel with a
// filter of its own equals a render with that filter; variance and mse foretell the spread between renders with other
// seeds; half buffers average to the whole. Misses: drivers but openexr and png.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

// Noise of known size: a floor under a small bright light and a half shadowed corner.
RenderRequest noisy(const std::string& channels, const std::string& options, int samples) {
  RenderRequest r;
  r.rib =
      "Hider \"raytrace\" \"int maxsamples\" [64]\nFormat 24 24 1\nIntegrator \"PxrPathTracer\" \"i\" \"int "
      "maxIndirectBounces\" [1]\n" +
      options +
      "Projection \"perspective\" \"fov\" [50]\nTranslate 0 -1 4\nWorldBegin\nAttributeBegin\nConcatTransform [1 0 0 "
      "0  0 0 1 0  0 -1 0 0  0 2.5 0 1]\n"
      "Light \"PxrRectLight\" \"key\" \"float intensity\" [6]\nAttributeEnd\nBxdf \"PxrDiffuse\" \"floor\" \"color "
      "diffuseColor\" [0.5 0.5 0.5]\n"
      "Polygon \"vertex point P\" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]\nPolygon \"vertex point P\" [-3 0 1  3 0 1  3 3 1 "
      " -3 3 1]\n"
      "Polygon \"vertex point P\" [-0.5 0.6 -0.5  0.5 0.6 -0.5  0.5 0.6 0.5  -0.5 0.6 0.5]\nWorldEnd\n";
  r.channels = channels;
  r.settings.samplesPerPixel = samples;
  return r;
}

TEST(ChannelStatistics, MseIsTheSpreadBetweenRenders) {
  const std::string declared =
      "PixelFilter \"box\" 1 1\nDisplayChannel \"color var\" \"string source\" [\"Ci\"] \"string statistics\" "
      "[\"variance\"]\n"
      "DisplayChannel \"color mse\" \"string source\" [\"Ci\"] \"string statistics\" [\"mse\"]\n";
  constexpr int kSeeds = 64, kSamples = 16;
  std::vector<testing::Moments> spread;
  double claimed = 0, variance = 0;
  size_t values = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    RenderRequest q = noisy("Ci,var,mse", declared, kSamples);
    q.settings.seed = uint32_t(seed + 1);
    SceneRender r(q);
    ASSERT_TRUE(r.ok());
    const image::Image ci = r.channel("Ci"), mse = r.channel("mse"), var = r.channel("var");
    spread.resize(ci.pixels.size());
    values = ci.pixels.size();
    for (size_t i = 0; i < values; ++i) {
      spread[i].add(double(ci.pixels[i]));
      claimed += double(mse.pixels[i]) / kSeeds;
      variance += double(var.pixels[i]) / kSeeds;
      EXPECT_FLOAT_EQ(mse.pixels[i] * kSamples, var.pixels[i]);
    }
  }
  double found = 0;
  for (const testing::Moments& m : spread) found += std::pow(m.standardError(), 2) * kSeeds;
  // samples of a pixel are stratified against each other: the mean is better than independent samples would make it,
  // never worse; 1,728 pixel values of 64 renders know the spread to 1 %
  EXPECT_LT(found, 1.05 * claimed);
  EXPECT_GT(found, 0.02 * claimed);
  EXPECT_GT(claimed, 1e-5);
  EXPECT_NEAR(variance, claimed * kSamples, 1e-4 * variance);
}

TEST(ChannelStatistics, HalvesAverageToTheWhole) {
  SceneRender r(noisy("Ci,even,odd",
                      "PixelFilter \"gaussian\" 2 2\nDisplayChannel \"color even\" \"string source\" [\"Ci\"] "
                      "\"string statistics\" [\"even\"]\n"
                      "DisplayChannel \"color odd\" \"string source\" [\"Ci\"] \"string statistics\" [\"odd\"]\n",
                      16));
  ASSERT_TRUE(r.ok());
  const image::Image ci = r.channel("Ci"), even = r.channel("even"), odd = r.channel("odd");
  bool differ = false;
  for (size_t i = 0; i < ci.pixels.size(); ++i) {
    EXPECT_NEAR(0.5f * (even.pixels[i] + odd.pixels[i]), ci.pixels[i], 1e-6f * std::fabs(ci.pixels[i]) + 1e-7f);
    differ |= even.pixels[i] != odd.pixels[i];
  }
  EXPECT_TRUE(differ);
}

// A channel with its own filter in a frame of another against a frame of that filter.
TEST(ChannelFilters, AreWhatAFrameOfThatFilterIs) {
  testing::Moments a, b;
  double worstPixel = 0;
  for (uint32_t seed = 1; seed <= 8; ++seed) {
    RenderRequest wide = noisy("Ci,sharp",
                               "PixelFilter \"gaussian\" 3 3\nDisplayChannel \"color sharp\" \"string source\" "
                               "[\"Ci\"] \"string filter\" [\"box\"] \"float[2] filterwidth\" [1 1]\n",
                               64);
    RenderRequest box = noisy("Ci", "PixelFilter \"box\" 1 1\n", 64);
    wide.settings.seed = seed;
    box.settings.seed = seed + 50;
    SceneRender x(wide), y(box);
    ASSERT_TRUE(x.ok() && y.ok());
    EXPECT_TRUE(x.messages().empty()) << x.messages()[0];
    a.add(overPixels(x.channel("sharp")).mean());
    b.add(overPixels(y.channel("Ci")).mean());
    // the edge of the card blurs over more pixels in the wide filter
    const image::Image sharp = x.channel("sharp"), soft = x.channel("Ci"), other = y.channel("Ci");
    double toSharp = 0, toSoft = 0;
    for (size_t i = 0; i < other.pixels.size(); ++i) {
      toSharp += std::fabs(double(sharp.pixels[i] - other.pixels[i]));
      toSoft += std::fabs(double(soft.pixels[i] - other.pixels[i]));
    }
    worstPixel = std::max(worstPixel, toSharp / toSoft);
  }
  EXPECT_SAME_MEAN(a, b, 0.01);
  EXPECT_LT(worstPixel, 0.7);
}

}  // namespace
}  // namespace kinora::tests
