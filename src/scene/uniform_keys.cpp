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

}  // namespace kinora::scene
