// The contract of displacements, see include/kinora/testing/filter_checks.h.
#include "testing/displacement_checks.h"

#include <kinora/displacement.h>
#include <kinora/testing/setting.h>
#include <kinora/testing/test_context.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "testing/bound_bxdf.h"
#include "testing/judge.h"

namespace kinora::testing {

namespace {

constexpr uint32_t kShadedPoints = 37;

// Points over a bent surface; `isReversed`: the last one first.
TestPoints pointsOf(bool isReversed) {
  TestPoints p;
  p.P.clear();
  p.N.clear();
  p.uv.clear();
  for (uint32_t i = 0; i < kShadedPoints; ++i) {
    const float a = float(isReversed ? kShadedPoints - 1 - i : i) * 0.37f;
    p.P.push_back({std::sin(a), 0.1f * a, std::cos(a)});
    p.N.push_back({std::sin(a), 0, std::cos(a)});
    p.uv.push_back({a / 14, 0.5f * (1 + std::sin(3 * a)), 0});
  }
  return p;
}

std::vector<float> offsetsOf(const Descriptor& d, const Setting& s, const WidthTable& table, bool isReversed) {
  TestContextOptions options;
  options.width = table.width;
  const TestContext c(d, s, pointsOf(isReversed), options);
  float* out[3] = {c.floats(kShadedPoints), c.floats(kShadedPoints), c.floats(kShadedPoints)};
  static_cast<const DisplacementFunctions*>(table.functions)->displace(&c.context(), out);
  std::vector<float> all;
  for (uint32_t i = 0; i < kShadedPoints; ++i)
    for (const float* x : out) all.push_back(x[isReversed ? kShadedPoints - 1 - i : i]);
  return all;
}

}  // namespace

CheckReport checkDisplacement(const Descriptor& d, uint64_t seed) {
  CheckReport report;
  report.plugin = d.name;
  const auto fail = [&](const char* check, const std::string& setting, const std::string& what) {
    noteFailure(report, check, setting, what);
  };
  const auto tables = runnableTables(d);
  if (tables.empty()) {
    fail("usable", "", "no functions");
    return report;
  }
  const auto* traits = static_cast<const DisplacementTraits*>(d.traits);
  for (const Setting& s : coveringSettings(d, 64, seed)) {
    ++report.settings;
    const ResolvedValues values(d, s);
    const CreateInfo info{nullptr, "under test", values.data(), values.count(), nullptr, nullptr};
    const float bound = traits && traits->bound ? traits->bound(&info) : INFINITY;
    if (!(bound >= 0)) fail("bound", s.text, "the bound is " + std::to_string(bound));
    std::vector<float> first;
    for (const WidthTable* table : tables) {
      const std::vector<float> there = offsetsOf(d, s, *table, false), back = offsetsOf(d, s, *table, true);
      if (first.empty()) first = there;
      for (uint32_t i = 0; i < kShadedPoints; ++i) {
        report.comparisons += 4;
        const std::string where = "width " + std::to_string(table->width) + ", point " + std::to_string(i);
        const float* o = &there[3 * i];
        const float length = std::sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2]);
        if (!std::isfinite(length)) fail("finite", s.text, where + " moves by no number");
        if (length > bound * 1.0001f) fail("bound", s.text, where + " moves farther than the bound");
        if (std::memcmp(o, &first[3 * i], 3 * sizeof(float)) != 0)
          fail("widths", s.text, where + " differs from width " + std::to_string(tables[0]->width));
        if (std::memcmp(o, &back[3 * i], 3 * sizeof(float)) != 0)
          fail("neighbours", s.text, where + " depends on where the point stands");
      }
    }
  }
  return report;
}

}  // namespace kinora::testing
