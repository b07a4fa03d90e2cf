// Cameras that look around: the raster's columns are turns about the camera's y axis, its rows elevations (sphere) or
// heights on a cylinder. What PxrSphereCamera and PxrCylinderCamera are made of. Included per target.
//
// Light paths: a pixel's solid angle is its part of the turn times that of sin(elevation); on the cylinder heights are
// tan(elevation), whose derivative is 1 / cos^2, which makes cos^3 d(height) d(turn) of it.
#include <kinora/projection_author.h>
#include <kinora/math/elementary.h>
#include "plugins/projection/parts/requested_lens.h"

#ifndef KINORA_AROUND_ONCE
#define KINORA_AROUND_ONCE
namespace kinora::around {
constexpr double kRadians = 3.14159265358979323846 / 180;

struct Data {
  bool isCylinder = false;
  float width = 1, height = 1;
  float turn = 1, rise = 1;  // of the whole picture: radians; radians or height at distance 1
};

inline std::unique_ptr<Data> make(const CreateInfo& info, const Param* params, size_t count, bool isCylinder) {
  const NamedValues v(info, params, count);
  const auto* picture = static_cast<const ProjectionInfo*>(info.extra);
  if (!picture || !picture->resolution[0] || !picture->resolution[1]) throw "the picture has no pixels";
  const double across = v.number("hsweep"), up = v.number("vsweep");
  if (!(across > 0) || across > 360) throw "hsweep must lie above 0 and up to 360 degrees";
  if (!(up > 0) || up > (isCylinder ? 179 : 180))
    throw "vsweep must lie above 0 and up to 180 degrees, 179 on a cylinder";
  tellOfNoLens(info);
  auto data = std::make_unique<Data>();
  data->isCylinder = isCylinder;
  data->width = float(picture->resolution[0]);
  data->height = float(picture->resolution[1]);
  data->turn = float(across * kRadians);
  data->rise = float(isCylinder ? 2 * std::tan(up * kRadians / 2) : up * kRadians);
  return data;
}
constexpr auto params(float up, float most) {
  return std::array{
      param::number("hsweep", 360.f).range(10, 360).help("Degrees from the left to the right of the picture."),
      param::number("vsweep", up).range(10, most).help("Degrees from the bottom to the top of the picture."),
  };
}
}  // namespace kinora::around
#endif

#if defined(KINORA_AROUND_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_AROUND_H_TARGET
#undef KINORA_AROUND_H_TARGET
#else
#define KINORA_AROUND_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

struct AroundProjection {
  using Data = around::Data;
  // Rays per solid angle in a direction of this elevation's cosine.
  template <int W>
  static KN_INLINE Float<W> density(const Data& k, Float<W> cosine) {
    using F = Float<W>;
    const F perPixel(k.width * k.height / (k.turn * k.rise)), c = max(cosine, F(1e-6f));
    return perPixel / (k.isCylinder ? c * c * c : c);
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    const F angle = fms(in.x, F(k.turn / k.width), F(0.5f * k.turn));
    const F up = fnma(in.y, F(k.rise / k.height), F(0.5f * k.rise));
    F sine, cosine, across, along;
    if (k.isCylinder) {
      cosine = F(1.f) / sqrt(fma(up, up, F(1.f)));
      sine = up * cosine;
    } else {
      sincos(up, sine, cosine);
      cosine = max(cosine, F(0.f));
    }
    sincos(angle, across, along);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    out.d = Vec3<W>(across * cosine, sine, along * cosine);
    out.weight = F(1.f);
    out.radius = F(0.f);
    out.spread = F(0.5f) / sqrt(density<W>(k, cosine));
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    const F aside = sqrt(fma(in.P.x, in.P.x, in.P.z * in.P.z)), distance = sqrt(fma(in.P.y, in.P.y, aside * aside));
    const F up = k.isCylinder ? in.P.y / max(aside, F(1e-30f)) : atan2(in.P.y, aside);
    out.o = Vec3<W>(F(0.f), F(0.f), F(0.f));
    out.x = fma(atan2(in.P.x, in.P.z), F(k.width / k.turn), F(0.5f * k.width));
    out.y = fnma(up, F(k.height / k.rise), F(0.5f * k.height));
    const Mask<W> seen = (aside > F(0.f)) & (out.x >= F(0.f)) & (out.x < F(k.width)) & (out.y >= F(0.f)) &
                         (out.y < F(k.height)) & isFinite(distance);
    out.importance = zeroUnless(seen, density<W>(k, aside / max(distance, F(1e-30f))));
    out.pdf = out.importance;
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
