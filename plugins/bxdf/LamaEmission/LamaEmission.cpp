// LamaEmission: a slab that gives off light, on both sides, and reflects none.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaEmission/LamaEmission.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {
    param::color("color", 1.f).help("Radiance given off."),
    KINORA_LAMA_COMMON_OF("No effect: it reflects nothing.", "No effect: what glows has no lobe.")};

struct LamaEmission {
  static void begin(const Context& c, lama::Closure& k) { bindLeaf(c, k, lama::kKindEmission, {.color = 0}); }
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaEmission, SlabMaterial<LamaEmission>, BxdfPlugin,
              .help = "Light given off; a leaf of LamaLayer, LamaMix and LamaAdd.", .params = kParams,
              .lobes = lama::kNamedLobes)
