#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.h"
#include "plugin/refused.h"
#include "render/camera_parameters.h"
#include "render/matrix_scale.h"
#include "render/shutter.h"
#include "scene/digests.h"
#include "scene/uniform_keys.h"

namespace kinora::render {

namespace {

// Resolution and crop window. False with a message when they leave no pixel, or too many.
bool setRaster(const scene::Scene& scene, const Settings& settings, Diagnostics& diagnostics, CameraState& c) {
  std::array<int, 2> res = scene.resolution;
  if (settings.resolution[0] > 0) res = settings.resolution;
  if (res[0] <= 0) res[0] = 640;
  if (res[1] <= 0) res[1] = 480;
  if (scene.frameAspect > 0) {
    // The largest part of the format that has this shape is the picture. Ratios are rounded numbers: what differs by
    // less than 1 % is meant to be the format's own. A resolution of the command line is a format too.
    const std::array<int, 2> asked = res;
    const double pixel = scene.pixelAspect > 0 ? scene.pixelAspect : 1, whole = res[0] * pixel / res[1];
    const double f = scene.frameAspect;
    if (f > whole * 1.01)
      res[1] = std::max(1, int(std::lround(res[0] * pixel / f)));
    else if (f < whole * 0.99)
      res[0] = std::max(1, int(std::lround(res[1] * f / pixel)));
    if (settings.resolution[0] > 0 && res != asked)
      diagnostics.warning("RENDER-FRAME-ASPECT", scene.pos,
                          "the scene's FrameAspectRatio is not that of " + std::to_string(asked[0]) + " x " +
                              std::to_string(asked[1]) + " pixels",
                          "the picture is the part of that shape, " + std::to_string(res[0]) + " x " +
                              std::to_string(res[1]) + " pixels");
  }
  if (res[0] > kMostSide || res[1] > kMostSide || int64_t(res[0]) * res[1] > kMostPixels) {
    diagnostics.error(
        "RENDER-RESOLUTION", scene.pos,
        "a picture of " + std::to_string(res[0]) + " x " + std::to_string(res[1]) + " pixels is too large",
        "nothing is rendered", "at most 65536 on a side and 2^31 pixels in all");
    return false;
  }
  c.resolution = res;
  std::array<float, 4> crop = scene.cropWindow;
  if (settings.crop[0] >= 0) crop = settings.crop;
  const auto edge = [](float f, int n) { return std::clamp(int(std::ceil(double(f) * n - 1e-6)), 0, n); };
  c.window = {edge(crop[0], res[0]), edge(crop[2], res[1]), edge(crop[1], res[0]), edge(crop[3], res[1])};
  if (c.window[0] >= c.window[2] || c.window[1] >= c.window[3]) {
    diagnostics.error(
        "RENDER-CROP", scene.pos,
        "the crop window holds no pixel of a picture of " + std::to_string(res[0]) + " x " + std::to_string(res[1]),
        "nothing is rendered", "a pixel belongs to the window that holds its top left corner");
    return false;
  }
  return true;
}

// A render space near the camera: float keeps its precision where it is looked at. Its origin lies on a coarse grid,
// so that it stays when the camera moves a little, and follows from where the camera is, so that it does not matter
// where the camera came from.
void setOrigin(const scene::Matrix& cameraToWorld, CameraState& c) {
  constexpr double kNear = 1024, kCell = 256;
  for (int k = 0; k < 3; ++k) {
    const double p = cameraToWorld[3][k];
    c.origin[k] = std::fabs(p) > kNear ? kCell * std::round(p / kCell) : 0;
  }
}

// Where the camera is over the shutter; a transform that is none becomes the identity.
void setPlace(scene::Camera& camera, Diagnostics& diagnostics, CameraState& c) {
  c.shutterOpen = camera.shutter[0];
  c.shutterClose = std::max(camera.shutter[1], camera.shutter[0]);
  const double middle = c.middle();
  c.worldToCamera = camera.worldToCamera.at(middle);
  if (!isFinite(c.worldToCamera) || std::fabs(c.worldToCamera.determinant()) < 1e-30) {
    diagnostics.warning("RENDER-CAMERA", camera.pos, "the camera's transform is singular or not finite",
                        "the identity is used");
    camera.worldToCamera = scene::Transform();
    c.worldToCamera = scene::Matrix();
  }
  const scene::Matrix cameraToWorld = c.worldToCamera.inverse();
  setOrigin(cameraToWorld, c);
  const bool moves = !camera.worldToCamera.isStatic() && c.shutterClose > c.shutterOpen;
  int keys = 1;
  if (moves) {
    // The way back from the camera is no straight line between keys: each interval of those that the scene says is divided,
    // until there are twice as many.
    constexpr int kMost = scene::kMostUniformKeys;
    const int said = scene::uniformKeyCount(camera.worldToCamera.times, c.shutterOpen, c.shutterClose, kMost);
    const int intervals = std::max(said - 1, 1),
              wanted = int(std::min<size_t>(camera.worldToCamera.matrices.size() * 2, 16));
    keys = intervals * std::clamp((wanted + intervals - 2) / intervals, 1, std::max((kMost - 1) / intervals, 1)) + 1;
  }
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-c.origin[0], -c.origin[1], -c.origin[2]));
  for (int k = 0; k < keys; ++k) {
    const double t = keys == 1 ? middle : c.shutterOpen + (c.shutterClose - c.shutterOpen) * k / (keys - 1);
    const scene::Matrix m = camera.worldToCamera.at(t).inverse() * shift;
    c.toRender.push_back(trace::Affine::from(m));
    c.fromRender.push_back(trace::Affine::from(m.inverse()));
  }
}

// Rays begin on the picture's plane, the lens and the near plane: what is beyond these numbers no ray can hold.
void boundNumbers(const scene::Camera& camera, Diagnostics& diagnostics, ProjectionInfo& info) {
  constexpr float kMost = kMostOfCamera;
  const auto tell = [&](const char* what, const char* done) {
    diagnostics.warning("RENDER-CAMERA", camera.pos, std::string(what) + " is beyond 1e15", done);
  };
  for (const float x : info.screenWindow)
    if (!(std::fabs(x) < kMost)) {
      tell("the screen window", "the usual one is used");
      std::fill_n(info.screenWindow, 4, 0.f);
      info.screenWindowGiven = false;
      break;
    }
  const bool hasLens = info.fStop > 0;
  if (hasLens && !(info.focalLength / (2 * info.fStop) < kMost && std::fabs(info.focalDistance) < 1e30f)) {
    tell("the width of the lens (focal length by f-stop)", "everything is in focus");
    info.fStop = 0;
  }
  if (!(std::fabs(info.clipping[0]) < kMost)) {
    tell("the near clipping plane", "0 is used");
    info.clipping[0] = 0;
  }
}

bool setProjection(const scene::Scene& scene, const scene::Camera& camera, Registry& registry, const Host& host,
                   uint32_t width, Diagnostics& diagnostics, CameraState& c) {
  ProjectionInfo info{};
  for (int k = 0; k < 4; ++k) info.screenWindow[k] = camera.screenWindow[size_t(k)];
  info.screenWindowGiven = camera.screenWindow != std::array<float, 4>{0, 0, 0, 0};
  info.frameAspect = scene.frameAspect > 0 ? scene.frameAspect
                                           : float(c.resolution[0]) / float(c.resolution[1]) *
                                                 (scene.pixelAspect > 0 ? scene.pixelAspect : 1);
  info.resolution[0] = uint32_t(c.resolution[0]);
  info.resolution[1] = uint32_t(c.resolution[1]);
  info.fStop = camera.depthOfField[0];
  info.focalLength = camera.depthOfField[1];
  info.focalDistance = camera.depthOfField[2];
  info.clipping[0] = camera.clipping[0];
  info.clipping[1] = camera.clipping[1];
  boundNumbers(camera, diagnostics, info);
  setAperture(camera, scene.hider, info);
  const scene::Matrix toCamera = camera.worldToCamera.at(c.middle());
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) info.worldToCamera[4 * i + j] = toCamera[i][j];
  std::string name = camera.projection ? camera.projection->plugin : "orthographic";
  if (scene.cameras.empty()) {
    diagnostics.warning("RENDER-NO-CAMERA", scene.pos, "the scene has no camera",
                        "an orthographic one at the origin looks along +z");
  }
  const std::string key = lowerCase(name);
  if (key == "perspective") name = "PxrPerspective";
  if (key == "orthographic") name = "PxrOrthographic";
  const Descriptor* d = registry.find(Kind::Projection, name, diagnostics, camera.pos);
  if (!d) {
    diagnostics.warning("PLUGIN-MISSING", camera.projection ? camera.projection->pos : camera.pos,
                        "no projection '" + name + "'", "PxrPerspective stands in",
                        adviceOnMissing(Kind::Projection, name));
    d = registry.find(Kind::Projection, "PxrPerspective", diagnostics, camera.pos);
  }
  if (!d || !c.projection.create(*d, camera.projection.get(), nullptr, &info, host, diagnostics)) {
    const Descriptor* plain = registry.find(Kind::Projection, "PxrPerspective", diagnostics, camera.pos);
    if (!plain || !c.projection.create(*plain, nullptr, nullptr, &info, host, diagnostics)) return false;
  }
  c.functions = static_cast<const ProjectionFunctions*>(functionsFor(*c.projection.plugin(), width));
  return c.functions != nullptr;
}

// How large a pixel is, by the footprint of the ray in the picture's middle: what surfaces are diced by.
void setPixelSize(CameraState& c) {
  alignas(64) float raster[2][16], lens[2][16], time[16], o[3][16], d[3][16], w[16], radius[16], spread[16];
  for (int i = 0; i < 16; ++i) {
    raster[0][i] = 0.5f * float(c.resolution[0]);
    raster[1][i] = 0.5f * float(c.resolution[1]);
    lens[0][i] = lens[1][i] = time[i] = 0.5f;
  }
  const CameraSampleArgs a{
      1, {raster[0], raster[1]}, {lens[0], lens[1]}, time, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, w, radius, spread};
  c.functions->rays(c.projection.data(), &a);
  c.pixelAngle = spread[0] > 0 ? 2.0 * spread[0] : 0;
  c.pixelSize = 2.0 * radius[0];
  if (c.pixelAngle > 0 || !(c.pixelSize > 0)) return;
  for (int i = 0; i < 16; ++i) {
    raster[0][i] = i & 1 ? float(c.resolution[0]) : 0.f;
    raster[1][i] = i & 2 ? float(c.resolution[1]) : 0.f;
  }
  c.functions->rays(c.projection.data(), &a);
  std::array<double, 4> beam{o[0][0], o[1][0], o[0][0], o[1][0]};
  for (int i = 0; i < 4; ++i) {
    if (!(d[2][i] > 0.999999f) || !std::isfinite(o[0][i]) || !std::isfinite(o[1][i])) return;
    for (const size_t k : {size_t(0), size_t(1)}) {
      beam[k] = std::min(beam[k], double(o[k][i]));
      beam[k + 2] = std::max(beam[k + 2], double(o[k][i]));
    }
  }
  c.beam = beam;
}

}  // namespace

Digest cameraDigestOf(const scene::Scene& scene) {
  Hasher h;
  h.word(scene.cameras.size() > 0);
  if (!scene.cameras.empty()) h.digest(scene::digestOf(scene.cameras.front()));
  h.digest(scene::digestOf(scene.hider));
  h.bytes(scene.resolution.data(), sizeof scene.resolution);
  h.bytes(scene.cropWindow.data(), sizeof scene.cropWindow);
  for (const float f : {scene.pixelAspect, scene.frameAspect}) h.bytes(&f, sizeof f);
  return h.result();
}

std::optional<CameraState> makeCamera(const scene::Scene& scene, const Settings& settings, Registry& registry,
                                      const Host& host, uint32_t width, Diagnostics& diagnostics) {
  scene::Camera camera;
  if (!scene.cameras.empty()) camera = scene.cameras.front();
  CameraState c;
  if (!setRaster(scene, settings, diagnostics, c)) return {};
  warnOfCameraParameters(camera, diagnostics);
  c.times = shutterTimes(camera, scene.hider, diagnostics);
  c.cuts = cutPlanes(camera);
  setPlace(camera, diagnostics, c);
  if (!setProjection(scene, camera, registry, host, width, diagnostics, c)) return {};
  setPixelSize(c);
  if (const auto* traits = static_cast<const ProjectionTraits*>(c.projection.plugin()->traits);
      traits && traits->sweep && samplesMotion(scene.hider)) {
    ShutterSweep sweep;
    traits->sweep(c.projection.data(), &sweep);
    c.rolling = RollingShutter(sweep, c.resolution, c.times);
  }
  return c;
}

}  // namespace kinora::render
