#include "figures.h"

#include <ctime>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

namespace kinora::bench {

namespace {
double seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}
}  // namespace

double wallSeconds() { return seconds(CLOCK_MONOTONIC); }
double processSeconds() { return seconds(CLOCK_PROCESS_CPUTIME_ID); }

double median(std::vector<double> v) {
  if (v.empty()) return 0;
  std::sort(v.begin(), v.end());
  const size_t n = v.size();
  return n % 2 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
}

void Figures::add(const std::string& name, const std::vector<double>& repetitions, const std::string& meaning) {
  if (repetitions.empty()) return;
  const auto [least, most] = std::minmax_element(repetitions.begin(), repetitions.end());
  list_.push_back({name, meaning, median(repetitions), *least, *most});
  const Figure& f = list_.back();
  std::printf("  %-30s %10.4g  [%.4g .. %.4g]\n", f.name.c_str(), f.value, f.min, f.max);
  std::fflush(stdout);
}

void Figures::fail(const std::string& code, const std::string& what) {
  std::fprintf(stderr, "kinora-bench: error %s: %s\n", code.c_str(), what.c_str());
  isSound_ = false;
}

void Figures::print() const {
  std::printf("\n%-30s %10s %10s %10s  %s\n", "figure", "median", "least", "most", "meaning");
  for (const Figure& f : list_)
    std::printf("%-30s %10.4g %10.4g %10.4g  %s\n", f.name.c_str(), f.value, f.min, f.max, f.meaning.c_str());
}

bool Figures::writeJson(const std::string& file) const {
  nlohmann::ordered_json j;
  for (const Figure& f : list_) {
    j[f.name] = f.value;
    j[f.name + "_min"] = f.min;
    j[f.name + "_max"] = f.max;
  }
  std::ofstream out(file);
  out << j.dump(1) << "\n";
  out.close();
  return bool(out);
}

}  // namespace kinora::bench
