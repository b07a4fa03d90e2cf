// OmnidirectionalStereo: all around for two eyes, in one picture: above what the left eye sees, below the right one's,
// each as PxrSphereCamera shows it. Whatever column is looked at, the eyes stand beside each other across that direction:
// they go round on a circle (Google, "Rendering Omni-directional Stereo Content", 2015).
//
// Light paths: for an eye on that circle the volume element is l^2 cos(elevation) dl d(turn) d(elevation) at distance l
// along the ray, as for an eye that stands still, and so is the density of rays. A point is seen by both eyes, a
// connection shows it to one: the lens number chooses which, for twice the importance.
#define KINORA_KERNEL_FILE "plugins/projection/OmnidirectionalStereo/OmnidirectionalStereo.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include "plugins/projection/parts/around.h"

#if KINORA_PLAIN
namespace kinora::omnidirectionalStereo {
constexpr Param kParams[] = {
    param::number("interpupilaryDistance", 0.0635f)
        .help("Between the eyes, in units of the scene: 0.0635 where these are metres. 0: both see the same."),
};
struct Data {
  around::Data eye;  // the picture of one
  float radius = 0;
};
std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams, std::size(kParams));
  const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
  if (!picture || !picture->resolution[0] || picture->resolution[1] < 2)
    throw "the picture has no pixels for two eyes";
  const double apart = v.number("interpupilaryDistance");
  if (!(apart >= 0) || !(apart < 1e6)) throw "interpupilaryDistance must not be negative";
  tellOfNoLens(info);
  auto data = std::make_unique<Data>();
  data->eye.width = float(picture->resolution[0]);
  data->eye.height = 0.5f * float(picture->resolution[1]);
  data->eye.turn = float(360 * around::kRadians);
  data->eye.rise = float(180 * around::kRadians);
  data->radius = float(apart / 2);
  return data;
}
}  // namespace kinora::omnidirectionalStereo
#endif

KINORA_KERNELS_BEGIN
struct OmnidirectionalStereo {
  using Data = omnidirectionalStereo::Data;
  // Where an eye stands that looks along a turn; side -1: the left one.
  template <int W>
  static KN_INLINE Vec3<W> eyeAt(const Data& k, Float<W> turn, Float<W> side) {
    using F = Float<W>;
    F sine, cosine;
    sincos(turn, sine, cosine);
    const F r = side * F(k.radius);
    return Vec3<W>(r * cosine, F(0.f), -(r * sine));
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    const Mask<W> left = in.y < F(k.eye.height);
    CameraSample<W> one = in;
    one.y = select(left, in.y, in.y - F(k.eye.height));
    AroundProjection::rays<W>(k.eye, one, out);
    out.o = eyeAt<W>(k, fms(in.x, F(k.eye.turn / k.eye.width), F(0.5f * k.eye.turn)), select(left, F(-1.f), F(1.f)));
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    const Mask<W> left = in.lensU < F(0.5f);
    const F side = select(left, F(-1.f), F(1.f)), r(k.radius);
    const F aside2 = fma(in.P.x, in.P.x, in.P.z * in.P.z), along = sqrt(max(fnma(r, r, aside2), F(0.f)));
    F turn = atan2(in.P.x, in.P.z) - atan2(side * r, along);
    turn = select(turn < F(-kPi), turn + F(kTwoPi), select(turn > F(kPi), turn - F(kTwoPi), turn));
    out.o = eyeAt<W>(k, turn, side);
    // as the eye in the middle sees the point that stands so relative to it
    CameraPoint<W> one = in;
    F sine, cosine;
    sincos(turn, sine, cosine);
    one.P = Vec3<W>(along * sine, in.P.y, along * cosine);
    CameraLink<W> link;
    AroundProjection::connect<W>(k.eye, one, link);
    const Mask<W> seen = aside2 > r * r;
    out.x = link.x;
    out.y = select(left, link.y, link.y + F(k.eye.height));
    out.pdf = zeroUnless(seen, link.pdf);
    out.importance = zeroUnless(seen, link.importance + link.importance);
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(OmnidirectionalStereo,
                  .help = "All around for two eyes, the left one's picture above the right one's. No depth of field.",
                  .params = omnidirectionalStereo::kParams, .setUp = setUpBy<omnidirectionalStereo::make>)
