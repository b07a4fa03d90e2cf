// Coarse polygons with smooth normals shade themselves in steps near the terminator: facets that are turned away from
// a light shadow themselves although their normals look at it. Their shadow rays start from the smooth surface that
// the normals mean: the hit point projected to the tangent planes of the triangle's corners, interpolated (J. Hanika,
// "Hacking the shadow terminator", Ray Tracing Gems II, 2021, chapter 4).
//
// That surface is a guess, so it counts only where it is a good one and where it is needed:
// - Corner normals lean little from the facet, and the lift is small against the triangle. Else they were averaged
// over
//   hard edges, and the smooth surface is not what the shape is.
// - The light lies behind the facet or grazes it: nothing convex shadows facets that face the light, and what a lift
//   passes by no longer casts its shadow.
// - Nothing lies between the facet and the smooth surface.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/where.h"

namespace kinora::shade {
namespace {

// Cosines of the largest angle between facet and corner normals: trusted in full up to 15 degrees (a sphere of 24
// facets around, a cylinder of 12), not at all from 30 on (the edges of a box: 45; its corners: 55).
constexpr float kTrustedLean = 0.9659258f, kFarLean = 0.8660254f;
// Lifts in heights of the triangle. With normals that lean by 15 degrees it is .19 halfway along the longest side of
// half a square; more comes of long thin triangles whose normals lean along them.
constexpr float kSmallLift = 0.25f, kLargeLift = 0.5f;
// Sine of a light's elevation over the facet from which on it is clearly seen, as far as shadows of the mesh on
// itself go.
constexpr float kFacing = 0.1f;

float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// 1 up to `full`, 0 from `none` on.
float fade(float x, float full, float none) { return std::clamp((none - x) / (none - full), 0.f, 1.f); }

}  // namespace

void GroupState::liftShadows(ShadowRays* rays) {
  const uint32_t n = rays->count, m = padded(n);
  const auto f = [&] { return arena_.make<float>(m); };
  // the few near the terminator, from their facets to where they would start
  float *o[3] = {}, *d[3] = {}, *length = nullptr, *time = nullptr;
  uint32_t *point = nullptr, *list = nullptr, count = 0;
  ShadowRun* runs = arena_.make<ShadowRun>(rays->runCount);
  uint32_t runCount = 0;
  forEachRun(*rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    for (uint32_t i = first; i < run.end; ++i) {
      const uint32_t s = rays->point[i];
      const float lift[3] = {left.lift[0][s], left.lift[1][s], left.lift[2][s]};
      const float l2 = dot3(lift, lift);
      if (!(l2 > 0)) continue;
      float side = 0, facing = 0;
      for (int k = 0; k < 3; ++k) {
        side += rays->d[k][i] * left.Ng[k][s];
        facing += rays->d[k][i] * left.facet[k][s];
      }
      const float part = fade(facing, 0, kFacing);
      if (!(side > 0) || !(part > 0)) continue;  // light that comes through the surface; light that is clearly seen
      if (!list) {
        for (int k = 0; k < 3; ++k) o[k] = f(), d[k] = f();
        length = f();
        time = f();
        point = arena_.make<uint32_t>(m);
        list = arena_.make<uint32_t>(m);
      }
      const float l = std::sqrt(l2);
      for (int k = 0; k < 3; ++k) {
        o[k][count] = rays->o[k][i];
        d[k][count] = lift[k] / l;
      }
      length[count] = part * l;
      time[count] = rays->time[i];
      point[count] = s;
      list[count++] = i;
    }
    runs[runCount++] = {run.context, run.list, count};
  });
  if (!count) return;
  uint32_t* blocked = arena_.make<uint32_t>(m);
  occluded({count, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, length, time, point, runCount, runs, nullptr, {}}, blocked,
           true);

  float *from[3], *to[3], *tMax = f();
  for (int k = 0; k < 3; ++k) {
    from[k] = f();
    to[k] = f();
    std::memcpy(from[k], rays->o[k], n * sizeof(float));
    std::memcpy(to[k], rays->d[k], n * sizeof(float));
    rays->o[k] = from[k];
    rays->d[k] = to[k];
  }
  std::memcpy(tMax, rays->tMax, n * sizeof(float));
  rays->tMax = tMax;
  for (uint32_t j = 0; j < count; ++j) {
    if (blocked[j]) continue;
    const uint32_t i = list[j];
    // the end stays where it is, or the ray would pass through what the light hangs from
    double end[3], t2 = 0;
    for (int k = 0; k < 3; ++k) {
      const float step = length[j] * d[k][j];
      from[k][i] += step;
      end[k] = double(to[k][i]) * tMax[i] - step;
      t2 += end[k] * end[k];
    }
    if (!(t2 > 0) || std::isinf(tMax[i])) continue;  // infinitely far: all directions are the same
    const double t = std::sqrt(t2);
    for (int k = 0; k < 3; ++k) to[k][i] = float(end[k] / t);
    tMax[i] = float(t);
  }
}

void GroupState::findLifts(const Context* c, float* const Ng[3]) {
  const trace::World& w = *world_.world;
  const VertexState& state = ContextHost::of(c).state;
  const Places& at = c->place;
  for (uint32_t i = 0; i < c->padded; ++i) {
    const GeometryInfo& info = world_.geometries[at.geometry[i]];
    for (int k = 0; k < 3; ++k) state.lift[k][i] = state.facet[k][i] = 0;
    if (!(info.flags & kLiftsShadows)) continue;
    const geometry::Mesh& mesh = w.mesh(at.geometry[i]);
    const geometry::Primvar& normals = *info.N;
    const uint32_t triangle = at.primitive[i];
    const float b1 = at.u[i], b2 = at.v[i], b[3] = {1.f - b1 - b2, b1, b2};
    // both deformation keys around the time, if there are any
    size_t key = 0;
    float f = 0;
    if (mesh.keyCount() > 1) {
      const float x = std::clamp(c->time[i], 0.f, 1.f) * float(mesh.keyCount() - 1);
      key = std::min(size_t(x), size_t(mesh.keyCount() - 2));
      f = x - float(key);
    }
    const bool movesNormals = normals.data.size() == size_t(mesh.keyCount()) * mesh.vertexCount * 3;
    // corners seen from the first, normals on the side that the ray came from; both in render space, where angles
    // count
    float corner[3][3], normal[3][3];
    for (int k = 0; k < 3; ++k) {
      const size_t v = mesh.indices[3 * size_t(triangle) + size_t(k)];
      const size_t of = normals.rate == geometry::Primvar::Rate::PerVertex   ? v
                        : normals.rate == geometry::Primvar::Rate::PerCorner ? 3 * size_t(triangle) + size_t(k)
                                                                             : 0;
      const Imath::V3f& q0 = mesh.points[key * mesh.vertexCount + v];
      const Imath::V3f& q1 = mesh.points[(f > 0 ? key + 1 : key) * mesh.vertexCount + v];
      const size_t n0 = movesNormals ? key * mesh.vertexCount + of : of;
      const size_t n1 = movesNormals && f > 0 ? n0 + mesh.vertexCount : n0;
      for (int j = 0; j < 3; ++j) {
        corner[k][j] = q0[j] + f * (q1[j] - q0[j]);
        if (k) corner[k][j] -= corner[0][j];
        normal[k][j] = normals.data[3 * n0 + size_t(j)] +
                       f * (normals.data[3 * n1 + size_t(j)] - normals.data[3 * n0 + size_t(j)]);
      }
    }
    std::memset(corner[0], 0, sizeof corner[0]);
    float turn = c->entering[i] ? 1.f : -1.f;  // normals of the mesh point outward
    if (!w.instance(at.instance[i]).baked) {
      // normals by cofactors: the inverse transpose times the determinant
      const trace::Affine x = w.objectToRender(at.instance[i], c->time[i]);
      float cofactor[3][3];
      for (int u = 0; u < 3; ++u)
        for (int v = 0; v < 3; ++v) {
          const int u1 = (u + 1) % 3, u2 = (u + 2) % 3, v1 = (v + 1) % 3, v2 = (v + 2) % 3;
          cofactor[u][v] = x.m[u1][v1] * x.m[u2][v2] - x.m[u1][v2] * x.m[u2][v1];
        }
      if (dot3(x.m[0], cofactor[0]) < 0) turn = -turn;
      for (int k = 0; k < 3; ++k) {
        const float p[3] = {corner[k][0], corner[k][1], corner[k][2]},
                    q[3] = {normal[k][0], normal[k][1], normal[k][2]};
        for (int j = 0; j < 3; ++j) {
          corner[k][j] = dot3(x.m[j], p);
          normal[k][j] = dot3(cofactor[j], q);
        }
      }
    }
    const float facet[3] = {c->Ng[0][i], c->Ng[1][i], c->Ng[2][i]};
    float least = 1, p[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      const float l2 = dot3(normal[k], normal[k]);
      const float inv = l2 > 0 ? turn / std::sqrt(l2) : 0.f;
      for (int j = 0; j < 3; ++j) {
        normal[k][j] *= inv;
        p[j] += b[k] * corner[k][j];
      }
      least = std::min(least, dot3(normal[k], facet));
    }
    if (!(least > kFarLean)) continue;
    float lift[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      const float toCorner[3] = {corner[k][0] - p[0], corner[k][1] - p[1], corner[k][2] - p[2]};
      const float below = b[k] * dot3(toCorner, normal[k]);
      for (int j = 0; below > 0 && j < 3; ++j) lift[j] += below * normal[k][j];
    }
    const float l2 = dot3(lift, lift);
    if (!(l2 > 0)) continue;
    // height over the longest side
    const float* e1 = corner[1];
    const float* e2 = corner[2];
    const float e3[3] = {e2[0] - e1[0], e2[1] - e1[1], e2[2] - e1[2]};
    const float longest2 = std::max({dot3(e1, e1), dot3(e2, e2), dot3(e3, e3)});
    const float along = dot3(e1, e2), twiceArea2 = dot3(e1, e1) * dot3(e2, e2) - along * along;
    if (!(twiceArea2 > 0)) continue;
    const float heights = std::sqrt(l2 * longest2 / twiceArea2);
    const float part = fade(-least, -kTrustedLean, -kFarLean) * fade(heights, kSmallLift, kLargeLift);
    if (!(part > 0)) continue;
    // What lies on which side follows from the smooth surface too: a facet that is turned away from a light which its
    // normals look at is lit. Media need the true side: what encloses one never comes here.
    float ng[3];
    for (int k = 0; k < 3; ++k) ng[k] = facet[k] + part * (c->N[k][i] - facet[k]);
    const float inv = 1.f / std::sqrt(dot3(ng, ng));  // half a sphere apart at most
    for (int k = 0; k < 3; ++k) {
      Ng[k][i] = ng[k] * inv;
      state.facet[k][i] = facet[k];
      state.lift[k][i] = part * lift[k];
    }
  }
}

}  // namespace kinora::shade
