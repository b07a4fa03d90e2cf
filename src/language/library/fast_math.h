// The elementary functions of the language for wide and dual values: the reference's approximations to the bit of the
// formula (their errors show at six printed digits, so more exact ones would print other numbers), its domain rules
// and its derivative rules. Facts: OpenImageIO's published fast-math approximations as restated in the project's
// notes. Plain and dual forms share names; call them qualified, lang::sin. Included per target.
#include "language/library/dual.h"

#if defined(KINORA_LANGUAGE_FAST_MATH_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_FAST_MATH_H_TARGET
#undef KINORA_LANGUAGE_FAST_MATH_H_TARGET
#else
#define KINORA_LANGUAGE_FAST_MATH_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// c[0] x^n + ... + c[n], from the left.
template <int W>
KN_INLINE Float<W> horner(Float<W>, float c) {
  return Float<W>(c);
}
template <int W>
KN_INLINE Float<W> hornerFrom(Float<W> sum, Float<W>) {
  return sum;
}
template <int W, class... Rest>
KN_INLINE Float<W> hornerFrom(Float<W> sum, Float<W> x, float c, Rest... rest) {
  return hornerFrom(sum * x + Float<W>(c), x, rest...);
}
template <int W, class... Rest>
KN_INLINE Float<W> horner(Float<W> x, float first, float c, Rest... rest) {
  return hornerFrom(Float<W>(first) * x + Float<W>(c), x, rest...);
}
// 1 - (1 - x): x rounded to a multiple of 2^-24, as the reference does to be rid of denormals; visible in small
// results
template <int W>
KN_INLINE Float<W> roundNearOne(Float<W> x) {
  return Float<W>(1.f) - (Float<W>(1.f) - x);
}
template <int W>
KN_INLINE Float<W> negateWhere(Mask<W> m, Float<W> x) {
  return choose(m, -x, x);
}
template <int W>
KN_INLINE Mask<W> isOdd(Int<W> i) {
  return (i & Int<W>(1)) == Int<W>(1);
}
inline constexpr float kLn2 = 0.693147180559945309f, kInvLn2 = 1.44269504088896341f, kPi = 3.14159265358979324f,
                       kHalfPi = 1.57079632679489662f, kLog10Of2 = 0.301029995663981195f, kSmallest = 1.17549435e-38f,
                       kLargest = 3.40282347e+38f;

// ---- logarithms ----
template <int W>
KN_INLINE Float<W> log2(Float<W> x) {
  using F = Float<W>;
  const Int<W> bits = asInt(HWY_NAMESPACE::clamp(x, F(kSmallest), F(kLargest)));
  const F exponent = toFloat(bits.template shr<23>() - Int<W>(127));
  const F f = asFloat((bits & Int<W>(0x007fffff)) | Int<W>(0x3f800000)) - F(1.f), f2 = f * f;
  const F hi =
      horner(f, -0.00931049621349f, 0.05206469089414f, -0.13753123777116f, 0.24187369696082f, -0.34730547155299f);
  const F lo = horner(f, 0.47868480909345f, -0.72116591947498f, 1.442689881667200f);
  return (f2 * f2 * hi + f * lo) + exponent;
}
template <int W>
KN_INLINE Float<W> log(Float<W> x) {
  return lang::log2(x) * Float<W>(kLn2);
}
template <int W>
KN_INLINE Float<W> log10(Float<W> x) {
  return lang::log2(x) * Float<W>(kLog10Of2);
}
// The exponent; |x| is clamped to the normal numbers.
template <int W>
KN_INLINE Float<W> logb(Float<W> x) {
  using F = Float<W>;
  const F a = HWY_NAMESPACE::clamp(HWY_NAMESPACE::abs(x), F(kSmallest), F(kLargest));
  return toFloat(asInt(a).template shr<23>() - Int<W>(127));
}
template <int W>
KN_INLINE Dual<W> scaledLog(Float<W> value, float scale, Dual<W> x) {
  return chain(value, keep(x.v >= Float<W>(kSmallest), Float<W>(scale) / x.v), x);
}
template <int W>
KN_INLINE Dual<W> log2(Dual<W> x) {
  return scaledLog(lang::log2(x.v), kInvLn2, x);
}
template <int W>
KN_INLINE Dual<W> log(Dual<W> x) {
  return scaledLog(lang::log(x.v), 1.f, x);
}
template <int W>
KN_INLINE Dual<W> log10(Dual<W> x) {
  return scaledLog(lang::log10(x.v), 0.434294481903251828f, x);
}
template <class F>
KN_INLINE F log(F x, F base) {
  return divide(lang::log(x), lang::log(base));
}

// ---- exponentials ----
template <int W>
KN_INLINE Float<W> exp2(Float<W> x) {
  using F = Float<W>;
  const F y = HWY_NAMESPACE::clamp(x, F(-126.f), F(126.f));
  const Int<W> m = toInt(y);
  const F f = roundNearOne(y - toFloat(m));
  const F r =
      horner(f, 1.33336498402e-3f, 9.810352697968e-3f, 5.551834031939e-2f, 0.2401793301105f, 0.693144857883f, 1.f);
  return asFloat(asInt(r) + m.template shl<23>());
}
template <int W>
KN_INLINE Float<W> exp(Float<W> x) {
  return lang::exp2(x * Float<W>(kInvLn2));
}
template <int W>
KN_INLINE Float<W> expm1(Float<W> x) {
  using F = Float<W>;
  const F y = roundNearOne(x);
  const F nearZero = copySign(F(0.5f) * (y * y) + y, x);
  return choose(HWY_NAMESPACE::abs(x) < F(0.03f), nearZero, lang::exp(x) - F(1.f));
}
template <int W>
KN_INLINE Dual<W> exp2(Dual<W> x) {
  const Float<W> r = lang::exp2(x.v);
  return chain(r, r * Float<W>(kLn2), x);
}
template <int W>
KN_INLINE Dual<W> exp(Dual<W> x) {
  const Float<W> r = lang::exp(x.v);
  return chain(r, r, x);
}
template <int W>
KN_INLINE Dual<W> expm1(Dual<W> x) {
  return chain(lang::expm1(x.v), lang::exp(x.v), x);
}

// ---- powers and roots ----
// Never NaN: 1 for y = 0, else 0 at x = 0; below 0 only integer powers, others are 0.
template <int W>
KN_INLINE Float<W> pow(Float<W> x, Float<W> y) {
  using F = Float<W>;
  F r = lang::exp2(y * lang::log2(HWY_NAMESPACE::abs(x)));
  const F whole = F(hn::Trunc(y.v));
  // above 2^24 every number is even
  const Mask<W> odd = isOdd(toInt(y)) & (HWY_NAMESPACE::abs(y) < F(16777216.f));
  const Mask<W> negative = x < F(0.f);
  r = negateWhere(negative & odd, r);
  r = keep(!(negative & (whole != y)), r);
  r = choose(y == F(2.f), HWY_NAMESPACE::min(x * x, F(kLargest)), r);
  r = choose(y == F(1.f), x, r);
  r = keep(x != F(0.f), r);
  return choose(y == F(0.f), F(1.f), r);
}
// The value is x * x^(y-1), not x^y: so the reference prints 0 for pow(0, 0) as soon as derivatives are wanted.
template <int W>
KN_INLINE Dual<W> pow(Dual<W> x, Dual<W> y) {
  using F = Float<W>;
  const F below = lang::pow(x.v, y.v - F(1.f)), value = x.v * below;
  const F alongX = y.v * below, alongY = keep(x.v > F(0.f), lang::log(x.v) * value);
  return {value, alongX * x.dx + alongY * y.dx, alongX * x.dy + alongY * y.dy};
}
template <int W>
KN_INLINE Float<W> inversesqrt(Float<W> x) {
  return keep(x > Float<W>(0.f), Float<W>(1.f) / HWY_NAMESPACE::sqrt(x));
}
template <int W>
KN_INLINE Dual<W> inversesqrt(Dual<W> x) {
  const Float<W> r = lang::inversesqrt(x.v);
  return chain(r, keep(x.v > Float<W>(0.f), Float<W>(-0.5f) * r / x.v), x);
}
// Two Newton steps from a guess with a third of the exponent; cbrt(0) = 0.
template <int W>
KN_INLINE Float<W> cbrt(Float<W> x) {
  using F = Float<W>;
  using I = Int<W>;
  const F a = HWY_NAMESPACE::abs(x);
  const I n = asInt(a);
  // n / 3 by shifts, the remainder corrected (Warren, Hacker's Delight, 10-9)
  I q = n.template shr<2>() + n.template shr<4>();
  q = q + q.template shr<4>();
  q = q + q.template shr<8>();
  q = q + q.template shr<16>();
  const I rest = n - q * I(3);
  q = q + (rest * I(11)).template shr<5>();
  F r = asFloat(I(0x2a5137a0) + q);
  for (int step = 0; step < 2; ++step) r = F(0.333333333f) * (F(2.f) * r + a / (r * r));
  return copySign(keep(a != F(0.f), r), x);
}
template <int W>
KN_INLINE Dual<W> cbrt(Dual<W> x) {
  const Float<W> r = lang::cbrt(x.v);
  return chain(r, keep(r != Float<W>(0.f), Float<W>(1.f) / (Float<W>(3.f) * r * r)), x);
}
template <class F>
KN_INLINE F hypot(F x, F y) {
  return lang::sqrt(x * x + y * y);
}
template <class F>
KN_INLINE F hypot(F x, F y, F z) {
  return lang::sqrt(x * x + y * y + z * z);
}

// ---- trigonometry ----
// x less `count` times pi in four parts, each `count * scale` times a quarter of pi's digits.
template <int W>
KN_INLINE Float<W> lessPi(Float<W> x, Float<W> count, float scale) {
  using F = Float<W>;
  x = count * F(-0.78515625f * scale) + x;
  x = count * F(-0.00024187564849853515625f * scale) + x;
  x = count * F(-3.7747668102383613586e-08f * scale) + x;
  return count * F(-1.2816720341285448015e-12f * scale) + x;
}
// Programs of others round the reduced angle to the last digit of pi/2 once more; that loses sin(x) of small x, so
// that sin(x) / x is noise near 0, and osl-numerics, section 8, does not have it. Clamped: far out (beyond 2.6e5) the
// reduction fails and the polynomials leave [-1, 1].
template <int W>
KN_INLINE void sincos(Float<W> angle, Float<W>& s, Float<W>& c) {
  using F = Float<W>;
  const Int<W> q = toNearestInt(angle * F(0.318309886183790672f));
  F x = lessPi(angle, toFloat(q), 4.f);
  const F x2 = x * x;
  const Mask<W> odd = isOdd(q);
  x = negateWhere(odd, x);
  s = horner(x2, 2.6083159809786593541503e-06f, -0.0001981069071916863322258f, 0.00833307858556509017944336f,
             -0.166666597127914428710938f);
  s = HWY_NAMESPACE::clamp(x2 * (s * x) + x, F(-1.f), F(1.f));
  c = horner(x2, -2.71811842367242206819355e-07f, 2.47990446951007470488548e-05f, -0.00138888787478208541870117f,
             0.0416666641831398010253906f, -0.5f, 1.f);
  c = HWY_NAMESPACE::clamp(negateWhere(odd, c), F(-1.f), F(1.f));
}
template <int W>
KN_INLINE Float<W> sin(Float<W> x) {
  Float<W> s, c;
  lang::sincos(x, s, c);
  return s;
}
template <int W>
KN_INLINE Float<W> cos(Float<W> x) {
  Float<W> s, c;
  lang::sincos(x, s, c);
  return c;
}
template <int W>
KN_INLINE void sincos(Dual<W> x, Dual<W>& sine, Dual<W>& cosine) {
  Float<W> s, c;
  lang::sincos(x.v, s, c);
  sine = chain(s, c, x);
  cosine = chain(c, -s, x);
}
template <int W>
KN_INLINE Dual<W> sin(Dual<W> x) {
  Float<W> s, c;
  lang::sincos(x.v, s, c);
  return chain(s, c, x);
}
template <int W>
KN_INLINE Dual<W> cos(Dual<W> x) {
  Float<W> s, c;
  lang::sincos(x.v, s, c);
  return chain(c, -s, x);
}
template <int W>
KN_INLINE Float<W> tan(Float<W> angle) {
  using F = Float<W>;
  const Int<W> q = toNearestInt(angle * F(0.636619772367581343f));
  const Mask<W> odd = isOdd(q);
  F x = lessPi(angle, toFloat(q), 2.f);
  const F x2 = x * x;
  F u = horner(x2, 0.00927245803177356719970703f, 0.00331984995864331722259521f, 0.0242998078465461730957031f,
               0.0534495301544666290283203f, 0.133383005857467651367188f, 0.333331853151321411132812f);
  u = x2 * (u * x) + x;
  return choose(odd, F(-1.f) / u, u);
}
template <int W>
KN_INLINE Dual<W> tan(Dual<W> x) {
  const Float<W> t = lang::tan(x.v);
  return chain(t, Float<W>(1.f) + t * t, x);
}
// acos of |x| for both: error 4.5e-5, visible in print
template <int W>
KN_INLINE Float<W> acosOfAbs(Float<W> x) {
  using F = Float<W>;
  const F a = HWY_NAMESPACE::abs(x), m = choose(a < F(1.f), roundNearOne(a), F(1.f));
  return HWY_NAMESPACE::sqrt(F(1.f) - m) * horner(m, -0.02164095f, 0.077980478f, -0.213300989f, 1.5707963267f);
}
template <int W>
KN_INLINE Float<W> acos(Float<W> x) {
  const Float<W> a = acosOfAbs(x);
  return choose(x < Float<W>(0.f), Float<W>(kPi) - a, a);
}
template <int W>
KN_INLINE Float<W> asin(Float<W> x) {
  return copySign(Float<W>(kHalfPi) - acosOfAbs(x), x);
}
template <int W>
KN_INLINE Float<W> asinSlope(Float<W> x) {
  using F = Float<W>;
  return keep(HWY_NAMESPACE::abs(x) < F(1.f), F(1.f) / HWY_NAMESPACE::sqrt(F(1.f) - x * x));
}
template <int W>
KN_INLINE Dual<W> acos(Dual<W> x) {
  return chain(lang::acos(x.v), -asinSlope(x.v), x);
}
template <int W>
KN_INLINE Dual<W> asin(Dual<W> x) {
  return chain(lang::asin(x.v), asinSlope(x.v), x);
}
template <int W>
KN_INLINE Float<W> atanUpToOne(Float<W> k) {
  using F = Float<W>;
  const F s = roundNearOne(k), t = s * s;
  return s * horner(t, 0.430165678f, 1.f) / horner(t, 0.0579354987f, 0.763007998f, 1.f);
}
template <int W>
KN_INLINE Float<W> atan(Float<W> x) {
  using F = Float<W>;
  const F a = HWY_NAMESPACE::abs(x);
  const Mask<W> steep = a > F(1.f);
  const F r = atanUpToOne(choose(steep, F(1.f) / a, a));
  return copySign(choose(steep, F(kHalfPi) - r, r), x);
}
template <int W>
KN_INLINE Dual<W> atan(Dual<W> x) {
  return chain(lang::atan(x.v), Float<W>(1.f) / (Float<W>(1.f) + x.v * x.v), x);
}
template <int W>
KN_INLINE Float<W> atan2(Float<W> y, Float<W> x) {
  using F = Float<W>;
  const F a = HWY_NAMESPACE::abs(x), b = HWY_NAMESPACE::abs(y);
  const Mask<W> steep = b > a;
  const F k = choose(b == F(0.f), F(0.f), choose(a == b, F(1.f), choose(steep, a, b) / choose(steep, b, a)));
  F r = atanUpToOne(k);
  r = choose(steep, F(kHalfPi) - r, r);
  r = choose(asInt(x) < Int<W>(0), F(kPi) - r, r);  // -0 is negative here
  return copySign(r, y);
}
// The sign of these derivatives is the opposite of calculus: so the reference prints them.
template <int W>
KN_INLINE Dual<W> atan2(Dual<W> y, Dual<W> x) {
  const Float<W> inverse = divide(Float<W>(1.f), x.v * x.v + y.v * y.v);
  return {lang::atan2(y.v, x.v), (y.v * x.dx - x.v * y.dx) * inverse, (y.v * x.dy - x.v * y.dy) * inverse};
}

// ---- hyperbolic functions ----
template <int W>
KN_INLINE Float<W> cosh(Float<W> x) {
  using F = Float<W>;
  const F e = lang::exp(HWY_NAMESPACE::abs(x));
  return F(0.5f) * e + F(0.5f) / e;
}
template <int W>
KN_INLINE Float<W> sinh(Float<W> x) {
  using F = Float<W>;
  const F a = HWY_NAMESPACE::abs(x), e = lang::exp(a), y = roundNearOne(a), y2 = y * y;
  const F series = y2 * (horner(y2, 2.03945513931e-4f, 8.32990277558e-3f, 0.1666673421859f) * y) + y;
  return copySign(choose(a > F(1.f), F(0.5f) * e - F(0.5f) / e, series), x);
}
template <int W>
KN_INLINE Float<W> tanh(Float<W> x) {
  using F = Float<W>;
  return copySign(F(1.f) - F(2.f) / (F(1.f) + lang::exp(F(2.f) * HWY_NAMESPACE::abs(x))), x);
}
template <int W>
KN_INLINE Dual<W> cosh(Dual<W> x) {
  return chain(lang::cosh(x.v), lang::sinh(x.v), x);
}
template <int W>
KN_INLINE Dual<W> sinh(Dual<W> x) {
  return chain(lang::sinh(x.v), lang::cosh(x.v), x);
}
template <int W>
KN_INLINE Dual<W> tanh(Dual<W> x) {
  const Float<W> c = lang::cosh(x.v);
  return chain(lang::tanh(x.v), Float<W>(1.f) / (c * c), x);
}

// ---- error function (Abramowitz and Stegun 7.1.28) ----
template <int W>
KN_INLINE Float<W> erf(Float<W> x) {
  using F = Float<W>;
  const F a = roundNearOne(HWY_NAMESPACE::abs(x));
  F p = horner(a, 0.0000430638f, 0.0002765672f, 0.0001520143f, 0.0092705272f, 0.0422820123f, 0.0705230784f, 1.f);
  p = p * p;
  p = p * p;
  p = p * p;
  p = p * p;
  return copySign(F(1.f) - F(1.f) / p, x);
}
template <int W>
KN_INLINE Float<W> erfc(Float<W> x) {
  return Float<W>(1.f) - lang::erf(x);
}
template <int W>
KN_INLINE Dual<W> erf(Dual<W> x) {
  return chain(lang::erf(x.v), Float<W>(1.12837916709551257f) * lang::exp(-(x.v * x.v)), x);
}
template <int W>
KN_INLINE Dual<W> erfc(Dual<W> x) {
  return chain(lang::erfc(x.v), Float<W>(-1.12837916709551257f) * lang::exp(-(x.v * x.v)), x);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
