#define KINORA_KERNEL_FILE "sampling/draw.cpp"
#include "sampling/draw.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/random.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

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

#if HWY_TARGET == HWY_AVX2
#define KN_DRAW(W)                                                                                              \
  void draw##W(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d, float* u,    \
               float* v) {                                                                                      \
    span<W>(t, n, s, i, d, 0, 1, u, v);                                                                         \
  }                                                                                                             \
  void split##W(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d, uint32_t p, \
                uint32_t ps, float* u, float* v) {                                                              \
    span<W>(t, n, s, i, subSampled(d, p, ps), p, ps, u, v);                                                     \
  }
KN_DRAW(1)
KN_DRAW(4)
KN_DRAW(8)
float event1(uint32_t seed, uint32_t sample, uint32_t dimension, uint32_t event) {
  return drawHashed(Int<1>(seed), Int<1>(sample), dimension, Int<1>(event)).lane0();
}
#else
void draw16(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d, float* u, float* v) {
  span<16>(t, n, s, i, d, 0, 1, u, v);
}
void split16(const SampleTable& t, uint32_t n, const uint32_t* s, const uint32_t* i, uint32_t d, uint32_t p,
             uint32_t ps, float* u, float* v) {
  span<16>(t, n, s, i, subSampled(d, p, ps), p, ps, u, v);
}
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
DrawSpan drawSpan(uint32_t width) {
  return kernelFor(width, &N_AVX2::draw1, &N_AVX2::draw4, &N_AVX2::draw8, &N_AVX3::draw16);
}
DrawSplit drawSplit(uint32_t width) {
  return kernelFor(width, &N_AVX2::split1, &N_AVX2::split4, &N_AVX2::split8, &N_AVX3::split16);
}
float drawEvent(uint32_t seed, uint32_t sample, uint32_t dimension, uint32_t event) {
  return N_AVX2::event1(seed, sample, dimension, event);
}
}  // namespace kinora
#endif
