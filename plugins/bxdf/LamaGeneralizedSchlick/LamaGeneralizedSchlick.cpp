// LamaGeneralizedSchlick: reflection after Schlick's formula with a colour face on, one at the edge and an exponent.
// In the top of a layer the rest reaches the base; by itself, or at the bottom, it is absorbed.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaGeneralizedSchlick/LamaGeneralizedSchlick.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : int {
  kReflectionTint,
  kTransmissionTint,
  kFresnelMode,
  kIor,
  kReflectivity,
  kReflectivity90,
  kReflectivityProfile,
  KINORA_LAMA_FACET_INDICES
};
constexpr Param kParams[] = {
    KINORA_LAMA_TINTS,
    param::integer("fresnelMode", 0)
        .options("0 scientific, 1 artistic")
        .help("What is reflected face on: by IOR, or reflectivity."),
    param::color("IOR", 1.5f).range(1, 3).help("Scientific: index of refraction, by channel."),
    param::color("reflectivity", 0.04f).help("Artistic: reflectance seen face on."),
    param::color("reflectivity90", 1.f).help("Reflectance at grazing angles."),
    param::number("reflectivityProfile", 0.2f)
        .range(0.1f, 1)
        .help("Inverse of the exponent of (1 - cos) between the two; 0.2 is Schlick's."),
    KINORA_LAMA_FACETS,
    KINORA_LAMA_ANISOTROPY,
    param::color("absorptionColor", 1.f).help(KINORA_LAMA_LATER "Absorption inside."),
    param::number("absorptionRadius", 1.f).help(KINORA_LAMA_LATER "The distance of absorptionColor."),
    KINORA_LAMA_SCATTERING,
    KINORA_LAMA_COMMON};
constexpr const char* kConserving[] = {"roughness=0.4; reflectivityProfile=1", nullptr};

struct LamaGeneralizedSchlick {
  static void begin(const Context& c, lama::Closure& k) {
    const bool artistic = flag(c, kFresnelMode);
    bindLeaf(c, k, artistic ? lama::kKindSchlick : lama::kKindScientificSchlick,
             {.color = kReflectionTint,
              .second = artistic ? kReflectivity : kIor,
              .third = kReflectivity90,
              .roughness = kRoughness,
              .anisotropy = kAnisotropy,
              .direction = kAnisotropyDirection,
              .rotation = kAnisotropyRotation,
              .amount = kReflectivityProfile,
              .normal = kNormal,
              .bumpShadowing = lama::indexOf(kParams, "bumpShadowing")});
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaGeneralizedSchlick, SlabMaterial<LamaGeneralizedSchlick>, BxdfPlugin,
              .help = "Reflection by Schlick's formula with free colours and exponent, for layers.",
              .params = kParams, .lobes = lama::kNamedLobes, .lossless = lama::kLosslessFacets,
              .conserving = kConserving)
