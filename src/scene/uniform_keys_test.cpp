// Proves: even keys fall on all key times where few enough do, and otherwise miss them as little as they can.
#include "scene/uniform_keys.h"

#include <gtest/gtest.h>

#include <vector>

namespace kinora::scene {
namespace {

int keys(std::vector<double> times, double open, double close, int most = 65) {
  return uniformKeyCount(times, open, close, most);
}

TEST(UniformKeys, FallOnTheKeysThatAreSaid) {
  EXPECT_EQ(keys({0, 1}, 0, 1), 2);
  EXPECT_EQ(keys({0, 0.5, 1}, 0, 1), 3);
  EXPECT_EQ(keys({0, 0.25, 1}, 0, 1), 5);
  EXPECT_EQ(keys({0, 0.1, 1}, 0, 1), 11);
  EXPECT_EQ(keys({-1, 0.5, 3}, 0, 1), 3);
  EXPECT_EQ(keys({0.25, 0.75}, 0, 1), 5) << "held before the first and after the last";
  EXPECT_EQ(keys({-1, 3}, 0, 1), 2);
  EXPECT_EQ(keys({0, 1}, 0.5, 0.5), 1) << "a closed shutter";
  EXPECT_EQ(keys({0, 1. / 3, 2. / 3, 1}, 0, 1), 4);
}

TEST(UniformKeys, MissOddTimesAsLittleAsTheyCan) {
  const int n = keys({0, 0.3183098861, 1}, 0, 1, 33);
  ASSERT_LE(n, 33);
  double miss = 1;
  for (int k = 0; k < n; ++k) miss = std::min(miss, std::abs(0.3183098861 - double(k) / (n - 1)));
  EXPECT_LT(miss, 1e-3);
}

TEST(UniformKeys, KnowWhatIsTooCloseForThem) {
  const auto close = [](std::vector<double> times) { return areCloserThanKeys(times, 0, 1); };
  EXPECT_TRUE(close({0, 0.001, 1}));
  EXPECT_TRUE(close({0, 0.5, 0.51, 1}));
  EXPECT_TRUE(close({-1, 0.01, 1})) << "what the shutter sees of the first piece";
  EXPECT_FALSE(close({0, 1. / 64, 1}));
  EXPECT_FALSE(close({-0.001, 0, 1})) << "before the shutter opens";
  EXPECT_FALSE(close({1, 1.001}));
  EXPECT_FALSE(areCloserThanKeys(std::vector<double>{0, 0.001, 1}, 0, 0)) << "a closed shutter";
}

}  // namespace
}  // namespace kinora::scene
