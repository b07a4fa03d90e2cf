// PxrBumpManifold2D: PxrManifold2D as scenes name it before a PxrBump. Gradients come with either here.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrBumpManifold2D/PxrBumpManifold2D.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/places/place2d.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kInvertT, kPrimvarS, kPrimvarT };
constexpr Param kParams[] = {
    KINORA_PLACE_ANGLE,
    KINORA_PLACE_PARAMS,
    param::flag("invertT", true).help("1: t becomes 1 - t, last of all."),
    KINORA_PLACE_PRIMVARS,
    param::output(Type::Struct, "result"),
    param::output(Type::Float, "resultS"),
    param::output(Type::Float, "resultT"),
};

struct PxrBumpManifold2D {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Place2D place(
        *c, {kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kNoPlaceParam, kInvertT, kPrimvarS, kPrimvarT});
    Manifold& m = args->manifolds[0];
    place.makeManifold<W>(m, args->outputs[1], args->outputs[2]);
    args->outputs[0] = m.q;
    place.makeGradients<W>(m);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrBumpManifold2D, .help = "Places the textures of bumps, with the slopes that they need.",
               .params = kParams)
