// PxrDisplace: P' = P + dispAmount * (dispScalar * N + dispVector + modelDispVector), in the space of the object.
#define KINORA_KERNEL_FILE "plugins/displacement/PxrDisplace/PxrDisplace.cpp"
#include <kinora/displacement_author.h>

#include <cmath>
#include <limits>

#ifndef KINORA_PXR_DISPLACE_ONCE
#define KINORA_PXR_DISPLACE_ONCE
namespace kinora::displace {
enum : uint32_t { kEnabled, kAmount, kScalar, kVector, kModelVector };

inline float bound(const CreateInfo* info) {
  if (!info->integer(kEnabled)) return 0;
  for (uint32_t i = kAmount; i <= kModelVector; ++i)
    if (info->values[i].connected) return std::numeric_limits<float>::infinity();
  float way = std::fabs(info->number(kScalar));
  for (const uint32_t i : {uint32_t(kVector), uint32_t(kModelVector)}) {
    const float* v = info->values[i].floats;
    if (info->values[i].count >= 3) way += std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return std::fabs(info->number(kAmount)) * way;
}
}  // namespace kinora::displace
#endif

KINORA_KERNELS_BEGIN

using namespace displace;

constexpr Param kParams[] = {
    param::onOff("enabled", true).help("0 leaves the surface where it is."),
    param::number("dispAmount", 1.f).range(-2, 2).help("Factor on the whole displacement."),
    param::number("dispScalar", 0.f).range(-1, 1).help("Distance along the normal; object units."),
    param::vector("dispVector", 0, 0, 0).help("Offset in object space."),
    param::vector("modelDispVector", 0, 0, 0).help("Offset modelled elsewhere, added to dispVector; object space."),
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

KINORA_DISPLACEMENT(PxrDisplace,
                    .help = "Moves a surface along its normal and by a vector, in the space of its object.",
                    .params = kParams, .bound = displace::bound)
