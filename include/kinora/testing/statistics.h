// The statistics the kit decides by: p-values, the multiple-comparison correction, and a generator of independent
// numbers. Called by the checks and by tests; it knows nothing of rendering. Not for code that runs per sample in a
// render.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace kinora::testing {

// Regularised upper incomplete gamma function Q(a, x) = 1 - P(a, x), a > 0, x >= 0; relative error below 1e-10.
double gammaQ(double a, double x);
// Probability that a chi-square variable with `freedom` degrees exceeds `value`.
double chiSquareTail(double value, double freedom);
// Probability that a standard normal variable is farther from 0 than z, both sides.
double normalTail(double z);
// Level of each of n independent tests so that all of them together reject a true hypothesis with probability
// `level`.
double sidakLevel(double level, uint64_t n);

struct ChiSquare {
  double statistic = 0, freedom = 0, p = 1;
};
// Pearson's test of counts against expected counts (same total). Cells with less than `least` expected are pooled.
// `deviation` (may be empty) is the standard error with which the expected counts are known; it widens each cell.
ChiSquare chiSquareTest(std::span<const double> observed, std::span<const double> expected,
                        std::span<const double> deviation = {}, double least = 10);

// Mean and its standard error.
class Moments {
 public:
  void add(double x) {  // Welford's update
    ++n_;
    const double d = x - mean_;
    mean_ += d / double(n_);
    squares_ += d * (x - mean_);
  }
  uint64_t count() const { return n_; }
  double mean() const { return mean_; }
  double variance() const { return n_ > 1 ? squares_ / double(n_ - 1) : 0; }
  double standardError() const;

 private:
  uint64_t n_ = 0;
  double mean_ = 0, squares_ = 0;
};

// Independent uniform numbers from a seed (SplitMix64: Steele, Lea and Flood 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  double uniform() { return double(next() >> 11) * 0x1p-53; }      // [0, 1)
  float uniformFloat() { return float(next() >> 40) * 0x1p-24f; }  // [0, 1), as a render's samples: 24 bits
  uint32_t below(uint32_t n) { return n ? uint32_t(next() % n) : 0; }

 private:
  uint64_t state_;
};

}  // namespace kinora::testing
