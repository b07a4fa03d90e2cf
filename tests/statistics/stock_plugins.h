// What the tests of this folder share: each is asked of every stock plug-in of some kinds.
#pragma once
#include <gtest/gtest.h>
#include <kinora/testing/report.h>

#include <iostream>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace kinora {

// isWanted(kind): whether plug-ins of this kind are meant.
template <class IsWanted>
std::vector<const Descriptor*> stockOf(IsWanted&& isWanted) {
  std::vector<const Descriptor*> r;
  for (const Descriptor* d : stockPlugins())
    if (isWanted(d->kind)) r.push_back(d);
  return r;
}

inline std::string pluginName(const ::testing::TestParamInfo<const Descriptor*>& info) { return info.param->name; }

// check(): a report of the testing kit, which is shown; it passes.
template <class Check>
testing::CheckReport expectContract(Check&& check) {
  setThreadFloatMode();  // as in a render
  testing::CheckReport report = check();
  std::cout << report.str();
  EXPECT_TRUE(report.passed);
  return report;
}

}  // namespace kinora
