// The colour of a ramp (ramp_knots.h) at a place, for patterns and light filters. Included per target, like wide.h.
#include <kinora/math/ramp_knots.h>
#include <kinora/simd/wide.h>

#if defined(KINORA_RAMP_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_RAMP_H_TARGET
#undef KINORA_RAMP_H_TARGET
#else
#define KINORA_RAMP_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Rgb<W> rampKnot(const RampKnots& s, Int<W> i) {
  const Int<W> last(s.count - 1), j = select(i > last, last, select(i < Int<W>(0), Int<W>(0), i));
  return {gather(s.rgb[0], j), gather(s.rgb[1], j), gather(s.rgb[2], j)};
}

// The ramp's colour at x, kept within its ends; black without knots.
template <int W>
KN_INLINE Rgb<W> rampAt(const RampKnots& s, Float<W> x) {
  using F = Float<W>;
  using I = Int<W>;
  if (s.count == 0) return Rgb<W>();
  x = clamp(x, F(s.knots[0]), F(s.knots[s.count - 1]));
  // the last knot at or before x; pieces between repeated knots are empty and never chosen, but at the upper end
  I i(0);
  F from(s.knots[0]), to(s.knots[s.count > 1 ? 1 : 0]);
  for (int k = 1; k + 1 < s.count; ++k) {
    const Mask<W> here = (x >= F(s.knots[k])) & (F(s.knots[k + 1]) > F(s.knots[k]));
    i = select(here, I(k), i);
    from = select(here, F(s.knots[k]), from);
    to = select(here, F(s.knots[k + 1]), to);
  }
  const F span = to - from;
  const F t = select(span > F(0.f), clamp((x - from) / max(span, F(1e-20f)), F(0.f), F(1.f)), F(0.f));
  const Rgb<W> b = rampKnot<W>(s, i), c = rampKnot<W>(s, i + I(1));
  if (s.curve == RampCurve::Constant)  // the last knot is no beginning of a piece
    return select(x >= F(s.knots[s.count - 1]), rampKnot<W>(s, I(s.count - 1)), b);
  if (s.curve == RampCurve::Linear) return lerp(b, c, t);
  const Rgb<W> a = rampKnot<W>(s, i - I(1)), d = rampKnot<W>(s, i + I(2));
  const F t2 = t * t, t3 = t2 * t;
  if (s.curve == RampCurve::Bspline) {
    const F u = F(1.f) - t, sixth(1.f / 6.f);
    const F wb = fma(F(3.f), t3, fma(F(-6.f), t2, F(4.f))), wc = fma(F(3.f), t + t2 - t3, F(1.f));
    return (a * (u * u * u) + b * wb + c * wc + d * t3) * sixth;
  }
  const F half(0.5f);
  const F wa = fma(F(2.f), t2, -t3 - t), wb = fma(F(3.f), t3, fma(F(-5.f), t2, F(2.f)));
  const F wc = fma(F(-3.f), t3, fma(F(4.f), t2, t)), wd = t3 - t2;
  return (a * wa + b * wb + c * wc + d * wd) * half;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
