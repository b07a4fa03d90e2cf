#define KINORA_KERNEL_FILE "shade/equiangular.cpp"
#include "shade/equiangular.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/math/elementary.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
#if HWY_TARGET == HWY_AVX2
float atan1(float x) { return atan(Float<1>(x)).lane0(); }
float tan1(float x) { return tan(Float<1>(x)).lane0(); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace kinora::shade {

EquiangularPoint seenFrom(const float o[3], const float d[3], const float p[3]) {
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
  return {along, std::max(std::sqrt(beside), least)};
}

float angleAt(const EquiangularPoint& p, float t) {
  if (p.distance == kPointAtInfinity.distance) return t;
  return N_AVX2::atan1((t - p.nearest) / p.distance);
}
float distanceAt(const EquiangularPoint& p, float angle) {
  if (p.distance == kPointAtInfinity.distance) return angle;
  return p.nearest + p.distance * N_AVX2::tan1(angle);
}

}  // namespace kinora::shade
#endif
