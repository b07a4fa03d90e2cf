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
  uint32_t mask;         // VisibilityBits that it asks for
};

struct UserHit {
  float t, u, v;       // u, v: of the patch
  float ng[3];         // geometric normal, any length
  uint32_t level;      // of resolution that was hit
  uint32_t primitive;  // what hits call the place's patch by; the patch itself, unless the geometry says another
};

// How a surface runs around a place of a hit, in the geometry's space: the micropolygon, a quad of two triangles.
struct UserFacet {
  float P[4][3], N[4][3];  // corners (0,0) (1,0) (1,1) (0,1) of the quad; normals there, unit but between two keys
  float u, v;              // in the quad
  float b1, b2;            // in the triangle: corners 0, 1, 2, or 0, 2, 3 where isSecond
  uint32_t isSecond;
  float steps[2];  // quads a unit of u and of v of the patch
  float radius;    // of a footprint at most, with which a ray that leaves sees the resolution that was hit
};

class UserGeometry {
 public:
  virtual ~UserGeometry() = default;
  virtual uint32_t patchCount() const = 0;
  // Moments at even distances over the shutter at which bounds() is asked. Between two of them a patch lies in what lies
  // between its boxes there; of one: it does not deform.
  virtual uint32_t keyCount() const { return 1; }
  // Box around all levels of a patch.
  virtual void bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const = 0;
  // Nearest hit of one patch. A function of the patch and the ray alone (but for tMax): where levels are made or
  // loaded on demand, which one is asked must not follow from what is there already.
  virtual bool intersect(uint32_t patch, const UserRay& ray, UserHit* hit) const = 0;
  // Geometry that shades as a mesh does: `mesh` of its shape holds the patches, as quads, with what lies on them. Hits
  // then name a triangle of it and, by u and v as barycentric coordinates b1 and b2, the parameters of the quad: b1 + b2
  // and b2 on its first triangle, b1 and b1 + b2 on the second.
  virtual bool hasFacets() const { return false; }
  // Of n places of hits, as Hits has them, at times of their own (0..1 over the shutter).
  virtual void facets(uint32_t n, const uint32_t* primitive, const uint32_t* level, const float* u, const float* v,
                      const float* time, UserFacet* out) const {
    (void)n, (void)primitive, (void)level, (void)u, (void)v, (void)time, (void)out;
  }
};

}  // namespace kinora::trace
