// LamaLayer: one material lying on another. What is connected becomes leaves of one material before shading (shade/layered_bxdfs);
// without anything connected it is black.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaLayer/LamaLayer.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/functions.h"

KINORA_KERNELS_BEGIN

constexpr Param kParams[] = {
    param::structure("materialTop")
        .help("What lies on top. Dielectric, Schlick and sheen let through what they do not reflect; diffuse, "
              "conductors and hair nothing."),
    param::structure("materialBase")
        .help("What lies under it: it gets what the top lets through, the lesser of the ways in and out."),
    param::number("topMix", 1.f).help("Visibility of the top: 0 the base alone."),
    param::number("topThickness", 0.f).help("No effect yet. Absorption in the top.")};

struct LamaLayer {
  static void begin(const Context&, lama::Closure&) {}
};

KINORA_KERNELS_END

KINORA_PLUGIN(LamaLayer, SlabMaterial<LamaLayer>, BxdfPlugin,
              .help = "A material on another: what the top lets through lights the base.", .params = kParams,
              .lobes = lama::kLobes)
