#include "render/camera_attributes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/text.h"

namespace kinora::render {

namespace {

// A near plane close to an eye far from the origin would be lost in floats, and with it the way back: depth is
// measured in a larger unit then. x, y and w, by which points get their places, stay.
scene::Matrix floatReady(scene::Matrix ndc) {
  const double size = std::max({std::fabs(ndc[0][3]), std::fabs(ndc[1][3]), std::fabs(ndc[2][3])});
  bool isByDepth = size > 0;
  for (int i = 0; i < 3; ++i) isByDepth = isByDepth && std::fabs(ndc[i][2] - ndc[i][3]) <= 1e-12 * size;
  const double least = 1e-3 * std::max(std::fabs(ndc[3][3]), 1e-3);
  if (isByDepth && std::fabs(ndc[3][3] - ndc[3][2]) < least) ndc[3][2] = ndc[3][3] - least;
  return ndc;
}

// Where the picture lies on the plane at distance 1: centre and width. All 0 where the matrix does not say.
std::array<float, 3> screenWindowOf(const scene::Matrix& toNdc) {
  // (X Y 1 1) M is w (x y ..): two equations in X and Y
  const auto placeOf = [&](double x, double y, double out[2]) {
    double a[3][2];  // rows of X, Y and of the rest
    for (int k = 0; k < 2; ++k) {
      const double at = k == 0 ? x : y;
      for (int r = 0; r < 2; ++r) a[r][k] = toNdc[r][k] - at * toNdc[r][3];
      a[2][k] = toNdc[2][k] + toNdc[3][k] - at * (toNdc[2][3] + toNdc[3][3]);
    }
    const double determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    out[0] = (a[1][0] * a[2][1] - a[1][1] * a[2][0]) / determinant;
    out[1] = (a[0][1] * a[2][0] - a[0][0] * a[2][1]) / determinant;
  };
  double centre[2], left[2], right[2];
  placeOf(0.5, 0.5, centre);
  placeOf(0, 0.5, left);
  placeOf(1, 0.5, right);
  const double width = std::hypot(right[0] - left[0], right[1] - left[1]);
  if (!std::isfinite(width) || !std::isfinite(centre[0] + centre[1])) return {0, 0, 0};
  return {float(centre[0]), float(centre[1]), float(width)};
}

}  // namespace

void describeCamera(const CameraState& camera, film::FrameMetadata& out) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) out.worldToCamera[size_t(4 * i + j)] = float(camera.worldToCamera[i][j]);
  const auto* traits = static_cast<const ProjectionTraits*>(camera.projection.plugin()->traits);
  if (!traits || !traits->ndcMatrix) return;
  double s[16];
  traits->ndcMatrix(camera.projection.data(), s);
  scene::Matrix toNdc;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) toNdc[i][j] = s[4 * i + j];
  const scene::Matrix ndc = floatReady(camera.worldToCamera * toNdc);
  out.worldToNdc.emplace();
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) (*out.worldToNdc)[size_t(4 * i + j)] = float(ndc[i][j]);
  out.screenWindow = screenWindowOf(toNdc);
}

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
