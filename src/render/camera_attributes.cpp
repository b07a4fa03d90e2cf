#include "render/camera_attributes.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/text.h"

namespace kinora::render {

scene::ParameterList cameraAttributes(const scene::Scene& scene, const CameraState& state) {
  const scene::Camera camera = scene.cameras.empty() ? scene::Camera() : scene.cameras.front();
  scene::ParameterList list;
  const auto numbers = [&](const char* name, std::vector<float> v) {
    scene::Parameter p;
    p.name = std::string("camera:") + name;
    p.floats = std::move(v);
    list.set(std::move(p));
  };
  scene::Parameter resolution;
  resolution.name = "camera:resolution";
  resolution.type = scene::ValueType::Int;
  resolution.ints = {state.resolution[0], state.resolution[1]};
  list.set(std::move(resolution));
  const std::string kind = camera.projection ? lowerCase(camera.projection->plugin) : "orthographic";
  const bool isPerspective = kind.ends_with("perspective") || kind.ends_with("camera");
  scene::Parameter projection;
  projection.name = "camera:projection";
  projection.type = scene::ValueType::String;
  projection.strings = {isPerspective ? "perspective" : kind.ends_with("orthographic") ? "orthographic" : kind};
  list.set(std::move(projection));
  if (isPerspective) numbers("fov", {camera.projection->params.getFloat("fov", 90)});
  numbers("pixelaspect", {scene.pixelAspect > 0 ? scene.pixelAspect : 1.f});
  const bool clips = camera.clipping[1] > camera.clipping[0];  // else RI_EPSILON and RI_INFINITY
  const float clip[2] = {clips ? camera.clipping[0] : 1e-10f, clips ? camera.clipping[1] : 1e38f};
  numbers("clip_near", {clip[0]});
  numbers("clip_far", {clip[1]});
  numbers("clip", {clip[0], clip[1]});
  numbers("shutter_open", {float(state.shutterOpen)});
  numbers("shutter_close", {float(state.shutterClose)});
  numbers("shutter", {float(state.shutterOpen), float(state.shutterClose)});
  // without a ScreenWindow the shorter side runs from -1 to 1
  std::array<float, 4> window = camera.screenWindow;
  if (window == std::array<float, 4>{0, 0, 0, 0}) {
    const float shape =
        float(state.resolution[0]) / float(state.resolution[1]) * (scene.pixelAspect > 0 ? scene.pixelAspect : 1.f);
    const float x = std::max(shape, 1.f), y = std::max(1 / shape, 1.f);
    window = {-x, x, -y, y};
  }
  numbers("screen_window", {window[0], window[2], window[1], window[3]});
  return list;
}

}  // namespace kinora::render
