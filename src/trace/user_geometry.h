// Geometry that intersects rays itself: patches that are no triangle mesh, and patches held at several resolutions of
// which each ray's footprint chooses one. Implemented by floors above (or tests), called by World through Embree from
// any thread. It knows no shading; World places it like any other shape, but never moves it into render space.
#pragma once
#include <cstdint>

namespace kinora::trace {

// A ray in the geometry's own space. The direction is not unit where the placement scales: t counts render units.
struct UserRay {
  float o[3], d[3];
  float tMin, tMax;      // only hits within count
  float time;            // 0..1 over the shutter
  float radius, spread;  // footprint in the geometry's units: its radius at t is radius + t * spread
};

struct UserHit {
  float t, u, v;   // u, v: of the patch
  float ng[3];     // geometric normal, any length
  uint32_t level;  // of resolution that was hit
};

class UserGeometry {
 public:
  virtual ~UserGeometry() = default;
  virtual uint32_t patchCount() const = 0;
  // Box around all levels of a patch, over the shutter.
  virtual void bounds(uint32_t patch, float lower[3], float upper[3]) const = 0;
  // Nearest hit of one patch. A function of the patch and the ray alone (but for tMax): where levels are made or
  // loaded on demand, which one is asked must not follow from what is there already.
  virtual bool intersect(uint32_t patch, const UserRay& ray, UserHit* hit) const = 0;
};

}  // namespace kinora::trace
