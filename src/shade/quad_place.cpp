// Places on quads. A quad is two triangles for rays, and place in it is bilinear: the hit point is seen along the
// quad's mean normal, where the inverse of u, v -> point is a quadratic for each of u and v. A quad that is not flat
// gets a map that is continuous over its diagonal and linear along its sides, so that neighbours agree.
#define KINORA_KERNEL_FILE "shade/quad_place.cpp"
#include <algorithm>
#include <cmath>

#include "shade/points.h"
#include "shade/where.h"
#include <kinora/simd/foreach_target.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

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
  for (uint32_t i = 0; i < q.n; i += W) {
    const F x1 = F::load(q.x[0] + i), x2 = F::load(q.x[1] + i), x3 = F::load(q.x[2] + i);
    const F s0 = F::load(q.share[0] + i), s1 = F::load(q.share[1] + i), s3 = F::load(q.share[2] + i);
    // With E = q1 - q0, F = q3 - q0, G = q2 - q3 - E and H from q0 to the point, all seen along the normal:
    // H = u E + v F + u v G, so (H - v F) x (E + v G) = 0, and the same for u with E and F in turn.
    const F v = rootInside<W>(s0 - s3, x1 * (s1 - s0) + x2 * (s1 - s3) + x3 * (s0 - s3) + s0, x2 * s1 + x3 * s0);
    const F u = rootInside<W>(s0 - s1, x3 * (s3 - s0) + x2 * (s3 - s1) + x1 * (s0 - s1) + s0, x2 * s3 + x1 * s0);
    select(s0 < F(0.f), F(-1.f), u).store(q.u + i);
    v.store(q.v + i);
  }
}

#if HWY_TARGET == HWY_AVX2
[[maybe_unused]] void quads1(const shade::QuadsArgs& a) { quads<1>(a); }
[[maybe_unused]] void quads4(const shade::QuadsArgs& a) { quads<4>(a); }
[[maybe_unused]] void quads8(const shade::QuadsArgs& a) { quads<8>(a); }
#else
[[maybe_unused]] void quads16(const shade::QuadsArgs& a) { quads<16>(a); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::shade {

QuadsKernel quadsKernel(uint32_t width) {
  switch (width) {
    case 1:
      return &N_AVX2::quads1;
    case 4:
      return &N_AVX2::quads4;
    case 16:
      return &N_AVX3::quads16;
    default:
      return &N_AVX2::quads8;
  }
}

namespace {

using Imath::V3f;

// Corners at the ray's time.
void cornersOfQuad(const geometry::Mesh& mesh, uint32_t first, float time, V3f out[4]) {
  const V3f *p = mesh.points.data(), *next = p;
  float f = 0;
  if (mesh.keyCount() > 1) {
    const float x = std::clamp(time, 0.f, 1.f) * float(mesh.keyCount() - 1);
    const uint32_t key = std::min(uint32_t(x), uint32_t(mesh.keyCount() - 2));
    f = x - float(key);
    p += size_t(key) * mesh.vertexCount;
    next = p + mesh.vertexCount;
  }
  for (int k = 0; k < 4; ++k) {
    const uint32_t v = mesh.indices[geometry::Mesh::quadCorner(first, k)];
    out[k] = p[v];
    if (f > 0) out[k] += (next[v] - p[v]) * f;
  }
}

// Areas of the triangles at corners 0, 1 and 3 as shares of the quad's; false where it has none or is not convex.
bool sharesOf(const V3f q[4], float share[3]) {
  const V3f e = q[1] - q[0], f = q[3] - q[0], d = q[2] - q[0];
  V3f at0 = e.cross(f), at1 = e.cross(d), at3 = d.cross(f), normal = at1 + at3;
  // squares of areas of tiny and huge quads leave the range of float
  const float size = std::max({std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)});
  if (!(size > 0)) return false;
  const float scale = 1.f / size;
  normal *= scale;
  const float inverse = 1.f / normal.dot(normal) * scale;
  share[0] = normal.dot(at0) * inverse;
  share[1] = normal.dot(at1) * inverse;
  share[2] = normal.dot(at3) * inverse;
  // corners of 180 degrees are within rounding
  constexpr float kRounding = 1e-5f;
  for (int k = 0; k < 3; ++k) {
    if (!(share[k] >= -kRounding && share[k] <= 1 + kRounding)) return false;
    share[k] = std::clamp(share[k], 0.f, 1.f);
  }
  return true;
}

}  // namespace

void findQuadPlaces(GroupState& group, uint32_t n, const uint32_t* slots, float* u, float* v) {
  const Hits& hits = group.group().hits;
  const trace::World& world = *group.world().world;
  QuadsArgs a{n, {}, {}, u, v};
  float* array[6];
  for (float*& x : array) x = group.arena().make<float>(n);
  for (int k = 0; k < 3; ++k) {
    a.x[k] = array[k];
    a.share[k] = array[3 + k];
  }
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const geometry::Mesh& mesh = world.mesh(hits.geometry[s]);
    const uint32_t triangle = hits.primitive[s], first = mesh.quadOf(triangle);
    float share[3] = {-1, 1, 1};
    if (first != geometry::Mesh::kNoQuad) {
      V3f q[4];
      cornersOfQuad(mesh, first, group.group().rays.time[s], q);
      if (!sharesOf(q, share)) share[0] = -1;
    }
    const bool second = triangle != first;
    array[0][i] = second ? 0.f : hits.u[s];
    array[1][i] = second ? hits.u[s] : hits.v[s];
    array[2][i] = second ? hits.v[s] : 0.f;
    for (int k = 0; k < 3; ++k) array[3 + k][i] = share[k];
  }
  quadsKernel(group.world().width)(a);
}

}  // namespace kinora::shade
#endif
