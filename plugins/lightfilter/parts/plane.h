// How light is projected through the filter's XY plane: the place in the plane that belongs to a lit point. What
// PxrBarnLightFilter, PxrCookieLightFilter and PxrGoboLightFilter stand on. Plain; plane_kernel.h evaluates it.
#pragma once
#include "plugins/lightfilter/parts/filter_setup.h"

namespace kinora::filterParts {

constexpr auto planeParams(const char* modeName, const char* choices) {
  return std::array{
      param::integer(modeName, 0)
          .options(choices)
          .help("Physical: the line from the lit point to the point on the light meets the plane. Analytic: the lit "
                "point is projected from one centre, so that large lights keep its edges sharp."),
      param::onOff("directional", false).help("Analytic: project along z instead of from a point."),
      param::onOff("useLightDirection", false)
          .help("Analytic: project from the light's origin, or along its own z axis, where that lies behind the "
                "plane."),
      param::number("apex", 25.f)
          .range(0.1f, 100)
          .help("Analytic: distance of the centre of projection behind the plane."),
      param::number("shearX", 0.f).range(-1, 1).help("Analytic: the projection moves in x by this much of z."),
      param::number("shearY", 0.f).range(-1, 1).help("Analytic: the projection moves in y by this much of z."),
      param::number("width", 1.f).range(0.1f, 4).help("Size in x."),
      param::number("height", 1.f).range(0.1f, 4).help("Size in y."),
  };
}

struct Plane {
  FilterSpace space;
  bool physical = true, directional = false;
  Float3 centre{0, 0, -25};  // of the projection from a point
  Float3 along{0, 0, 1};     // the directional one's, with z 1

  void setAnalytic(const NamedValues& v, const char* modeName) {
    physical = v.integer(modeName) == 0;
    directional = v.integer("directional") != 0;
    const double shear[2] = {v.number("shearX"), v.number("shearY")}, apex = std::max(v.number("apex"), 1e-3);
    centre = Float3(-shear[0] * apex, -shear[1] * apex, -apex);
    along = Float3(shear[0], shear[1], 1);
    const auto* info = static_cast<const LightFilterInfo*>(v.info().extra);
    if (!v.integer("useLightDirection") || !info || !info->light) return;
    CreateInfo ofLight{};
    ofLight.placement = info->light;
    const LocalFrame light = LocalFrame::of(ofLight);
    const Double3 from = space.place(light.origin), axis = space.direction(light.z);
    if (from.z < -1e-3) centre = Float3(from);
    if (axis.z > 1e-3 * length(axis)) along = Float3(axis.x / axis.z, axis.y / axis.z, 1);
  }
};

}  // namespace kinora::filterParts
