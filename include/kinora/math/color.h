// Colour models and blend operations for wide values, for pattern authors. Colours are scene-linear; hue is in turns
// 0..1. Blend modes as image editors define them, on values meant for 0..1. Included per target, like wide.h.
#include <kinora/math/elementary.h>

#ifndef KINORA_COLOR_ONCE
#define KINORA_COLOR_ONCE
namespace kinora {
// Codes of PxrBlend's and PxrLayeredBlend's `operation`.
enum class Blend : int {
  Color,
  ColorBurn,
  ColorDodge,
  Darken,
  DarkerColor,
  Difference,
  Dissolve,
  Divide,
  Exclusion,
  HardLight,
  HardMix,
  Hue,
  Lighten,
  LighterColor,
  LinearBurn,
  LinearDodge,
  LinearLight,
  Luminosity,
  Multiply,
  Normal,
  Overlay,
  PinLight,
  Saturation,
  Screen,
  SoftLight,
  Subtract,
  VividLight,
  Count
};
#define KINORA_BLEND_CHOICES                                                                                       \
  "0 Color, 1 ColorBurn, 2 ColorDodge, 3 Darken, 4 DarkerColor, 5 Difference, 6 Dissolve, 7 Divide, 8 Exclusion, " \
  "9 HardLight, 10 HardMix, 11 Hue, 12 Lighten, 13 LighterColor, 14 LinearBurn, 15 LinearDodge, 16 LinearLight, "  \
  "17 Luminosity, 18 Multiply, 19 Normal, 20 Overlay, 21 PinLight, 22 Saturation, 23 Screen, 24 SoftLight, "       \
  "25 Subtract, 26 VividLight"
}  // namespace kinora
#endif

#if defined(KINORA_COLOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_COLOR_H_TARGET
#undef KINORA_COLOR_H_TARGET
#else
#define KINORA_COLOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Float<W> minComponent(Rgb<W> c) {
  return min(c.x, min(c.y, c.z));
}
template <int W>
KN_INLINE Float<W> fraction(Float<W> x) {
  return x - floor(x);
}
template <int W>
KN_INLINE Rgb<W> grey(Float<W> x) {
  return {x, x, x};
}
template <int W>
KN_INLINE Rgb<W> clamp01(Rgb<W> c) {
  const Float<W> o(0.f), i(1.f);
  return {clamp(c.x, o, i), clamp(c.y, o, i), clamp(c.z, o, i)};
}

// Hue in turns, 0 where there is none.
template <int W>
KN_INLINE Float<W> hueOf(Rgb<W> c) {
  using F = Float<W>;
  const F high = maxComponent(c), span = high - minComponent(c);
  const F scale = F(1.f / 6.f) / max(span, F(1e-20f));
  F h = select(high == c.x, (c.y - c.z) * scale,
               select(high == c.y, fma(c.z - c.x, scale, F(1.f / 3.f)), fma(c.x - c.y, scale, F(2.f / 3.f))));
  return fraction(select(span > F(0.f), h, F(0.f)));
}
// The pure colour of a hue: components 0..1, one of them 1, one 0.
template <int W>
KN_INLINE Rgb<W> pureHue(Float<W> h) {
  using F = Float<W>;
  const F six = fraction(h) * F(6.f);
  return clamp01(Rgb<W>(abs(six - F(3.f)) - F(1.f), F(2.f) - abs(six - F(2.f)), F(2.f) - abs(six - F(4.f))));
}
// Hue, saturation and value (hue in turns); value is the largest component.
template <int W>
KN_INLINE Vec3<W> rgbToHsv(Rgb<W> c) {
  using F = Float<W>;
  const F high = maxComponent(c), span = high - minComponent(c);
  return {hueOf(c), select(high > F(0.f), span / max(high, F(1e-20f)), F(0.f)), high};
}
template <int W>
KN_INLINE Rgb<W> hsvToRgb(Vec3<W> v) {
  const Float<W> one(1.f);
  return lerp(Rgb<W>(one, one, one), pureHue(v.x), v.y) * v.z;
}
// Hue, saturation and lightness (hue in turns); lightness is the mean of the largest and the smallest component.
template <int W>
KN_INLINE Vec3<W> rgbToHsl(Rgb<W> c) {
  using F = Float<W>;
  const F high = maxComponent(c), low = minComponent(c), span = high - low, light = (high + low) * F(0.5f);
  const F room = F(1.f) - abs(fma(F(2.f), light, F(-1.f)));
  return {hueOf(c), select(span > F(0.f), span / max(room, F(1e-6f)), F(0.f)), light};
}
template <int W>
KN_INLINE Rgb<W> hslToRgb(Vec3<W> v) {
  using F = Float<W>;
  const F chroma = max(F(1.f) - abs(fma(F(2.f), v.z, F(-1.f))), F(0.f)) * v.y;  // above white all is grey
  return (pureHue(v.x) - grey(F(0.5f))) * chroma + grey(v.z);
}

// c moved to luminance l; then its distance from grey is cut until it fits 0..1.
template <int W>
KN_INLINE Rgb<W> withLuminance(Rgb<W> c, Float<W> l) {
  using F = Float<W>;
  Rgb<W> r = c + grey(l - luminance(c));
  const F low = minComponent(r), high = maxComponent(r);
  const F down = select(low < F(0.f), l / max(l - low, F(1e-20f)), F(1.f));
  const F up = select(high > F(1.f), (F(1.f) - l) / max(high - l, F(1e-20f)), F(1.f));
  const F keep = max(min(down, up), F(0.f));
  return grey(l) + (r - grey(l)) * keep;
}
// The saturation (largest minus smallest component) of c becomes s.
template <int W>
KN_INLINE Rgb<W> withSpan(Rgb<W> c, Float<W> s) {
  using F = Float<W>;
  const F low = minComponent(c), span = maxComponent(c) - low;
  return (c - grey(low)) * select(span > F(0.f), s / max(span, F(1e-20f)), F(0.f));
}
template <int W>
KN_INLINE Float<W> safeDivide(Float<W> a, Float<W> b) {
  using F = Float<W>;
  return select(b > F(0.f), a / max(b, F(1e-20f)), select(a > F(0.f), F(1.f), F(0.f)));
}

// One component of a blend; a: bottom, b: top.
template <int W>
KN_INLINE Float<W> blendComponent(Blend op, Float<W> a, Float<W> b) {
  using F = Float<W>;
  const F one(1.f), zero(0.f), half(0.5f), two(2.f);
  switch (op) {
    case Blend::ColorBurn:
      return one - min(safeDivide(one - a, b), one);
    case Blend::ColorDodge:
      return min(safeDivide(a, one - b), one);
    case Blend::Darken:
      return min(a, b);
    case Blend::Lighten:
      return max(a, b);
    case Blend::Difference:
      return abs(a - b);
    case Blend::Divide:
      return safeDivide(a, b);
    case Blend::Exclusion:
      return fnma(two, (a - half) * (b - half), half);
    case Blend::HardLight:
      return select(b <= half, two * a * b, one - two * (one - a) * (one - b));
    case Blend::HardMix:
      return select(a + b >= one, one, zero);
    case Blend::LinearBurn:
      return a + b - one;
    case Blend::LinearDodge:
      return a + b;
    case Blend::LinearLight:
      return fma(two, b, a) - one;
    case Blend::Multiply:
      return a * b;
    case Blend::Overlay:
      return select(a <= half, two * a * b, one - two * (one - a) * (one - b));
    case Blend::PinLight:
      return select(b <= half, min(a, two * b), max(a, fma(two, b, -one)));
    case Blend::Screen:
      return one - (one - a) * (one - b);
    // W3C compositing, "soft-light"
    case Blend::SoftLight: {
      const F root = select(a <= F(0.25f), fma(fma(F(16.f), a, F(-12.f)), a, F(4.f)) * a, safeSqrt(a));
      const F t = fma(two, b, -one);
      return select(b <= half, fma(t * a, one - a, a), fma(t, root - a, a));
    }
    case Blend::Subtract:
      return a - b;
    case Blend::VividLight:
      return select(b <= half, one - min(safeDivide(one - a, two * b), one),
                    min(safeDivide(a, two * (one - b)), one));
    default:
      return b;
  }
}
// bottom under top, before alpha. Dissolve needs a random number and is the caller's; it counts as Normal here.
template <int W>
KN_INLINE Rgb<W> blendColors(Blend op, Rgb<W> a, Rgb<W> b) {
  switch (op) {
    case Blend::Color:
      return withLuminance(b, luminance(a));
    case Blend::Luminosity:
      return withLuminance(a, luminance(b));
    case Blend::Hue:
      return withLuminance(withSpan(b, maxComponent(a) - minComponent(a)), luminance(a));
    case Blend::Saturation:
      return withLuminance(withSpan(a, maxComponent(b) - minComponent(b)), luminance(a));
    case Blend::DarkerColor:
      return select(luminance(b) < luminance(a), b, a);
    case Blend::LighterColor:
      return select(luminance(b) > luminance(a), b, a);
    default:
      return {blendComponent(op, a.x, b.x), blendComponent(op, a.y, b.y), blendComponent(op, a.z, b.z)};
  }
}
// The whole of one blend: top with alpha over a bottom with alpha (colours not multiplied by alpha).
template <int W>
KN_INLINE void blendOver(Blend op, Rgb<W>& color, Float<W>& alpha, Rgb<W> top, Float<W> topAlpha) {
  using F = Float<W>;
  // where the bottom is transparent there is nothing to blend with: the top alone
  const Rgb<W> mixed = lerp(top, blendColors(op, color, top), alpha);
  const F sum = fma(alpha, F(1.f) - topAlpha, topAlpha);
  const Rgb<W> through = color * (alpha * (F(1.f) - topAlpha)) + mixed * topAlpha;
  color = select(sum > F(0.f), through * (F(1.f) / max(sum, F(1e-20f))), Rgb<W>());
  alpha = sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
