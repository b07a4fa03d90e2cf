// PxrHairColor: colours of hair for PxrMarschnerHair, from melanin or from the colour that hair shall have as a whole.
// Absorption by eumelanin: d'Eon et al., "An Energy-Conserving Hair Reflectance Model" (EGSR 2011), section 6.1. Between
// absorption and the colour of hair as a whole: Chiang et al. (EGSR 2016), section 4.2, for their azimuthal roughness .3.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrHairColor/PxrHairColor.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/variation/vary.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kMode,
  kColorSpace,
  kMelanin,
  kColor,
  kRandomMelanin,
  kRandomColor,
  kDarkenRoots,
  kDarkenSlope,
  kDarkenEnd,
  kStrayDensity,
  kStrayMelanin,
  kStrayColor,
  kStrayRandomMelanin,
  kStrayRandomColor,
  kDye,
  kRandomDyeHue,
  kRandomDyeSaturation,
  kHairIndex,
  kRandPivot,
  kFirstOutput
};
#define KINORA_BY_HAIR " Needs hairIndexPrimvar."
constexpr Param kParams[] = {
    param::integer("mode", 0).options("0 melanin, 1 colour").help("What the colour of hair is made of."),
    param::flag("colorSpace", false).help("No effect: colours are scene-linear."),
    param::number("melanin", 0.2f)
        .help("Concentration of melanin: 0 white, 0.2 blond, 0.5 brown, 0.8 dark brown, 1 black."),
    param::color("color", 0.5f)
        .help("Mode 1: colour of hair as a whole, with all the light that goes from hair to hair."),
    param::number("randomMelanin", 0.05f)
        .help("Largest change of the melanin from hair to hair, a fraction of it." KINORA_BY_HAIR),
    param::color("randomColor", 0.f)
        .help("Mode 1: largest change of the colour from hair to hair, a fraction of each channel." KINORA_BY_HAIR),
    param::number("darkenRoots", 0.f).help("Melanin added at the root."),
    param::number("darkenSlope", 1.f).range(0.1f, 4).help("How it fades: 1 evenly, above 1 mostly near the root."),
    param::number("darkenEndPosition", 0.5f).help("Where along the hair it ends: 0 the root, 1 the tip."),
    param::number("strayDensity", 0.1f).help("Share of stray hairs: white ones come with age." KINORA_BY_HAIR),
    param::number("strayMelanin", 0.05f).help("Melanin of stray hairs."),
    param::color("strayColor", 0.8f).help("Mode 1: colour of stray hairs."),
    param::number("strayRandomMelanin", 0.f).help("As randomMelanin, of stray hairs."),
    param::color("strayRandomColor", 0.f).help("As randomColor, of stray hairs."),
    param::color("dye", 1.f).help("Colour of a dye on white hair; its absorption adds to the hair's. White: none."),
    param::number("randomDyeHue", 0.f).help("Largest change of the dye's hue: 1 goes all around." KINORA_BY_HAIR),
    param::number("randomDyeSaturation", 0.f).help("Largest change of the dye's saturation." KINORA_BY_HAIR),
    param::string("hairIndexPrimvar", "")
        .help("Primitive variable that is another number for each hair (uniform). Empty: all hairs are alike."),
    param::number("randPivot", 0.5f).help("No effect: variations go to both sides alike."),
    param::output(Type::Color, "resultDiff"),
    param::output(Type::Color, "resultTT"),
    param::output(Type::Color, "resultTRT"),
};

struct PxrHairColor {
  struct Inputs {
    Value number[kHairIndex], index, v, has;  // has: above 0 where there is an index; no components: everywhere
    bool artistic, varies;
    explicit Inputs(const Context& c) {
      for (uint32_t i = kMelanin; i < kHairIndex; ++i) number[i] = c.param(i);
      artistic = fixedInteger(c, kMode) == 1;
      const Primvar hair(c, c.fn->text(&c, kHairIndex));
      index = hair.value;
      varies = hair.isSomewhere;
      if (varies && !hair.isEverywhere) shareComponent(hair.radius, kPrimvarComponents, has);
      v = c.builtin(Builtin::V);
    }
  };
  // A number of [-1, 1) for each hair and purpose.
  template <int W>
  static KN_INLINE Float<W> drawn(Int<W> hair, uint32_t purpose) {
    return fma(Float<W>(2.f), toUnitFloat(hashWords(hair, Int<W>(0x2545f491u + purpose))), Float<W>(-1.f));
  }
  // Absorption for melanin of 0..1: d'Eon's eumelanin, its amount growing without bounds towards 1.
  template <int W>
  static KN_INLINE Rgb<W> ofMelanin(Float<W> melanin) {
    using F = Float<W>;
    const F amount = -log(max(F(1.f) - max(melanin, F(0.f)), F(1e-4f)));
    return Rgb<W>(F(0.419f), F(0.697f), F(1.37f)) * amount;
  }
  static constexpr float kWhole = 5.8884f;  // Chiang's polynomial of the azimuthal roughness at .3
  template <int W>
  static KN_INLINE Rgb<W> ofColor(Rgb<W> c) {
    using F = Float<W>;
    const auto one = [](F x) {
      const F l = log(clamp(x, F(1e-4f), F(1.f))) * F(1.f / kWhole);
      return l * l;
    };
    return {one(c.x), one(c.y), one(c.z)};
  }
  template <int W>
  static KN_INLINE Rgb<W> fading(Rgb<W> depth) {
    return {exp(-depth.x), exp(-depth.y), exp(-depth.z)};
  }

  template <int W>
  static KN_INLINE Rgb<W> absorption(const Inputs& s, At at) {
    using F = Float<W>;
    Int<W> hair(0u);
    Mask<W> stray(false);
    F random(0.f);
    Mask<W> varies(s.varies);
    if (s.has.components) varies = loadFloat<W>(s.has, at) > F(0.f);
    const auto variation = [&](uint32_t purpose) { return zeroUnless(varies, drawn(hair, purpose)); };
    if (s.varies) {
      hair = hashWords(Int<W>(0x68616972u), seedOf(loadComponent<W>(s.index, 0, at)));
      stray = varies & (fma(drawn(hair, 0), F(0.5f), F(0.5f)) < loadFloat<W>(s.number[kStrayDensity], at));
      random = variation(1);
    }
    const auto number = [&](uint32_t own, uint32_t ofStray) {
      return select(stray, loadFloat<W>(s.number[ofStray], at), loadFloat<W>(s.number[own], at));
    };
    const F end = loadFloat<W>(s.number[kDarkenEnd], at);
    const F left = clamp(F(1.f) - loadFloat<W>(s.v, at) / max(end, F(1e-6f)), F(0.f), F(1.f));
    const F roots = max(loadFloat<W>(s.number[kDarkenRoots], at), F(0.f)) *
                    pow(left, max(loadFloat<W>(s.number[kDarkenSlope], at), F(1e-3f)));
    Rgb<W> sum;
    if (s.artistic) {
      Rgb<W> c = select(stray, loadRgb<W>(s.number[kStrayColor], at), loadRgb<W>(s.number[kColor], at));
      const Rgb<W> range =
          select(stray, loadRgb<W>(s.number[kStrayRandomColor], at), loadRgb<W>(s.number[kRandomColor], at));
      if (s.varies)
        c = c * Rgb<W>(fma(range.x, variation(2), F(1.f)), fma(range.y, variation(3), F(1.f)),
                       fma(range.z, variation(4), F(1.f)));
      sum = ofColor(c) + ofMelanin(roots);
    } else {
      const F m = number(kMelanin, kStrayMelanin), range = number(kRandomMelanin, kStrayRandomMelanin);
      sum = ofMelanin(clamp(m * fma(range, random, F(1.f)), F(0.f), F(1.f)) + roots);
    }
    Vec3<W> dye = loadRgb<W>(s.number[kDye], at);
    if (s.varies) {
      Vec3<W> hsv = rgbToHsv(dye);
      hsv.x = fma(loadFloat<W>(s.number[kRandomDyeHue], at), F(0.5f) * variation(5), hsv.x);
      hsv.y =
          clamp(hsv.y * fma(loadFloat<W>(s.number[kRandomDyeSaturation], at), variation(6), F(1.f)), F(0.f), F(1.f));
      dye = select(varies, hsvToRgb(hsv), dye);  // the way there and back changes last bits
    }
    return sum + ofColor(dye);
  }

  template <int W>
  static void compute(const Context* c, const PatternArgs* a) {
    using F = Float<W>;
    const Inputs s(*c);
    float* out[3][3];
    for (uint32_t k = 0; k < 3; ++k) makeOutput(*c, a->outputs[k], 3, out[k]);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const Rgb<W> sigma = absorption<W>(s, At{i, false});
      // the mean way through a fibre of radius 1 and index 1.55, of light that comes from the side
      const Rgb<W> through = fading(sigma * F(1.86f));
      fading(Rgb<W>(sqrt(sigma.x), sqrt(sigma.y), sqrt(sigma.z)) * F(kWhole)).store(out[0], i);
      through.store(out[1], i);
      (through * through).store(out[2], i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrHairColor, .help = "Colours of hair from melanin, or from the colour that hair has as a whole.",
               .params = kParams)
