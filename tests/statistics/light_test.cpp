// Every light of the registry against the contract of light.h, with settings derived from its declaration: a new
// plug-in is covered by being there. Misses shadows, linking and filters, which are the renderer's, and motion.
#include <gtest/gtest.h>
#include <kinora/testing/light_checks.h>

#include <iostream>

#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace kinora {
namespace {

std::vector<const Descriptor*> stockLights() {
  std::vector<const Descriptor*> r;
  for (const Descriptor* d : stockPlugins())
    if (d->kind == Kind::Light) r.push_back(d);
  return r;
}

class EveryLight : public ::testing::TestWithParam<const Descriptor*> {};

TEST_P(EveryLight, KeepsTheContract) {
  setThreadFloatMode();  // as in a render
  const testing::CheckReport report = testing::checkLight(*GetParam());
  std::cout << report.str();
  EXPECT_TRUE(report.passed);
  EXPECT_GT(report.statisticalTests, 0u);
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(EveryLight);
INSTANTIATE_TEST_SUITE_P(Stock, EveryLight, ::testing::ValuesIn(stockLights()),
                         [](const auto& info) { return std::string(info.param->name); });

}  // namespace
}  // namespace kinora
