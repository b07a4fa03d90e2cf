#define KINORA_KERNEL_FILE "shade/beer_lambert.cpp"
#include "shade/beer_lambert.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/math/elementary.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
#if HWY_TARGET == HWY_AVX2
float exp1(float x) { return exp(Float<1>(x)).lane0(); }
float log1(float x) { return log(Float<1>(x)).lane0(); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::shade {
float beerLambert(float absorption, float distance) {
  if (!(absorption > 0)) return 1;
  const float depth = absorption * distance;
  return depth < 100 ? N_AVX2::exp1(-depth) : 0;  // e^-88 is the least normal number
}
float freeDepth(float u) { return -N_AVX2::log1(1.f - u); }
}  // namespace kinora::shade
#endif
