// Collects what the checks of one plug-in find. Bounded comparisons fail at once; p-values are kept until all tests
// of the run are known, because the level of each depends on their number. Used by the checks only.
#pragma once
#include <kinora/testing/report.h>
#include <kinora/testing/test_context.h>

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

namespace kinora::testing {

// printf into a string.
template <class... A>
std::string text(const char* format, A... arguments) {
  char buffer[512];
  std::snprintf(buffer, sizeof buffer, format, arguments...);
  return buffer;
}
inline std::string text(Vec3 v) { return text("(%.6g %.6g %.6g)", double(v.x), double(v.y), double(v.z)); }

// For checks that need no Judge, since they make exact comparisons alone.
void noteFailure(CheckReport& report, const char* check, const std::string& setting, const std::string& what);

class Judge {
 public:
  explicit Judge(std::string plugin);
  void setSetting(const std::string& setting);
  void fail(const char* check, const std::string& what);
  void count(uint64_t comparisons) { report_.comparisons += comparisons; }
  // A test whose p is uniform in 0..1 when the plug-in is right. `what` says expected, got and where.
  void test(const char* check, double p, const std::string& what);
  // |got - expected| beyond `slack` (what quadrature and single precision may be off by) in units of `error`.
  void compare(const char* check, double got, double error, double expected, double slack, const std::string& what);
  CheckReport finish(double level = 0.01);

 private:
  struct Suspect {
    std::string check, line;
    double p;
  };
  CheckReport report_;
  std::string setting_ = "defaults";
  std::vector<Suspect> suspects_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace kinora::testing
