#define KINORA_KERNEL_FILE "shade/beer_lambert.cpp"
#include "shade/beer_lambert.h"

#include "shade/one_lane.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/math/elementary.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

template <int W>
KN_INLINE void through(uint32_t n, float* depth) {
  using F = Float<W>;
  for (uint32_t i = 0; i < n; i += W) {
    const F x = F::load(depth + i);
    zeroUnless(x < F(shade::kOpaqueDepth), exp(-x)).store(depth + i);
  }
}

#if HWY_TARGET == HWY_AVX2
[[maybe_unused]] void through1(uint32_t n, float* depth) { through<1>(n, depth); }
[[maybe_unused]] void through4(uint32_t n, float* depth) { through<4>(n, depth); }
[[maybe_unused]] void through8(uint32_t n, float* depth) { through<8>(n, depth); }
#else
[[maybe_unused]] void through16(uint32_t n, float* depth) { through<16>(n, depth); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::shade {

void letThrough(uint32_t width, uint32_t n, float* depth) {
  kernelFor(width, &N_AVX2::through1, &N_AVX2::through4, &N_AVX2::through8, &N_AVX3::through16)(n, depth);
}

float beerLambert(float absorption, float distance) {
  if (!(absorption > 0)) return 1;
  const float depth = absorption * distance;
  return depth < kOpaqueDepth ? oneLane::exp(-depth) : 0;
}
float freeDepth(float u) { return -oneLane::log(1.f - u); }

}  // namespace kinora::shade
#endif
