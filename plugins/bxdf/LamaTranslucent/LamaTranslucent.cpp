// LamaTranslucent: light that passes a thin sheet and leaves the other side in all directions, after Lambert.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaTranslucent/LamaTranslucent.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kColor, kNormal };
constexpr Param kParams[] = {param::color("color", 0.18f).help("Share of light that passes."),
                             param::normal("normal").help("Shading normal from a bump pattern."),
                             param::number("roughness", 0.f).help(KINORA_LAMA_LATER "Of what leaves."),
                             KINORA_LAMA_COMMON_UNSHADOWED};
constexpr const char* kLossless[] = {"color=1 1 1", nullptr};

struct LamaTranslucent {
  static void begin(const Context& c, lama::Closure& k) {
    bindLeaf(c, k, lama::kKindTranslucent, {.color = kColor, .normal = kNormal});
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaTranslucent, SlabMaterial<LamaTranslucent>, BxdfPlugin,
              .help = "Diffuse transmission; a leaf of LamaLayer, LamaMix and LamaAdd.", .params = kParams,
              .lobes = lama::kNamedLobes, .lossless = kLossless)
