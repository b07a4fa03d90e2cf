// PxrHairColor: a whole colour comes back, melanin darkens as its absorption says, roots, dye and variation do what they are
// called, equal bits at all widths. What hair of such colours looks like is not judged here.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {
namespace {

const char* const kResults[] = {"resultDiff", "resultTT", "resultTRT"};

TEST(PxrHairColor, AWholeColorComesBack) {
  TestContext t("PxrHairColor", 1);
  t.setBuiltin(Builtin::V, {{0.9f}});
  t.set("mode", 1);
  t.set("color", {{0.5f}, {0.2f}, {0.05f}});
  ASSERT_TRUE(t.run(8));
  const double color[3] = {0.5, 0.2, 0.05};
  for (uint32_t k = 0; k < 3; ++k) {
    const double sigma = std::pow(std::log(color[k]) / 5.8884, 2), through = std::exp(-1.86 * sigma);
    EXPECT_NEAR(t.at("resultDiff", 0, k), color[k], 1e-5);
    EXPECT_NEAR(t.at("resultTT", 0, k), through, 1e-5);
    EXPECT_NEAR(t.at("resultTRT", 0, k), through * through, 1e-5) << "two ways";
  }
}

TEST(PxrHairColor, MelaninIsEumelanin) {
  const double eumelanin[3] = {0.419, 0.697, 1.37};
  TestContext t("PxrHairColor", 1);
  t.setBuiltin(Builtin::V, {{0.9f}});
  for (const double melanin : {0.0, 0.2, 0.7, 1.0}) {
    t.set("melanin", float(melanin));
    ASSERT_TRUE(t.run(8));
    for (uint32_t k = 0; k < 3; ++k)
      EXPECT_NEAR(t.at("resultTT", 0, k), std::exp(1.86 * eumelanin[k] * std::log(std::max(1 - melanin, 1e-4))), 1e-4)
          << melanin;
  }
}

TEST(PxrHairColor, RootsAreDarkerAndADyeAddsItsAbsorption) {
  TestContext t("PxrHairColor", 4);
  t.setBuiltin(Builtin::V, {{0, 0.3f, 0.6f, 1}});
  t.set("melanin", 0.3f);
  const auto through = [&](uint32_t point, uint32_t k) { return t.at("resultTT", point, k); };
  ASSERT_TRUE(t.run(8));
  const float plain[3] = {through(3, 0), through(3, 1), through(3, 2)};
  t.set("darkenRoots", 0.5f);
  t.set("darkenEndPosition", 0.6f);
  ASSERT_TRUE(t.run(8));
  EXPECT_LT(through(0, 1), through(1, 1));
  EXPECT_LT(through(1, 1), through(2, 1));
  EXPECT_EQ(through(2, 1), through(3, 1));
  t.set("dye", {{0.2f}, {0.6f}, {0.9f}});
  ASSERT_TRUE(t.run(8));
  const float both[3] = {through(3, 0), through(3, 1), through(3, 2)};
  t.set("melanin", 0);
  ASSERT_TRUE(t.run(8));
  for (uint32_t k = 0; k < 3; ++k) EXPECT_NEAR(both[k], plain[k] * through(3, k), 1e-5);
}

TEST(PxrHairColor, HairsDifferByTheirIndexOnly) {
  constexpr uint32_t kHairs = 2048;
  std::vector<float> v, index;
  for (uint32_t i = 0; i < 2 * kHairs; ++i) {
    v.push_back(float(i % 2));
    index.push_back(float(i / 2));  // both ends of each
  }
  TestContext t("PxrHairColor", 2 * kHairs);
  t.setBuiltin(Builtin::V, {v});
  t.setPrimvar("hair", {index});
  t.set("melanin", 0.5f);
  t.set("randomMelanin", 0.2f);
  t.set("strayDensity", 0.1f);
  t.set("strayMelanin", 0);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 1; i < 2 * kHairs; ++i)
    ASSERT_EQ(t.at("resultTT", i), t.at("resultTT", 0)) << "no index: all alike";
  t.setText("hairIndexPrimvar", "hair");
  std::vector<float> first;
  for (const uint32_t width : {1u, 4u, 8u, 16u}) {
    if (!t.run(width)) continue;
    std::vector<float> all;
    for (const char* name : kResults)
      for (uint32_t k = 0; k < 3; ++k)
        for (const float x : t.all(name, k)) all.push_back(x);
    if (first.empty()) first = all;
    ASSERT_EQ(all.size(), first.size());
    EXPECT_EQ(std::memcmp(all.data(), first.data(), all.size() * sizeof(float)), 0) << "width " << width;
  }
  uint32_t strays = 0;
  double low = 1, high = 0;
  for (uint32_t i = 0; i < 2 * kHairs; i += 2) {
    const float through = t.at("resultTT", i);
    EXPECT_EQ(through, t.at("resultTT", i + 1));
    strays += through > 0.999f;
    if (through > 0.999f) continue;
    const double melanin = 1 - std::exp(std::log(double(through)) / (1.86 * 0.419));
    low = std::min(low, melanin);
    high = std::max(high, melanin);
  }
  EXPECT_NEAR(strays, 0.1 * kHairs, 4 * std::sqrt(0.1 * 0.9 * kHairs));
  EXPECT_NEAR(low, 0.4, 0.005);
  EXPECT_NEAR(high, 0.6, 0.005);
}

}  // namespace
}  // namespace kinora::patternTest
