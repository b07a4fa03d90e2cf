// Elementary functions for wide values, our own polynomials: the same bits at every width and on every CPU. Accuracy
// is stated beside each, measured by src/math/elementary_test.cpp. Included per target, like wide.h. Polynomial
// coefficients: minimax fits on the reduced range (Cephes' published single-precision tables, S. Moshier, for sin,
// cos, log, exp, atan, asin); evaluation order is fixed by explicit fused operations.
#include <kinora/simd/wide.h>

#if defined(KINORA_ELEMENTARY_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_ELEMENTARY_H_TARGET
#undef KINORA_ELEMENTARY_H_TARGET
#else
#define KINORA_ELEMENTARY_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// sin and cos of x in radians; absolute error below 1.5e-7 for |x| < 8192; larger arguments lose accuracy with
// ulp(x).
template <int W>
KN_INLINE void sincos(Float<W> x, Float<W>& s, Float<W>& c) {
  using F = Float<W>;
  const Int<W> q = toNearestInt(x * F(0.636619772367581343f));  // multiples of pi/2
  const F k = toFloat(q);
  // pi/2 in three parts (Cody and Waite)
  F r = fnma(k, F(1.5703125f), x);
  r = fnma(k, F(4.837512969970703125e-4f), r);
  r = fnma(k, F(7.5497899548918821e-8f), r);
  const F r2 = r * r;
  F ps = fma(r2, F(-1.9515295891e-4f), F(8.3321608736e-3f));
  ps = fma(ps, r2, F(-1.6666654611e-1f));
  ps = fma(ps * r2, r, r);
  F pc = fma(r2, F(2.443315711809948e-5f), F(-1.388731625493765e-3f));
  pc = fma(pc, r2, F(4.166664568298827e-2f));
  pc = fma(pc * r2, r2, fnma(F(0.5f), r2, F(1.f)));
  const Mask<W> swap = (q & Int<W>(1)) == Int<W>(1);
  const F ss = select(swap, pc, ps), cc = select(swap, ps, pc);
  s = select((q & Int<W>(2)) == Int<W>(2), -ss, ss);
  c = select(((q + Int<W>(1)) & Int<W>(2)) == Int<W>(2), -cc, cc);
}
template <int W>
KN_INLINE Float<W> sin(Float<W> x) {
  Float<W> s, c;
  sincos(x, s, c);
  return s;
}
template <int W>
KN_INLINE Float<W> cos(Float<W> x) {
  Float<W> s, c;
  sincos(x, s, c);
  return c;
}
// tan x; relative error below 1e-6 for |x| < 1.5.
template <int W>
KN_INLINE Float<W> tan(Float<W> x) {
  Float<W> s, c;
  sincos(x, s, c);
  return s / c;
}

// 2^x; relative error below 2e-7; 0 below -126, infinity above 128.
template <int W>
KN_INLINE Float<W> exp2(Float<W> x) {
  using F = Float<W>;
  const F y = clamp(x, F(-126.f), F(127.99999f));
  const Int<W> n = toNearestInt(y);
  const F f = y - toFloat(n);
  F p = fma(f, F(1.535336188319500e-4f), F(1.339887440266574e-3f));
  p = fma(p, f, F(9.618437357674640e-3f));
  p = fma(p, f, F(5.550332471162809e-2f));
  p = fma(p, f, F(2.402264791363012e-1f));
  p = fma(p, f, F(6.931472028550421e-1f));
  p = fma(p, f, F(1.f));
  // n may be 128: two factors keep the exponent in range
  const Int<W> h = n.template sar<1>();
  const F a = asFloat((h + Int<W>(127)).template shl<23>()), b = asFloat((n - h + Int<W>(127)).template shl<23>());
  F r = p * a * b;
  r = select(x < F(-126.f), F(0.f), r);
  r = select(x >= F(128.f), F(__builtin_inff()), r);
  return select(x != x, x, r);
}
// e^x; relative error below 2e-7; 0 below -87.33, infinity above 88.72.
template <int W>
KN_INLINE Float<W> exp(Float<W> x) {
  using F = Float<W>;
  const F y = clamp(x, F(-87.33654f), F(88.72283f));
  const Int<W> n = toNearestInt(y * F(1.44269504088896341f));
  const F k = toFloat(n);
  F r = fnma(k, F(0.693359375f), y);
  r = fma(k, F(2.12194440e-4f), r);
  F p = fma(r, F(1.9875691500e-4f), F(1.3981999507e-3f));
  p = fma(p, r, F(8.3334519073e-3f));
  p = fma(p, r, F(4.1665795894e-2f));
  p = fma(p, r, F(1.6666665459e-1f));
  p = fma(p, r, F(5.0000001201e-1f));
  p = fma(p, r * r, r + F(1.f));
  const Int<W> h = n.template sar<1>();
  const F a = asFloat((h + Int<W>(127)).template shl<23>()), b = asFloat((n - h + Int<W>(127)).template shl<23>());
  F e = p * a * b;
  e = select(x < F(-87.33654f), F(0.f), e);
  e = select(x > F(88.72283f), F(__builtin_inff()), e);
  return select(x != x, x, e);
}
// ln x; relative error below 2e-7 away from 1, absolute 1e-7 near it; -infinity at 0, NaN below.
template <int W>
KN_INLINE Float<W> log(Float<W> x) {
  using F = Float<W>;
  const Mask<W> tiny = x < F(1.17549435e-38f);
  const F y = select(tiny, x * F(8388608.f), x);
  const Int<W> bits = asInt(y);
  Int<W> e = bits.template shr<23>() - Int<W>(126);
  F m = asFloat((bits & Int<W>(0x007fffff)) | Int<W>(0x3f000000));  // [0.5, 1)
  const Mask<W> low = m < F(0.707106781186547524f);
  e = select(low, e - Int<W>(1), e);
  m = select(low, m + m, m) - F(1.f);
  const F z = m * m;
  F p = fma(m, F(7.0376836292e-2f), F(-1.1514610310e-1f));
  p = fma(p, m, F(1.1676998740e-1f));
  p = fma(p, m, F(-1.2420140846e-1f));
  p = fma(p, m, F(1.4249322787e-1f));
  p = fma(p, m, F(-1.6668057665e-1f));
  p = fma(p, m, F(2.0000714765e-1f));
  p = fma(p, m, F(-2.4999993993e-1f));
  p = fma(p, m, F(3.3333331174e-1f));
  p = p * m * z;
  const F k = toFloat(e) - select(tiny, F(23.f), F(0.f));
  p = fma(k, F(-2.12194440e-4f), p);
  p = fnma(F(0.5f), z, p);
  F r = fma(k, F(0.693359375f), m + p);
  r = select(x == F(0.f), F(-__builtin_inff()), r);
  r = select(x < F(0.f), F(__builtin_nanf("")), r);
  return select((x == F(__builtin_inff())) | (x != x), x, r);
}
template <int W>
KN_INLINE Float<W> log2(Float<W> x) {
  return log(x) * Float<W>(1.44269504088896341f);
}
// x^y for x >= 0 (negative x: NaN; 0^y is 0 for y > 0, 1 for y = 0). Relative error about |y ln x| * 1e-7.
template <int W>
KN_INLINE Float<W> pow(Float<W> x, Float<W> y) {
  using F = Float<W>;
  F r = exp(y * log(x));
  r = select((x == F(0.f)) & (y > F(0.f)), F(0.f), r);
  return select((y == F(0.f)) | (x == F(1.f)), F(1.f), r);
}
// atan x; absolute error below 2e-7.
template <int W>
KN_INLINE Float<W> atan(Float<W> x) {
  using F = Float<W>;
  const F a = abs(x);
  const Mask<W> big = a > F(2.414213562373095f), mid = (a > F(0.4142135623730950f)) & !big;
  const F y0 = select(big, F(1.57079632679489662f), select(mid, F(0.785398163397448310f), F(0.f)));
  const F t = select(big, F(-1.f) / max(a, F(1e-30f)), select(mid, (a - F(1.f)) / (a + F(1.f)), a));
  const F z = t * t;
  F p = fma(z, F(8.05374449538e-2f), F(-1.38776856032e-1f));
  p = fma(p, z, F(1.99777106478e-1f));
  p = fma(p, z, F(-3.33329491539e-1f));
  return copySign(y0 + fma(p * z, t, t), x);
}
// Angle of (x, y) in [-pi, pi]; 0 at the origin; absolute error below 4e-7.
template <int W>
KN_INLINE Float<W> atan2(Float<W> y, Float<W> x) {
  using F = Float<W>;
  const F ax = abs(x), ay = abs(y);
  const F hi = max(ax, ay), lo = min(ax, ay);
  F r = atan(lo / max(hi, F(1e-37f)));
  r = select(ay > ax, F(1.57079632679489662f) - r, r);
  r = select(x < F(0.f), F(3.14159265358979324f) - r, r);
  return copySign(r, y);
}
// asin x; x is clamped to [-1, 1]; absolute error below 2e-7.
template <int W>
KN_INLINE Float<W> asin(Float<W> x) {
  using F = Float<W>;
  const F a = min(abs(x), F(1.f));
  const Mask<W> big = a > F(0.5f);
  const F z = select(big, F(0.5f) * (F(1.f) - a), a * a);
  const F s = select(big, sqrt(z), a);
  F p = fma(z, F(4.2163199048e-2f), F(2.4181311049e-2f));
  p = fma(p, z, F(4.5470025998e-2f));
  p = fma(p, z, F(7.4953002686e-2f));
  p = fma(p, z, F(1.6666752422e-1f));
  p = fma(p * z, s, s);
  return copySign(select(big, F(1.57079632679489662f) - (p + p), p), x);
}
// acos x; x is clamped to [-1, 1]; absolute error below 4e-7, 2e-7 for x > 0.5.
template <int W>
KN_INLINE Float<W> acos(Float<W> x) {
  using F = Float<W>;
  const F a = min(abs(x), F(1.f));
  // near 1 through the half angle, so that small angles keep relative accuracy
  const F half = asin(safeSqrt(F(0.5f) * (F(1.f) - a)));
  const F r = half + half;
  return select(x < F(0.f), F(3.14159265358979324f) - r, r);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
