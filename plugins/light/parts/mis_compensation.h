// What light samples of an infinite light are made for, where rays find it too. The power heuristic leaves even light from
// all around to directions by the bxdf, so that samples of it are nearly lost; best is to sample what stands out of the
// mean (Karlik, Sik, Vevoda, Skrivan and Krivanek, "MIS Compensation: Optimizing Sampling Techniques in Multiple
// Importance Sampling", SIGGRAPH Asia 2019). A share of all radiance is kept: estimates by light samples alone, and points
// from which no direction is followed, need a density everywhere.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace kinora::lightParts {

// .1 to .5 are alike, but for what light samples alone find, which wants more (docs/sampling.md).
inline constexpr double kKeptShare = 0.2;

inline double compensated(double radiance, double mean) {
  return std::max(radiance - mean, 0.0) + kKeptShare * radiance;
}

// Mean radiance of cells, row by row, of which each has its row's solid angle.
struct Cells {
  std::vector<double>& radiance;
  const std::vector<double>& solidAngle;
  size_t columns;
  double mean() const {
    double sum = 0, sphere = 0;
    for (size_t j = 0; j < solidAngle.size(); ++j)
      for (size_t i = 0; i < columns; ++i) {
        sum += radiance[j * columns + i] * solidAngle[j];
        sphere += solidAngle[j];
      }
    return sum / sphere;
  }
  void compensate(double mean) {
    for (double& x : radiance) x = compensated(x, mean);
  }
};

}  // namespace kinora::lightParts
