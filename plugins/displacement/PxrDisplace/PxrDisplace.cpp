// PxrDisplace: P' = P + dispAmount * (dispScalar * N + dispVector + modelDispVector).
#define KINORA_KERNEL_FILE "plugins/displacement/PxrDisplace/PxrDisplace.cpp"
#include <kinora/displacement_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kEnabled, kAmount, kScalar, kVector, kModelVector };
constexpr Param kParams[] = {
    param::integer("enabled", 1).range(0, 1).options("0 off, 1 on").help("0 leaves the surface where it is."),
    param::number("dispAmount", 1.f).range(-2, 2).help("Factor on the whole displacement."),
    param::number("dispScalar", 0.f).range(-1, 1).help("Distance along the normal."),
    param::vector("dispVector", 0, 0, 0).help("Offset in the space of the points."),
    param::vector("modelDispVector", 0, 0, 0).help("Offset modelled elsewhere, added to dispVector."),
};

struct PxrDisplace {
  template <int W>
  static KN_INLINE Vec3<W> offset(const Context& c, At at) {
    if (!fixedInteger(c, kEnabled)) return Vec3<W>(0.f);
    const Value vector = c.param(kVector), model = c.param(kModelVector), scalar = c.param(kScalar),
                amount = c.param(kAmount);
    const Rgb<W> v = loadRgb<W>(vector, at), m = loadRgb<W>(model, at);
    const Float<W> s = loadFloat<W>(scalar, at), a = loadFloat<W>(amount, at);
    const Vec3<W> n = Vec3<W>::load(c.N, at.first);
    return {a * fma(s, n.x, v.x + m.x), a * fma(s, n.y, v.y + m.y), a * fma(s, n.z, v.z + m.z)};
  }
};

KINORA_KERNELS_END

KINORA_DISPLACEMENT(PxrDisplace, .help = "Moves a surface along its normal and by a vector. Kept, not rendered yet.",
                    .params = kParams)
