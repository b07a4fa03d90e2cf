// LamaIridescence: what a thin film reflects, a soap bubble's skin or oil; facets as those of the other slabs. In the
// top of a layer the rest reaches the base; by itself, or at the bottom, it is absorbed.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaIridescence/LamaIridescence.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kTint, kRelative, kMin, kMax, kFilmIor, kRoughness, kNormal, kAnisotropy, kDirection };
constexpr Param kParams[] = {
    param::color("tint", 1.f).help("Multiplies what is reflected."),
    param::number("relativeFilmThickness", 0.5f).help("Thickness between the least and the greatest."),
    param::number("minFilmThickness", 400.f).range(0, 2000).help("Thickness at 0, nanometres."),
    param::number("maxFilmThickness", 800.f).range(0, 2000).help("Thickness at 1, nanometres."),
    param::number("filmIOR", 1.3f).range(1, 3).help("Index of refraction of the film; air on both sides."),
    KINORA_LAMA_FACETS,
    KINORA_LAMA_ANISOTROPY_ALONG,
    KINORA_LAMA_COMMON};
constexpr const char* kConserving[] = {"roughness=0", "roughness=0.3; filmIOR=3; relativeFilmThickness=0.1",
                                       "roughness=1; filmIOR=2", nullptr};

struct LamaIridescence {
  static void begin(const Context& c, lama::Closure& k) {
    bindLeaf(c, k, lama::kKindFilm,
             {.color = kTint,
              .second = kMin,
              .third = kMax,
              .roughness = kRoughness,
              .anisotropy = kAnisotropy,
              .direction = kDirection,
              .ior = kFilmIor,
              .amount = kRelative,
              .normal = kNormal,
              .bumpShadowing = lama::indexOf(kParams, "bumpShadowing")});
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaIridescence, SlabMaterial<LamaIridescence>, BxdfPlugin,
              .help = "A thin film; a leaf of LamaLayer, LamaMix and LamaAdd.", .params = kParams,
              .lobes = lama::kNamedLobes, .conserving = kConserving)
