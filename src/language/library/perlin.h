// Gradient noise of the language in one to four dimensions (Perlin, "Improving Noise", SIGGRAPH 2002, over the hash
// of hash.h): signed and unsigned, float and triple, periodic, with analytic gradients. The interface of every noise
// of this library: a struct with
//   value<N, C, W>(x, period, r)  r[C] from the coordinates x[N]; period[N], or null for none; C is 1 or 3
//   dual<N, C, W>(x, period, r)   the same with derivatives; the values have the same bits
// The work is done in one function a combination (not inlined: periodic and plain, signed and unsigned lookups share
// it; the call is lost in some 400 vector operations). The components of a triple share the hashes. Included per
// target.
#include "language/library/hash.h"

#if defined(KINORA_LANGUAGE_PERLIN_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_PERLIN_H_TARGET
#undef KINORA_LANGUAGE_PERLIN_H_TARGET
#else
#define KINORA_LANGUAGE_PERLIN_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// Where a coordinate lies on its axis: the lattice indices below and above it and the fraction.
template <int W>
struct LatticeSpan {
  Int<W> low, high;
  Float<W> f;
  KN_INLINE LatticeSpan() {}
  KN_INLINE LatticeSpan(Float<W> x, const Float<W>* period) {
    const Float<W> whole = HWY_NAMESPACE::floor(x);
    f = x - whole;
    low = lang::toInteger(whole);
    high = low + Int<W>(1);
    if (!period) return;
    const Int<W> p = floorInt(*period), q = choose(p < Int<W>(1), Int<W>(1), p);
    high = wrap(high, q);
    low = wrap(low, q);
  }
};

// A value with its derivatives along x, y, z and w. Members that a dimension has not are never read.
template <int W>
struct NoiseGradient {
  Float<W> v, x, y, z, w;
  KN_INLINE NoiseGradient() {}
};
// The faded fraction, its complement and its derivative.
template <int W>
struct Fade {
  Float<W> t, rest, slope;
  KN_INLINE explicit Fade(Float<W> f) {
    using F = Float<W>;
    t = f * f * f * (f * (F(6.f) * f - F(15.f)) + F(10.f));
    rest = F(1.f) - t;
    slope = F(30.f) * (f * (f - F(1.f))) * (f * (f - F(1.f)));
  }
};
enum Axis { kAxisX, kAxisY, kAxisZ, kAxisW };
// a * (1 - t) + b * t along an axis.
template <int N, bool kGradient, Axis kAlong, int W>
KN_INLINE NoiseGradient<W> blend(NoiseGradient<W> a, NoiseGradient<W> b, const Fade<W>& k) {
  NoiseGradient<W> r;
  r.v = a.v * k.rest + b.v * k.t;
  if constexpr (kGradient) {
    const Float<W> rise = (b.v - a.v) * k.slope;
    r.x = a.x * k.rest + b.x * k.t;
    if constexpr (N > 1) r.y = a.y * k.rest + b.y * k.t;
    if constexpr (N > 2) r.z = a.z * k.rest + b.z * k.t;
    if constexpr (N > 3) r.w = a.w * k.rest + b.w * k.t;
    if constexpr (kAlong == kAxisX) r.x += rise;
    if constexpr (kAlong == kAxisY) r.y += rise;
    if constexpr (kAlong == kAxisZ) r.z += rise;
    if constexpr (kAlong == kAxisW) r.w += rise;
  }
  return r;
}

// x with its sign turned where bit B of k is set.
template <int B, int W>
KN_INLINE Float<W> turn(Int<W> k, Float<W> x) {
  return asFloat(asInt(x) ^ (k.template shl<31 - B>() & Int<W>(int32_t(0x80000000))));
}
// The gradient of a corner times the way from it: one of a few directions by the hash.
template <bool kGradient, int W>
KN_INLINE NoiseGradient<W> corner1(Int<W> h, Float<W> x) {
  NoiseGradient<W> r;
  const Float<W> g = turn<3>(h, toFloat((h & Int<W>(7)) + Int<W>(1)));
  r.v = g * x;
  if constexpr (kGradient) r.x = g;
  return r;
}
template <bool kGradient, int W>
KN_INLINE NoiseGradient<W> corner2(Int<W> h, Float<W> x, Float<W> y) {
  using F = Float<W>;
  NoiseGradient<W> r;
  const Mask<W> along = (h & Int<W>(4)) == Int<W>(0);
  r.v = turn<0>(h, choose(along, x, y)) + turn<1>(h, F(2.f) * choose(along, y, x));
  if constexpr (kGradient) {
    const F one = turn<0>(h, F(1.f)), two = turn<1>(h, F(2.f));
    r.x = choose(along, one, two);
    r.y = choose(along, two, one);
  }
  return r;
}
template <bool kGradient, int W>
KN_INLINE NoiseGradient<W> corner3(Int<W> h, Float<W> x, Float<W> y, Float<W> z) {
  using F = Float<W>;
  using I = Int<W>;
  NoiseGradient<W> r;
  const Mask<W> firstX = (h & I(8)) == I(0), secondY = (h & I(12)) == I(0), secondX = (h & I(13)) == I(12);
  r.v = turn<0>(h, choose(firstX, x, y)) + turn<1>(h, choose(secondY, y, choose(secondX, x, z)));
  if constexpr (kGradient) {
    const F a = turn<0>(h, F(1.f)), b = turn<1>(h, F(1.f));
    const F bX = keep(secondX, b), bY = keep(secondY, b);
    r.x = choose(firstX, a, bX);
    r.y = choose(firstX, bY, a);
    r.z = b - (bX + bY);
  }
  return r;
}
template <bool kGradient, int W>
KN_INLINE NoiseGradient<W> corner4(Int<W> h, Float<W> x, Float<W> y, Float<W> z, Float<W> w) {
  using F = Float<W>;
  using I = Int<W>;
  NoiseGradient<W> r;
  const I group = h & I(24);
  const Mask<W> firstY = group == I(24), secondY = (h & I(16)) == I(0), thirdZ = group == I(0);
  r.v = turn<0>(h, choose(firstY, y, x)) + turn<1>(h, choose(secondY, y, z)) + turn<2>(h, choose(thirdZ, z, w));
  if constexpr (kGradient) {
    const F a = turn<0>(h, F(1.f)), b = turn<1>(h, F(1.f)), c = turn<2>(h, F(1.f)), zero(0.f);
    r.x = choose(firstY, zero, a);
    r.y = choose(secondY, b, keep(firstY, a));
    r.z = choose(secondY, keep(thirdZ, c), b);
    r.w = choose(thirdZ, zero, c);
  }
  return r;
}

// The hashes of the corners of a cell: x varies fastest, then y, z, w.
template <int N, int W>
KN_INLINE void cornerHashes(const LatticeSpan<W>* s, Int<W>* h) {
  using I = Int<W>;
  const I start(hashStart(N));
  const I x0 = start + s[0].low, x1 = start + s[0].high;
  if constexpr (N == 1) {
    const I c = hashFinishBC(start, start);
    h[0] = hashFinishA(x0, start, c);
    h[1] = hashFinishA(x1, start, c);
  } else if constexpr (N == 2) {
    for (int y = 0; y < 2; ++y) {
      const I b = start + (y ? s[1].high : s[1].low), c = hashFinishBC(b, start);
      h[2 * y] = hashFinishA(x0, b, c);
      h[2 * y + 1] = hashFinishA(x1, b, c);
    }
  } else if constexpr (N == 3) {
    const I y0 = start + s[1].low, y1 = start + s[1].high, z0 = start + s[2].low, z1 = start + s[2].high;
    const I c00 = hashFinishBC(y0, z0), c10 = hashFinishBC(y1, z0), c01 = hashFinishBC(y0, z1),
            c11 = hashFinishBC(y1, z1);
    h[0] = hashFinishA(x0, y0, c00), h[1] = hashFinishA(x1, y0, c00);
    h[2] = hashFinishA(x0, y1, c10), h[3] = hashFinishA(x1, y1, c10);
    h[4] = hashFinishA(x0, y0, c01), h[5] = hashFinishA(x1, y0, c01);
    h[6] = hashFinishA(x0, y1, c11), h[7] = hashFinishA(x1, y1, c11);
  } else {
    for (int i = 0; i < 8; ++i) {
      I a = i & 1 ? x1 : x0, b = start + (i & 2 ? s[1].high : s[1].low), c = start + (i & 4 ? s[2].high : s[2].low);
      hashMix(a, b, c);
      c = hashFinishBC(b, c);
      h[i] = hashFinishA(a + s[3].low, b, c);
      h[i + 8] = hashFinishA(a + s[3].high, b, c);
    }
  }
}

// Eight corners of a cube, at w in the fourth dimension.
template <int N, bool kGradient, int W>
KN_INLINE NoiseGradient<W> corner(Int<W> h, Float<W> x, Float<W> y, Float<W> z, Float<W> w) {
  if constexpr (N == 3)
    return corner3<kGradient>(h, x, y, z);
  else
    return corner4<kGradient>(h, x, y, z, w);
}
template <int N, bool kGradient, int W>
KN_INLINE NoiseGradient<W> cube(const Int<W>* h, Float<W> x, Float<W> y, Float<W> z, Float<W> w, const Fade<W>& fx,
                                const Fade<W>& fy, const Fade<W>& fz) {
  const Float<W> one(1.f), x1 = x - one, y1 = y - one, z1 = z - one;
  const auto c00 = blend<N, kGradient, kAxisZ>(corner<N, kGradient>(h[0], x, y, z, w),
                                               corner<N, kGradient>(h[4], x, y, z1, w), fz);
  const auto c10 = blend<N, kGradient, kAxisZ>(corner<N, kGradient>(h[1], x1, y, z, w),
                                               corner<N, kGradient>(h[5], x1, y, z1, w), fz);
  const auto c0 = blend<N, kGradient, kAxisX>(c00, c10, fx);
  const auto c01 = blend<N, kGradient, kAxisZ>(corner<N, kGradient>(h[2], x, y1, z, w),
                                               corner<N, kGradient>(h[6], x, y1, z1, w), fz);
  const auto c11 = blend<N, kGradient, kAxisZ>(corner<N, kGradient>(h[3], x1, y1, z, w),
                                               corner<N, kGradient>(h[7], x1, y1, z1, w), fz);
  return blend<N, kGradient, kAxisY>(c0, blend<N, kGradient, kAxisX>(c01, c11, fx), fy);
}
template <int N, bool kGradient, int W>
KN_INLINE NoiseGradient<W> interpolate(const LatticeSpan<W>* s, const Int<W>* h) {
  const Float<W> one(1.f), x = s[0].f;
  const Fade<W> fx(x);
  if constexpr (N == 1) {
    return blend<1, kGradient, kAxisX>(corner1<kGradient>(h[0], x), corner1<kGradient>(h[1], x - one), fx);
  } else {
    const Float<W> y = s[1].f;
    const Fade<W> fy(y);
    if constexpr (N == 2) {
      const auto low =
          blend<2, kGradient, kAxisX>(corner2<kGradient>(h[0], x, y), corner2<kGradient>(h[1], x - one, y), fx);
      const auto high = blend<2, kGradient, kAxisX>(corner2<kGradient>(h[2], x, y - one),
                                                    corner2<kGradient>(h[3], x - one, y - one), fx);
      return blend<2, kGradient, kAxisY>(low, high, fy);
    } else {
      const Float<W> z = s[2].f;
      const Fade<W> fz(z);
      if constexpr (N == 3) {
        return cube<3, kGradient>(h, x, y, z, z, fx, fy, fz);
      } else {
        const Float<W> w = s[3].f;
        NoiseGradient<W> end[2];
        for (int i = 0; i < 2; ++i) end[i] = cube<4, kGradient>(h + 8 * i, x, y, z, i ? w - one : w, fx, fy, fz);
        return blend<4, kGradient, kAxisW>(end[0], end[1], Fade<W>(w));
      }
    }
  }
}

inline constexpr float kPerlinScale[5] = {0, 0.2500f, 0.6616f, 0.9820f, 0.8344f};
// out: for each of C components the value, then with kGradient its N derivatives; signed and scaled.
template <int N, int C, bool kGradient, int W>
HWY_ATTR HWY_NOINLINE void perlinLookup(const LatticeSpan<W>* s, Float<W>* out) {
  Int<W> h[1 << N];
  cornerHashes<N>(s, h);
  const Float<W> scale(kPerlinScale[N]);
  for (int c = 0; c < C; ++c) {
    const NoiseGradient<W> r = interpolate<N, kGradient>(s, h);
    *out++ = scale * r.v;
    if constexpr (kGradient) {
      *out++ = scale * r.x;
      if constexpr (N > 1) *out++ = scale * r.y;
      if constexpr (N > 2) *out++ = scale * r.z;
      if constexpr (N > 3) *out++ = scale * r.w;
    }
    // component c of a triple takes its directions from byte c; the bits above do not matter
    if constexpr (C > 1)
      for (int i = 0; i < 1 << N; ++i) h[i] = h[i].template shr<8>();
  }
}
// Derivatives of a result along the grid from its gradient g[N].
template <int N, int W>
KN_INLINE Dual<W> alongGrid(Float<W> value, const Float<W>* g, const Dual<W>* x) {
  Float<W> dx = g[0] * x[0].dx, dy = g[0] * x[0].dy;
  for (int i = 1; i < N; ++i) dx += g[i] * x[i].dx, dy += g[i] * x[i].dy;
  return {value, dx, dy};
}
// 0.5 (r + 1)
template <int W>
KN_INLINE Float<W> toUnsigned(Float<W> r) {
  return Float<W>(0.5f) * (r + Float<W>(1.f));
}
template <int W>
KN_INLINE Dual<W> toUnsigned(Dual<W> r) {
  return Float<W>(0.5f) * (r + Float<W>(1.f));
}

struct PerlinNoise {
  template <int N, int C, int W>
  static KN_INLINE void value(const Float<W>* x, const Float<W>* period, Float<W>* r) {
    LatticeSpan<W> s[N];
    for (int i = 0; i < N; ++i) s[i] = LatticeSpan<W>(x[i], period ? period + i : nullptr);
    perlinLookup<N, C, false>(s, r);
  }
  template <int N, int C, int W>
  static KN_INLINE void dual(const Dual<W>* x, const Float<W>* period, Dual<W>* r) {
    LatticeSpan<W> s[N];
    for (int i = 0; i < N; ++i) s[i] = LatticeSpan<W>(x[i].v, period ? period + i : nullptr);
    Float<W> out[C * (N + 1)];
    perlinLookup<N, C, true>(s, out);
    for (int c = 0; c < C; ++c) r[c] = alongGrid<N>(out[c * (N + 1)], out + c * (N + 1) + 1, x);
  }
};
// The unsigned form of any noise: 0.5 (r + 1).
template <class Signed>
struct UnsignedNoise {
  template <int N, int C, int W>
  static KN_INLINE void value(const Float<W>* x, const Float<W>* period, Float<W>* r) {
    Signed::template value<N, C, W>(x, period, r);
    for (int c = 0; c < C; ++c) r[c] = toUnsigned(r[c]);
  }
  template <int N, int C, int W>
  static KN_INLINE void dual(const Dual<W>* x, const Float<W>* period, Dual<W>* r) {
    Signed::template dual<N, C, W>(x, period, r);
    for (int c = 0; c < C; ++c) r[c] = toUnsigned(r[c]);
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
