// What a run of checks found. Made by checkBxdf() and checkLight(), read by tests, by kinora-check-plugin, and by
// plug-in authors. It needs no test framework, prints nothing and stops nothing.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::testing {

struct CheckReport {
  std::string plugin;
  bool passed = true;
  // "check: plug-in {setting} where: what was expected, what was got, p". The first few of each check.
  std::vector<std::string> failures;
  std::map<std::string, uint32_t, std::less<>> failuresByCheck;  // all of them, counted
  uint32_t settings = 0;                                         // parameter settings tried
  uint64_t comparisons = 0;                                      // exact or bounded comparisons made
  uint32_t statisticalTests = 0;                                 // tests with a p-value
  double threshold = 0;  // p below which one of them fails (Sidak's correction over all of them)
  double seconds = 0;

  bool failed(std::string_view check) const { return failuresByCheck.find(check) != failuresByCheck.end(); }
  std::string str() const;  // one paragraph for a person
};

}  // namespace kinora::testing
