// Places on quads. A quad is two triangles for rays, and place in it is bilinear: the hit point is seen along the
// quad's mean normal, where the inverse of u, v -> point is a quadratic for each of u and v. A quad that is not flat
// gets a map that is continuous over its diagonal and linear along its sides, so that neighbours agree.
#define KINORA_KERNEL_FILE "shade/quad_place.cpp"
#include <algorithm>
#include <cmath>

#include "shade/points.h"
#include "shade/group.h"
#include "shade/surface_points.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"

KINORA_KERNELS_BEGIN

// The root in 0..1 of a x^2 - b x + c, which is not negative at 0 and not positive at 1. Either form divides by a sum
// of numbers of one sign; where a side of the quad is drawn together to the point, anything finite will do.
template <int W>
KN_INLINE Float<W> rootInside(Float<W> a, Float<W> b, Float<W> c) {
  using F = Float<W>;
  const F s = sqrt(max(b * b - F(4.f) * a * c, F(0.f)));
  const F near = (c + c) / max(b + s, F(1e-20f)), far = (b - s) / min(a + a, F(-1e-20f));
  return min(max(select(b < F(0.f), far, near), F(0.f)), F(1.f));
}

template <int W>
void quads(const shade::QuadsArgs& q) {
  using F = Float<W>;
  const F zero(0.f), one(1.f);
  for (uint32_t i = 0; i < q.n; i += W) {
    const Vec3<W> e = Vec3<W>::load(q.e[0], i), d = Vec3<W>::load(q.e[1], i), f = Vec3<W>::load(q.e[2], i);
    // Areas of the triangles at corners 0, 1 and 3, seen along the quad's mean normal, as shares of the quad's; the
    // normal is scaled first, as squares of areas of tiny and huge quads leave the range of float.
    const Vec3<W> at1 = cross(e, d), at3 = cross(d, f), whole = at1 + at3;
    const F scale = one / max(max(abs(whole.x), max(abs(whole.y), abs(whole.z))), F(1e-36f));
    const Vec3<W> normal = whole * scale;
    const F part = scale / max(dot(normal, normal), F(1e-6f));
    const F s0 = dot(normal, cross(e, f)) * part, s1 = dot(normal, at1) * part, s3 = dot(normal, at3) * part;
    // corners of 180 degrees are within rounding
    const F low = min(s0, min(s1, s3)), high = max(s0, max(s1, s3));
    const Mask<W> convex = (low >= F(-1e-5f)) & (high <= F(1.00001f)) & (high > zero);
    const F a0 = min(max(s0, zero), one), a1 = min(max(s1, zero), one), a3 = min(max(s3, zero), one);
    // With E, F the sides at corner 0, G = q2 - q3 - E and H from q0 to the point, all seen along the normal:
    // H = u E + v F + u v G, so (H - v F) x (E + v G) = 0, and the same for u with E and F in turn.
    const F x1 = F::load(q.x[0] + i), x2 = F::load(q.x[1] + i), x3 = F::load(q.x[2] + i);
    const F v = rootInside<W>(a0 - a3, x1 * (a1 - a0) + x2 * (a1 - a3) + x3 * (a0 - a3) + a0, x2 * a1 + x3 * a0);
    const F u = rootInside<W>(a0 - a1, x3 * (a3 - a0) + x2 * (a3 - a1) + x1 * (a0 - a1) + a0, x2 * a3 + x1 * a0);
    select(convex, u, F(-1.f)).store(q.u + i);
    v.store(q.v + i);
  }
}

KN_POINTERS(kQuads, quads)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade {

QuadsKernel quadsKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kQuads); }

using Imath::V3f;

void findQuadPlaces(GroupState& group, const SurfaceArgs& points, float* u, float* v) {
  const Places& at = points.at;
  const uint32_t n = points.n;
  const trace::World& world = *group.world().world;
  const auto isByParameter = [&](uint32_t i) { return points.facet && points.facet[i]; };
  if (points.isByParameter) {  // of patches, which are quads all
    for (uint32_t i = 0; i < n; ++i) {
      const bool isFirst = at.primitive[i] % 2 == 0;
      u[i] = isFirst ? at.u[i] + at.v[i] : at.u[i];
      v[i] = isFirst ? at.v[i] : at.u[i] + at.v[i];
    }
    return;
  }
  float* array[12];
  for (float*& x : array) x = group.arena().make<float>(n);
  QuadsArgs a{};
  a.n = n;
  a.u = u;
  a.v = v;
  for (int k = 0; k < 3; ++k) {
    a.x[k] = array[k];
    for (int j = 0; j < 3; ++j) a.e[k][j] = array[3 + 3 * k + j];
  }
  for (uint32_t i = 0; i < n; ++i) {
    const geometry::Mesh& mesh = world.mesh(at.geometry[i]);
    const uint32_t triangle = at.primitive[i], first = mesh.quadOf(triangle);
    if (first == geometry::Mesh::kNoQuad || isByParameter(i)) {
      for (float* x : array) x[i] = 0;  // no area: no place in a quad
      continue;
    }
    const geometry::Mesh::KeyPair keys = mesh.keysAt(points.time[i]);
    V3f q[4];
    for (int k = 0; k < 4; ++k) {
      const V3f* p = &mesh.points[keys.first + mesh.indices[geometry::Mesh::quadCorner(first, k)]];
      q[k] = *p;
      if (keys.part > 0) q[k] += (p[keys.second - keys.first] - *p) * keys.part;
    }
    const bool second = triangle != first;
    array[0][i] = second ? 0.f : at.u[i];
    array[1][i] = second ? at.u[i] : at.v[i];
    array[2][i] = second ? at.v[i] : 0.f;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) array[3 + 3 * k + j][i] = q[k + 1][j] - q[0][j];
  }
  quadsKernel(group.world().width)(a);
  if (!points.facet) return;
  for (uint32_t i = 0; i < n; ++i) {
    const geometry::Mesh& mesh = world.mesh(at.geometry[i]);
    const uint32_t triangle = at.primitive[i], first = mesh.quadOf(triangle);
    if (first == geometry::Mesh::kNoQuad || !isByParameter(i)) continue;
    u[i] = first == triangle ? at.u[i] + at.v[i] : at.u[i];
    v[i] = first == triangle ? at.v[i] : at.u[i] + at.v[i];
  }
}

const trace::UserFacet* const* findFacets(GroupState& group, const SurfaceArgs& a) {
  const trace::World& world = *group.world().world;
  const trace::UserFacet** out = nullptr;
  Arena& arena = group.arena();
  for (uint32_t i = 0, end; i < a.n; i = end) {
    const trace::UserGeometry* geometry = world.faceted(a.at.geometry[i]);
    const uint32_t instance = a.at.instance[i];
    for (end = i + 1; end < a.n && a.at.instance[end] == instance && a.at.geometry[end] == a.at.geometry[i];) ++end;
    if (!geometry) continue;
    if (!out) {
      out = arena.make<const trace::UserFacet*>(a.n);
      std::fill_n(out, a.n, nullptr);
    }
    auto* facets = arena.make<trace::UserFacet>(end - i);
    const bool moves = world.instance(instance).keyCount > 1;
    float scale = 1;
    geometry->facets(end - i, a.at.primitive + i, a.at.level + i, a.at.u + i, a.at.v + i, a.time + i, facets);
    for (uint32_t k = i; k < end; ++k) {
      if (k == i || moves) {
        const float det = std::fabs(world.objectToRender(instance, a.time[k]).determinant());
        scale = det > 0 ? std::cbrt(det) : 1.f;
      }
      facets[k - i].radius *= scale;
      out[k] = &facets[k - i];
    }
  }
  return out;
}

}  // namespace kinora::shade
#endif
