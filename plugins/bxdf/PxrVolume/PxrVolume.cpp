// PxrVolume: a participating medium. What is lost of light along the way is extinction = densityFloat * densityColor a
// unit of length of the scene; diffuseColor is the share of it that is scattered (single-scattering albedo). Phase
// function: two of Henyey and Greenstein's (1941) mixed by blendFactor, sampled exactly by their inverse. emitColor is
// emitted along the way whatever the density: fire glows where there is no smoke.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrVolume/PxrVolume.cpp"
#include <kinora/bxdf_author.h>
#include <cmath>

#if KINORA_PLAIN
namespace kinora::pxrVolume {
enum : uint32_t {
  kDiffuseColor,
  kEmitColor,
  kDensityFloatPrimVar,
  kDensityFloat,
  kDensityColorPrimVar,
  kDensityColor,
  kExtinctionDistance,
  kAnisotropy,
  kAnisotropy2,
  kBlendFactor,
  kMultiScatter,
  kMaxDensity,
  kEquiangularWeight,
  kMultiScatterOpt,
  kExtinctionMultiplier,
  kContributionMultiplier,
  kMinSamples,
  kMaxSamples,
  kSamples,
  kStepSize,
  kVelocity,
  kVelocityPrimVar,
  kVelocityMultiplier,
  kTransmittanceColor,
  kTransmittanceDistance
};
constexpr const char kOneDistance[] =
    "No effect: distances are drawn by tracking, one along each ray, and more come by samples a pixel.";
constexpr Param kParams[] = {
    param::color("diffuseColor", 1.f).help("Share of the extinction that is scattered, not absorbed: 0 to 1."),
    param::color("emitColor", 0.f).help("Radiance emitted per unit of length in the scene, whatever the density."),
    param::string("densityFloatPrimVar", "").help("Primvar or grid that stands for densityFloat."),
    param::number("densityFloat", 1.f).help("Extinction per unit of length in the scene; negative is 0."),
    param::string("densityColorPrimVar", "").help("Primvar or grid that stands for densityColor."),
    param::color("densityColor", 1.f).help("Factor on the extinction, by channel: colours shadows."),
    param::number("extinctionDistance", 0.f)
        .help("Not 0: the extinction is constant, and a way of this length lets 5 % of the light through."),
    param::number("anisotropy", 0.f)
        .range(-1, 1)
        .help("Mean cosine of scattering: 1 forward (taken as .99), 0 even, -1 backward."),
    param::number("anisotropy2", 0.f).range(-1, 1).help("The same of a second lobe."),
    param::number("blendFactor", 0.f).help("Share of the second lobe."),
    param::integer("multiScatter", 0)
        .options("0 once, 1 any number of times")
        .help("How often light is scattered in the medium; once: points in it see the lights alone."),
    param::number("maxDensity", -1.f)
        .fixed()
        .help("Largest extinction that patterns make of it, per unit of length; -1: found out by looking."),
    param::number("equiangularWeight", 0.5f)
        .fixed()
        .help("How much distances that suit nearby lights count, beside those that suit the extinction: 0 not at "
              "all, 1 alone where they are tried."),
    param::integer("multiScatterOpt", 0)
        .options("0 exact, 1 approximate")
        .help("Light that was scattered often goes on through a thinner medium, by the two multipliers."),
    param::number("extinctionMultiplier", 1.f)
        .fixed()
        .help("With multiScatterOpt: factor on the extinction from where a path is scattered on, again at each "
              "scattering."),
    param::number("contributionMultiplier", 1.f)
        .fixed()
        .help("With multiScatterOpt: factor on the light that each scattering but the first brings."),
    param::integer("minSamples", 4).range(0, 64).help(kOneDistance),
    param::integer("maxSamples", 4).range(0, 64).help(kOneDistance),
    param::integer("samples", 4).range(0, 64).help("Old name; the same."),
    param::number("stepSize", 0.1f).help("Not needed: nothing is marched in steps."),
    param::vector("velocity", 0, 0, 0)
        .help("How the grids of the medium move, per unit of the shutter's time, in object space: a constant."),
    param::string("velocityPrimVar", "").help("Primvar or grid that stands for velocity."),
    param::number("velocityMultiplier", 1.f).fixed().help("Factor on the velocity: 0 stops the motion."),
    param::color("transmittanceColor", 1.f)
        .help("What is left of white light after transmittanceDistance, where that is given."),
    param::number("transmittanceDistance", -1.f)
        .fixed()
        .range(-1, 10)
        .fixed()
        .help("Not negative: the extinction is that of transmittanceColor, whatever the density; 0: there is none."),
};
constexpr LobeDecl kLobes[] = {{"Volume", kLobeVolume | kLobeDiffuse}};
constexpr const char* kLossless[] = {
    "diffuseColor=1 1 1; multiScatter=1", "diffuseColor=1 1 1; anisotropy=0.7; multiScatter=1",
    "diffuseColor=1 1 1; anisotropy=0.8; anisotropy2=-0.5; blendFactor=0.3; multiScatter=1", nullptr};
constexpr float kOpaqueDepth = 2.9957323f;  // log 20

// By what is left after a distance.
inline float extinctionOf(float left, float distance) {
  const double share = left > 1e-4f ? (left < 1 ? double(left) : 1.0) : 1e-4;
  return distance > 0 ? float(-std::log(share) / double(distance)) : 0.f;
}

inline bool hasText(const ParamValue& v) { return v.count && v.strings && v.strings[0] && *v.strings[0]; }

inline uint32_t flagsOf(const ParamValue* v, uint32_t) {
  return (v[kMultiScatter].floats[0] != 0 ? 0u : uint32_t(kMediumScattersOnce)) |
         (v[kEmitColor].mayBeOn() ? uint32_t(kMediumMayEmit) : 0u);
}

inline uint32_t productOf(const ParamValue* v, uint32_t, ExtinctionProduct* out) {
  const auto share = [&](uint32_t parameter) {
    const float x = v[parameter].floats[0];
    return x > 0 ? (x < 1 ? x : 1.f) : 0.f;
  };
  *out = {};
  for (float& f : out->factor) f = 1;
  out->most = v[kMaxDensity].floats[0];
  out->towardsLights = share(kEquiangularWeight);
  if (v[kMultiScatterOpt].floats[0] != 0) {
    out->extinctionByBounce = share(kExtinctionMultiplier);
    out->contributionByBounce = share(kContributionMultiplier);
  }
  out->velocityFactor = v[kVelocityMultiplier].floats[0];
  if (hasText(v[kVelocityPrimVar]))
    out->velocity = v[kVelocityPrimVar].strings[0];
  else
    for (int k = 0; k < 3; ++k) out->constantVelocity[k] = v[kVelocity].floats[k] * out->velocityFactor;
  if (const float after = v[kTransmittanceDistance].floats[0]; after >= 0) {
    if (v[kTransmittanceColor].connected) return 0;
    for (int k = 0; k < 3; ++k) out->factor[k] = extinctionOf(v[kTransmittanceColor].floats[k], after);
    return 1;
  }
  const ParamValue& distance = v[kExtinctionDistance];
  if (distance.connected) return 0;
  if (distance.floats[0] > 0) {
    for (float& f : out->factor) f = kOpaqueDepth / distance.floats[0];
    return 1;
  }
  const bool namesNumber = hasText(v[kDensityFloatPrimVar]), namesColor = hasText(v[kDensityColorPrimVar]);
  if ((!namesNumber && v[kDensityFloat].connected) || (!namesColor && v[kDensityColor].connected)) return 0;
  if (namesNumber) out->number = v[kDensityFloatPrimVar].strings[0];
  if (namesColor) out->color = v[kDensityColorPrimVar].strings[0];
  for (int k = 0; k < 3; ++k)
    out->factor[k] =
        (namesNumber ? 1.f : v[kDensityFloat].floats[0]) * (namesColor ? 1.f : v[kDensityColor].floats[k]);
  return 1;
}
}  // namespace kinora::pxrVolume
#endif

KINORA_KERNELS_BEGIN
using namespace pxrVolume;

struct PxrVolume {
  struct Closure {
    Value albedo, g, g2, blend;
    bool isTwo = false;
  };
  static void begin(const Context& c, Closure& k) {
    k.albedo = c.param(kDiffuseColor);
    k.g = c.param(kAnisotropy);
    k.g2 = c.param(kAnisotropy2);
    k.blend = c.param(kBlendFactor);
    k.isTwo = !k.blend.uniform() || k.blend.data[0][0] > 0;
  }
  static void medium(const Context* c, const MediumArgs* a) {
    const auto at = [](const Value& v, uint32_t k, uint32_t i) {
      const float x = v.data[k][v.stride ? i : 0];
      return x > 0 && x < 1e30f ? x : 0.f;
    };
    const auto named = [&](uint32_t primvar, uint32_t parameter) {
      const char* name = c->fn->text(c, primvar);
      if (!*name) return c->param(parameter);
      const Value v = c->fn->primvar(c, name, nullptr);
      static const float kNone = 0;
      return v.components ? v : Value{{&kNone, &kNone, &kNone}, 0, 3};
    };
    const Value distance = c->param(kExtinctionDistance), number = named(kDensityFloatPrimVar, kDensityFloat),
                color = named(kDensityColorPrimVar, kDensityColor);
    const Value left = c->param(kTransmittanceColor);
    const float after = c->param(kTransmittanceDistance).data[0][0];
    for (uint32_t i = 0; i < c->padded; ++i) {
      if (after >= 0) {
        for (uint32_t k = 0; k < 3; ++k) a->extinction[k][i] = extinctionOf(left.data[k][left.stride ? i : 0], after);
        continue;
      }
      const float reach = at(distance, 0, i), d = at(number, 0, i);
      for (uint32_t k = 0; k < 3; ++k)
        a->extinction[k][i] = reach > 0 ? kOpaqueDepth / reach : d * at(color, color.components == 3 ? k : 0, i);
    }
    if (!a->emission[0]) return;
    const Value glow = c->param(kEmitColor);
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t i = 0; i < c->padded; ++i) a->emission[k][i] = at(glow, k, i);
  }

  // Its peak is kept within what floats can follow; near 0 the inverse would be a quotient of nothing.
  template <int W>
  static KN_INLINE Float<W> usable(Float<W> g) {
    using F = Float<W>;
    return select(abs(g) < F(1e-3f), F(0.f), clamp(g, F(-0.99f), F(0.99f)));
  }
  // Halves of the squared distances from wi to where light goes on straight, and to where it goes back: 1 - cosine and
  // 1 + cosine, of which a difference of cosines would lose the peak.
  template <int W>
  static KN_INLINE Float<W> phase(Float<W> g, Float<W> ahead, Float<W> back) {
    using F = Float<W>;
    const F a = abs(g), one = F(1.f) - a;
    const F d = max(one * one + F(2.f) * a * select(g < F(0.f), back, ahead), F(1e-7f));
    return F(0.25f * kInvPi) * (F(1.f) - g * g) / (d * sqrt(d));
  }

  template <int W>
  struct Lanes {
    Vec3<W> wo;
    Rgb<W> scattered;
    Float<W> g, g2, blend;
    bool isTwo;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : wo(s.wo), isTwo(k.isTwo) {
      using F = Float<W>;
      const Rgb<W> albedo = loadRgb<W>(k.albedo, s.at);
      scattered = {clamp(albedo.x, F(0.f), F(1.f)), clamp(albedo.y, F(0.f), F(1.f)), clamp(albedo.z, F(0.f), F(1.f))};
      g = usable(loadFloat<W>(k.g, s.at));
      g2 = isTwo ? usable(loadFloat<W>(k.g2, s.at)) : g;
      blend = isTwo ? clamp(loadFloat<W>(k.blend, s.at), F(0.f), F(1.f)) : F(0.f);
    }
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      const Float<W> half(0.5f), ahead = half * dot(wo + wi, wo + wi), back = half * dot(wo - wi, wo - wi);
      const Float<W> first = phase(g, ahead, back);
      out.pdf = out.pdfReverse = isTwo ? first + blend * (phase(g2, ahead, back) - first) : first;
      out.add(0, scattered * out.pdf);
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      using F = Float<W>;
      const F a = isTwo ? select(w < blend, g2, g) : g;
      const Mask<W> isEven = a == F(0.f);
      const F s = (F(1.f) - a * a) / (F(1.f) + a - F(2.f) * a * u);
      F cosine = (F(1.f) + a * a - s * s) / (F(2.f) * select(isEven, F(1.f), a));
      cosine = clamp(select(isEven, F(1.f) - F(2.f) * u, cosine), F(-1.f), F(1.f));
      const F sine = safeSqrt(fnma(cosine, cosine, F(1.f)));
      F across, along;
      sincos(v * F(kTwoPi), across, along);
      out.wi = Frame<W>(-wo).toWorld({sine * along, sine * across, cosine});
      out.valid = Mask<W>(true);
      out.discrete = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return scattered; }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrVolume, .help = "A medium that absorbs, scatters and emits: fog, smoke, clouds, fire.",
            .params = kParams, .lobes = kLobes, .mediumFlags = &pxrVolume::flagsOf,
            .extinctionProduct = &pxrVolume::productOf, .lossless = kLossless, .conserving = kLossless,
            .flags = kBxdfFillsSpace)
