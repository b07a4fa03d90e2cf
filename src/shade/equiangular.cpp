#include "shade/equiangular.h"

#include <algorithm>
#include <cmath>

#include "shade/one_lane.h"

namespace kinora::shade {

EquiangularPoint seenFrom(const float o[3], const float d[3], const float p[3], float radius) {
  float v[3], along = 0, beside = 0, far = 0;
  for (int k = 0; k < 3; ++k) {
    v[k] = p[k] - o[k];
    along += v[k] * d[k];
    far += v[k] * v[k];
  }
  for (int k = 0; k < 3; ++k) {
    const float x = v[k] - along * d[k];
    beside += x * x;
  }
  // a ray that passes through the point itself
  const float least = 1e-4f * std::sqrt(far) + 1e-6f;
  return {along, std::max(std::sqrt(beside + radius * radius), least)};
}

float angleAt(const EquiangularPoint& p, float t) {
  if (p.distance == kPointAtInfinity.distance) return t;
  return oneLane::atan((t - p.nearest) / p.distance);
}
float distanceAt(const EquiangularPoint& p, float angle) {
  if (p.distance == kPointAtInfinity.distance) return angle;
  return p.nearest + p.distance * oneLane::tan(angle);
}

}  // namespace kinora::shade
