// Every bxdf of the registry against the contract of bxdf.h, with settings derived from its declaration: a new
// plug-in is covered by being there. Proves what the checks' names say for the settings tried; misses defects that
// need particular primvars, textures or connected networks.
#include <gtest/gtest.h>
#include <kinora/testing/bxdf_checks.h>

#include <iostream>

#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace kinora {
namespace {

std::vector<const Descriptor*> stockOf(Kind kind) {
  std::vector<const Descriptor*> r;
  for (const Descriptor* d : stockPlugins())
    if (d->kind == kind) r.push_back(d);
  return r;
}

class EveryBxdf : public ::testing::TestWithParam<const Descriptor*> {};

TEST_P(EveryBxdf, KeepsTheContract) {
  setThreadFloatMode();  // as in a render
  const testing::CheckReport report = testing::checkBxdf(*GetParam());
  std::cout << report.str();
  EXPECT_TRUE(report.passed);
  EXPECT_GT(report.statisticalTests, 0u);
}

INSTANTIATE_TEST_SUITE_P(Stock, EveryBxdf, ::testing::ValuesIn(stockOf(Kind::Bxdf)),
                         [](const auto& info) { return std::string(info.param->name); });

}  // namespace
}  // namespace kinora
