// Hair by Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model for Production Path
// Tracing" (EGSR 2016): one fibre, its parameters, and its values and directions at W points. Used by LamaHairChiang,
// and by LamaHairSurface, where several of them share a surface. Included per target.
#include "plugins/bxdf/hair/fiber.h"

#ifndef KINORA_HAIR_CHIANG_ONCE
#define KINORA_HAIR_CHIANG_ONCE
namespace kinora::hair {

// Parameters in the order in which ChiangClosure binds them; names and help begin with the texts given.
constexpr uint32_t kChiangParams = 12;
#define KINORA_HAIR_CHIANG_PARAMS(NAME, HELP)                                                                        \
  param::integer(NAME "colorMode", 0)                                                                                \
      .range(0, 2)                                                                                                   \
      .options("0 colorTT, 1 melanin, 2 absorption")                                                                 \
      .help(HELP "What says how much the inside absorbs."),                                                          \
      param::color(NAME "colorR", 1.f).help(HELP "Tint of reflection: white where it is physical."),                 \
      param::color(NAME "colorTT", 0.8f, 0.5f, 0.3f)                                                                 \
          .help(HELP "Mode 0: colour of hair as a whole, all bounces between fibres in."),                           \
      param::color(NAME "colorTintTT", 1.f)                                                                          \
          .help(HELP "Tint of light that goes through, besides what the inside absorbs."),                           \
      param::color(NAME "colorTintTRT", 1.f)                                                                         \
          .help(HELP "The same of light that is reflected inside, and of longer paths."),                            \
      param::number(NAME "eumelanin", 1.3f)                                                                          \
          .range(0, 8)                                                                                               \
          .help(HELP "Mode 1: concentration of the brown pigment: 0.3 blond, 1.3 brown, 8 black."),                  \
      param::number(NAME "pheomelanin", 0.f).range(0, 8).help(HELP "Mode 1: concentration of the red pigment."),     \
      param::color(NAME "absorption", 0.5f).help(HELP "Mode 2: absorption in a length of the fibre's radius."),      \
      param::number(NAME "longitudinalRoughness", 0.3f)                                                              \
          .range(0.05f, 1)                                                                                           \
          .help(HELP                                                                                                 \
                "Width of all lobes along the fibre, the paper's beta_M; light that goes through has half of that "  \
                "width, "                                                                                            \
                "what is reflected inside twice."),                                                                  \
      param::number(NAME "azimuthalRoughness", 0.3f)                                                                 \
          .range(0.05f, 1)                                                                                           \
          .help(HELP "Width of the lobes about the fibre: beta_N. At 0.05, the least of both, that is a degree."),   \
      param::number(NAME "offset", 2.f)                                                                              \
          .range(-10, 10)                                                                                            \
          .help(HELP                                                                                                 \
                "Tilt of the cuticle's scales, degrees: above 0 they shift reflection towards the root by twice as " \
                "much, "                                                                                             \
                "the second highlight towards the tip by 4 times."),                                                 \
      param::number(NAME "IOR", 1.55f).range(1.2f, 1.9f).help(HELP "Index of refraction.")

struct ChiangClosure {
  bool adjoint = false;
  int mode = 0;
  Value colorR, colorTT, tintTT, tintTRT, eumelanin, pheomelanin, absorption, along, about, offset, ior;
  FiberPlace place;
  void bind(const Context& c, uint32_t first) {
    adjoint = c.traits & kTraitLightPath;
    mode = int(c.param(first).data[0][0]);
    Value* const values[] = {&colorR,     &colorTT, &tintTT, &tintTRT, &eumelanin, &pheomelanin,
                             &absorption, &along,   &about,  &offset,  &ior};
    for (Value* v : values) *v = c.param(++first);
    place.bind(c);
  }
};

}  // namespace kinora::hair
#endif

#if defined(KINORA_HAIR_CHIANG_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_HAIR_CHIANG_H_TARGET
#undef KINORA_HAIR_CHIANG_H_TARGET
#else
#define KINORA_HAIR_CHIANG_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Ways to make a direction: the paths of HairPath without glints, then all longer ones.
enum ChiangTechnique : uint32_t { kChiangLonger = kPathGlint, kChiangTechniques };

template <int W>
struct ChiangFiber {
  using F = Float<W>;
  // What is known of the direction that light comes from, whichever of the two that is.
  struct Side {
    Inclination<W> shifted[3];  // seen from the cuticle's scales
    FiberHit<W> hit;
    Rgb<W> share[kChiangTechniques];  // of the light, by path
    F energy[kChiangTechniques], total;
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
  KN_INLINE ChiangFiber() {}

  HWY_ATTR HWY_NOINLINE ChiangFiber(const hair::ChiangClosure& k, const Surface<W>& s)
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
      const F brown = max(loadFloat<W>(k.eumelanin, s.at), none), red = max(loadFloat<W>(k.pheomelanin, s.at), none);
      absorption = Rgb<W>(fma(brown, F(0.419f), red * F(0.187f)), fma(brown, F(0.697f), red * F(0.4f)),
                          fma(brown, F(1.37f), red * F(1.05f)));
    } else {
      absorption = positive(loadRgb<W>(k.absorption, s.at));
    }
    own = sideOf(frame.outgoing, frame.gamma);
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
    s.share[kChiangLonger] = s.share[kPathTRT] * Rgb<W>(longer(passes.x), longer(passes.y), longer(passes.z));
    s.total = F(0.f);
    for (uint32_t k = 0; k < kChiangTechniques; ++k) s.total += s.energy[k] = average(s.share[k]);
    return s;
  }
  // Densities by technique of light that leaves with an inclination, at an azimuth from where it comes from.
  KN_INLINE void densities(const Side& from, const Inclination<W>& i, F phi, F out[kChiangTechniques]) const {
    for (uint32_t p = 0; p < 3; ++p)
      out[p] = along[p].density(from.shifted[p], i) * about.density(phi - from.hit.centre[p]);
    out[kChiangLonger] = along[kPathTRT].density(from.shifted[kPathTRT], i) * F(kInvTwoPi);
  }
  // To the lobes from `lobe` on: R, TT and TRT, of each that of wo's side and that from behind.
  template <class Scale>
  KN_INLINE void add(const Side& side, const F density[kChiangTechniques], Scale scale, Vec3<W> wi, uint32_t lobe,
                     LobeSum<W>& out) const {
    const Mask<W> above = dot(Ng, wi) >= F(0.f);
    for (uint32_t p = 0; p < 3; ++p) {
      Rgb<W> w = side.share[p] * (scale * density[p]);
      if (p == kPathTRT) w += side.share[kChiangLonger] * (scale * density[kChiangLonger]);
      out.add(lobe + 2 * p, zeroUnless(above, w));
      out.add(lobe + 2 * p + 1, zeroUnless(!above, w));
    }
  }

  KN_INLINE void sample(F u, F v, F w, LobeSample<W>& out) const {
    const ChosenTechnique<W> chosen(own.energy, own.total, w);
    const Int<W> which = chosen.which;
    const F third = chosen.rest;
    out.wi =
        normalize(sampleFiber(frame, along, own.shifted, which, kChiangTechniques, u, v, [&](uint32_t p) HWY_ATTR {
          return p < 3 ? own.hit.centre[p] + about.sample(third) : third * F(kTwoPi);
        }));
    out.valid = chosen.found;
    out.discrete = Mask<W>(false);
    out.below = Mask<W>(false);
  }
  KN_INLINE Rgb<W> albedo() const {
    Rgb<W> sum;
    for (uint32_t k = 0; k < kChiangTechniques; ++k) sum += own.share[k];
    return sum;
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
