// Cell noise (constant in each unit cell) and hash noise (another value for every other coordinate) of the language.
// Both in [0, 1], without derivatives. The interface is that of every noise here (perlin.h): C = 1 or 3 results of N
// coordinates, periods or null. Included per target.
#include "language/library/hash.h"

#if defined(KINORA_LANGUAGE_CELL_NOISE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_CELL_NOISE_H_TARGET
#undef KINORA_LANGUAGE_CELL_NOISE_H_TARGET
#else
#define KINORA_LANGUAGE_CELL_NOISE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// x brought into [0, p) in floats; p is first made a whole number, at least 1.
template <int W>
KN_INLINE Float<W> wrapCoordinate(Float<W> x, Float<W> period) {
  const Float<W> p = HWY_NAMESPACE::max(HWY_NAMESPACE::floor(period), Float<W>(1.f));
  return x - p * HWY_NAMESPACE::floor(x / p);
}

template <int N, int C, int W>
KN_INLINE void hashResults(Int<W>* k, Float<W>* r) {
  if constexpr (C == 1) {
    r[0] = toZeroOne(hashOf<N>(k));
  } else {
    for (int c = 0; c < 3; ++c) {
      k[N] = Int<W>(c);
      r[c] = toZeroOne(hashOf<N + 1>(k));
    }
  }
}
// The dual form of a noise without slopes.
template <class Noise>
struct SteppedNoise {
  template <int N, int C, int W>
  static KN_INLINE void dual(const Dual<W>* x, const Float<W>* period, Dual<W>* r) {
    Float<W> p[N], v[C];
    for (int i = 0; i < N; ++i) p[i] = x[i].v;
    Noise::template value<N, C, W>(p, period, v);
    for (int c = 0; c < C; ++c) r[c] = Dual<W>(v[c]);
  }
};
struct CellNoise : SteppedNoise<CellNoise> {
  template <int N, int C, int W>
  static KN_INLINE void value(const Float<W>* x, const Float<W>* period, Float<W>* r) {
    Int<W> k[N + 1];
    for (int i = 0; i < N; ++i) k[i] = floorInt(period ? wrapCoordinate(x[i], period[i]) : x[i]);
    hashResults<N, C>(k, r);
  }
};
struct HashNoise : SteppedNoise<HashNoise> {
  template <int N, int C, int W>
  static KN_INLINE void value(const Float<W>* x, const Float<W>* period, Float<W>* r) {
    Int<W> k[N + 1];
    for (int i = 0; i < N; ++i) k[i] = asInt(period ? wrapCoordinate(x[i], period[i]) : x[i]);
    hashResults<N, C>(k, r);
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
