// What the tests of plug-ins broken on purpose ask of a check's report. Shared by broken_bxdfs_test and
// broken_lights_test.
#pragma once
#include <gtest/gtest.h>
#include <kinora/plugin.h>
#include <kinora/testing/report.h>

#include <iostream>
#include <string>

namespace kinora::testing {

struct BrokenCase {
  Descriptor descriptor;
  std::string check;
};
inline void PrintTo(const BrokenCase& c, std::ostream* out) { *out << c.descriptor.name; }
inline std::string nameOf(const ::testing::TestParamInfo<BrokenCase>& info) { return info.param.descriptor.name; }

// `check` is the one that has to find the defect of plug-in `name`; empty: there is none.
inline void expectVerdict(const CheckReport& report, const std::string& check, const char* name) {
  std::cout << report.str();
  if (check.empty()) {
    EXPECT_TRUE(report.passed) << "a correct plug-in";
    return;
  }
  EXPECT_TRUE(report.failed(check)) << check << " had to find this";
  EXPECT_FALSE(report.passed);
  // a report says which plug-in and which setting
  bool named = false;
  for (const std::string& line : report.failures) named = named || line.starts_with(check + ": " + name + " {");
  EXPECT_TRUE(named);
}

}  // namespace kinora::testing
