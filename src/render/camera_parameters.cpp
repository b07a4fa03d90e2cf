#include "render/camera_parameters.h"

#include <algorithm>

#include "base/near_name.h"

namespace kinora::render {

void warnOfCameraParameters(const scene::Camera& camera, Diagnostics& diagnostics) {
  static const std::vector<std::string> kKnown = {
      "shutterOpenTime",   "shutterCloseTime", "shutteropening", "apertureNSides", "apertureAngle",
      "apertureRoundness", "apertureDensity",  "dofaspect",      "nearClip",       "farClip"};
  // of pairs of pictures and of focus in a part of the picture: read, without effect
  static const std::vector<std::string> kWithoutEffect = {"extremeoffset", "stereoplanedepths", "stereoplaneoffsets",
                                                          "focusregion"};
  const auto holds = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const scene::Parameter& p : camera.params) {
    if (holds(kKnown, p.name) || p.name.starts_with("__") || p.name.starts_with("user:")) continue;
    if (holds(kWithoutEffect, p.name)) {
      const auto isZero = [](auto x) { return x == 0; };
      if (std::all_of(p.floats.begin(), p.floats.end(), isZero) && std::all_of(p.ints.begin(), p.ints.end(), isZero))
        continue;
      diagnostics.warning(
          "PARAM-NO-EFFECT", p.pos,
          "the camera '" + camera.name + "' has '" + p.name + "', which has no effect in this version", "ignored");
      continue;
    }
    const std::string near = didYouMean(p.name, kKnown);
    diagnostics.warning("PARAM-UNKNOWN", p.pos, "the camera '" + camera.name + "' has no parameter '" + p.name + "'",
                        "ignored", near.empty() ? "lens and field of view belong to Projection" : near);
  }
}

void setAperture(const scene::Camera& camera, const scene::NodePtr& hider, ProjectionInfo& info) {
  std::vector<float> old;
  if (hider) old = hider->params.getFloats("aperture");
  const auto number = [&](const char* name, size_t index, float usual) {
    return camera.params.getFloat(name, old.size() == 4 ? old[index] : usual);
  };
  info.apertureSides = number("apertureNSides", 0, 0);
  info.apertureAngle = number("apertureAngle", 1, 0);
  info.apertureRoundness = number("apertureRoundness", 2, 1);
  info.apertureDensity = number("apertureDensity", 3, 0);
  info.apertureAspect = camera.params.getFloat("dofaspect", hider ? hider->params.getFloat("dofaspect", 1) : 1);
}

}  // namespace kinora::render
