#include "trace/transformed_geometry.h"

#include <ImathBox.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace kinora::trace {

namespace {

void multiply(const float m[3][3], const float v[3], float out[3]) {
  for (int i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

float lengthOf(const float v[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

TransformedGeometry::TransformedGeometry(std::shared_ptr<const UserGeometry> own, const scene::Matrix& toOuter)
    : own_(std::move(own)),
      toOuterExact_(toOuter),
      toOuter_(Affine::from(toOuter)),
      toOwn_(Affine::from(toOuter.inverse())) {
  const float(&m)[3][3] = toOuter_.m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      cofactor_[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  lengths_ = std::cbrt(std::fabs(toOuter_.determinant()));
}

void TransformedGeometry::bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const {
  float from[3], to[3];
  own_->bounds(patch, key, from, to);
  Imath::Box3d box;
  for (int c = 0; c < 8; ++c)
    box.extendBy(Imath::V3d(c & 1 ? to[0] : from[0], c & 2 ? to[1] : from[1], c & 4 ? to[2] : from[2]) *
                 toOuterExact_);
  double most = 0;
  for (int k = 0; k < 3; ++k) most = std::max({most, std::fabs(box.min[k]), std::fabs(box.max[k])});
  // rays are rounded on their way in, by what is left of the largest coordinate
  for (int k = 0; k < 3; ++k) {
    lower[k] = float(box.min[k] - 1e-6 * most);
    upper[k] = float(box.max[k] + 1e-6 * most);
  }
}

bool TransformedGeometry::intersect(uint32_t patch, const UserRay& ray, UserHit* hit) const {
  UserRay r = ray;
  toOwn_.point(ray.o, r.o);
  multiply(toOwn_.m, ray.d, r.d);
  const float length = lengthOf(ray.d), scale = length > 0 ? lengthOf(r.d) / length : 1.f;
  r.radius *= scale;
  r.spread *= scale;
  if (!own_->intersect(patch, r, hit)) return false;
  const float ng[3] = {hit->ng[0], hit->ng[1], hit->ng[2]};
  multiply(cofactor_, ng, hit->ng);
  return true;
}

void TransformedGeometry::facets(uint32_t n, const uint32_t* primitive, const uint32_t* level, const float* u,
                                 const float* v, const float* time, UserFacet* out) const {
  own_->facets(n, primitive, level, u, v, time, out);
  // normals keep their side where the transform mirrors, as those of meshes do that are baked
  const float side = toOuter_.determinant() < 0 ? -1.f : 1.f;
  for (uint32_t k = 0; k < n; ++k) {
    UserFacet& f = out[k];
    for (int c = 0; c < 4; ++c) {
      const float p[3] = {f.P[c][0], f.P[c][1], f.P[c][2]}, m[3] = {f.N[c][0], f.N[c][1], f.N[c][2]};
      toOuter_.point(p, f.P[c]);
      multiply(cofactor_, m, f.N[c]);
      const float before = lengthOf(m), after = lengthOf(f.N[c]), size = after > 0 ? side * before / after : 0.f;
      for (float& x : f.N[c]) x *= size;
    }
    f.radius *= lengths_;
  }
}

}  // namespace kinora::trace
