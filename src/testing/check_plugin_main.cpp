// kinora-check-plugin: runs the testing kit on a plug-in library, or on a stock plug-in by name.
#include <kinora/testing/bxdf_checks.h>
#include <kinora/testing/filter_checks.h>
#include <kinora/testing/light_checks.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "simd/dispatch.h"

namespace {
constexpr const char* kUsage =
    "usage: kinora-check-plugin [--seed N] [--setting 'name=v v v; name=v'] FILE.so|NAME ...\n"
    "Checks the plug-ins of a library, or a stock plug-in by name, against the contract of its kind.\n"
    "  --seed N      other random settings and numbers (default 1)\n"
    "  --setting S   one parameter setting in full, instead of all that follow from the declaration\n"
    "exit code: 0 all passed, 1 a check failed, 2 bad command line, 4 nothing to check\n";
}

int main(int argc, char** argv) {
  using namespace kinora;
  testing::BxdfCheckOptions options;
  std::string setting;
  bool oneSetting = false;
  std::vector<std::string> names;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--help" || a == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if ((a == "--seed" || a == "--setting") && i + 1 < argc) {
      if (a == "--setting") {
        setting = argv[++i];
        oneSetting = true;
        continue;
      }
      char* end = nullptr;
      options.seed = std::strtoull(argv[++i], &end, 10);
      if (!*argv[i] || *end) {
        std::fputs("kinora-check-plugin: --seed wants a number\n", stderr);
        return 2;
      }
    } else if (a.empty() || a[0] == '-') {
      std::fputs(kUsage, stderr);
      return 2;
    } else {
      names.push_back(a);
    }
  }
  if (names.empty()) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  if (!cpuHasAvx2()) {
    std::fputs("kinora-check-plugin: this CPU lacks AVX2 or FMA\n", stderr);
    return 9;
  }
  setThreadFloatMode();
  const std::vector<const Descriptor*> stock = stockPlugins();
  Registry registry;
  Diagnostics diagnostics;
  bool passed = true, any = false;
  for (const std::string& name : names) {
    std::vector<const Descriptor*> chosen;
    if (name.find('/') == name.npos && !name.ends_with(".so")) {
      for (const Descriptor* d : stock)
        if (name == d->name) chosen.push_back(d);
      if (chosen.empty()) std::fprintf(stderr, "kinora-check-plugin: there is no stock plug-in '%s'\n", name.c_str());
    } else {
      const size_t before = registry.all().size();
      registry.load(name.find('/') == name.npos ? "./" + name : name, diagnostics, {});
      const std::vector<const Descriptor*> all = registry.all();
      chosen.assign(all.begin() + std::ptrdiff_t(before), all.end());
    }
    for (const Descriptor* d : chosen) {
      testing::CheckReport report;
      testing::LightCheckOptions lightOptions;
      lightOptions.seed = options.seed;
      if (testing::hasFilterChecks(d->kind) && !oneSetting) {
        report = testing::checkFilter(*d, options.seed);
        any = true;
        passed = passed && report.passed;
        std::fputs(report.str().c_str(), stdout);
        continue;
      }
      if (d->kind != Kind::Bxdf && d->kind != Kind::Light) {
        std::printf("%s: no checks for plug-ins of kind %s\n", d->name, nameOf(d->kind));
        continue;
      }
      if (oneSetting) {
        testing::Setting s;
        std::string error;
        if (!testing::parseSetting(*d, setting, s, error)) {
          std::fprintf(stderr, "kinora-check-plugin: %s\n", error.c_str());
          return 2;
        }
        report =
            d->kind == Kind::Light ? testing::checkLight(*d, s, lightOptions) : testing::checkBxdf(*d, s, options);
      } else {
        report = d->kind == Kind::Light ? testing::checkLight(*d, lightOptions) : testing::checkBxdf(*d, options);
      }
      any = true;
      passed = passed && report.passed;
      std::fputs(report.str().c_str(), stdout);
    }
  }
  return !any ? 4 : passed ? 0 : 1;
}
