// LamaConductor: a metal, by its complex index of refraction or by colours; GGX facets that lose no energy.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaConductor/LamaConductor.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : int { kTint, kFresnelMode, kIor, kExtinction, kReflectivity, kEdgeColor, KINORA_LAMA_FACET_INDICES };
constexpr Param kParams[] = {
    param::color("tint", 1.f).help("Multiplies what is reflected."),
    param::integer("fresnelMode", 0)
        .options("0 scientific, 1 artistic")
        .help("Scientific: IOR and extinction. Artistic: reflectivity and edgeColor, after Gulbrandsen (JCGT 2014)."),
    param::color("IOR", 0.18f, 0.42f, 1.37f).range(0.1f, 4).help("Scientific: index of refraction, by channel."),
    param::color("extinction", 3.42f, 2.35f, 1.77f).range(0, 6).help("Scientific: extinction, by channel."),
    param::color("reflectivity", 0.945f, 0.7772f, 0.3737f).help("Artistic: reflectance seen face on."),
    param::color("edgeColor", 0.9979f, 0.9813f, 0.7523f)
        .help("Artistic: towards what the curve bends before it reaches white at the edge."),
    KINORA_LAMA_FACETS,
    KINORA_LAMA_ANISOTROPY,
    param::normal("conductorNormal").help(KINORA_LAMA_LATER "Another name for the normal in exports."),
    param::number("tailMix", 0.f).help(KINORA_LAMA_LATER "A second, longer tail of the highlight."),
    param::number("tailLength", 0.f).help(KINORA_LAMA_LATER "Its length."),
    param::flag("overrideExteriorIOR", false).help(KINORA_LAMA_LATER "Takes exteriorIOR."),
    param::number("exteriorIOR", 1.f).range(1, 3).help(KINORA_LAMA_LATER "Index of what lies on the metal."),
    param::flag("edgeColorMode", false).help(KINORA_LAMA_LATER "Another reading of edgeColor."),
    param::number("surfaceMollification", 0.f).help(KINORA_LAMA_LATER "Roughness added to small curved surfaces."),
    param::number("motionMollification", 0.f).help(KINORA_LAMA_LATER "Roughness added to fast ones."),
    KINORA_LAMA_COMMON};
constexpr const char* kConserving[] = {"roughness=0.4", "fresnelMode=1; roughness=0.7", nullptr};

struct LamaConductor {
  static void begin(const Context& c, lama::Closure& k) {
    const bool artistic = flag(c, kFresnelMode);
    bindLeaf(c, k, artistic ? lama::kKindArtisticConductor : lama::kKindConductor,
             {.color = kTint,
              .second = artistic ? kReflectivity : kIor,
              .third = artistic ? kEdgeColor : kExtinction,
              .roughness = kRoughness,
              .anisotropy = kAnisotropy,
              .direction = kAnisotropyDirection,
              .rotation = kAnisotropyRotation,
              .normal = kNormal,
              .bumpShadowing = lama::indexOf(kParams, "bumpShadowing")});
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaConductor, SlabMaterial<LamaConductor>, BxdfPlugin,
              .help = "A metal; a material by itself, or a leaf of LamaLayer, LamaMix and LamaAdd.",
              .params = kParams, .lobes = lama::kNamedLobes, .lossless = lama::kLosslessFacets,
              .conserving = kConserving)
