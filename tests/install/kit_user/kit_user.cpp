// Checks the example bxdf with the installed kit, at few settings: that the kit links and answers is what matters
// here.
#include <kinora/testing/bxdf_checks.h>

#include <cstdio>

extern "C" const kinora::Descriptor* kinoraPlugins(uint32_t index);

int main() {
  kinora::testing::BxdfCheckOptions options;
  options.randomSettings = 2;
  options.statisticalSettings = 2;
  options.samples = 1u << 14;
  const kinora::testing::CheckReport report = kinora::testing::checkBxdf(*kinoraPlugins(0), options);
  std::puts(report.str().c_str());
  return report.passed && report.comparisons > 0 ? 0 : 1;
}
