// Noise for wide values, for pattern and displacement authors: gradient noise on an integer lattice (Perlin,
// "Improving Noise", SIGGRAPH 2002: quintic fade, gradients along the twelve edge directions of a cube; here an
// integer hash takes the place of the permutation table, so that the period is 2^32) and fractal sums of it that fade
// out below the footprint. The same bits at every width. Included per target, like wide.h.
#include <kinora/math/elementary.h>

#ifndef KINORA_NOISE_ONCE
#define KINORA_NOISE_ONCE
namespace kinora {
// Mean of |gradientNoise| and standard deviation of gradientNoise over space; measured, see src/math/noise_test.cpp.
inline constexpr float kNoiseScale =
    1.3f / 2147483648.f;  // to the contrast of Perlin's noise; 1 in 1e5 values are clamped
inline constexpr float kNoiseMeanAbs = 0.1995f, kNoiseDeviation = 0.2482f;

inline constexpr int kMaxNoiseLayers = 32;
}  // namespace kinora
#endif

#if defined(KINORA_NOISE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_NOISE_H_TARGET
#undef KINORA_NOISE_H_TARGET
#else
#define KINORA_NOISE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// 32 random bits of a lattice point. Two rounds of xor and multiply: enough for gradients and jitter, not for
// sampling.
template <int W>
KN_INLINE Int<W> foldHigh(Int<W> h) {
  return h ^ h.template shr<15>();
}
template <int W>
KN_INLINE Int<W> mixColumn(Int<W> hx, Int<W> hy) {
  return foldHigh(hx ^ hy) * Int<W>(0x8da6b343u);
}
template <int W>
KN_INLINE Int<W> hashLattice(Int<W> x, Int<W> y, Int<W> z, uint32_t seed) {
  const Int<W> m = mixColumn(x * Int<W>(0x9e3779b1u) + Int<W>(seed), y * Int<W>(0x85ebca77u));
  return foldHigh((m ^ foldHigh(z * Int<W>(0xc2b2ae3du))) * Int<W>(0x27d4eb2fu)) * Int<W>(0x165667b1u);
}

// Dot product of (x, y, z) with a random gradient whose components are uniform in +-2^31: three overlapping windows
// of the hash, converted as they are (cheaper than selecting one of a few directions, and without favourite
// directions).
template <int W>
KN_INLINE Float<W> gradientDot(Int<W> h, Float<W> x, Float<W> y, Float<W> z) {
  return fma(toFloat(h), x, fma(toFloat(h.template shl<8>()), y, toFloat(h.template shl<16>()) * z));
}

template <int W>
KN_INLINE Float<W> quinticFade(Float<W> t) {
  return t * t * t * fma(t, fma(t, Float<W>(6.f), Float<W>(-15.f)), Float<W>(10.f));
}

// Noise in [-1, 1] (unbounded: in [-1.3, 1.3]), mean 0, zero at lattice points (integers); features about one unit
// wide. Positions beyond 2^31 repeat.
template <int W>
KN_INLINE Float<W> unboundedNoise(Vec3<W> p, uint32_t seed) {
  using F = Float<W>;
  using I = Int<W>;
  const F fx = floor(p.x), fy = floor(p.y), fz = floor(p.z);
  const F x0 = p.x - fx, y0 = p.y - fy, z0 = p.z - fz;
  const F x1 = x0 - F(1.f), y1 = y0 - F(1.f), z1 = z0 - F(1.f);
  const I kx(0x9e3779b1u), ky(0x85ebca77u), kz(0xc2b2ae3du), k(0x27d4eb2fu);
  const I hx0 = toInt(fx) * kx + I(seed), hy0 = toInt(fy) * ky, nz = toInt(fz) * kz;
  const I hx1 = hx0 + kx, hy1 = hy0 + ky;
  const I hz0 = foldHigh(nz), hz1 = foldHigh(nz + kz);
  const I m00 = mixColumn(hx0, hy0), m10 = mixColumn(hx1, hy0), m01 = mixColumn(hx0, hy1), m11 = mixColumn(hx1, hy1);
  const F u = quinticFade(x0), v = quinticFade(y0), w = quinticFade(z0);
  const F a = lerp(gradientDot((m00 ^ hz0) * k, x0, y0, z0), gradientDot((m10 ^ hz0) * k, x1, y0, z0), u);
  const F b = lerp(gradientDot((m01 ^ hz0) * k, x0, y1, z0), gradientDot((m11 ^ hz0) * k, x1, y1, z0), u);
  const F c = lerp(gradientDot((m00 ^ hz1) * k, x0, y0, z1), gradientDot((m10 ^ hz1) * k, x1, y0, z1), u);
  const F d = lerp(gradientDot((m01 ^ hz1) * k, x0, y1, z1), gradientDot((m11 ^ hz1) * k, x1, y1, z1), u);
  return lerp(lerp(a, b, v), lerp(c, d, v), w) * F(kNoiseScale);
}
template <int W>
KN_INLINE Float<W> gradientNoise(Vec3<W> p, uint32_t seed) {
  return clamp(unboundedNoise(p, seed), Float<W>(-1.f), Float<W>(1.f));
}

// How much of a layer of `frequency` a footprint of radius r can show: all while a feature spans two diameters,
// nothing when it is narrower than three quarters of one (sampling theorem, with a smooth end).
template <int W>
KN_INLINE Float<W> layerVisibility(Float<W> r, Float<W> frequency) {
  using F = Float<W>;
  const F x = clamp(fnma(r * frequency, F(2.4f), F(1.6f)), F(0.f), F(1.f));
  return x * x * fnma(F(2.f), x, F(3.f));
}

// A fractal sum: `layers` of noise, each `lacunarity` times finer and lacunarity^-dimension times as high as the one
// before.
template <int W>
struct FractalShape {
  int layers = 6;          // at most kMaxNoiseLayers
  bool turbulent = false;  // absolute values: creases
  Float<W> lacunarity, dimension;
  Float<W> erosion;    // 0..1: fine layers vanish in the valleys of coarse ones
  Float<W> variation;  // slides the layers past each other: another, or a moving, pattern
  KN_INLINE FractalShape() : lacunarity(2.f), dimension(1.f) {}  // written out, see LobeSum in bxdf_author.h
};

// Fractal sum at p (already times the base frequency), radius in the same units: in [-1, 1], or [0, 1] when
// turbulent. Layers finer than the footprint are replaced by their mean, so that far surfaces neither alias nor
// change brightness.
template <int W>
KN_INLINE Float<W> fractalNoise(const FractalShape<W>& shape, Vec3<W> p, Float<W> radius, uint32_t seed) {
  using F = Float<W>;
  const int layers = shape.layers < 1 ? 1 : shape.layers > kMaxNoiseLayers ? kMaxNoiseLayers : shape.layers;
  const F gain = exp2(-shape.dimension * log2(max(shape.lacunarity, F(1e-3f))));
  const F mean(shape.turbulent ? kNoiseMeanAbs : 0.f);
  const bool eroded = (shape.erosion != F(0.f)).any();
  F sum(0.f), signal(1.f), amplitude(1.f), frequency(1.f), total(0.f);
  for (int i = 0; i < layers; ++i) {
    const F visible = layerVisibility(radius, frequency);
    F n = mean;
    if ((visible > F(0.f)).any()) {
      // layers share no lattice points and slide in different directions
      const float o = float(i);
      const F v = shape.variation;
      const Vec3<W> q(fma(p.x, frequency, fma(v, F(i & 1 ? -0.731f : 0.731f), F(o * 17.317f))),
                      fma(p.y, frequency, fma(v, F(i & 2 ? -0.683f : 0.683f), F(o * 31.719f))),
                      fma(p.z, frequency, fma(v, F(1.f), F(o * 23.541f))));
      n = unboundedNoise(q, seed + uint32_t(i) * 0x632be5abu);
      if (shape.turbulent) n = abs(n);
      n = lerp(mean, n, visible);
    }
    sum = fma(n * signal, amplitude, sum);
    total += amplitude;
    if (eroded) {
      const F height = shape.turbulent ? n : fma(n, F(0.5f), F(0.5f));
      signal = signal * lerp(F(1.f), clamp(height + height, F(0.f), F(1.f)), shape.erosion);
    }
    amplitude *= gain;
    frequency *= shape.lacunarity;
  }
  return clamp(sum / total, F(shape.turbulent ? 0.f : -1.f), F(1.f));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
