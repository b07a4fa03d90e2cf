// The first camera of a scene, ready to make rays: raster, places over the shutter, projection; and the space that
// is rendered in. Made by WorldBuilder, read by passes, dicing and lights. A function of the scene alone.
#pragma once
#include <kinora/projection.h>

#include <array>
#include <optional>
#include <vector>

#include "base/digest.h"
#include "render/clipping.h"
#include "render/instance.h"
#include "render/renderer.h"
#include "render/rolling_shutter.h"
#include "trace/world.h"

namespace kinora::render {

struct CameraState {
  Instance projection;
  const ProjectionFunctions* functions = nullptr;  // for the width in use
  std::array<int, 2> resolution{640, 480};
  std::array<int, 4> window{0, 0, 640, 480};  // x0 y0 x1 y1 of the crop, half open
  std::vector<trace::Affine> toRender;        // camera to render, uniform keys over the shutter
  std::vector<trace::Affine> fromRender;
  double shutterOpen = 0, shutterClose = 0;
  std::vector<float> times;      // warp of sample times by the shutter's shape; empty: none
  RollingShutter rolling;        // of those times
  std::vector<CutPlane> cuts;    // camera space
  scene::Matrix worldToCamera;   // at the middle of the shutter
  double origin[3] = {0, 0, 0};  // of render space, world
  double pixelAngle = 0;         // of the footprint of a pixel: radians,
  double pixelSize = 0;          // and its width at the eye
  // Where the rays of a projection without perspective start, all of them along z: camera space, x y x y. Empty for
  // others.
  std::optional<std::array<double, 4>> beam;
  double middle() const { return 0.5 * (shutterOpen + shutterClose); }
  // Whether camera space has the other handedness than world space.
  bool isMirrored() const { return worldToCamera.determinant() < 0; }
};

// Of all that makeCamera() reads.
Digest cameraDigestOf(const scene::Scene& scene);
// Nothing, after a message, when there is nothing to look at.
std::optional<CameraState> makeCamera(const scene::Scene& scene, const Settings& settings, Registry& registry,
                                      const Host& host, uint32_t width, Diagnostics& diagnostics);

}  // namespace kinora::render
