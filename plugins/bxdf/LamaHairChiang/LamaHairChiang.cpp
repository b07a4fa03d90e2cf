// LamaHairChiang: hair and fur by Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model
// for Production Path Tracing" (EGSR 2016): reflection (R), light that goes through (TT), that is reflected inside (TRT)
// and all longer paths, for the offset across the width at which a ray meets the fibre. Roughnesses are perceptual, and
// the absorption is found from the colour that hair as a whole should have. Of its published names there are colorR,
// colorTT, colorTintTT, offset and IOR; the others, the units and the defaults are chosen here after the paper.
//
// As PxrMarschnerHair has it, what leaves stands for the whole passage (kBxdfFiber), energy is conserved for light
// that is followed from the eye, and light paths take the adjoint. Directions are made by path and exactly by its lobes.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaHairChiang/LamaHairChiang.cpp"
#include <kinora/bxdf_author.h>

#include "plugins/bxdf/hair/fiber.h"
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kColorMode,
  kColorR,
  kColorTT,
  kColorTintTT,
  kColorTintTRT,
  kEumelanin,
  kPheomelanin,
  kAbsorption,
  kLongitudinalRoughness,
  kAzimuthalRoughness,
  kOffset,
  kIor,
  kPresence
};
constexpr Param kParams[] = {
    param::integer("colorMode", 0)
        .range(0, 2)
        .options("0 colorTT, 1 melanin, 2 absorption")
        .help("What says how much the inside absorbs."),
    param::color("colorR", 1.f).help("Tint of reflection: white where it is physical."),
    param::color("colorTT", 0.8f, 0.5f, 0.3f)
        .help("Mode 0: colour of hair as a whole, all bounces between fibres in."),
    param::color("colorTintTT", 1.f).help("Tint of light that goes through, besides what the inside absorbs."),
    param::color("colorTintTRT", 1.f).help("The same of light that is reflected inside, and of longer paths."),
    param::number("eumelanin", 1.3f)
        .range(0, 8)
        .help("Mode 1: concentration of the brown pigment: 0.3 blond, 1.3 brown, 8 black."),
    param::number("pheomelanin", 0.f).range(0, 8).help("Mode 1: concentration of the red pigment."),
    param::color("absorption", 0.5f).help("Mode 2: absorption in a length of the fibre's radius."),
    param::number("longitudinalRoughness", 0.3f)
        .range(0.05f, 1)
        .help(
            "Width of all lobes along the fibre, the paper's beta_M; light that goes through has half of that width, "
            "what is reflected inside twice."),
    param::number("azimuthalRoughness", 0.3f)
        .range(0.05f, 1)
        .help("Width of the lobes about the fibre: beta_N. At 0.05, the least of both, that is a degree."),
    param::number("offset", 2.f)
        .range(-10, 10)
        .help(
            "Tilt of the cuticle's scales, degrees: above 0 they shift reflection towards the root by twice as much, "
            "the second highlight towards the tip by 4 times."),
    param::number("IOR", 1.55f).range(1.2f, 1.9f).help("Index of refraction."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    KINORA_LAMA_COMMON_OF("No effect: hair has no bumps.", KINORA_LAMA_LOBE_NAME)};

// Ways to make a direction: the paths of HairPath without glints, then all longer ones.
enum Technique : uint32_t { kMakeLonger = kPathGlint, kTechniques };
// Each scatters to both sides of the surface; one follows the other.
constexpr LobeDecl kLobes[] = {
    {"=lobeName:HairSpecularR", kLobeSpecular},   {"=lobeName:HairSpecularR", kLobeSpecular | kLobeTransmit},
    {"=lobeName:HairSpecularTT", kLobeSpecular},  {"=lobeName:HairSpecularTT", kLobeSpecular | kLobeTransmit},
    {"=lobeName:HairSpecularTRT", kLobeSpecular}, {"=lobeName:HairSpecularTRT", kLobeSpecular | kLobeTransmit}};
constexpr const char* kLossless[] = {
    "colorTT=1 1 1", "colorMode=2; absorption=0 0 0; longitudinalRoughness=0.1; azimuthalRoughness=0.1; offset=5",
    "colorMode=1; eumelanin=0; longitudinalRoughness=1; azimuthalRoughness=1; IOR=1.3",
    "colorTT=1 1 1; longitudinalRoughness=0.6; azimuthalRoughness=0.8; offset=0; IOR=1.8", nullptr};
constexpr const char* kConserving[] = {"", "colorMode=1; eumelanin=0.3; pheomelanin=1", nullptr};

struct LamaHairChiang {
  struct Closure {
    bool adjoint = false;
    int mode = 0;
    Value colorR, colorTT, tintTT, tintTRT, eumelanin, pheomelanin, absorption, along, about, offset, ior;
    hair::FiberPlace place;
  };
  static void begin(const Context& c, Closure& k) {
    k.adjoint = c.traits & kTraitLightPath;
    k.mode = int(c.param(kColorMode).data[0][0]);
    k.colorR = c.param(kColorR);
    k.colorTT = c.param(kColorTT);
    k.tintTT = c.param(kColorTintTT);
    k.tintTRT = c.param(kColorTintTRT);
    k.eumelanin = c.param(kEumelanin);
    k.pheomelanin = c.param(kPheomelanin);
    k.absorption = c.param(kAbsorption);
    k.along = c.param(kLongitudinalRoughness);
    k.about = c.param(kAzimuthalRoughness);
    k.offset = c.param(kOffset);
    k.ior = c.param(kIor);
    k.place.bind(c);
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }

  template <int W>
  struct Lanes {
    using F = Float<W>;
    // What is known of the direction that light comes from, whichever of the two that is.
    struct Side {
      Inclination<W> shifted[3];  // seen from the cuticle's scales
      FiberHit<W> hit;
      Rgb<W> share[kTechniques];  // of the light, by path
      F energy[kTechniques], total;
      KN_INLINE Side() {}
    };
    FiberFrame<W> frame;
    Vec3<W> Ng;
    AlongLobe<W> along[3];
    AboutLobe<W> about;
    F tiltSine[3], tiltCosine[3], ior;
    Rgb<W> tint[3], absorption;
    Side own;
    bool adjoint;

    HWY_ATTR HWY_NOINLINE Lanes(const Closure& k, const Surface<W>& s)
        : frame(k.place, s), Ng(s.Ng), adjoint(k.adjoint) {
      const F none(0.f), one(1.f);
      const F least(0.05f);
      const F m = clamp(loadFloat<W>(k.along, s.at), least, one), n = clamp(loadFloat<W>(k.about, s.at), least, one);
      // Section 4.1: the fits of what widths are perceived as even steps.
      const F n2 = n * n, n4 = n2 * n2, n8 = n4 * n4, m2 = m * m, m4 = m2 * m2, m8 = m4 * m4;
      const F deviation = fma(m, F(0.726f), fma(m2, F(0.812f), F(3.7f) * (m8 * m8 * m4)));
      along[kPathR] = AlongLobe<W>(deviation);
      along[kPathTT] = AlongLobe<W>(deviation * F(0.5f));  // a fourth of the variance, and four times of it
      along[kPathTRT] = AlongLobe<W>(deviation * F(2.f));
      // The fit is of a Gaussian's deviation; a logistic of as high a peak has sqrt(pi / 8) of it as its scale, and
      // pi / sqrt(3) of that is its own deviation.
      const F spread = fma(n, F(0.265f), fma(n2, F(1.194f), F(5.372f) * (n8 * n8 * n4 * n2)));
      about = AboutLobe<W>(spread * F(0.626657069f * 1.81379936f));
      const F tilt = loadFloat<W>(k.offset, s.at) * F(-kPi / 180.f);
      constexpr float kTilts[3] = {2.f, -1.f, -4.f};
      for (int p = 0; p < 3; ++p) sincos(tilt * F(kTilts[p]), tiltSine[p], tiltCosine[p]);
      ior = clamp(loadFloat<W>(k.ior, s.at), F(1.01f), F(4.f));
      tint[kPathR] = positive(loadRgb<W>(k.colorR, s.at));
      tint[kPathTT] = positive(loadRgb<W>(k.tintTT, s.at));
      tint[kPathTRT] = positive(loadRgb<W>(k.tintTRT, s.at));
      if (k.mode == 0) {
        // Section 4.2: from the colour of the whole, which depends on how widely light turns about the fibres.
        const F whole =
            fma(n, F(-0.215f), F(5.969f)) + n2 * fma(n, F(-10.73f), F(2.532f)) + n4 * fma(n, F(0.245f), F(5.574f));
        const Rgb<W> c = loadRgb<W>(k.colorTT, s.at);
        const auto of = [&](F x) {
          const F depth = log(clamp(x, F(1e-4f), one)) / whole;
          return depth * depth;
        };
        absorption = Rgb<W>(of(c.x), of(c.y), of(c.z));
      } else if (k.mode == 1) {
        // by concentration (d'Eon et al. 2011)
        const F brown = max(loadFloat<W>(k.eumelanin, s.at), none),
                red = max(loadFloat<W>(k.pheomelanin, s.at), none);
        absorption = Rgb<W>(fma(brown, F(0.419f), red * F(0.187f)), fma(brown, F(0.697f), red * F(0.4f)),
                            fma(brown, F(1.37f), red * F(1.05f)));
      } else {
        absorption = positive(loadRgb<W>(k.absorption, s.at));
      }
      own = sideOf(frame.outgoing, frame.gamma);
    }

    static KN_INLINE Rgb<W> positive(Rgb<W> c) {
      const F none(0.f);
      return {max(c.x, none), max(c.y, none), max(c.z, none)};
    }

    KN_INLINE Side sideOf(const Inclination<W>& o, F normal) const {
      const F one(1.f);
      Side s;
      s.hit = FiberHit<W>(o, normal, ior, ior, one, one);
      for (int p = 0; p < 3; ++p) s.shifted[p] = o.lessened(tiltSine[p], tiltCosine[p]);
      // one way through the inside: in projection a chord, as long as the inclination inside makes it
      F h, unused;
      sincos(normal, h, unused);
      const F eta = safeSqrt(fms(ior, ior, o.s * o.s)) / max(o.c, F(1e-3f)), sine = h / max(eta, one);
      const F cosInside = safeSqrt(fnma(o.s / ior, o.s / ior, one));
      const F way = F(2.f) * safeSqrt(fnma(sine, sine, one)) / cosInside;
      const Rgb<W> passes(exp(-(absorption.x * way)), exp(-(absorption.y * way)), exp(-(absorption.z * way)));
      const F f = s.hit.reflectance, t = one - f;
      const auto longer = [&](F through) { return f * through / max(fnma(f, through, one), F(1e-4f)); };
      const Rgb<W> tt = passes * (t * t), trt = tt * passes * f;
      s.share[kPathR] = tint[kPathR] * f;
      s.share[kPathTT] = tint[kPathTT] * tt;
      s.share[kPathTRT] = tint[kPathTRT] * trt;
      s.share[kMakeLonger] = s.share[kPathTRT] * Rgb<W>(longer(passes.x), longer(passes.y), longer(passes.z));
      s.total = F(0.f);
      for (uint32_t k = 0; k < kTechniques; ++k) s.total += s.energy[k] = average(s.share[k]);
      return s;
    }
    // Densities by technique of light that leaves with an inclination, at an azimuth from where it comes from.
    KN_INLINE void densities(const Side& from, const Inclination<W>& i, F phi, F out[kTechniques]) const {
      for (uint32_t p = 0; p < 3; ++p)
        out[p] = along[p].density(from.shifted[p], i) * about.density(phi - from.hit.centre[p]);
      out[kMakeLonger] = along[kPathTRT].density(from.shifted[kPathTRT], i) * F(kInvTwoPi);
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      evaluateFiber(*this, wi, out, [&](const Inclination<W>& i, F) HWY_ATTR { return sideOf(i, -frame.gamma); });
    }
    KN_INLINE void add(const Side& side, const F density[kTechniques], F scale, Vec3<W> wi, LobeSum<W>& out) const {
      const Mask<W> above = dot(Ng, wi) >= F(0.f);
      for (uint32_t p = 0; p < 3; ++p) {
        Rgb<W> w = side.share[p] * (scale * density[p]);
        if (p == kPathTRT) w += side.share[kMakeLonger] * (scale * density[kMakeLonger]);
        out.add(2 * p, zeroUnless(above, w));
        out.add(2 * p + 1, zeroUnless(!above, w));
      }
    }

    KN_INLINE void sample(F u, F v, F w, LobeSample<W>& out) const {
      const ChosenTechnique<W> chosen(own.energy, own.total, w);
      const Int<W> which = chosen.which;
      const F third = chosen.rest;
      out.wi = normalize(sampleFiber(frame, along, own.shifted, which, kTechniques, u, v, [&](uint32_t p) HWY_ATTR {
        return p < 3 ? own.hit.centre[p] + about.sample(third) : third * F(kTwoPi);
      }));
      out.valid = chosen.found;
      out.discrete = Mask<W>(false);
      out.below = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const {
      Rgb<W> sum;
      for (uint32_t k = 0; k < kTechniques; ++k) sum += own.share[k];
      return sum;
    }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(LamaHairChiang,
            .help = "Hair and fur by Chiang et al.: perceptual roughnesses, and a colour that hair has as a whole.",
            .params = kParams, .lobes = kLobes, .presenceParam = kPresence, .lossless = kLossless,
            .conserving = kConserving, .flags = kBxdfNotReciprocal | kBxdfFiber)
