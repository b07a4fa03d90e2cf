// PxrMarschnerHair: hair, fur and other fibres on curves. Reflection (R), transmission (TT), internal reflection (TRT), its
// caustics (glints), the rest of the longer paths, and a diffuse lobe. Papers: hair/fiber.h; diffuse lobes of Zinke et al.,
// "A Simple Analytic Model for Global Illumination in Hair" and Kajiya and Kay (SIGGRAPH 1989). Importance: by lobes, each
// exactly, longitudinally and azimuthally.
//
// Where a ray meets a curve says where across its width light goes in. What leaves stands for the whole passage: rays go on
// from the axis, on whatever side (kBxdfFiber). The model conserves energy for light that is followed from the eye; it is not
// reciprocal to the letter, so that light paths take its adjoint: the value with the two directions exchanged, times the ratio
// of the widths that the fibre shows them. Averaged over the width both are one.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrMarschnerHair/PxrMarschnerHair.cpp"
#include <kinora/bxdf_author.h>

#include "plugins/bxdf/hair/fiber.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kDiffuseModelType,
  kDiffuseGain,
  kDiffuseColor,
  kGainR,
  kGainTRT,
  kGainTT,
  kGainGlints,
  kColorR,
  kColorTRT,
  kColorTT,
  kConeR,
  kConeTRT,
  kConeTT,
  kOffset,
  kIor,
  kMixFresnel,
  kGlintWidth,
  kEccentricity,
  kEccentricityDirection,
  kGlowGain,
  kGlowColor,
  kEnergyCompensation,
  kShadowColor,
  kPresence,
  kInputAov
};
constexpr Param kParams[] = {
    param::integer("diffuseModelType", 0)
        .options("0 Zinke, 1 Kajiya")
        .help("Diffuse scattering of a white cylinder, more of it back than through, or the same on all sides."),
    param::number("diffuseGain", 0.f)
        .help("Multiplies the diffuse colour: fur and wool have much, human hair little."),
    param::color("diffuseColor", 0.18f).help("Fraction of light scattered diffusely."),
    param::number("specularGainR", 1.f).help("Multiplies reflection, the white highlight."),
    param::number("specularGainTRT", 1.f).help("Multiplies what is reflected inside, the coloured second highlight."),
    param::number("specularGainTT", 1.f).help("Multiplies what goes through, seen against the light."),
    param::number("specularGainGLINTS", 1.f)
        .help("Share of the second highlight that gathers in its caustics: 1 is half of it."),
    param::color("specularColorR", 1.f).help("Colour of reflection: white where it is physical."),
    param::color("specularColorTRT", 0.4f)
        .help("Colour of the second highlight and of glints: what is left after two ways through the fibre."),
    param::color("specularColorTT", 0.4f).help("Colour of light that goes through: what is left after one way."),
    param::number("specularConeAngleR", 8.f)
        .range(1, 40)
        .help("Width of reflection, degrees: standard deviation along the fibre and about it."),
    param::number("specularConeAngleTRT", 8.f).range(1, 40).help("Width of the second highlight, degrees."),
    param::number("specularConeAngleTT", 8.f).range(1, 40).help("Width of what goes through, degrees."),
    param::number("specularOffset", -3.f)
        .range(-10, 10)
        .help("Tilt of the cuticle's scales, degrees; below 0 they shift highlights towards the root: reflection by "
              "twice as much, the second highlight by 3 times the other way."),
    param::number("specularIor", 1.55f).range(1.2f, 1.9f).help("Index of refraction."),
    param::number("specularMixFresnel", 1.f)
        .help(
            "1: Fresnel's reflectance at the angle of the hit. 0: its mean over the width, the same from all sides."),
    param::number("specularGlintWidth", 10.f).range(2, 30).help("Width of each glint about the fibre, degrees."),
    param::number("specularEccentricity", 1.f)
        .range(0.8f, 1)
        .help("Ratio of the axes of the fibre's section: it moves the second highlight and its glints."),
    param::normal("eccentricityDirection")
        .help("Direction of the section's axis, render space; 0 0 0: the surface's normal."),
    param::number("glowGain", 0.f).help("Multiplies the light that the fibre gives off."),
    param::color("glowColor", 1.f).help("Radiance that the fibre gives off."),
    param::number("specularEnergyCompensation", 0.f)
        .help("1: the diffuse lobe gets what the others leave. 0: it is added to them."),
    param::color("shadowColor", 0.f)
        .help("Share of lights' light that is left in shadows which the hair casts, by channel. Light paths (PxrVCM) "
              "see nothing of it."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::make(Type::Int, "inputAOV", 0, 0, 0).help("Patterns that show values in display channels: PxrMatteID."),
};

// Ways to make a direction; the first are those of HairPath.
enum Technique : uint32_t { kMakeRest = kHairPaths, kMakeDiffuse, kTechniques };
// Each scatters to both sides of the surface; one follows the other.
constexpr LobeDecl kLobes[] = {
    {"HairSpecularR", kLobeSpecular},      {"HairSpecularR", kLobeSpecular | kLobeTransmit},
    {"HairSpecularTT", kLobeSpecular},     {"HairSpecularTT", kLobeSpecular | kLobeTransmit},
    {"HairSpecularTRT", kLobeSpecular},    {"HairSpecularTRT", kLobeSpecular | kLobeTransmit},
    {"HairSpecularGLINTS", kLobeSpecular}, {"HairSpecularGLINTS", kLobeSpecular | kLobeTransmit},
    {"HairDiffuse", kLobeDiffuse},         {"HairDiffuse", kLobeDiffuse | kLobeTransmit},
};
enum : uint32_t { kLobeR = 0, kLobeTT = 2, kLobeTRT = 4, kLobeGlints = 6, kLobeHairDiffuse = 8 };
#define KINORA_HAIR_WHITE "specularColorTRT=1 1 1; specularColorTT=1 1 1"
constexpr const char* kLossless[] = {
    KINORA_HAIR_WHITE,
    KINORA_HAIR_WHITE "; specularGainGLINTS=0; specularConeAngleR=4; specularConeAngleTT=15; specularConeAngleTRT=25",
    KINORA_HAIR_WHITE "; specularMixFresnel=0; specularOffset=6; specularIor=1.35; specularEccentricity=0.85",
    KINORA_HAIR_WHITE
    "; specularMixFresnel=0.5; specularConeAngleR=40; specularConeAngleTT=40; specularConeAngleTRT=40",
    "diffuseGain=1; diffuseColor=1 1 1; specularGainR=0; specularGainTT=0; specularGainTRT=0; specularGainGLINTS=0",
    "diffuseModelType=1; diffuseGain=1; diffuseColor=1 1 1; specularGainR=0; specularGainTT=0; specularGainTRT=0; "
    "specularGainGLINTS=0",
    "diffuseGain=1; diffuseColor=1 1 1; specularEnergyCompensation=1",
    nullptr};
constexpr const char* kConserving[] = {
    "",
    "diffuseGain=1; diffuseColor=1 1 1; specularEnergyCompensation=1; specularColorTT=0.9 0.6 0.3; "
    "specularColorTRT=0.8 0.36 0.1",
    nullptr};

struct PxrMarschnerHair {
  struct Closure {
    bool kajiya = false, adjoint = false, eccentric = false;
    Value diffuseGain, diffuseColor, gain[kHairPaths], color[3], cone[3], offset, ior, mix, glintWidth, eccentricity,
        direction, compensation, glowGain, glowColor;
    hair::FiberPlace place;
  };
  template <int W>
  using HasEmission = void;
  static void begin(const Context& c, Closure& k) {
    k.kajiya = c.param(kDiffuseModelType).data[0][0] == 1.f;
    k.adjoint = c.traits & kTraitLightPath;
    k.diffuseGain = c.param(kDiffuseGain);
    k.diffuseColor = c.param(kDiffuseColor);
    constexpr uint32_t kGains[kHairPaths] = {kGainR, kGainTT, kGainTRT, kGainGlints};
    for (uint32_t p = 0; p < kHairPaths; ++p) k.gain[p] = c.param(kGains[p]);
    constexpr uint32_t kColors[3] = {kColorR, kColorTT, kColorTRT}, kCones[3] = {kConeR, kConeTT, kConeTRT};
    for (uint32_t p = 0; p < 3; ++p) {
      k.color[p] = c.param(kColors[p]);
      k.cone[p] = c.param(kCones[p]);
    }
    k.offset = c.param(kOffset);
    k.ior = c.param(kIor);
    k.mix = c.param(kMixFresnel);
    k.glintWidth = c.param(kGlintWidth);
    k.eccentricity = c.param(kEccentricity);
    k.eccentric = k.eccentricity.stride || k.eccentricity.data[0][0] != 1.f;
    k.direction = c.param(kEccentricityDirection);
    k.compensation = c.param(kEnergyCompensation);
    k.glowGain = c.param(kGlowGain);
    k.glowColor = c.param(kGlowColor);
    k.place.bind(c);
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }
  template <int W>
  static KN_INLINE Rgb<W> emission(const Closure& k, At at) {
    return loadRgb<W>(k.glowColor, at) * loadFloat<W>(k.glowGain, at);
  }

  template <int W>
  struct Lanes {
    using F = Float<W>;
    // What is known of the direction that light comes from, whichever of the two that is.
    struct Side {
      Inclination<W> shifted[3];  // for R, TT, TRT: seen from the cuticle's scales
      FiberHit<W> hit;
      F energy[kTechniques], total;
      KN_INLINE Side() {}
    };
    FiberFrame<W> frame;
    Vec3<W> Ng;
    Mask<W> turnsWithNormal;  // the section's axis, where no direction is said
    F turn;                   // azimuth of the section's axis, from X
    AlongLobe<W> along[3];
    AboutLobe<W> about[kHairPaths];
    F tiltSine[3], tiltCosine[3];
    F ior, mix, mean, eccentricity;
    Rgb<W> color[kHairPaths], inside, diffuse;  // inside: of one way through the fibre
    F colorMean[kHairPaths], insideMean, diffuseMean, glints, compensation;
    Side own;
    bool kajiya, adjoint, eccentric;

    HWY_ATTR HWY_NOINLINE Lanes(const Closure& k, const Surface<W>& s)
        : frame(k.place, s), Ng(s.Ng), kajiya(k.kajiya), adjoint(k.adjoint), eccentric(k.eccentric) {
      const F none(0.f), one(1.f);
      turn = frame.gamma;
      turnsWithNormal = Mask<W>(true);
      if (eccentric) {
        const Vec3<W> d = loadVec<W>(k.direction, s.at);
        turnsWithNormal = dot(d, d) <= F(1e-12f);
        turn = select(turnsWithNormal, turn, atan2(dot(d, frame.Y), dot(d, frame.X)));
      }
      // the lobes
      const F degree(kPi / 180.f);
      const F tilt = loadFloat<W>(k.offset, s.at) * degree;
      constexpr float kTilts[3] = {2.f, -1.f, -3.f};  // Marschner et al.: a, -a / 2, -3 a / 2 of the half angle
      for (int p = 0; p < 3; ++p) {
        const F deviation = loadFloat<W>(k.cone[p], s.at) * degree;
        along[p] = AlongLobe<W>(deviation);
        about[p] = AboutLobe<W>(deviation);
        sincos(tilt * F(kTilts[p]), tiltSine[p], tiltCosine[p]);
        const Rgb<W> c = loadRgb<W>(k.color[p], s.at);
        color[p] = positive(c * loadFloat<W>(k.gain[p], s.at));
        if (p == kPathTT) inside = Rgb<W>(within(c.x), within(c.y), within(c.z));
        if (p == kPathTRT) color[kPathGlint] = positive(c * loadFloat<W>(k.gain[kPathGlint], s.at));
      }
      about[kPathGlint] = AboutLobe<W>(loadFloat<W>(k.glintWidth, s.at) * degree);
      glints = clamp(loadFloat<W>(k.gain[kPathGlint], s.at), none, one) * F(0.5f);
      color[kPathGlint] = color[kPathGlint] * F(0.5f);
      ior = clamp(loadFloat<W>(k.ior, s.at), F(1.01f), F(4.f));
      mix = clamp(loadFloat<W>(k.mix, s.at), none, one);
      mean = meanFiberReflectance(ior);
      eccentricity = clamp(loadFloat<W>(k.eccentricity, s.at), F(0.5f), F(2.f));
      diffuse = positive(loadRgb<W>(k.diffuseColor, s.at) * loadFloat<W>(k.diffuseGain, s.at));
      compensation = clamp(loadFloat<W>(k.compensation, s.at), none, one);
      for (int p = 0; p < int(kHairPaths); ++p) colorMean[p] = average(color[p]);
      insideMean = average(inside);
      diffuseMean = average(diffuse);
      own = sideOf(frame.outgoing, frame.gamma, turn);
    }

    static KN_INLINE F within(F x) { return clamp(x, F(0.f), F(1.f)); }
    // Of the paths beyond TRT, relative to TRT: a geometric series (Chiang et al. 2016).
    static KN_INLINE F beyond(F f, F inside) { return f * inside / max(fnma(f, inside, F(1.f)), F(1e-4f)); }

    KN_INLINE Side sideOf(const Inclination<W>& o, F normal, F axis) const {
      Side s;
      F inner = ior;
      if (eccentric) {
        // Marschner et al., section 5.2.3
        const F e = ior - F(1.f), a2 = eccentricity * eccentricity;
        const F one = fma(F(2.f) * e, a2, F(2.f) - ior), other = fma(F(2.f), e / a2, F(2.f) - ior);
        inner = clamp(F(0.5f) * fma(cos(axis + axis), one - other, one + other), F(1.01f), F(4.f));
      }
      s.hit = FiberHit<W>(o, normal, ior, inner, mix, mean);
      for (int p = 0; p < 3; ++p) s.shifted[p] = o.lessened(tiltSine[p], tiltCosine[p]);
      const F f = s.hit.reflectance, t = F(1.f) - f, trt = t * t * f;
      s.energy[kPathR] = f * colorMean[kPathR];
      s.energy[kPathTT] = t * t * colorMean[kPathTT];
      s.energy[kPathTRT] = trt * (F(1.f) - glints) * colorMean[kPathTRT];
      s.energy[kPathGlint] = trt * colorMean[kPathGlint];
      s.energy[kMakeRest] = trt * colorMean[kPathTRT] * beyond(f, insideMean);
      F sum(0.f);
      for (uint32_t k = 0; k < kMakeDiffuse; ++k) sum += s.energy[k];
      s.energy[kMakeDiffuse] = diffuseMean * max(fnma(compensation, sum, F(1.f)), F(0.f));
      s.total = sum + s.energy[kMakeDiffuse];
      return s;
    }
    // Densities by technique of light that leaves with an inclination, at an azimuth from where it comes from.
    KN_INLINE void densities(const Side& from, const Inclination<W>& i, F phi, F out[kTechniques]) const {
      F alongPath[3];
      for (int p = 0; p < 3; ++p) alongPath[p] = along[p].density(from.shifted[p], i);
      for (uint32_t p = 0; p < kHairPaths; ++p)
        out[p] = alongPath[p < 3 ? p : kPathTRT] * about[p].density(phi - from.hit.centre[p]);
      out[kMakeRest] = alongPath[kPathTRT] * F(kInvTwoPi);
      if (kajiya) {
        out[kMakeDiffuse] = i.c * F(kInvPi * kInvPi);
      } else {
        // Lambert's law on a cylinder, averaged over what is seen of it
        const F a = abs(AboutLobe<W>::wrapped(phi));
        F s, c;
        sincos(a, s, c);
        out[kMakeDiffuse] = i.c * F(0.25f * kInvPi) * max(fma(F(kPi) - a, c, s), F(0.f));
      }
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      FiberDensity<W> forward, back;
      evaluateFiber(*this, wi, F(1.f), kLobeR, out, forward, back, [&](const Inclination<W>& i, F phi) HWY_ATTR {
        return sideOf(i, -frame.gamma, select(turnsWithNormal, -turn, turn - phi));
      });
      out.pdf = forward.mean();
      out.pdfReverse = back.mean();
    }
    KN_INLINE void add(const Side& side, const F density[kTechniques], F scale, Vec3<W> wi, uint32_t first,
                       LobeSum<W>& out) const {
      const F f = side.hit.reflectance, t = F(1.f) - f, trt = t * t * f * scale;
      const Mask<W> above = dot(Ng, wi) >= F(0.f);
      const auto put = [&](uint32_t lobe, Rgb<W> w) {
        out.add(first + lobe, zeroUnless(above, w));
        out.add(first + lobe + 1, zeroUnless(!above, w));
      };
      put(kLobeR, color[kPathR] * (f * scale * density[kPathR]));
      put(kLobeTT, color[kPathTT] * (t * t * scale * density[kPathTT]));
      const Rgb<W> rest(beyond(f, inside.x), beyond(f, inside.y), beyond(f, inside.z));
      put(kLobeTRT, color[kPathTRT] * (trt * (F(1.f) - glints) * density[kPathTRT]) +
                        color[kPathTRT] * rest * (trt * density[kMakeRest]));
      put(kLobeGlints, color[kPathGlint] * (trt * density[kPathGlint]));
      put(kLobeHairDiffuse, diffuse * leftOver(side) * (scale * density[kMakeDiffuse]));
    }
    // All that is not diffuse, by channel.
    KN_INLINE Rgb<W> specularAlbedo(const Side& side) const {
      const F f = side.hit.reflectance, t = F(1.f) - f, trt = t * t * f;
      const Rgb<W> rest(beyond(f, inside.x), beyond(f, inside.y), beyond(f, inside.z));
      return color[kPathR] * f + color[kPathTT] * (t * t) + color[kPathGlint] * trt +
             color[kPathTRT] * (trt * (F(1.f) - glints)) + color[kPathTRT] * rest * trt;
    }
    KN_INLINE Rgb<W> leftOver(const Side& side) const {
      const Rgb<W> s = specularAlbedo(side);
      const F one(1.f), none(0.f);
      return {max(fnma(compensation, s.x, one), none), max(fnma(compensation, s.y, one), none),
              max(fnma(compensation, s.z, one), none)};
    }

    KN_INLINE void sample(F u, F v, F w, LobeSample<W>& out) const {
      const ChosenTechnique<W> chosen(own.energy, own.total, w);
      const Int<W> which = chosen.which;
      const F third = chosen.rest;
      out.wi = sampleFiber(frame, along, own.shifted, which, kMakeDiffuse, u, v, [&](uint32_t p) HWY_ATTR {
        return p < kHairPaths ? own.hit.centre[p] + about[p].sample(third) : third * F(kTwoPi);
      });
      const Mask<W> isDiffuse = which == Int<W>(uint32_t(kMakeDiffuse));
      if (isDiffuse.any()) {
        // Zinke: a cosine about the normal at an even offset. Kajiya: the same inclinations, any azimuth.
        const Vec3<W> l = cosineHemisphere(u, v);
        const F h = kajiya ? F(0.f) : fma(F(2.f), third, F(-1.f));
        F a = h, b = safeSqrt(fnma(h, h, F(1.f)));
        F y = l.y, z = l.z;
        if (kajiya) {
          sincos(third * F(kTwoPi), a, b);
          z = safeSqrt(fnma(l.x, l.x, F(1.f)));
          y = F(0.f);
        }
        out.wi =
            select(isDiffuse, fma(frame.T, l.x, fma(frame.X, fms(z, b, y * a), frame.Y * fma(z, a, y * b))), out.wi);
      }
      out.wi = normalize(out.wi);
      out.valid = chosen.found;
      out.discrete = Mask<W>(false);
      out.below = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return specularAlbedo(own) + diffuse * leftOver(own); }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrMarschnerHair,
            .help =
                "Hair, fur and fibres on curves: reflection, light that goes through, the coloured second highlight, "
                "glints, and a diffuse lobe.",
            .params = kParams, .lobes = kLobes, .presenceParam = kPresence, .lossless = kLossless,
            .conserving = kConserving, .flags = kBxdfNotReciprocal | kBxdfFiber)
