#define KINORA_KERNEL_FILE "shade/beer_lambert.cpp"
#include "shade/beer_lambert.h"

#include "shade/one_lane.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/math/elementary.h>

KINORA_KERNELS_BEGIN

template <int W>
KN_INLINE void through(uint32_t n, float* depth) {
  using F = Float<W>;
  for (uint32_t i = 0; i < n; i += W) {
    const F x = F::load(depth + i);
    zeroUnless(x < F(shade::kOpaqueDepth), exp(-x)).store(depth + i);
  }
}

KN_POINTERS(kThrough, through)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade {

void letThrough(uint32_t width, uint32_t n, float* depth) { (*KN_PICK_WIDTH(width, kThrough))(n, depth); }

float beerLambert(float absorption, float distance) {
  if (!(absorption > 0)) return 1;
  const float depth = absorption * distance;
  return depth < kOpaqueDepth ? oneLane::exp(-depth) : 0;
}
float freeDepth(float u) { return -oneLane::log(1.f - u); }

}  // namespace kinora::shade
#endif
