// PxrManifold2D: texture coordinates turned, scaled and shifted about the origin, in this order, then inverted.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrManifold2D/PxrManifold2D.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/places/place2d.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kInvertS, kInvertT, kPrimvarS, kPrimvarT };
constexpr Param kParams[] = {
    KINORA_PLACE_ANGLE,
    KINORA_PLACE_PARAMS,
    param::flag("invertS", false).help("1: s becomes 1 - s, last of all."),
    param::flag("invertT", true).help("1: t becomes 1 - t, last of all."),
    KINORA_PLACE_PRIMVARS,
    param::output(Type::Struct, "result"),
    param::output(Type::Float, "resultS"),
    param::output(Type::Float, "resultT"),
};

struct PxrManifold2D {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Place2D place(*c, {kAngle, kScaleS, kScaleT, kOffsetS, kOffsetT, kInvertS, kInvertT, kPrimvarS, kPrimvarT});
    Manifold& m = args->manifolds[0];
    place.makeManifold<W>(m, args->outputs[1], args->outputs[2]);
    args->outputs[0] = m.q;
    if (args->wanted[0] & kWantGradients) place.makeGradients<W>(m);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrManifold2D, .help = "Places 2D textures: rotates, scales, shifts and inverts texture coordinates.",
               .params = kParams)
