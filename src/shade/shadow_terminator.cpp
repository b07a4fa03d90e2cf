// Coarse polygons with smooth normals shade themselves in steps near the terminator. Their shadow rays start from the
// smooth surface that the normals mean: the hit point projected to the tangent planes of the triangle's corners,
// interpolated (J. Hanika, "Hacking the shadow terminator", Ray Tracing Gems II, 2021, chapter 4).
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/where.h"

namespace kinora::shade {

void GroupState::liftShadows(ShadowRays* rays) {
  float* o[3];
  for (int k = 0; k < 3; ++k) {
    o[k] = arena_.make<float>(padded(rays->count));
    std::memcpy(o[k], rays->o[k], rays->count * sizeof(float));
    rays->o[k] = o[k];
  }
  for (uint32_t i = 0; i < rays->count; ++i) {
    const uint32_t s = rays->slot[i];
    float side = 0;
    for (int k = 0; k < 3; ++k) side += rays->d[k][i] * leftNg_[k][s];
    if (!(side > 0)) continue;  // light that comes through the surface
    for (int k = 0; k < 3; ++k) o[k][i] += lift_[k][s];
  }
}

void GroupState::findLifts(uint32_t n, const uint32_t* slots, const Context* c, float* const Ng[3]) {
  const trace::World& w = *world_.world;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const GeometryInfo& info = world_.geometries[group_.hits.geometry[s]];
    for (int k = 0; k < 3; ++k) lift_[k][s] = 0;
    if (!(info.flags & kLiftsShadows)) continue;
    const geometry::Mesh& mesh = w.mesh(group_.hits.geometry[s]);
    const geometry::Primvar& normals = *info.N;
    const uint32_t triangle = group_.hits.primitive[s];
    const float b1 = group_.hits.u[s], b2 = group_.hits.v[s], b[3] = {1.f - b1 - b2, b1, b2};
    // both deformation keys around the time, if there are any
    size_t key = 0;
    float f = 0;
    if (mesh.keyCount() > 1) {
      const float x = std::clamp(group_.rays.time[s], 0.f, 1.f) * float(mesh.keyCount() - 1);
      key = std::min(size_t(x), size_t(mesh.keyCount() - 2));
      f = x - float(key);
    }
    const bool movesNormals = normals.data.size() == size_t(mesh.keyCount()) * mesh.vertexCount * 3;
    float corner[3][3], normal[3][3], p[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      const size_t v = mesh.indices[3 * size_t(triangle) + size_t(k)];
      const size_t at = normals.rate == geometry::Primvar::Rate::PerVertex   ? v
                        : normals.rate == geometry::Primvar::Rate::PerCorner ? 3 * size_t(triangle) + size_t(k)
                                                                             : 0;
      const Imath::V3f& q0 = mesh.points[key * mesh.vertexCount + v];
      const Imath::V3f& q1 = mesh.points[(f > 0 ? key + 1 : key) * mesh.vertexCount + v];
      const size_t n0 = movesNormals ? key * mesh.vertexCount + at : at;
      const size_t n1 = movesNormals && f > 0 ? n0 + mesh.vertexCount : n0;
      for (int j = 0; j < 3; ++j) {
        corner[k][j] = q0[j] + f * (q1[j] - q0[j]);
        p[j] += b[k] * corner[k][j];
        normal[k][j] = normals.data[3 * n0 + size_t(j)] +
                       f * (normals.data[3 * n1 + size_t(j)] - normals.data[3 * n0 + size_t(j)]);
      }
    }
    const float side = c->entering[i] ? 1.f : -1.f;  // normals of the mesh point outward
    float lift[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      float below = 0;
      for (int j = 0; j < 3; ++j) below -= (p[j] - corner[k][j]) * normal[k][j] * side;
      if (below <= 0) continue;
      for (int j = 0; j < 3; ++j) lift[j] += b[k] * below * normal[k][j] * side;
    }
    // what lies on which side follows from the smooth surface too: a facet that is turned away from a light which its
    // normals look at is lit. Media need the true side: what encloses one never comes here.
    for (int k = 0; k < 3; ++k) Ng[k][i] = c->N[k][i];
    const trace::Instance& instance = w.instance(group_.hits.instance[s]);
    if (instance.baked) {
      for (int j = 0; j < 3; ++j) lift_[j][s] = lift[j];
    } else {
      const trace::Affine m = w.objectToRender(group_.hits.instance[s], group_.rays.time[s]);
      for (int j = 0; j < 3; ++j) lift_[j][s] = m.m[j][0] * lift[0] + m.m[j][1] * lift[1] + m.m[j][2] * lift[2];
    }
  }
}

}  // namespace kinora::shade
