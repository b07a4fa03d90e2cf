// Geometry that meets rays itself, with a transform baked into it, as bake() does it with meshes: rays and shading see it
// where others of its part are, it goes on in its own space. Used where primitives of an object share a part.
#pragma once
#include <memory>

#include "trace/user_geometry.h"
#include "trace/world.h"

namespace kinora::trace {

class TransformedGeometry final : public UserGeometry {
 public:
  // toOuter: affine, from the space of `own`; rays go through it and back without loss.
  TransformedGeometry(std::shared_ptr<const UserGeometry> own, const scene::Matrix& toOuter);

  uint32_t patchCount() const override { return own_->patchCount(); }
  uint32_t keyCount() const override { return own_->keyCount(); }
  void bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const override;
  bool intersect(uint32_t patch, const UserRay& ray, UserHit* hit) const override;
  bool hasFacets() const override { return own_->hasFacets(); }
  void facets(uint32_t n, const uint32_t* primitive, const uint32_t* level, const float* u, const float* v,
              const float* time, UserFacet* out) const override;

 private:
  std::shared_ptr<const UserGeometry> own_;
  scene::Matrix toOuterExact_;
  Affine toOuter_, toOwn_;
  float cofactor_[3][3];  // of toOuter_: areas and their sides go by it
  float lengths_;         // by which they grow on the way out
};

}  // namespace kinora::trace
