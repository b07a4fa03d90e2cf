// Every light of the registry against the contract of light.h, with settings derived from its declaration: a new
// plug-in is covered by being there. Misses shadows, linking and filters, which are the renderer's, and motion.
#include <gtest/gtest.h>
#include <kinora/testing/light_checks.h>

#include "tests/statistics/stock_plugins.h"

namespace kinora {
namespace {

class EveryLight : public ::testing::TestWithParam<const Descriptor*> {};

TEST_P(EveryLight, KeepsTheContract) {
  const testing::CheckReport report = expectContract([] { return testing::checkLight(*GetParam()); });
  EXPECT_GT(report.statisticalTests, 0u);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(EveryLight);
INSTANTIATE_TEST_SUITE_P(Stock, EveryLight, ::testing::ValuesIn(stockOf([](Kind k) { return k == Kind::Light; })),
                         pluginName);

}  // namespace
}  // namespace kinora
