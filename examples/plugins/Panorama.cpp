// A projection: all around the eye, on a cylinder.
//   Projection "Panorama" "float heightAngle" [90]
#define KINORA_KERNEL_FILE "Panorama.cpp"
#include <cmath>
#include <kinora/projection_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::panorama {
constexpr Param kParams[] = {
    param::number("heightAngle", 90.f).range(1, 170).help("Degrees from the bottom to the top of the picture."),
};
struct Data {
  float width, height, tangent;
  explicit Data(const CreateInfo& info) {
    const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
    const double angle = info.number(0);
    if (!(angle > 0 && angle < 179)) throw "heightAngle must lie between 0 and 179 degrees";
    width = float(picture->resolution[0]);
    height = float(picture->resolution[1]);
    tangent = float(std::tan(angle * 3.14159265358979 / 360));
  }
};
}  // namespace kinora::panorama
#endif

KINORA_KERNELS_BEGIN
using namespace panorama;

struct Panorama {
  using Data = panorama::Data;
  static constexpr float kTurn = 6.2831853f;
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    const F angle = fms(in.x, F(kTurn / k.width), F(0.5f * kTurn));
    const F up = F(k.tangent) * fnma(in.y, F(2.f / k.height), F(1.f));
    const F scale = F(1.f) / sqrt(fma(up, up, F(1.f)));
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    out.d = Vec3<W>(sin(angle), up, cos(angle)) * scale;
    out.weight = F(1.f);
    out.radius = F(0.f);
    out.spread = F(0.5f * kTurn / k.width) * scale;
  }
  // No way back: light paths do not find this camera.
  template <int W>
  static KN_INLINE void connect(const Data&, const CameraPoint<W>& in, CameraLink<W>& out) {
    out.o = in.P;
    out.x = out.y = out.importance = out.pdf = Float<W>(0.f);
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(Panorama, .help = "All around the eye on a cylinder.", .params = kParams, .setUp = setUp<Data>)
