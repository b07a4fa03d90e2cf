// LamaDiffuse: diffuse reflection on both sides, alone or as a leaf of a layered material (LamaSurface).
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaDiffuse/LamaDiffuse.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kColor, kRoughness, kNormal, kDiffuseColor };
constexpr Param kParams[] = {
    param::color("color", 0.18f).help("Reflectance."),
    param::number("roughness", 0.f)
        .help("0 Lambert's law .. 1; energy-preserving Oren-Nayar (Portsmouth, Kutz and Hill 2025)."),
    param::normal("normal").help("Shading normal from a bump pattern."),
    param::color("diffuseColor", 0.18f).help("Another name of color; counts where it is not 0.18."),
    KINORA_LAMA_COMMON};
constexpr const char* kLossless[] = {"color=1 1 1", "color=1 1 1; roughness=0.5", "color=1 1 1; roughness=1",
                                     nullptr};

struct LamaDiffuse {
  static void begin(const Context& c, lama::Closure& k) {
    bindLeaf(c, k, lama::kKindDiffuse,
             {.color = kColor,
              .roughness = kRoughness,
              .normal = kNormal,
              .bumpShadowing = lama::indexOf(kParams, "bumpShadowing")});
    k.leaves[0].color = colorOf(c, kColor, kDiffuseColor, 0.18f);
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaDiffuse, SlabMaterial<LamaDiffuse>, BxdfPlugin,
              .help = "A diffuse slab; a material by itself, or a leaf of LamaLayer, LamaMix and LamaAdd.",
              .params = kParams, .lobes = lama::kNamedLobes, .lossless = kLossless)
