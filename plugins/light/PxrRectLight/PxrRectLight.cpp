// PxrRectLight: the unit square of the local XY plane, emitting to the side of local +Z.
#define KINORA_KERNEL_FILE "plugins/light/PxrRectLight/PxrRectLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/rectangle_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrRectLight {
constexpr auto kParams = joinParams(lightParams::kRadiance, lightParams::kNormalize, lightParams::kMap,
                                    lightParams::kShaping, lightParams::kControl);
using Data = lightParts::Rectangle;

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->common = LightCommon::of(values, Data::areaOf(frame));
  light->shaping = Shaping::of(values, false);
  light->map.load(values);
  values.warnNoEffect();
  light->place(values, frame);
  return light;
}

void describe(const void* data, LightDescription* d) { *d = lightParts::describe(*static_cast<const Data*>(data)); }
double irradiance(const void* data, const double P[3], const double N[3]) {
  return lightParts::irradiance(*static_cast<const Data*>(data), P, N);
}
}  // namespace kinora::pxrRectLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrRectLight;

struct PxrRectLight : RectangleLight<PxrRectLight, pxrRectLight::Data> {
  // x, y: local position in [-.5, .5]. A viewer in front sees the map upright and not mirrored when the scene's space
  // is left-handed: u runs along -x, v (down) along -y.
  template <int W>
  static KN_INLINE Rgb<W> radiance(const RectangleLanes<Data, W>& k, Vec3<W>, Float<W> x, Float<W> y,
                                   Float<W> cosine) {
    Rgb<W> l = k.of.rgb([](const Data& d) { return d.common.radiance; }) * shape(k.of, cosine);
    if (k.of.any([](const Data& d) { return d.map.valid(); }))
      l = l * lookUp<W, false>(k.of, Float<W>(0.5f) - x, Float<W>(0.5f) - y);
    return l;
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrRectLight,
             .help =
                 "Rectangle: the unit square of the local XY plane, emitting to the side of local +Z. Seen from the "
                 "front with local +Y up, a map stands upright with its left edge at local +X.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
