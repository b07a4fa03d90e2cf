// LamaDielectric: by itself and at the bottom of layers a clear or rough glass that bounds a medium; as the top of a
// layer a coat that reflects, and lets the rest through to what it lies on.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaDielectric/LamaDielectric.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : int {
  kReflectionTint,
  kTransmissionTint,
  kFresnelMode,
  kIor,
  kReflectivity,
  kRoughness,
  kNormal,
  kAnisotropy,
  kDirection,
  kAbsorptionColor,
  kAbsorptionRadius,
  kRotation
};
constexpr Param kParams[] = {
    KINORA_LAMA_TINTS,
    param::integer("fresnelMode", 0)
        .options("0 artistic, 1 scientific")
        .help("Artistic: the index is that of reflectivity. Scientific: IOR."),
    param::number("IOR", 1.5f).range(1, 3).help("Scientific: index of refraction."),
    param::number("reflectivity", 0.04f).range(0, 0.25f).help("Artistic: reflectance seen face on."),
    KINORA_LAMA_FACETS,
    KINORA_LAMA_ANISOTROPY_ALONG,
    KINORA_LAMA_INTERIOR,
    param::number("rotation", 0.f).help(KINORA_LAMA_ROTATION),
    KINORA_LAMA_INTERIOR_SCATTERING,
    KINORA_LAMA_COMMON_UNSHADOWED};
constexpr const char* kLossless[] = {"roughness=0", "roughness=0.3; fresnelMode=1; IOR=1.33", "roughness=0.6",
                                     "roughness=1; fresnelMode=1; IOR=2", nullptr};
constexpr const char* kConserving[] = {
    "roughness=0.3; reflectionTint=0.9 0.7 0.5; transmissionTint=0.5 0.7 0.9; fresnelMode=1", nullptr};

struct LamaDielectric {
  static constexpr bool kGlass = true;
  static void begin(const Context& c, lama::Closure& k) {
    const bool scientific = flag(c, kFresnelMode);
    bindLeaf(c, k, scientific ? lama::kKindGlass : lama::kKindArtisticGlass,
             {.color = kReflectionTint,
              .through = kTransmissionTint,
              .third = kAbsorptionColor,
              .roughness = kRoughness,
              .anisotropy = kAnisotropy,
              .direction = kDirection,
              .rotation = kRotation,
              .ior = scientific ? kIor : kReflectivity,
              .amount = kAbsorptionRadius,
              .normal = kNormal});
  }
  static uint32_t enclosesMedium(const ParamValue*, uint32_t) { return 1; }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaDielectric, SlabMaterial<LamaDielectric>, BxdfPlugin,
              .help = "Glass by itself; a coat where it is the top of a LamaLayer.", .params = kParams,
              .lobes = lama::kNamedLobes, .enclosesMedium = LamaDielectric::enclosesMedium,
              .interiorMedium = &lama::kInterior, .lossless = kLossless, .conserving = kConserving)
