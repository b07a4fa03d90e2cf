// What a transform does to lengths and volumes, and whether it can be used at all.
#pragma once
#include <cmath>

#include "scene/scene.h"

namespace kinora::render {

inline bool isFinite(const scene::Matrix& m) {
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(m[i / 4][i % 4])) return false;
  return true;
}

// Of volumes; below 0 where the transform mirrors. Its translation and last column do not count.
inline double volumeScaleOf(const scene::Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}
// Of lengths, on average over directions.
inline double scaleOf(const scene::Matrix& m) { return std::cbrt(std::fabs(volumeScaleOf(m))); }

}  // namespace kinora::render
