// The factor from the parameters, and that a wrong number is refused. That samples and hits take it alike is tested
// in src/light and tests/filters.
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;

// Factor at some point; empty when create() refuses.
V factor(const Numbers& given) {
  const TestFilter f("PxrIntMultLightFilter", given);
  return f.made() ? f.at({1, 2, 3}) : V();
}

TEST(PxrIntMultLightFilter, FactorsFollowTheParameters) {
  EXPECT_EQ(factor({}), (V{1, 1, 1}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"exposure", {1}}}), (V{6, 6, 6}));
  EXPECT_EQ(factor({{"tint", {1, 0.5f, 0}}}), (V{1, 0.5f, 0}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"density", {0.25f}}}), (V{1.5f, 1.5f, 1.5f}));
  EXPECT_EQ(factor({{"intensity", {3}}, {"density", {0.25f}}, {"invert", {1}}}), (V{2.5f, 2.5f, 2.5f}));
  EXPECT_EQ(factor({{"intensity", {-1}}}), (V{0, 0, 0})) << "light is not negative";
  EXPECT_TRUE(factor({{"intensity", {3e38f}}, {"exposure", {10}}}).empty());
}

}  // namespace
}  // namespace kinora
