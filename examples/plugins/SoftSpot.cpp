// A light filter: the light falls off with the distance from the z axis of a coordinate system.
//   LightFilter "SoftSpot" "spot" "float radius" [0.5]   (before the Light that it filters)
#define KINORA_KERNEL_FILE "SoftSpot.cpp"
#include <kinora/light_setup.h>
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::softSpot {
enum : uint32_t { kRadius, kCoordsys };
constexpr Param kParams[] = {
    param::number("radius", 1.f).range(0.1f, 10).help("Where the light has fallen to half, in the filter's space."),
    param::string("coordsys", "").help("Coordinate system of the filter; empty: the light's."),
};
struct Data {
  Float3 center, axis;  // render space
  float inverseRadius2;
  explicit Data(const CreateInfo& info) {
    const LocalFrame frame = LocalFrame::of(info);
    const double radius = info.number(kRadius) * length(frame.x);
    if (!(radius > 0)) throw "radius must be positive";
    center = Float3(frame.origin);
    axis = Float3(normalized(frame.z));
    inverseRadius2 = float(1 / (radius * radius));
  }
};
}  // namespace kinora::softSpot
#endif

KINORA_KERNELS_BEGIN
using namespace softSpot;

struct SoftSpot {
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
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(SoftSpot, .help = "Light that falls off around an axis.", .params = kParams, .setUp = setUp<Data>)
