// PxrPanini: wide views without the stretched sides of perspective (T. Sharpless, B. Postle and D. German, "Pannini: A
// New Projection for Rendering Wide Angle Perspective Images", 2010): directions are put on an upright cylinder, which is
// then looked at from `compression` radii behind its axis. 0 is perspective; uprights stay straight.
//
// With phi the turn and theta the elevation of a direction, d the compression and S = (d + 1) / (d + cos phi), the screen
// has h = S sin phi and v = S tan theta; its area over the solid angle is dh/dphi S / cos^3 theta.
#define KINORA_KERNEL_FILE "plugins/projection/PxrPanini/PxrPanini.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>
#include <kinora/math/elementary.h>

#if KINORA_PLAIN
namespace kinora::pxrPanini {
constexpr Param kParams[] = {
    param::number("fov", 90.f)
        .range(10, 150)
        .help("Degrees that the shorter side of the picture spans, through its middle; below 180."),
    param::number("compression", 1.f)
        .range(0, 1)
        .help("How much the sides are drawn together: 0 perspective, 1 a stereographic cylinder."),
};
struct Data {
  ScreenMap screen;
  float d = 1, scale = 1;  // scale: of the screen, h and v over its coordinates
  explicit Data(const CreateInfo& info) {
    const NamedValues v(info, kParams, std::size(kParams));
    const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
    screen = ScreenMap::of(picture);
    const double fov = v.number("fov"), compression = v.number("compression");
    if (!(fov > 0) || !(fov < 180)) throw "fov must lie between 0 and 180 degrees";
    if (!(compression >= 0) || compression > 1) throw "compression must lie between 0 and 1";
    const double half = fov * 3.14159265358979323846 / 360;
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
    const Vec3<W> dir(sinPhi * cosTheta, up * cosTheta, cosPhi * cosTheta);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    out.d = dir * (one / length(dir));
    out.weight = one;
    out.radius = F(0.f);
    out.spread = F(0.5f) / sqrt(density<W>(k, cosPhi, cosTheta));
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    const F aside = sqrt(fma(in.P.x, in.P.x, in.P.z * in.P.z)), distance = sqrt(fma(in.P.y, in.P.y, aside * aside));
    const F inv = F(1.f) / max(aside, F(1e-30f)), cosPhi = in.P.z * inv, cosTheta = aside / max(distance, F(1e-30f));
    const F d(k.d), open = d + cosPhi, S = (d + F(1.f)) / max(open, F(1e-6f)), scale = S * inv / F(k.scale);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    toRaster(k.screen, in.P.x * scale, in.P.y * scale, out.x, out.y);
    const Mask<W> seen = (aside > F(0.f)) & (open > F(1e-4f)) & insideRaster(k.screen, out.x, out.y) &
                         isFinite(distance) & (cosTheta > F(1e-6f));
    out.importance = zeroUnless(seen, density<W>(k, select(seen, cosPhi, F(1.f)), select(seen, cosTheta, F(1.f))));
    out.pdf = out.importance;
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(PxrPanini, .help = "Wide views without stretched sides, uprights straight.",
                  .params = pxrPanini::kParams, .setUp = setUp<pxrPanini::Data>)
