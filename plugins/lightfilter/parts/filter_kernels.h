// What light filters share at a lit point. Included per target, after filter_setup.h.
#include <kinora/light_author.h>
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>
#include <kinora/math/ramp.h>

#if defined(KINORA_FILTER_KERNELS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_FILTER_KERNELS_H_TARGET
#undef KINORA_FILTER_KERNELS_H_TARGET
#else
#define KINORA_FILTER_KERNELS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Vec3<W> directionIn(const filterParts::FilterSpace& s, Vec3<W> d) {
  return {dot(d, wide<W>(s.x)), dot(d, wide<W>(s.y)), dot(d, wide<W>(s.z))};
}
template <int W>
KN_INLINE Vec3<W> placeIn(const filterParts::FilterSpace& s, Vec3<W> p) {
  return directionIn<W>(s, p - wide<W>(s.origin));
}

// 0 before `from`, 1 behind `to`, smooth between; a step where they are the same.
template <int W>
KN_INLINE Float<W> smoothly(Float<W> from, Float<W> to, Float<W> x) {
  using F = Float<W>;
  const F room = to - from;
  const F t = select(room > F(1e-12f), clamp((x - from) / max(room, F(1e-12f)), F(0.f), F(1.f)),
                     select(x < to, F(0.f), F(1.f)));
  return t * t * fnma(F(2.f), t, F(3.f));
}

// How far beyond the region's edge in its softness: 0 within, 1 outside of the soft edge; `outside` is the way from
// the inner box on each axis, `softness` the width of the edge towards each.
template <int W>
KN_INLINE Float<W> intoEdge(Vec3<W> outside, Vec3<W> softness, Float<W> radius) {
  using F = Float<W>;
  const Vec3<W> squares = outside * outside;
  const F d2 = squares.x + squares.y + squares.z, beyond = sqrt(d2) - radius;
  // towards an edge or a corner the softness is that of the axes by their parts of the way
  const F width = dot(squares, softness) / max(d2, F(1e-30f));
  return select(beyond > F(0.f), select(width > F(1e-12f), min(beyond / max(width, F(1e-12f)), F(1.f)), F(1.f)),
                F(0.f));
}
// The part of the way to a place that is outside of [low, high] on one axis, and the softness on that side.
template <int W>
KN_INLINE Float<W> outsideOf(Float<W> p, float low, float high, float softLow, float softHigh, Float<W>& soft) {
  using F = Float<W>;
  const F below = F(low) - p, above = p - F(high);
  soft = select(below > F(0.f), F(softLow), F(softHigh));
  return max(max(below, above), F(0.f));
}

template <int W>
KN_INLINE Float<W> strengthAt(const filterParts::DistanceStrength& k, Float<W> distance) {
  using F = Float<W>;
  if (!k.varies) return F(1.f);
  F way = clamp((distance - F(k.near)) * F(k.perReach), F(0.f), F(1.f));
  if (k.power != 1) way = pow(way, F(k.power));
  const F first = way * F(1 / k.middle), second = (way - F(k.middle)) * F(1 / (1 - k.middle));
  return select(way < F(k.middle), lerp(F(k.atNear), F(k.atMiddle), first), lerp(F(k.atMiddle), F(k.atFar), second));
}

// The filter's colour with another saturation; never negative.
template <int W>
KN_INLINE Rgb<W> saturated(Rgb<W> color, float saturation) {
  using F = Float<W>;
  if (saturation == 1) return color;
  const F grey = luminance(color);
  const Rgb<W> c = lerp(Rgb<W>(grey, grey, grey), color, F(saturation));
  return {max(c.x, F(0.f)), max(c.y, F(0.f)), max(c.z, F(0.f))};
}

// A filter's colour in the strength in which it acts.
template <int W>
KN_INLINE Rgb<W> filtered(Rgb<W> color, Float<W> density) {
  using F = Float<W>;
  return lerp(Rgb<W>(F(1.f), F(1.f), F(1.f)), color, density);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
