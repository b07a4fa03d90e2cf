#include "testing/judge.h"

#include <kinora/testing/statistics.h>

#include <algorithm>
#include <cmath>

namespace kinora::testing {

namespace {
constexpr uint32_t kShownPerCheck = 6, kNotedPerCheck = 5;
void addFailure(CheckReport& r, const std::string& check, const std::string& line, uint32_t most = kShownPerCheck) {
  r.passed = false;
  if (++r.failuresByCheck[check] <= most) r.failures.push_back(check + ": " + line);
}
}  // namespace

void noteFailure(CheckReport& report, const char* check, const std::string& setting, const std::string& what) {
  addFailure(report, check, report.plugin + " {" + setting + "}: " + what, kNotedPerCheck);
}

Judge::Judge(std::string plugin) : start_(std::chrono::steady_clock::now()) { report_.plugin = std::move(plugin); }

void Judge::setSetting(const std::string& setting) {
  setting_ = setting;
  ++report_.settings;
}

void Judge::fail(const char* check, const std::string& what) {
  addFailure(report_, check, report_.plugin + " {" + setting_ + "} " + what);
}

void Judge::test(const char* check, double p, const std::string& what) {
  ++report_.statisticalTests;
  // a test that found nothing remarkable cannot fail whatever the final level is
  if (!(p > 0.01))
    suspects_.push_back({check, report_.plugin + " {" + setting_ + "} " + what + text(", p %.3g", p), p});
}

void Judge::compare(const char* check, double got, double error, double expected, double slack,
                    const std::string& what) {
  const double excess = std::max(0.0, std::abs(got - expected) - slack);
  const double p = !(got - expected == got - expected) ? 0
                   : excess == 0                       ? 1
                   : error > 0                         ? normalTail(excess / error)
                                                       : 0;
  test(check, p, what + text(": expected %.6g, got %.6g +- %.2g", expected, got, error));
}

CheckReport Judge::finish(double level) {
  report_.threshold = sidakLevel(level, report_.statisticalTests);
  std::stable_sort(suspects_.begin(), suspects_.end(), [](const Suspect& a, const Suspect& b) { return a.p < b.p; });
  for (const Suspect& s : suspects_)
    if (!(s.p > report_.threshold)) addFailure(report_, s.check, s.line);
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return report_;
}

std::string CheckReport::str() const {
  std::string r = text("%s: %s; %u settings, %llu comparisons, %u statistical tests (threshold %.2g), %.2f s\n",
                       plugin.c_str(), passed ? "passed" : "FAILED", settings, (unsigned long long)comparisons,
                       statisticalTests, threshold, seconds);
  for (const std::string& f : failures) r += "  " + f + "\n";
  for (const auto& [check, n] : failuresByCheck)
    if (n > kShownPerCheck) r += text("  %s: %u failures in all\n", check.c_str(), n);
  return r;
}

}  // namespace kinora::testing
