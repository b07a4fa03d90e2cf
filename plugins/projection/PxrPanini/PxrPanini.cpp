// PxrPanini: wide views without the stretched sides of perspective (T. Sharpless, B. Postle and D. German, "Pannini: A
// New Projection for Rendering Wide Angle Perspective Images", 2010): directions are put on an upright cylinder, which is
// then looked at from `compression` radii behind its axis. 0 is perspective; uprights stay straight.
//
// With phi the turn and theta the elevation of a direction, d the compression and S = (d + 1) / (d + cos phi), the screen
// has h = S sin phi and v = S tan theta; its area over the solid angle is dh/dphi S / cos^3 theta.
//
// Depth of field is that of PxrPerspective: a thin lens at the eye that faces along the view axis, sharp on the plane at
// distance F. With o the lens point the unit direction D through the middle of the lens becomes D - o D.z / F, and what
// looks aside or back (D.z <= 0) is sharp at infinity. On the way back a unit direction w from the lens point is that of
// M w = w + o w.z / F; the determinant of M is 1 (o.z = 0), so that a solid angle there is 1 / |M w|^3 as large.
#define KINORA_KERNEL_FILE "plugins/projection/PxrPanini/PxrPanini.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>
#include <kinora/math/elementary.h>
#include "plugins/projection/parts/requested_lens.h"

#if KINORA_PLAIN
namespace kinora::pxrPanini {
constexpr Param kParams[] = {
    param::number("fov", 90.f)
        .range(10, 150)
        .help("Degrees that the shorter side of the picture spans, through its middle; below 180."),
    param::number("compression", 1.f)
        .help("How much the sides are drawn together: 0 perspective, 1 a stereographic cylinder."),
};
struct Data {
  ScreenMap screen;
  ThinLens lens;           // but its screen and field of view
  float d = 1, scale = 1;  // scale: of the screen, h and v over its coordinates
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams, std::size(kParams));
    const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
    screen = ScreenMap::of(picture);
    const double fov = v.number("fov"), compression = v.number("compression");
    if (!(fov > 0) || !(fov < 180)) throw "fov must lie between 0 and 180 degrees";
    if (!(compression >= 0) || compression > 1) throw "compression must lie between 0 and 1";
    const double half = fov * 3.14159265358979323846 / 360;
    setRequestedLens(lens, *picture);
    d = float(compression);
    scale = float(picture->frameAspect < 1 ? (compression + 1) * std::sin(half) / (compression + std::cos(half))
                                           : std::tan(half));
  }
};
}  // namespace kinora::pxrPanini
#endif

KINORA_KERNELS_BEGIN
struct PxrPanini {
  using Data = pxrPanini::Data;
  // Rays per solid angle.
  template <int W>
  static KN_INLINE Float<W> density(const Data& k, Float<W> cosPhi, Float<W> cosTheta) {
    using F = Float<W>;
    const F d(k.d), one(1.f), below = one / (d + cosPhi), S = (d + one) * below;
    const F slope = S * fma(d, cosPhi, one) * below;
    return slope * S / (cosTheta * cosTheta * cosTheta * F(k.scale * k.scale * k.screen.pixelArea()));
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    F h, v;
    toScreen(k.screen, in.x, in.y, h, v);
    h = h * F(k.scale);
    v = v * F(k.scale);
    const F d(k.d), one(1.f), a = h / (d + one), k2 = a * a;
    const F root = sqrt(fma(k2, fnma(d, d, one), one)), cosPhi = (root - k2 * d) / (k2 + one);
    // h over S, and v over S
    const F perS = (d + cosPhi) / (d + one), sinPhi = h * perS, up = v * perS;
    const F cosTheta = one / sqrt(fma(up, up, one));
    Vec3<W> dir(sinPhi * cosTheta, up * cosTheta, cosPhi * cosTheta);
    F perAngle = density<W>(k, cosPhi, cosTheta);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    if (k.lens.lensRadius > 0) {
      out.o = ThinLensProjection::lensPoint<W>(k.lens, in.lensU, in.lensV);
      dir = dir - out.o * (max(dir.z, F(0.f)) * F(k.lens.sharp[2]));
      const F size = length(dir);
      perAngle = perAngle * (size * size * size);
    }
    out.d = dir * (one / length(dir));
    out.weight = one;
    out.radius = F(0.f);
    out.spread = F(0.5f) / sqrt(perAngle);
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    Vec3<W> P = in.P;  // as through the middle of the lens
    F perLensAngle(1.f);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    if (k.lens.lensRadius > 0) {
      out.o = ThinLensProjection::lensPoint<W>(k.lens, in.lensU, in.lensV);
      const Vec3<W> to = in.P - out.o, w = to * (F(1.f) / max(length(to), F(1e-30f)));
      P = w + out.o * (max(w.z, F(0.f)) * F(k.lens.sharp[2]));
      const F size = max(length(P), F(1e-6f));
      perLensAngle = F(1.f) / (size * size * size);
    }
    const F aside = sqrt(fma(P.x, P.x, P.z * P.z)), distance = sqrt(fma(P.y, P.y, aside * aside));
    const F inv = F(1.f) / max(aside, F(1e-30f)), cosPhi = P.z * inv, cosTheta = aside / max(distance, F(1e-30f));
    const F d(k.d), open = d + cosPhi, S = (d + F(1.f)) / max(open, F(1e-6f)), scale = S * inv / F(k.scale);
    toRaster(k.screen, P.x * scale, P.y * scale, out.x, out.y);
    const Mask<W> seen = (aside > F(0.f)) & (open > F(1e-4f)) & insideRaster(k.screen, out.x, out.y) &
                         isFinite(distance) & (cosTheta > F(1e-6f));
    out.importance =
        zeroUnless(seen, density<W>(k, select(seen, cosPhi, F(1.f)), select(seen, cosTheta, F(1.f))) * perLensAngle);
    out.pdf = out.importance;
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(
    PxrPanini,
    .help =
        "Wide views without stretched sides, uprights straight. The DepthOfField request acts as on PxrPerspective: "
        "sharp is a plane that faces the view axis, and what lies 90 degrees from it and more is sharp at infinity.",
    .params = pxrPanini::kParams, .setUp = setUp<pxrPanini::Data>)
