// Simplex noise of the language in one to four dimensions, signed, float and triple, with analytic gradients
// (Perlin's simplex lattice in the formulation of Gustavson, "Simplex noise demystified", 2005, over a hash). The
// interface is that of perlin.h; there is no periodic form, periods are ignored. Included per target.
#include "language/library/perlin.h"

#if defined(KINORA_LANGUAGE_SIMPLEX_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_SIMPLEX_H_TARGET
#undef KINORA_LANGUAGE_SIMPLEX_H_TARGET
#else
#define KINORA_LANGUAGE_SIMPLEX_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <int W>
KN_INLINE Int<W> simplexHash(Int<W> a, Int<W> b, Int<W> c) {
  return hashFinish(a, b, c ^ Int<W>(0xdeadbeefu));
}
template <int N, int W>
KN_INLINE Int<W> simplexHashOf(const Int<W>* k, Int<W> seed) {
  const Int<W> zero(0);
  if constexpr (N == 1)
    return simplexHash(k[0], seed, zero);
  else if constexpr (N == 2)
    return simplexHash(k[0], k[1], seed);
  else if constexpr (N == 3)
    return simplexHash(k[0], k[1], simplexHash(k[2], seed, zero));
  else
    return simplexHash(k[0], k[1], simplexHash(k[2], k[3], seed));
}
// -1, 0 or 1: pair number `index` of the bit pairs of a word, less 1.
template <int W>
KN_INLINE Float<W> fromPairs(uint32_t pairs, Int<W> index) {
  return toFloat((shiftRight(Int<W>(pairs), index + index) & Int<W>(3)) - Int<W>(1));
}
template <int W>
KN_INLINE Float<W> minusOneIf(Int<W> k, int32_t bit) {
  return choose((k & Int<W>(bit)) == Int<W>(0), Float<W>(1.f), Float<W>(-1.f));
}
// The direction of a corner. Sixteen in space: the edges of a cube, four of them twice.
template <int N, int W>
KN_INLINE void simplexGradient(Int<W> h, Float<W>* g) {
  using I = Int<W>;
  using F = Float<W>;
  if constexpr (N == 1) {
    g[0] = turn<3>(h, toFloat((h & I(7)) + I(1)));
  } else if constexpr (N == 2) {
    // (-1,-1)(1,0)(-1,0)(1,1)(-1,1)(0,-1)(0,1)(1,-1)
    const I k = h & I(7);
    g[0] = fromPairs(0b10'01'01'00'10'00'10'00u, k);
    g[1] = fromPairs(0b00'10'00'10'10'01'01'00u, k);
  } else if constexpr (N == 3) {
    // (1,0,1)(0,1,1)(-1,0,1)(0,-1,1)(1,0,-1)(0,1,-1)(-1,0,-1)(0,-1,-1)(1,-1,0)(1,1,0)(-1,1,0)(-1,-1,0), then
    // (1,0,1)(-1,0,1)(0,1,-1)(0,-1,-1)
    const I k = h & I(15);
    g[0] = fromPairs(0b01'01'00'10'00'00'10'10'01'00'01'10'01'00'01'10u, k);
    g[1] = fromPairs(0b00'10'01'01'00'10'10'00'00'01'10'01'00'01'10'01u, k);
    g[2] = fromPairs(0b00'00'10'10'01'01'01'01'00'00'00'00'10'10'10'10u, k);
  } else {
    // one component is 0, the others are signs in order
    const I axis = (h & I(31)).template shr<3>();
    const F a = minusOneIf(h, 4), b = minusOneIf(h, 2), c = minusOneIf(h, 1), zero(0.f);
    g[0] = choose(axis == I(0), zero, a);
    g[1] = choose(axis == I(0), a, choose(axis == I(1), zero, b));
    g[2] = choose(axis < I(2), b, choose(axis == I(2), zero, c));
    g[3] = choose(axis == I(3), zero, c);
  }
}

inline constexpr float kSimplexScale[5] = {0, 0.36f, 64, 68, 54};
inline constexpr float kSkew[5] = {0, 0, 0.366025403f, 1.f / 3.f, 0.309016994f};
inline constexpr float kUnskew[5] = {0, 0, 0.211324865f, 1.f / 6.f, 0.138196601f};

// The N + 1 corners around x: their lattice indices and the ways from them to x.
template <int N, int W>
KN_INLINE void simplexCorners(const Float<W>* x, Int<W> (*index)[N], Float<W> (*way)[N]) {
  using I = Int<W>;
  using F = Float<W>;
  if constexpr (N == 1) {
    const F whole = HWY_NAMESPACE::floor(x[0]);
    index[0][0] = toInteger(whole);
    index[1][0] = index[0][0] + I(1);
    way[0][0] = x[0] - whole;
    way[1][0] = way[0][0] - F(1.f);
  } else {
    F sum = x[0] + x[1];
    for (int i = 2; i < N; ++i) sum += x[i];
    const F skewed = sum * F(kSkew[N]);
    I total(0);
    for (int i = 0; i < N; ++i) {
      index[0][i] = floorInt(x[i] + skewed);
      total = total + index[0][i];
    }
    const F t = toFloat(total) * F(kUnskew[N]);
    for (int i = 0; i < N; ++i) way[0][i] = x[i] - (toFloat(index[0][i]) - t);
    // how many of the other axes are shorter; ties go to the earlier axis in space, else to the later one
    I rank[N];
    for (int i = 0; i < N; ++i) rank[i] = I(0);
    for (int i = 0; i < N; ++i)
      for (int j = i + 1; j < N; ++j) {
        const Mask<W> longer = N == 3 ? way[0][i] >= way[0][j] : way[0][i] > way[0][j];
        rank[i] = rank[i] + choose(longer, I(1), I(0));
        rank[j] = rank[j] + choose(longer, I(0), I(1));
      }
    for (int m = 1; m <= N; ++m)
      for (int i = 0; i < N; ++i) {
        const Mask<W> stepped = rank[i] >= I(N - m);
        index[m][i] = index[0][i] + choose(stepped, I(1), I(0));
        way[m][i] = way[0][i] - choose(stepped, F(1.f), F(0.f)) + F(float(m) * kUnskew[N]);
      }
  }
}

// out: for each of C components the value, then with kGradient its N derivatives.
template <int N, int C, bool kGradient, int W>
HWY_ATTR HWY_NOINLINE void simplexLookup(const Float<W>* x, Float<W>* out) {
  using F = Float<W>;
  Int<W> index[N + 1][N];
  F way[N + 1][N];
  simplexCorners<N>(x, index, way);
  const F scale(kSimplexScale[N]);
  for (int c = 0; c < C; ++c) {
    F sum(0.f), slope[N];
    for (int i = 0; i < N; ++i) slope[i] = F(0.f);
    for (int m = 0; m <= N; ++m) {
      F g[N];
      simplexGradient<N>(simplexHashOf<N>(index[m], Int<W>(c)), g);
      const F* e = way[m];
      F t(N == 1 ? 1.f : 0.5f), along = g[0] * e[0];
      for (int i = 0; i < N; ++i) t -= e[i] * e[i];
      for (int i = 1; i < N; ++i) along += g[i] * e[i];
      t = HWY_NAMESPACE::max(t, F(0.f));
      const F t2 = t * t, t4 = t2 * t2;
      sum += t4 * along;
      if constexpr (kGradient) {
        const F inward = F(-8.f) * (t2 * t) * along;
        for (int i = 0; i < N; ++i) slope[i] += inward * e[i] + t4 * g[i];
      }
    }
    *out++ = scale * sum;
    if constexpr (kGradient)
      for (int i = 0; i < N; ++i) *out++ = scale * slope[i];
  }
}

struct SimplexNoise {
  template <int N, int C, int W>
  static KN_INLINE void value(const Float<W>* x, const Float<W>*, Float<W>* r) {
    simplexLookup<N, C, false>(x, r);
  }
  template <int N, int C, int W>
  static KN_INLINE void dual(const Dual<W>* x, const Float<W>*, Dual<W>* r) {
    Float<W> p[N], out[C * (N + 1)];
    for (int i = 0; i < N; ++i) p[i] = x[i].v;
    simplexLookup<N, C, true>(p, out);
    for (int c = 0; c < C; ++c) r[c] = alongGrid<N>(out[c * (N + 1)], out + c * (N + 1) + 1, x);
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
