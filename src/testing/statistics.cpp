#include <kinora/testing/statistics.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace kinora::testing {

double gammaQ(double a, double x) {
  if (!(a > 0) || !(x >= 0)) return std::numeric_limits<double>::quiet_NaN();
  if (x == 0) return 1;
  if (std::isinf(x)) return 0;
  const double front = std::exp(a * std::log(x) - x - std::lgamma(a));
  if (x < a + 1) {
    // power series of the lower function: x^a e^-x sum x^n / (a (a+1) ... (a+n))
    double term = 1 / a, sum = term;
    for (int n = 1; n < 100000 && term > sum * 1e-16; ++n) {
      term *= x / (a + n);
      sum += term;
    }
    return std::max(0.0, 1 - front * sum);
  }
  // continued fraction of the upper function, evaluated by Lentz's method
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
  for (int n = 1; n < 100000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    if (std::abs(c) < kTiny) c = kTiny;
    const double factor = c * d;
    h *= factor;
    if (std::abs(factor - 1) < 1e-15) break;
  }
  return front * h;
}

double chiSquareTail(double value, double freedom) {
  return freedom > 0 ? gammaQ(0.5 * freedom, 0.5 * std::max(0.0, value)) : 1;
}

double normalTail(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

double sidakLevel(double level, uint64_t n) { return n ? -std::expm1(std::log1p(-level) / double(n)) : level; }

ChiSquare chiSquareTest(std::span<const double> observed, std::span<const double> expected,
                        std::span<const double> deviation, double least) {
  std::vector<size_t> order(expected.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });
  ChiSquare result;
  double o = 0, e = 0, v = 0;
  uint32_t cells = 0;
  const auto close = [&] {
    const double d = o - e;
    result.statistic += d * d / (e + v);
    ++cells;
    o = e = v = 0;
  };
  double rest = std::accumulate(expected.begin(), expected.end(), 0.0);
  for (const size_t i : order) {
    o += observed[i];
    e += expected[i];
    rest -= expected[i];
    if (!deviation.empty()) v += deviation[i] * deviation[i];
    // the last pool takes what is too little for a cell of its own
    if (e >= least && (rest >= least || i == order.back())) close();
  }
  if (e > 0 || o > 0) {
    e = std::max(e, 1e-3);
    close();
  }
  result.freedom = cells > 1 ? cells - 1 : 0;
  // one cell: nothing to compare but the total, which the caller fixes
  result.p = chiSquareTail(result.statistic, result.freedom);
  return result;
}

double Moments::standardError() const { return n_ > 1 ? std::sqrt(variance() / double(n_)) : 0; }

}  // namespace kinora::testing
