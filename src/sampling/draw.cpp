#define KINORA_KERNEL_FILE "sampling/draw.cpp"
#include "sampling/draw.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/random.h>

KINORA_KERNELS_BEGIN

template <int W>
void span(const SampleTable& table, uint32_t n, const uint32_t* seed, const uint32_t* sample, uint32_t dimension,
          uint32_t part, uint32_t parts, float* u, float* v) {
  for (uint32_t i = 0; i < n; i += W) {
    Float<W> a, b;
    const Int<W> s = Int<W>::load(sample + i) * Int<W>(parts) + Int<W>(part);
    draw2(table, Int<W>::load(seed + i), s, dimension, a, b);
    a.store(u + i);
    b.store(v + i);
  }
}

#define KN_X(W)                                                                                                      \
  [[maybe_unused]] void draw##W(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d,  \
                                float* u, float* v) {                                                                \
    span<W>(t, n, s, i, d, 0, 1, u, v);                                                                              \
  }                                                                                                                  \
  [[maybe_unused]] void split##W(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d, \
                                 uint32_t p, uint32_t ps, float* u, float* v) {                                      \
    span<W>(t, n, s, i, subSampled(d, p, ps), p, ps, u, v);                                                          \
  }
KN_EACH_WIDTH(KN_X)
#undef KN_X
#if HWY_TARGET == HWY_AVX2
float event1(uint32_t seed, uint32_t sample, uint32_t dimension, uint32_t event) {
  return drawHashed(Int<1>(seed), Int<1>(sample), dimension, Int<1>(event)).lane0();
}
#endif
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora {
DrawSpan drawSpan(uint32_t width) { return KN_PICK_WIDTH(width, draw); }
DrawSplit drawSplit(uint32_t width) { return KN_PICK_WIDTH(width, split); }
float drawEvent(uint32_t seed, uint32_t sample, uint32_t dimension, uint32_t event) {
  return N_AVX2::event1(seed, sample, dimension, event);
}
}  // namespace kinora
#endif
