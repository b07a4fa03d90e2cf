// Colour of the language on wide and dual triples: conversions between the spaces of color_system.h (with
// derivatives), luminance, black bodies and wavelengths (without). Included per target.
#include "language/library/color_system.h"
#include "language/library/vector.h"
#include <kinora/math/elementary.h>

#if defined(KINORA_LANGUAGE_COLOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_COLOR_H_TARGET
#undef KINORA_LANGUAGE_COLOR_H_TARGET
#else
#define KINORA_LANGUAGE_COLOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <class V>
KN_INLINE V applyColorMatrix(const float* m, V c) {
  using Plain = decltype(valueOf(c.x));
  const auto row = [&](int i) HWY_ATTR {
    return c.x * Plain(m[3 * i]) + c.y * Plain(m[3 * i + 1]) + c.z * Plain(m[3 * i + 2]);
  };
  return {row(0), row(1), row(2)};
}
template <class V>
KN_INLINE auto luminance(const language::ColorSystem& s, V c) {
  using Plain = decltype(valueOf(c.x));
  return c.x * Plain(s.luminance[0]) + c.y * Plain(s.luminance[1]) + c.z * Plain(s.luminance[2]);
}

template <class V>
KN_INLINE V hsvToRgb(V c) {
  using F = decltype(c.x + c.y);
  using Plain = decltype(valueOf(c.x));
  const Plain one(1.f), hv = valueOf(c.x);
  const F s = c.y, v = c.z, h = (c.x - HWY_NAMESPACE::floor(hv)) * Plain(6.f);
  const Plain i = HWY_NAMESPACE::floor(valueOf(h));
  const F f = h - i, p = v * (one - s), q = v * (one - s * f), t = v * (one - s * (one - f));
  V r(v, p, q);
  r = choose(i == Plain(4.f), V(t, p, v), r);
  r = choose(i == Plain(3.f), V(p, q, v), r);
  r = choose(i == Plain(2.f), V(p, v, t), r);
  r = choose(i == Plain(1.f), V(q, v, p), r);
  r = choose(i == Plain(0.f), V(v, t, p), r);
  return choose(valueOf(s) < Plain(0.0001f), V(v, v, v), r);
}
template <class V>
KN_INLINE V rgbToHsv(V c) {
  using F = decltype(c.x + c.y);
  using Plain = decltype(valueOf(c.x));
  const F r = c.x, g = c.y, b = c.z;
  const F most = greatest(r, greatest(g, b)), least = lang::least(r, lang::least(g, b)), D = most - least;
  const Plain mv = valueOf(most), zero(0.f);
  const F s = keep(mv > zero, divide(D, most));
  const F six = D * Plain(6.f);
  F h = Plain(2.f / 3.f) + divide(r - g, six);
  h = choose(valueOf(g) >= mv, Plain(1.f / 3.f) + divide(b - r, six), h);
  h = choose(valueOf(r) >= mv, divide(g - b, six), h);
  h = choose(valueOf(h) < zero, h + Plain(1.f), h);
  return {keep(valueOf(s) > zero, h), s, most};
}
template <class V>
KN_INLINE V hslToRgb(V c) {
  using F = decltype(c.x + c.y);
  using Plain = decltype(valueOf(c.x));
  const Plain one(1.f);
  const F s = c.y, l = c.z;
  const F v = choose(valueOf(l) <= Plain(0.5f), l * (one + s), l * (one - s) + s);
  const F least = l * Plain(2.f) - v;
  return keep(valueOf(v) > Plain(0.f), hsvToRgb(V(c.x, divide(v - least, v), v)));
}
template <class V>
KN_INLINE V rgbToHsl(V c) {
  using F = decltype(c.x + c.y);
  using Plain = decltype(valueOf(c.x));
  const F most = greatest(c.x, greatest(c.y, c.z)), least = lang::least(c.x, lang::least(c.y, c.z));
  const F l = (least + most) * Plain(0.5f);
  const F width = choose(valueOf(l) <= Plain(0.5f), most + least, Plain(2.f) - most - least);
  const auto grey = valueOf(most) == valueOf(least);
  return {keep(!grey, rgbToHsv(c).x), keep(!grey, divide(most - least, width)), l};
}
inline constexpr float kRgbToYiq[9] = {.299f, .587f, .114f, .596f, -.275f, -.321f, .212f, -.523f, .311f};
inline constexpr float kYiqToRgb[9] = {1, .9557f, .6199f, 1, -.2716f, -.6469f, 1, -1.1082f, 1.7051f};
template <class V>
KN_INLINE V xyzToXyY(V c) {
  using F = decltype(c.x + c.y);
  const F n = c.x + c.y + c.z;
  const auto some = !(valueOf(n) < decltype(valueOf(n))(1e-6f));
  return {keep(some, divide(c.x, n)), keep(some, divide(c.y, n)), c.y};
}
template <class V>
KN_INLINE V xyYToXyz(V c) {
  using F = decltype(c.x + c.y);
  using Plain = decltype(valueOf(c.x));
  const auto some = valueOf(c.y) > Plain(1e-6f);
  const F scale = divide(c.z, c.y);
  return {keep(some, scale * c.x), c.z, keep(some, scale * (Plain(1.f) - c.x - c.y))};
}
// x^y for x > 0 by the renderer's own functions: the language's pow would show in the last printed digit.
template <int W>
KN_INLINE Float<W> powerOf(Float<W> x, float y) {
  return HWY_NAMESPACE::pow(x, Float<W>(y));
}
template <int W>
KN_INLINE Dual<W> powerOf(Dual<W> x, float y) {
  const Float<W> r = powerOf(x.v, y);
  return chain(r, Float<W>(y) * divide(r, x.v), x);
}
template <class F>
KN_INLINE F srgbDecode(F x) {
  using Plain = decltype(valueOf(x));
  const F curve = powerOf((x + Plain(.055f)) * Plain(1.f / 1.055f), 2.4f);
  return choose(valueOf(x) <= Plain(.04045f), x * Plain(1.f / 12.92f), curve);
}
template <class F>
KN_INLINE F srgbEncode(F x) {
  using Plain = decltype(valueOf(x));
  const F curve = powerOf(x, 1.f / 2.4f) * Plain(1.055f) - Plain(.055f);
  return choose(valueOf(x) <= Plain(.0031308f), x * Plain(12.92f), curve);
}

template <class V>
KN_INLINE V toRgb(const language::ColorSystem& s, language::ColorSpace from, V c) {
  using language::ColorSpace;
  switch (from) {
    case ColorSpace::Hsv:
      return hsvToRgb(c);
    case ColorSpace::Hsl:
      return hslToRgb(c);
    case ColorSpace::Yiq:
      return applyColorMatrix(kYiqToRgb, c);
    case ColorSpace::Xyz:
      return applyColorMatrix(s.xyzToRgb, c);
    case ColorSpace::XyY:
      return applyColorMatrix(s.xyzToRgb, xyYToXyz(c));
    case ColorSpace::Srgb:
      return {srgbDecode(c.x), srgbDecode(c.y), srgbDecode(c.z)};
    default:
      return c;
  }
}
template <class V>
KN_INLINE V fromRgb(const language::ColorSystem& s, language::ColorSpace to, V c) {
  using language::ColorSpace;
  switch (to) {
    case ColorSpace::Hsv:
      return rgbToHsv(c);
    case ColorSpace::Hsl:
      return rgbToHsl(c);
    case ColorSpace::Yiq:
      return applyColorMatrix(kRgbToYiq, c);
    case ColorSpace::Xyz:
      return applyColorMatrix(s.rgbToXyz, c);
    case ColorSpace::XyY:
      return xyzToXyY(applyColorMatrix(s.rgbToXyz, c));
    case ColorSpace::Srgb:
      return {srgbEncode(c.x), srgbEncode(c.y), srgbEncode(c.z)};
    default:
      return c;
  }
}
template <class V>
KN_INLINE V transformc(const language::ColorSystem& s, language::ColorSpace from, language::ColorSpace to, V c) {
  if (from == to) return c;
  return fromRgb(s, to, toRgb(s, from, c));
}

template <int W>
KN_INLINE Vec3<W> wavelengthColor(const language::ColorSystem& s, Float<W> nanometres) {
  using F = Float<W>;
  const F at = (nanometres - F(380.f)) / F(5.f);
  const Mask<W> visible = (at > F(-1.f)) & (at < F(80.f));  // int(i) in 0..79
  const F inside = keep(visible, at);
  const Int<W> i = toInt(inside), first = i * Int<W>(3);
  const F t = inside - toFloat(i);
  const float* table = language::matchingFunctions();
  Vec3<W> xyz;
  F* const c[3] = {&xyz.x, &xyz.y, &xyz.z};
  for (int k = 0; k < 3; ++k)
    *c[k] = HWY_NAMESPACE::gather(table + k, first) * (F(1.f) - t) + HWY_NAMESPACE::gather(table + k + 3, first) * t;
  const Vec3<W> rgb = applyColorMatrix(s.xyzToRgb, xyz) * F(1.f / 2.52f);
  const F zero(0.f);
  return keep(visible, Vec3<W>(greatest(rgb.x, zero), greatest(rgb.y, zero), greatest(rgb.z, zero)));
}
template <int W>
KN_INLINE Vec3<W> blackbody(const language::ColorSystem& s, Float<W> kelvin) {
  using F = Float<W>;
  const Mask<W> cold = kelvin < F(language::kBlackbodyLeast), hot = kelvin >= F(language::kBlackbodyMost);
  const F inside = keep((kelvin >= F(language::kBlackbodyLeast)) & !hot, kelvin - F(language::kBlackbodyLeast));
  const F half = inside * F(0.5f);
  F root = lang::cbrt(half);
  root = keep(half > F(0.f), F(1.f / 3.f) * (F(2.f) * root + half / (root * root)));  // to all digits
  const F at = root * root;
  const Int<W> i = toInt(at), first = i * Int<W>(3);
  const F t = at - toFloat(i);
  const float* table = s.blackbodyRoots.data();
  Vec3<W> r;
  F* const c[3] = {&r.x, &r.y, &r.z};
  for (int k = 0; k < 3; ++k) {
    const F fifth =
        HWY_NAMESPACE::gather(table + k, first) * (F(1.f) - t) + HWY_NAMESPACE::gather(table + k + 3, first) * t;
    const F square = fifth * fifth;
    *c[k] = square * square * fifth;
  }
  if (hot.any()) {  // rare: by the spectrum, lane by lane
    float temperature[W], rgb[3][W];
    kelvin.store(temperature);
    for (int k = 0; k < 3; ++k) c[k]->store(rgb[k]);
    for (uint32_t b = hot.bits(); b; b &= b - 1) {
      const int lane = __builtin_ctz(b);
      const auto color = language::blackbodyColor(s, temperature[lane]);
      for (int k = 0; k < 3; ++k) rgb[k][lane] = color[size_t(k)];
    }
    for (int k = 0; k < 3; ++k) *c[k] = F::load(rgb[k]);
  }
  return choose(cold, Vec3<W>(F(1e-6f), F(0.f), F(0.f)), r);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
