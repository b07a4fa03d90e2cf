// PxrLightProbe: all directions in a disk (P. Debevec, "Rendering Synthetic Objects into Real Scenes", 1998): the middle
// looks along the view axis, and the distance from it is the angle to the axis, up to straight back at the rim. The disk
// fills the shorter side of the picture; beyond it nothing is seen.
//
// Light paths: with theta the angle to the axis a point of the screen is at theta / pi, so that an area dA there covers
// pi^2 sin(theta) / theta dA of directions.
#define KINORA_KERNEL_FILE "plugins/projection/PxrLightProbe/PxrLightProbe.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>
#include <kinora/math/elementary.h>
#include "plugins/projection/parts/requested_lens.h"

#if KINORA_PLAIN
namespace kinora::pxrLightProbe {
struct Data {
  ScreenMap screen;
  explicit Data(const CreateInfo& info) : screen(ScreenMap::of(static_cast<const ProjectionInfo*>(info.extra))) {
    tellOfNoLens(info);
  }
};
}  // namespace kinora::pxrLightProbe
#endif

KINORA_KERNELS_BEGIN
struct PxrLightProbe {
  using Data = pxrLightProbe::Data;
  // Rays per solid angle.
  template <int W>
  static KN_INLINE Float<W> density(const Data& k, Float<W> theta, Float<W> sine) {
    using F = Float<W>;
    const F ratio = select(theta > F(1e-4f), theta / max(sine, F(1e-6f)), F(1.f));
    return ratio * F(1.f / (k.screen.pixelArea() * kPi * kPi));
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    F sx, sy, sine, cosine;
    toScreen(k.screen, in.x, in.y, sx, sy);
    const F r = sqrt(fma(sx, sx, sy * sy));
    const Mask<W> seen = r <= F(1.f);
    const F theta = min(r, F(1.f)) * F(kPi);
    sincos(theta, sine, cosine);
    const F across = select(r > F(1e-6f), sine / max(r, F(1e-6f)), F(kPi));
    const Vec3<W> d(sx * across, sy * across, cosine);
    // what is beyond the disk looks away from far behind everything
    out.o = Vec3<W>(F(0.f), F(0.f), select(seen, F(0.f), F(-1e12f)));
    out.d = select(seen, d * (F(1.f) / max(length(d), F(1e-6f))), Vec3<W>(F(0.f), F(0.f), F(-1.f)));
    out.weight = select(seen, F(1.f), F(0.f));
    out.radius = F(0.f);
    out.spread = F(0.5f) / sqrt(density<W>(k, theta, sine));
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    const F aside = sqrt(fma(in.P.x, in.P.x, in.P.y * in.P.y)), distance = sqrt(fma(in.P.z, in.P.z, aside * aside));
    const F theta = atan2(aside, in.P.z), scale = theta * F(1.f / kPi) / max(aside, F(1e-30f));
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    toRaster(k.screen, in.P.x * scale, in.P.y * scale, out.x, out.y);
    const Mask<W> seen = (distance > F(0.f)) & insideRaster(k.screen, out.x, out.y) & isFinite(distance);
    out.importance = zeroUnless(seen, density<W>(k, theta, aside / max(distance, F(1e-30f))));
    out.pdf = out.importance;
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(PxrLightProbe,
                  .help =
                      "All directions in a disk: the distance from the middle is the angle to the view axis, 180 "
                      "degrees at the rim. No depth of field.",
                  .setUp = setUp<pxrLightProbe::Data>)
