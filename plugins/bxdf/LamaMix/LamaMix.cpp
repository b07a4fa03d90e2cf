// LamaMix: two materials side by side, by weight. What is connected becomes leaves of one material before shading (shade/layered_bxdfs);
// without anything connected it is black.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaMix/LamaMix.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/functions.h"

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {param::structure("material1").help("The first material."),
                             param::structure("material2").help("The second."),
                             param::number("mix", 0.f).help("0 the first alone .. 1 the second alone.")};

struct LamaMix {
  static void begin(const Context&, lama::Closure&) {}
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaMix, SlabMaterial<LamaMix>, BxdfPlugin, .help = "A blend of two materials.", .params = kParams,
              .lobes = lama::kLobes)
