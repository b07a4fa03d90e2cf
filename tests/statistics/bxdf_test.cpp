// Every bxdf of the registry against the contract of bxdf.h, with settings derived from its declaration: a new
// plug-in is covered by being there. Proves what the checks' names say for the settings tried; misses defects that
// need particular primvars, textures or connected networks.
#include <gtest/gtest.h>
#include <kinora/testing/bxdf_checks.h>

#include "tests/statistics/stock_plugins.h"

namespace kinora {
namespace {

class EveryBxdf : public ::testing::TestWithParam<const Descriptor*> {};

TEST_P(EveryBxdf, KeepsTheContract) {
  const testing::CheckReport report = expectContract([] { return testing::checkBxdf(*GetParam()); });
  EXPECT_GT(report.statisticalTests, 0u);
}

INSTANTIATE_TEST_SUITE_P(Stock, EveryBxdf, ::testing::ValuesIn(stockOf([](Kind k) { return k == Kind::Bxdf; })),
                         pluginName);

}  // namespace
}  // namespace kinora
