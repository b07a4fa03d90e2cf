// Rounding, remainders, thresholds, blends and integer arithmetic of the language for wide and dual values, with its
// rules where C has none (division by zero, ties). Called like fast_math.h: lang::mod. Included per target.
#include "language/library/dual.h"

#if defined(KINORA_LANGUAGE_ROUND_MATH_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_ROUND_MATH_H_TARGET
#undef KINORA_LANGUAGE_ROUND_MATH_H_TARGET
#else
#define KINORA_LANGUAGE_ROUND_MATH_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// ---- rounding; derivatives are dropped, so there are no dual forms ----
template <int W>
KN_INLINE Float<W> ceil(Float<W> x) {
  return Float<W>(hn::Ceil(x.v));
}
template <int W>
KN_INLINE Float<W> trunc(Float<W> x) {
  return Float<W>(hn::Trunc(x.v));
}
// Halves away from zero; by the fraction, because x + 0.5 rounds up from the number just below 0.5.
template <int W>
KN_INLINE Float<W> round(Float<W> x) {
  using F = Float<W>;
  const F whole = lang::trunc(x);
  return copySign(whole + keep(HWY_NAMESPACE::abs(x - whole) >= F(0.5f), copySign(F(1.f), x)), x);
}
template <int W>
KN_INLINE Float<W> sign(Float<W> x) {
  using F = Float<W>;
  return choose(x < F(0.f), F(-1.f), keep(x != F(0.f), F(1.f)));
}
template <int W>
KN_INLINE Float<W> step(Float<W> edge, Float<W> x) {
  return keep(!(x < edge), Float<W>(1.f));
}
// float to int: towards zero; out of range and NaN give the lowest integer, on every CPU.
template <int W>
KN_INLINE Int<W> toInteger(Float<W> x) {
  return choose(x < Float<W>(2147483648.f), toInt(x), Int<W>(int32_t(0x80000000)));
}
// The lattice index of a coordinate.
template <int W>
KN_INLINE Int<W> floorInt(Float<W> x) {
  return lang::toInteger(HWY_NAMESPACE::floor(x));
}

template <int W>
KN_INLINE Float<W> abs(Float<W> x) {
  return HWY_NAMESPACE::abs(x);
}
template <int W>
KN_INLINE Dual<W> abs(Dual<W> x) {
  return choose(x.v >= Float<W>(0.f), Dual<W>(HWY_NAMESPACE::abs(x.v), x.dx, x.dy),
                Dual<W>(HWY_NAMESPACE::abs(x.v), -x.dx, -x.dy));
}

// The language's isnan, isinf and isfinite, as masks.
template <int W>
KN_INLINE Mask<W> isNan(Float<W> x) {
  return x != x;
}
template <int W>
KN_INLINE Mask<W> isInf(Float<W> x) {
  return HWY_NAMESPACE::abs(x) == Float<W>(__builtin_inff());
}
template <class F>
KN_INLINE F radians(F x) {
  return x * decltype(valueOf(x))(0.0174532925199432958f);
}
template <class F>
KN_INLINE F degrees(F x) {
  return x * decltype(valueOf(x))(57.2957795130823209f);
}

// ---- remainders ----
template <int W>
KN_INLINE Float<W> fmod(Float<W> a, Float<W> b) {
  return keep(b != Float<W>(0.f), a - lang::trunc(a / b) * b);
}
template <int W>
KN_INLINE Dual<W> fmod(Dual<W> a, Dual<W> b) {
  return {lang::fmod(a.v, b.v), a.dx, a.dy};
}
template <int W>
KN_INLINE Float<W> mod(Float<W> a, Float<W> b) {
  return a - b * HWY_NAMESPACE::floor(divide(a, b));
}
template <int W>
KN_INLINE Dual<W> mod(Dual<W> a, Dual<W> b) {
  const Float<W> whole = HWY_NAMESPACE::floor(divide(a.v, b.v));
  return {a.v - b.v * whole, a.dx - b.dx * whole, a.dy - b.dy * whole};
}

// ---- blends and thresholds, for Float and Dual alike ----
template <class F>
KN_INLINE F mix(F a, F b, F x) {
  using Plain = decltype(valueOf(x));
  return a * (Plain(1.f) - x) + b * x;
}
// The language's select(x, y, c): y where c is not zero.
template <class F, int W>
KN_INLINE F pick(F x, F y, Float<W> c) {
  return choose(c != Float<W>(0.f), y, x);
}
template <class F>
KN_INLINE F smoothstep(F e0, F e1, F x) {
  using Plain = decltype(valueOf(x));
  const F t = divide(x - e0, e1 - e0);
  const F s = (Plain(3.f) - Plain(2.f) * t) * (t * t);
  return choose(valueOf(x) < valueOf(e0), F(0.f), choose(valueOf(x) >= valueOf(e1), F(1.f), s));
}
template <class F>
KN_INLINE F linearstep(F e0, F e1, F x) {
  const F t = clampTo(divide(x - e0, e1 - e0), F(0.f), F(1.f));
  return choose(valueOf(e0) == valueOf(e1), F(lang::step(valueOf(e0), valueOf(x))), t);
}
// A linear step whose corners are parabolas of half width eps (in units of x).
template <class F>
KN_INLINE F smoothLinearstep(F e0, F e1, F x, F eps) {
  using Plain = decltype(valueOf(x));
  const F w = divide(F(1.f), e1 - e0), E = eps * w, X = (x - e0) * w;
  const F low = X + E, high = Plain(1.f) + E - X, twice = Plain(2.f) * E;
  const F rising = divide(low * low * Plain(0.5f), twice);
  const F settling = Plain(1.f) - divide(high * high * Plain(0.5f), twice);
  const Plain vx = valueOf(X), ve = valueOf(E), one(1.f), zero(0.f);
  F r = choose(vx < ve, rising, settling);
  r = choose((vx >= ve) & (vx <= one - ve), X, r);
  r = choose(vx >= one + ve, F(1.f), r);
  r = choose(vx <= -ve, F(0.f), r);
  return choose(valueOf(e0) == valueOf(e1), F(lang::step(valueOf(e0), valueOf(x))), r);
}
// A step filtered by a box of width |dedge| + |ds|.
template <class F>
KN_INLINE F aastep(F edge, F s, F dedge, F ds) {
  using Plain = decltype(valueOf(s));
  const F width = lang::abs(dedge) + lang::abs(ds), half = width * Plain(0.5f), start = edge - half;
  F r = divide(s - start, width);
  r = choose(valueOf(s) >= valueOf(edge + half), F(1.f), r);
  return choose(valueOf(s) <= valueOf(start), F(0.f), r);
}
template <int W>
KN_INLINE Float<W> filterwidth(Dual<W> x) {
  return HWY_NAMESPACE::sqrt(x.dx * x.dx + x.dy * x.dy);
}

// ---- integers ----
// a / b towards zero; 0 for b = 0; the lowest integer by -1 stays what it is. Exact: the float quotient is off by at
// most 2^-22 of itself, a second one takes the rest but one.
template <int W>
KN_INLINE Int<W> divide(Int<W> a, Int<W> b) {
  using F = Float<W>;
  using I = Int<W>;
  const I zero(0), one(1), lowest(int32_t(0x80000000));
  const Mask<W> negative = (a ^ b) < zero;
  const I ua = choose(a < zero, zero - a, a), ub = choose(b < zero, zero - b, b);
  const F fb = HWY_NAMESPACE::abs(toFloat(ub));  // |lowest| is itself as an integer, 2^31 as a float
  I q = toInt(HWY_NAMESPACE::abs(toFloat(ua)) / fb);
  I rest = ua - q * ub;
  const I more = toInt(toFloat(rest) / fb);
  q = q + more;
  rest = rest - more * ub;
  const Mask<W> under = rest < zero;
  q = choose(under, q - one, q);
  rest = choose(under, rest + ub, rest);
  q = choose(rest >= ub, q + one, q);
  q = choose(ub == lowest, choose(ua == lowest, one, zero), q);
  q = choose(negative, zero - q, q);
  return choose(b == zero, zero, q);
}
// The language's % : 0 for b = 0.
template <int W>
KN_INLINE Int<W> remainder(Int<W> a, Int<W> b) {
  return choose(b == Int<W>(0), Int<W>(0), a - divide(a, b) * b);
}
// The language's mod(int, int): a - b * (a / b) with the integer quotient, so of a's sign; a for b = 0.
template <int W>
KN_INLINE Int<W> mod(Int<W> a, Int<W> b) {
  return a - b * divide(a, b);
}
// a reduced to [0, b) for b > 0.
template <int W>
KN_INLINE Int<W> wrap(Int<W> a, Int<W> b) {
  const Int<W> r = a - divide(a, b) * b;
  return choose(r < Int<W>(0), r + b, r);
}
// Counts of 32 and more (undefined in the language) shift everything out. One lane goes through plain integers:
// Highway 1.0.3's one-lane shift takes 64 bits of count, the second lane's among them.
template <int W>
KN_INLINE Int<W> shiftLeft(Int<W> a, Int<W> count) {
  const Mask<W> fits = (count & Int<W>(~31)) == Int<W>(0);
  const Int<W> k = count & Int<W>(31);
  if constexpr (W == 1) {
    return choose(fits, Int<W>(int32_t(uint32_t(a.lane0()) << k.lane0())), Int<W>(0));
  } else {
    const typename Int<W>::DU u;
    const auto r = hn::Shl(hn::BitCast(u, a.v), hn::BitCast(u, k.v));
    return choose(fits, Int<W>(hn::BitCast(typename Int<W>::D(), r)), Int<W>(0));
  }
}
template <int W>
KN_INLINE Int<W> shiftRight(Int<W> a, Int<W> count) {
  const Int<W> k = choose((count & Int<W>(~31)) == Int<W>(0), count, Int<W>(31));
  if constexpr (W == 1)
    return Int<W>(a.lane0() >> k.lane0());
  else
    return Int<W>(hn::Shr(a.v, k.v));
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
