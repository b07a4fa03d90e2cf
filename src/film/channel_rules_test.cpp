// Proves: variances, filters of channels' own, remap, exposure and quantisation do what their closed forms say, keep
// their bits in any order of adding, and survive shards. Misses: how good an estimate a variance is.
#include <gtest/gtest.h>
#include <kinora/math/srgb.h>

#include <cmath>
#include <random>

#include "film/display_plan.h"
#include "film/filter_ratio.h"
#include "film/film_test_samples.h"

namespace kinora::film {
namespace {

using test::makeFilm;
using test::Samples;

TEST(ChannelStatistics, VarianceAndItsMeanFromTheSamples) {
  ChannelLayout layout;
  Channel c = colorChannel("var", "Ci");
  c.statistic = Statistic::Variance;
  ASSERT_EQ(layout.add(colorChannel("Ci")), 0);
  ASSERT_EQ(layout.add(c), 1);
  c.name = "mse";
  c.statistic = Statistic::MeanVariance;
  ASSERT_EQ(layout.add(c), 2);
  Channel z = depthChannel("zvar", "zfiltered");
  z.reducer = Reducer::Average;
  z.statistic = Statistic::Variance;
  ASSERT_EQ(layout.add(z), 3);
  auto film = makeFilm(2, 1, layout);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0, 2);
  Samples s(layout.recordFloats());
  constexpr int kCount = 64;
  double sum[4] = {}, squares[4] = {};
  for (int i = 0; i < kCount; ++i) {
    std::vector<float> record{uniform(random), 10 * uniform(random), 0.01f, 1000 * uniform(random)};
    s.add(0, 0, uint32_t(i), i % 8 == 0 ? -0.25f : 1.1f, record);
    for (int k = 0; k < 4; ++k) {
      const double y = double(record[size_t(k)]) * (k == 3 ? 1.0 : i % 8 == 0 ? -0.25 : double(1.1f));
      sum[k] += y;
      squares[k] += y * y;
    }
  }
  s.addTo(*film);
  float out[4], mse[4], depth[1];
  film->resolvePixel(1, 0, 0, out);
  film->resolvePixel(2, 0, 0, mse);
  film->resolvePixel(3, 0, 0, depth);
  for (int k = 0; k < 3; ++k) {
    const double v = (squares[k] - sum[k] * sum[k] / kCount) / (kCount - 1);
    EXPECT_NEAR(out[k], v, 1e-6 * v + 1e-8) << k;
    EXPECT_FLOAT_EQ(mse[k], out[k] / kCount);
  }
  const double v = (squares[3] - sum[3] * sum[3] / kCount) / (kCount - 1);
  EXPECT_NEAR(depth[0], v, 1e-5 * v);
  film->resolvePixel(1, 1, 0, out);
  EXPECT_EQ(out[0], 0) << "a pixel without samples";
}

TEST(ChannelStatistics, OrderAndMergingDoNotMatter) {
  ChannelLayout layout;
  layout.add(colorChannel("Ci"));
  Channel c = colorChannel("mse", "Ci");
  c.statistic = Statistic::MeanVariance;
  layout.add(c);
  Channel own = colorChannel("own", "Ci");
  own.filter = {"box", 1, 1};
  layout.add(own);
  own.name = "ownEven";
  own.half = Half::Even;
  layout.add(own);
  Channel remapped = colorChannel("calm", "Ci");
  remapped.remap = {1, 2, 100};
  layout.add(remapped);
  ASSERT_EQ(layout.size(), 5);
  EXPECT_EQ(layout.filters().size(), 1u);
  const Samples s = test::randomSamples(layout, {0, 0, 5, 3}, 8, 2);
  auto a = makeFilm(5, 3, layout), b = makeFilm(5, 3, layout), c1 = makeFilm(5, 3, layout);
  s.addTo(*a);
  std::vector<int> order = s.inOrder();
  std::shuffle(order.begin(), order.end(), std::mt19937(9));
  s.addTo(*b, order, 0, 40);
  s.addTo(*c1, order, 40, order.size());
  ASSERT_TRUE(b->merge(*c1).ok());
  EXPECT_TRUE(test::sameState(*a, *b));
}

TEST(ChannelLayout, RefusesRulesThatCannotBe) {
  ChannelLayout layout;
  Channel c = colorChannel("a");
  c.statistic = Statistic::Variance;
  c.half = Half::Even;
  EXPECT_EQ(layout.add(c), -1);
  c.half = Half::Both;
  c.reducer = Reducer::ZMin;
  EXPECT_EQ(layout.add(c), -1);
  c = colorChannel("b");
  c.remap = {2, 1, 3};
  EXPECT_EQ(layout.add(c), -1);
  for (int i = 0; i < ChannelLayout::kMaxFilters + 1; ++i) {
    c = colorChannel("f" + std::to_string(i));
    c.filter = {"box", 1 + float(i), 1};
    EXPECT_EQ(layout.add(c), i < ChannelLayout::kMaxFilters ? i : -1);
  }
}

// A smooth function of the place, through samples of one filter weighed for another, against its integral.
TEST(FilterRatio, WeighsSamplesOfOneFilterForAnother) {
  const auto f = [](double x, double y) { return 1 + 0.5 * x + 0.3 * y * y + 0.2 * x * y; };
  const std::tuple<const char*, float, const char*, float> pairs[] = {
      {"gaussian", 2, "box", 1},    {"gaussian", 3, "triangle", 2}, {"mitchell", 4, "gaussian", 2},
      {"box", 3, "catmull-rom", 3}, {"disk", 2, "box", 1},          {"catmull-rom", 4, "disk", 2}};
  for (const auto& [frameName, frameWidth, ownName, ownWidth] : pairs) {
    PixelFilter frame, own;
    ASSERT_TRUE(PixelFilter::make(frameName, frameWidth, frameWidth, frame).ok());
    ASSERT_TRUE(PixelFilter::make(ownName, ownWidth, ownWidth, own).ok());
    const FilterRatio ratio(frame, own);
    EXPECT_GT(ratio.covered(), 0.98) << frameName << ' ' << ownName;
    double sum = 0, weights = 0, expected = 0, norm = 0;
    constexpr int n = 512;  // a multiple of the cells: their weights are averaged evenly
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const float u = (float(i) + 0.5f) / n, v = (float(j) + 0.5f) / n;
        const FilterSample s = frame.sample(u, v);
        const double w = double(ratio.weight(u, v));
        sum += w * f(double(s.dx), double(s.dy));
        weights += w;
        const double x = (double(u) - 0.5) * double(ownWidth), y = (double(v) - 0.5) * double(ownWidth);
        expected += own.evaluate(x, y) * f(x, y);
        norm += own.evaluate(x, y);
      }
    EXPECT_NEAR(sum / weights, expected / norm, 4e-3) << frameName << " for " << ownName;
    EXPECT_NEAR(weights / (double(n) * n), 1, 2e-3);
  }
  PixelFilter narrow, wide;
  ASSERT_TRUE(PixelFilter::make("box", 1, 1, narrow).ok());
  ASSERT_TRUE(PixelFilter::make("gaussian", 3, 3, wide).ok());
  EXPECT_LT(FilterRatio(narrow, wide).covered(), 0.7);
}

TEST(Remap, CompressesAndExpands) {
  const std::array<float, 3> r{1, 2, 50};
  EXPECT_EQ(compress(0.7f, r), 0.7f);
  EXPECT_NEAR(compress(50, r), 2, 1e-6);
  EXPECT_NEAR(compress(1.001f, r), 1.001f, 1e-5) << "slope 1 where it begins";
  float before = 0;
  for (const float x : {0.f, 0.5f, 1.f, 1.5f, 3.f, 10.f, 100.f, 1e4f}) {
    const float y = compress(x, r);
    EXPECT_GE(y, before);
    EXPECT_NEAR(expand(y, r), x, 2e-3f * x);
    before = y;
  }
  std::array<float, 3> back;
  EXPECT_EQ(sourceBehind(remappedSource("lpe:C.*L", r), back), "lpe:C.*L");
  EXPECT_EQ(back, r);
  EXPECT_EQ(sourceBehind("Ci", back), "Ci");
  EXPECT_EQ(back[2], 0);
}

TEST(DisplayValues, ExposureQuantisationAndDither) {
  DisplayValues v;
  v.gain = 2;
  v.gamma = 2;
  EXPECT_FLOAT_EQ(displayed(0.5f, v, true, 0, true, 0, 0, 0), 1);
  EXPECT_FLOAT_EQ(displayed(0.125f, v, true, 0, true, 0, 0, 0), 0.5f);
  EXPECT_EQ(displayed(0.125f, v, false, 0, false, 0, 0, 0), 0.125f) << "data is not exposed";
  // a driver that encodes as sRGB stores what the gamma says, not both curves: 0.5 is encoded from 0.21404
  EXPECT_NEAR(displayed(0.125f, v, true, 255, true, 0, 0, 0), 0.21404f, 1e-5);
  v = {};
  v.one = 4;
  v.most = 4;
  EXPECT_EQ(displayed(0.6f, v, true, 0, true, 0, 0, 0), 0.5f) << "4 steps";
  EXPECT_EQ(displayed(7.f, v, true, 0, true, 0, 0, 0), 1.f);
  EXPECT_EQ(displayed(-1.f, v, true, 0, true, 0, 0, 0), 0.f);
  // dither keeps the mean
  v.dither = 0.5f;
  double sum = 0;
  int low = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      const float d = displayed(0.6f, v, true, 0, true, x, y, 0);
      low += d == 0.5f;
      EXPECT_TRUE(d == 0.5f || d == 0.75f);
      EXPECT_EQ(d, displayed(0.6f, v, true, 0, true, x, y, 0));
      sum += double(d);
    }
  EXPECT_NEAR(sum / 1e4, 0.6, 0.005);
  EXPECT_GT(low, 5000);
  // for a driver that rounds to 8 bits of sRGB itself
  v = {};
  v.dither = 0.5f;
  sum = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) sum += double(displayed(0.2f, v, true, 255, true, x, y, 1));
  EXPECT_NEAR(sum / 1e4, 0.2, 2e-4);
}

// quantize [zero one min max]: 1 becomes the code `one`, whatever the file could hold, and codes stay within
// min..max.
TEST(DisplayValues, OneBecomesTheCodeOfThatName) {
  const SrgbEncoder bytes(256), shorts(65536);
  const auto code = [&](float value, std::array<float, 4> q, int most, bool isColor) {
    DisplayValues v;
    v.zero = q[0], v.one = q[1], v.least = q[2], v.most = q[3];
    const float out = displayed(value, v, isColor, float(most), isColor, 0, 0, 0);
    return int(!isColor ? quantizeLinear(out, uint32_t(most)) : most == 255 ? bytes.encode(out) : shorts.encode(out));
  };
  EXPECT_EQ(code(1, {0, 200, 0, 255}, 255, true), 200);
  EXPECT_EQ(code(1, {0, 200, 0, 255}, 255, false), 200);
  EXPECT_EQ(code(1.2f, {0, 200, 0, 255}, 255, false), 240) << "there is room above one";
  EXPECT_EQ(code(5, {0, 200, 0, 255}, 255, false), 255);
  EXPECT_EQ(code(5, {0, 200, 0, 235}, 255, true), 235);
  EXPECT_EQ(code(0, {16, 235, 16, 235}, 255, false), 16);
  EXPECT_EQ(code(0, {16, 235, 16, 235}, 255, true), 16);
  EXPECT_EQ(code(1, {0, 1023, 0, 1023}, 65535, true), 1023) << "ten bits in sixteen";
  EXPECT_EQ(code(0.5f, {0, 1023, 0, 1023}, 65535, false), 512);
  EXPECT_EQ(code(1, {0, 65535, 0, 65535}, 65535, true), 65535);
  for (int k = 0; k < 256; ++k)
    EXPECT_EQ(code(float(k) / 255, {0, 255, 0, 255}, 255, false), k) << "the usual one changes nothing";
}

scene::Parameter numbers(const char* name, scene::ValueType type, std::vector<float> values) {
  scene::Parameter p;
  p.name = name;
  p.type = type;
  p.floats = std::move(values);
  return p;
}
scene::Parameter word(const char* name, const char* value) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::String;
  p.strings = {value};
  return p;
}

TEST(DisplayPlan, RulesOfChannelsAndDisplays) {
  scene::Scene s;
  std::string said;
  Diagnostics messages([&](const std::string& line, Severity) { said += line + "\n"; });
  const auto channel = [&](const char* name, scene::ValueType type) -> scene::DisplayChannel& {
    s.channels.push_back({name, type, 1, {}, {}});
    return s.channels.back();
  };
  using scene::ValueType;
  channel("mse", ValueType::Color).params.set(word("source", "Ci"));
  s.channels.back().params.set(word("statistics", "mse"));
  channel("sharp", ValueType::Color).params.set(word("source", "Ci"));
  s.channels.back().params.set(word("filter", "box"));
  s.channels.back().params.set(numbers("filterwidth", ValueType::Float, {1, 1}));
  channel("calm", ValueType::Color).params.set(word("source", "color lpe:CD.*[LO]"));
  s.channels.back().params.set(numbers("remap", ValueType::Float, {1, 2, 50}));
  channel("idmse", ValueType::Int).params.set(word("source", "id"));
  s.channels.back().params.set(word("statistics", "mse"));
  s.displays.push_back({"a.exr", "openexr", "Ci,mse,sharp,calm,idmse", {}, {}});
  s.displays.push_back({"b.exr", "openexr", "Ci,a", {}, {}});
  s.displays.back().params.set(word("filter", "triangle"));
  s.displays.back().params.set(numbers("exposure", ValueType::Float, {2, 1}));
  s.displays.back().params.set(numbers("dither", ValueType::Float, {-1}));
  s.displays.push_back({"c.png", "png", "Ci,a,P,Nn", {}, {}});
  const DisplayPlan p = planDisplays(s, {}, {}, messages);
  const auto at = [&](const char* name) -> const Channel& { return p.layout[p.layout.find(name)]; };
  EXPECT_EQ(at("mse").statistic, Statistic::MeanVariance);
  EXPECT_EQ(at("sharp").filter, (ChannelFilter{"box", 1, 1}));
  EXPECT_TRUE(at("calm").isRemapped());
  EXPECT_EQ(at("idmse").statistic, Statistic::Value);
  EXPECT_EQ(at("Ci").filter.name, "") << "the frame's";
  EXPECT_EQ(at("Ci'").filter, (ChannelFilter{"triangle", 2, 2})) << "the same in a display that filters otherwise";
  EXPECT_EQ(at("a").filter.name, "triangle");
  EXPECT_EQ(at("a'").filter.name, "") << "the plain one of the third display";
  EXPECT_EQ(p.outputs[1].channels[0].values.gain, 2);
  EXPECT_EQ(p.outputs[0].channels[0].values, DisplayValues());
  s.exposure = {3, 2.2f};
  const DisplayPlan exposed = planDisplays(s, {}, {}, messages);
  EXPECT_EQ(exposed.outputs[0].channels[0].values.gain, 3) << "Exposure of the frame";
  EXPECT_EQ(exposed.outputs[0].channels[0].values.gamma, 2.2f);
  EXPECT_EQ(exposed.outputs[1].channels[0].values.gain, 2) << "the display's own";
  s.exposure = {1, 1};
  EXPECT_NE(said.find("DISPLAY-CHANNEL-STATISTICS"), std::string::npos) << said;
  EXPECT_NE(said.find("\"dither\""), std::string::npos) << said;

  // light paths from lights go where they can
  const DisplayPlan q = planDisplays(s, {"", true, false}, {}, messages);
  EXPECT_TRUE(q.layout[q.layout.find("Ci")].splats);
  EXPECT_FALSE(q.layout[q.layout.find("mse")].splats);
  EXPECT_FALSE(q.layout[q.layout.find("calm")].splats);
  EXPECT_NE(said.find("DISPLAY-CHANNEL-SPLATS"), std::string::npos) << said;
}

}  // namespace
}  // namespace kinora::film
