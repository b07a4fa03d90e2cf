// Random changes of a colour by a seed: hue, saturation, luminance and gamma. What PxrVary and PxrMultiTexture have in
// common. Included per target.
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>
#include <kinora/random.h>

#ifndef KINORA_VARY_ONCE
#define KINORA_VARY_ONCE
#define KINORA_VARY_MODES "0 centered, 1 up, 2 down"
#define KINORA_VARY_AMOUNTS(hue, saturation, luminance, gamma)                                    \
  param::number(hue, 0.f).help("Largest change of the hue: 1 goes all around."),                  \
      param::number(saturation, 0.f).help("Largest change of the saturation, a fraction of it."), \
      param::number(luminance, 0.f).help("Largest change of the brightness, a fraction of it."),  \
      param::number(gamma, 0.f).help("Largest change of the gamma: 1 doubles or halves it.")
#define KINORA_VARY_SIDES                                                                             \
  param::integer("hueMode", 0).range(0, 2).options(KINORA_VARY_MODES).help("To which side hues go."), \
      param::integer("saturationMode", 0)                                                             \
          .range(0, 2)                                                                                \
          .options(KINORA_VARY_MODES)                                                                 \
          .help("To which side saturations go."),                                                     \
      param::integer("luminanceMode", 0)                                                              \
          .range(0, 2)                                                                                \
          .options(KINORA_VARY_MODES)                                                                 \
          .help("To which side brightness goes."),                                                    \
      param::integer("gammaMode", 0).range(0, 2).options(KINORA_VARY_MODES).help("To which side gammas go.")
#define KINORA_VARY_SOURCE                   \
  param::integer("randomSource", 0)          \
      .options("0 object id, 1 object name") \
      .help("What has a variation of its own. Names count by the object's id.")
#endif

#if defined(KINORA_VARY_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_VARY_H_TARGET
#undef KINORA_VARY_H_TARGET
#else
#define KINORA_VARY_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Bits of a number as a seed; -0 counts as 0.
template <int W>
KN_INLINE Int<W> seedOf(Float<W> x) {
  return asInt(x + Float<W>(0.f));
}

struct Variation {
  enum : uint32_t { kHue, kSaturation, kLuminance, kGamma, kCount };
  Value amount[kCount];
  int mode[kCount];
  // amounts and modes are parameters that follow each other.
  Variation(const Context& c, uint32_t firstAmount, uint32_t firstMode) {
    for (uint32_t k = 0; k < kCount; ++k) {
      amount[k] = c.param(firstAmount + k);
      mode[k] = fixedInteger(c, firstMode + k);
    }
  }
  bool uniform() const { return allUniform({&amount[0], &amount[1], &amount[2], &amount[3]}); }
  bool isOff() const {
    for (const Value& v : amount)
      if (!v.uniform() || v.data[0][0] != 0.f) return false;
    return true;
  }
  // The amount times a random number of -1..1, 0..1 or -1..0.
  template <int W>
  KN_INLINE Float<W> drawn(uint32_t k, Int<W> seed, At at) const {
    using F = Float<W>;
    const F u = toUnitFloat(hashWords(seed, Int<W>(0x51ed270bu + k)));
    const F v = mode[k] == 1 ? u : mode[k] == 2 ? u - F(1.f) : fma(F(2.f), u, F(-1.f));
    return v * loadFloat<W>(amount[k], at);
  }
  template <int W>
  KN_INLINE Rgb<W> apply(Rgb<W> c, Int<W> seed, At at) const {
    using F = Float<W>;
    // centred, a full variation of the hue reaches half a turn to either side
    const F turn = drawn(kHue, seed, at) * F(mode[kHue] == 0 ? 0.5f : 1.f);
    Vec3<W> v = rgbToHsv(c);
    // colours below zero would not survive the trip through hue
    c = select(turn == F(0.f), c, hsvToRgb(Vec3<W>(v.x + turn, v.y, v.z)));
    // more saturation than the colour has room for would take channels below zero
    const Rgb<W> least{min(c.x, F(0.f)), min(c.y, F(0.f)), min(c.z, F(0.f))};
    c = lerp(grey(luminance(c)), c, max(F(1.f) + drawn(kSaturation, seed, at), F(0.f)));
    c = {max(c.x, least.x), max(c.y, least.y), max(c.z, least.z)};
    c = c * max(F(1.f) + drawn(kLuminance, seed, at), F(0.f));
    const F e = drawn(kGamma, seed, at), power = exp2(-e);
    const auto bent = [&](F x) { return select((e == F(0.f)) | (x <= F(0.f)), x, pow(max(x, F(1e-30f)), power)); };
    return {bent(c.x), bent(c.y), bent(c.z)};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
