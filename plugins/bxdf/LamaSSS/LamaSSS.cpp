// LamaSSS: scattering below the surface, by random walks or Burley's profile, alone or as a leaf of a layered material
// (LamaSurface). Parameters are those of the published MaterialX definition (ND_lama_sss) and the names that
// RenderMan's exporters write.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaSSS/LamaSSS.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kColor,
  kNormal,
  kRadius,
  kScale,
  kUnitLength,
  kAnisotropy,
  kBleed,
  kSubset,
  kContinuationRays,
  kIor,
  kFollowTopology,
  kMode,
  kInversion,
  kSssColor,
  kSssNormal
};
constexpr Param kParams[] = {
    param::color("color", 0.18f).help("Albedo of a plane surface: what comes out of what arrives."),
    param::normal("normal").help("Shading normal from a bump pattern."),
    KINORA_LAMA_SUBSURFACE,
    param::integer("sssMode", 0)
        .range(0, 3)
        .options("0 path traced Davis, 1 path traced exponential, 2 Burley, 3 Burley by mean free paths")
        .help("0: walks whose flights have heavier tails by sssBleed. 3: sssRadius is the way from one scattering to "
              "the next. Integrators other than PxrPathTracer, PxrDirectLighting and PxrOcclusion reflect diffusely "
              "instead."),
    param::integer("albedoInversionMethod", 0)
        .options("0 Pixar, 1 Chiang")
        .help("Path traced, 1: sssRadius is the way from one scattering to the next, whatever the albedo."),
    param::color("sssColor", 0.18f).help("Another name of color; counts where it is not 0.18."),
    param::normal("sssNormal").help("Another name of normal."),
    param::integer("mode", 0)
        .range(0, 2)
        .options("0 reflection, 1 transmission, 2 reflection with direct illumination")
        .help("No effect: lights within a body are seen in all modes."),
    KINORA_LAMA_COMMON};
constexpr const char* kLossless[] = {"color=1 1 1", nullptr};
constexpr const char* kConserving[] = {
    "color=1 1 1; sssRadius=1 1 1; sssUnitLength=1",
    "color=0.8 0.6 0.4; sssRadius=1 0.5 0.2; sssUnitLength=1; sssMode=1; sssAnisotropy=0.5",
    "color=0.8 0.8 0.8; sssRadius=0.01 0.01 0.01; sssUnitLength=1; sssMode=3",
    "color=0.9 0.6 0.4; sssRadius=1 1 1; sssUnitLength=1; sssIOR=1.5", nullptr};

struct LamaSSS {
  static constexpr bool kScatters = true;

  static void begin(const Context& c, lama::Closure& k) {
    bindSubsurface(
        c, k, {kRadius, kScale, kUnitLength, kAnisotropy, kBleed, kSubset, kContinuationRays, kIor, kFollowTopology});
    bindLeaf(c, k, kindOf(int(c.param(kMode).data[0][0]), flag(c, kInversion)), {.color = kColor, .normal = kNormal});
    lama::Leaf& l = k.leaves[0];
    bindOtherNormal(c, k, l, kSssNormal);
    l.softens = l.bump >= 0 && flag(c, uint32_t(lama::indexOf(kParams, "bumpShadowing")));
    l.color = k.below[0].color = colorOf(c, kColor, kSssColor, 0.18f);
  }
  static char kindOf(int mode, bool areFlights) {
    switch (mode) {
      case 1:
        return areFlights ? lama::kKindExponentialFlights : lama::kKindExponential;
      case 2:
        return lama::kKindBurleyProfile;
      case 3:
        return lama::kKindBurleyProfileFlights;
      default:
        return areFlights ? lama::kKindSubsurfaceFlights : lama::kKindSubsurface;
    }
  }
  static uint32_t scattersBelow(const ParamValue* v, uint32_t) { return v[kRadius].mayBeOn() && v[kScale].mayBeOn(); }
};

KINORA_KERNELS_END

KINORA_PLUGIN(
    LamaSSS, SlabMaterial<LamaSSS>, BxdfPlugin,
    .help = "Scattering below the surface; a material by itself, or a leaf of LamaLayer, LamaMix and LamaAdd.",
    .params = kParams, .lobes = lama::kNamedLobes, .scattersBelow = LamaSSS::scattersBelow, .lossless = kLossless,
    .conserving = kConserving)
