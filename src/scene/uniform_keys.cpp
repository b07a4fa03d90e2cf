#include "scene/uniform_keys.h"

#include <algorithm>
#include <cmath>

namespace kinora::scene {

int uniformKeyCount(std::span<const double> times, double open, double close, int most) {
  if (!(close > open)) return 1;
  int best = 2;
  double bestMiss = 1e300;
  for (int n = 2; n <= most; ++n) {
    double miss = 0;
    for (const double t : times) {
      if (!(t > open && t < close)) continue;
      const double x = (t - open) / (close - open) * (n - 1);
      miss = std::max(miss, std::abs(x - std::round(x)) / (n - 1));
    }
    if (miss < bestMiss * 0.999) {
      best = n;
      bestMiss = miss;
    }
    if (miss <= 1e-6) return n;  // of the shutter
  }
  return best;
}

bool areCloserThanKeys(std::span<const double> times, double open, double close) {
  const double step = (close - open) / (kMostUniformKeys - 1);
  for (size_t k = 0; k + 1 < times.size() && step > 0; ++k) {
    const double length = std::min(times[k + 1], close) - std::max(times[k], open);
    if (length > 1e-6 * step && length < 0.999 * step) return true;
  }
  return false;
}

}  // namespace kinora::scene
