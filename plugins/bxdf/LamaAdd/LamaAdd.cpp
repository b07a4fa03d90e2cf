// LamaAdd: two materials with a weight each. What is connected becomes leaves of one material before shading (shade/layered_bxdfs);
// without anything connected it is black.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaAdd/LamaAdd.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/functions.h"

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {param::structure("material1").help("The first material."),
                             param::structure("material2").help("The second."),
                             param::number("weight1", 1.f).help("Weight of the first."),
                             param::number("weight2", 0.f)
                                 .help("Weight of the second. Where both together could return more than arrives, "
                                       "both are scaled down; light given off is not.")};

struct LamaAdd {
  static void begin(const Context&, lama::Closure&) {}
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaAdd, SlabMaterial<LamaAdd>, BxdfPlugin,
              .help = "A weighted sum of two materials that never gains energy.", .params = kParams,
              .lobes = lama::kLobes)
