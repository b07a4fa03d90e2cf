// Proves the range, mean and fading of PxrFractal, its inputs' meaning, equal bits at all widths; prints its speed.
// The noise underneath is proved in src/math/noise_test.cpp.
#include "plugins/pattern/test_context.h"

#include <chrono>
#include <cmath>
#include <cstdio>

namespace kinora::patternTest {
namespace {
constexpr double kMeanAbs = 0.1995;  // of the noise, kNoiseMeanAbs
void place(TestContext& t, uint32_t n, float size, float radius) {
  t.c.host = &t;
  t.setBuiltin(Builtin::Po, {spread(n, -size, size, 7), spread(n, -size, size, 11), spread(n, -size, size, 13)});
  t.setBuiltin(Builtin::PoRadius, {{radius}});
}
double mean(const TestContext& t, uint32_t n, double* deviation) {
  double sum = 0, squares = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const double x = t.at("resultF", i);
    sum += x;
    squares += x * x;
  }
  if (deviation) *deviation = std::sqrt(std::max(0.0, squares / n - sum / n * sum / n));
  return sum / n;
}
}  // namespace

TEST(PxrFractal, LiesInZeroToOneAboutTheMiddle) {
  constexpr uint32_t n = 20011;
  for (int turbulent : {0, 1}) {
    TestContext t("PxrFractal", n);
    place(t, n, 200, 0);
    t.set("turbulent", float(turbulent));
    ASSERT_TRUE(t.run(8));
    float low = 1, high = 0;
    for (uint32_t i = 0; i < n; ++i)
      low = std::min(low, t.at("resultF", i)), high = std::max(high, t.at("resultF", i));
    EXPECT_GE(low, 0.f);
    EXPECT_LE(high, 1.f);
    double deviation = 0;
    const double m = mean(t, n, &deviation);
    EXPECT_NEAR(m, turbulent ? kMeanAbs : 0.5, 0.01);
    EXPECT_GT(deviation, 0.03);
    EXPECT_EQ(t.at("resultG", 5), t.at("resultF", 5));
  }
}

TEST(PxrFractal, FadesToItsMeanBelowTheFootprint) {
  constexpr uint32_t n = 20011;
  for (int turbulent : {0, 1}) {
    TestContext t("PxrFractal", n);
    t.set("turbulent", float(turbulent));
    place(t, n, 200, 0);
    ASSERT_TRUE(t.run(8));
    const double fine = mean(t, n, nullptr);
    place(t, n, 200, 10.f);
    ASSERT_TRUE(t.run(8));
    double deviation = 1;
    EXPECT_NEAR(mean(t, n, &deviation), fine, 0.005);
    EXPECT_LT(deviation, 1e-6);
    place(t, n, 200, 0.2f);  // the first layer shows, the third does not
    ASSERT_TRUE(t.run(8));
    mean(t, n, &deviation);
    EXPECT_GT(deviation, 0.02);
  }
}

TEST(PxrFractal, InputsMatter) {
  constexpr uint32_t n = 64;
  TestContext t("PxrFractal", n);
  place(t, n, 10, 0);
  t.set("layers", 1);
  ASSERT_TRUE(t.run(8));
  const std::vector<float> plain = t.all("resultF", 0);
  t.set("frequency", 2);
  place(t, n, 5, 0);  // half the size at twice the frequency is the same
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < n; ++i) EXPECT_NEAR(t.at("resultF", i), plain[i], 1e-5f);
  t.set("variation", 0.37f);
  ASSERT_TRUE(t.run(8));
  EXPECT_GT(std::fabs(t.at("resultF", 3) - plain[3]), 1e-4f);
  t.set("floatScale", 2);
  t.set("floatOffset", 1);
  t.set("variation", 0.f);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF", 3), 2 * plain[3] + 1, 1e-5f);
  EXPECT_NEAR(t.at("resultR", 3), plain[3], 1e-5f);
  t.setManifold("manifold", {{0.3f}, {0.4f}}, {{0.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_TRUE(t.out("resultF").uniform());
}

TEST(PxrFractal, SameBitsAtAllWidths) {
  constexpr uint32_t n = 77;
  TestContext t("PxrFractal", n);
  place(t, n, 50, 0.03f);
  t.set("erosion", 0.5f);
  t.set("variation", Numbers{spread(n, 0, 4)});
  t.set("lacunarity", 2.17f);
  expectSameBitsAtAllWidths(t);
  t.set("turbulent", 1);
  t.set("surfacePosition", 1);
  t.setBuiltin(Builtin::Pworld, {spread(n, 1e6f, 1.0001e6f), spread(n, -3, 3), spread(n, 0, 1)});
  expectSameBitsAtAllWidths(t);
}

// Not a pass or fail: a machine under load would fail at random. The figures go to docs/performance.md.
TEST(PxrFractal, PrintsItsSpeed) {
  constexpr uint32_t n = 4096;
  for (uint32_t width : {1u, 4u, 8u, 16u}) {
    TestContext t("PxrFractal", n);
    place(t, n, 50, 0);
    if (!t.run(width)) continue;
    double best = 1e9;
    for (int k = 0; k < 15; ++k) {
      const auto start = std::chrono::steady_clock::now();
      t.run(width);
      best = std::min(best,
                      std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() / n);
    }
    std::printf("PxrFractal, 6 layers, width %u: %.1f ns a point\n", width, best);
    EXPECT_GT(best, 0);
  }
}

}  // namespace kinora::patternTest
