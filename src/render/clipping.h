// Cuts camera rays at the clipping planes of the scene: near, far (Clipping) and any others (ClippingPlane). Camera
// space.
#pragma once
#include <cmath>
#include <vector>

#include "scene/scene.h"

namespace kinora::render {

// No ray begins farther away than this on the picture's plane, the lens or the near plane: Embree takes none.
inline constexpr float kMostOfCamera = 1e15f;

// What lies on the side that the normal points to is cut away.
struct CutPlane {
  float normal[3], offset;  // cut where dot(normal, p) > offset
};

// Empty when nothing is cut. A plane whose normal is zero or not finite is left out.
inline std::vector<CutPlane> cutPlanes(const scene::Camera& camera) {
  std::vector<CutPlane> out;
  if (camera.clipping[1] > camera.clipping[0]) {
    if (camera.clipping[0] > 0 && camera.clipping[0] < kMostOfCamera)
      out.push_back({{0, 0, -1}, -camera.clipping[0]});
    if (camera.clipping[1] < 1e30f) out.push_back({{0, 0, 1}, camera.clipping[1]});
  }
  for (const std::array<double, 6>& p : camera.clippingPlanes) {
    const double length = std::sqrt(p[3] * p[3] + p[4] * p[4] + p[5] * p[5]);
    const double offset = (p[0] * p[3] + p[1] * p[4] + p[2] * p[5]) / length;
    if (length > 0 && std::isfinite(offset))
      out.push_back({{float(p[3] / length), float(p[4] / length), float(p[5] / length)}, float(offset)});
  }
  return out;
}

inline bool cutAway(const std::vector<CutPlane>& planes, const float p[3]) {
  for (const CutPlane& c : planes)
    if (c.normal[0] * p[0] + c.normal[1] * p[1] + c.normal[2] * p[2] > c.offset) return true;
  return false;
}

// The part of a ray that is left: from `first` to `last` (at most), empty when last <= first.
inline void cutRay(const std::vector<CutPlane>& planes, const float o[3], const float d[3], float& first,
                   float& last) {
  for (const CutPlane& c : planes) {
    const float along = c.normal[0] * d[0] + c.normal[1] * d[1] + c.normal[2] * d[2];
    const float room = c.offset - (c.normal[0] * o[0] + c.normal[1] * o[1] + c.normal[2] * o[2]);
    if (along > 0)
      last = std::fmin(last, room / along);
    else if (along < 0)
      first = std::fmax(first, room / along);
    else if (room < 0)
      last = 0;
  }
}

}  // namespace kinora::render
