// LamaSheen: the grazing reflection of cloth and dust. In the top of a layer the rest reaches the base.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaSheen/LamaSheen.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kColor, kRoughness, kNormal };
constexpr Param kParams[] = {
    param::color("color", 1.f).help("Multiplies the sheen."),
    param::number("roughness", 0.1f)
        .help("How far the sheen reaches in from the outline (Conty Estevez and Kulla 2017); never over all light."),
    param::normal("normal").help("Shading normal from a bump pattern."), KINORA_LAMA_COMMON};
constexpr const char* kConserving[] = {"roughness=0", "roughness=0.1", "roughness=0.5", "roughness=1", nullptr};

struct LamaSheen {
  static void begin(const Context& c, lama::Closure& k) {
    bindLeaf(c, k, lama::kKindSheen,
             {.color = kColor,
              .roughness = kRoughness,
              .normal = kNormal,
              .bumpShadowing = lama::indexOf(kParams, "bumpShadowing")});
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaSheen, SlabMaterial<LamaSheen>, BxdfPlugin,
              .help = "Sheen of cloth; a leaf of LamaLayer, LamaMix and LamaAdd.", .params = kParams,
              .lobes = lama::kNamedLobes, .conserving = kConserving)
