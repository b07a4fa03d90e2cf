// A light filter: the light falls off with the distance from the z axis of a coordinate system.
//   LightFilter "SoftSpot" "spot" "float radius" [0.5]   (before the Light that it filters)
#define KINORA_KERNEL_FILE "SoftSpot.cpp"
#include <kinora/light_filter.h>
#include <kinora/light_setup.h>

#include <cmath>
#include <iterator>
#include <memory>

#include <kinora/simd/foreach_target.h>
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#ifndef SOFTSPOT_ONCE
#define SOFTSPOT_ONCE
namespace kinora::softSpot {
constexpr Param kParams[] = {
    param::number("radius", 1.f).range(0.1f, 10).help("Where the light has fallen to half, in the filter's space."),
    param::string("coordsys", "").help("Coordinate system of the filter; empty: the light's."),
};
struct Data {
  Float3 center, axis;  // render space
  float inverseRadius2;
};
}  // namespace kinora::softSpot
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
struct Spot {
  using Data = softSpot::Data;
  // Depends on the lit point alone, so light samples and rays that meet the light agree.
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    const Vec3<W> axis(F(k.axis.x), F(k.axis.y), F(k.axis.z));
    const Vec3<W> from = p.P - Vec3<W>(F(k.center.x), F(k.center.y), F(k.center.z));
    const Vec3<W> off = from - axis * dot(from, axis);
    const F f = F(1.f) / fma(dot(off, off), F(k.inverseRadius2), F(1.f));
    return {f, f, f};
  }
};
using Runner = LightFilterRunner<Spot>;
KINORA_WIDTH_TABLES(Runner, LightFilterFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace softSpot;

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues v(*info, kParams, std::size(kParams));
    const LocalFrame frame = LocalFrame::of(*info);
    const double radius = v.number("radius") * length(frame.x);
    if (!(radius > 0)) throw "radius must be positive";
    return std::make_unique<Data>(
               Data{Float3(frame.origin), Float3(normalized(frame.z)), float(1 / (radius * radius))})
        .release();
  });
}
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::LightFilter,
                             0,
                             "SoftSpot",
                             "Light that falls off around an axis.",
                             kParams,
                             uint32_t(std::size(kParams)),
                             kTables,
                             4,
                             nullptr,
                             create,
                             [](void* d) { delete static_cast<Data*>(d); }};
}  // namespace
KINORA_REGISTER(SoftSpot, kDescriptor)
}  // namespace kinora
#endif
