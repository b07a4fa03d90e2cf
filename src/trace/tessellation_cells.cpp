// The kernel of rays that meet the cells of a tessellation: boxes four at a time, then rows of four cells. Compiled for
// one target, which every CPU has that runs Kinora: what a ray meets depends on no width.
#define KINORA_KERNEL_FILE "trace/tessellation_cells.cpp"
#include <algorithm>

#include "trace/tessellation.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/tables.h>
#include <kinora/simd/wide.h>

KINORA_KERNELS_BEGIN

#if HWY_TARGET == HWY_AVX2
using F4 = Float<4>;

// Seen along the ray: x and y across it, z the distance.
struct Sheared {
  F4 x, y, z;
  KN_INLINE Sheared(F4 a, F4 b, F4 c) : x(a), y(b), z(c) {}
};
KN_INLINE F4 edgeOf(const Sheared& a, const Sheared& b) { return a.x * b.y - a.y * b.x; }

// isMoving: between two keys.
template <bool isMoving>
struct CellSearch {
  const trace::GridView& grid;
  const trace::GridRay& ray;
  uint32_t nu, nv;
  trace::CellHit* hit;
  bool any = false;

  // as Moment::mix has it, to the bit: triangles between lines on an edge are not of this kernel
  HWY_ATTR F4 between(const float* from) const {
    const F4 a = F4::load(from);
    return isMoving ? a + (F4::load(from + grid.toNext) - a) * F4(grid.part) : a;
  }

  HWY_ATTR Sheared load(size_t at) const {
    const F4 z = between(grid.plane[ray.kz] + at) - F4(ray.o[ray.kz]);
    return Sheared((between(grid.plane[ray.kx] + at) - F4(ray.o[ray.kx])) - F4(ray.sx) * z,
                   (between(grid.plane[ray.ky] + at) - F4(ray.o[ray.ky])) - F4(ray.sy) * z, z * F4(ray.sz));
  }

  // u, v, w: of the corners a, b, c
  HWY_ATTR void triangles(F4 u, F4 v, F4 w, const Sheared& a, const Sheared& b, const Sheared& c, Mask<4> live,
                          uint32_t i0, uint32_t j, bool isSecond) {
    const F4 zero(0.f);
    const F4 least = min(u, min(v, w)), most = max(u, max(v, w));
    Mask<4> in = live & ((least >= zero) | (most <= zero));
    if (in.none()) return;
    const F4 det = u + v + w;
    in &= !(det == zero);
    const F4 t = (u * a.z + v * b.z + w * c.z) / select(in, det, F4(1.f));
    in &= (t > F4(ray.tMin)) & (t < F4(hit->t));
    if (in.none()) return;
    alignas(16) float ts[4], us[4], vs[4], ws[4];
    t.store(ts);
    u.store(us);
    v.store(vs);
    w.store(ws);
    const uint32_t bits = in.bits();
    for (uint32_t l = 0; l < 4; ++l) {
      if (!(bits >> l & 1) || !(ts[l] < hit->t)) continue;
      const float d = us[l] + vs[l] + ws[l], low = ws[l] / d, high = (vs[l] + ws[l]) / d;
      hit->t = ts[l];
      hit->u = isSecond ? vs[l] / d : high;
      hit->v = isSecond ? high : low;
      hit->i = i0 + l;
      hit->j = j;
      hit->isSecond = isSecond;
      any = true;
    }
  }

  HWY_ATTR void block(uint32_t i0, uint32_t j0) {
    const size_t stride = nu + 1;
    const uint32_t rows = std::min(4u, nv - j0);
    const Mask<4> live = Mask<4>::firstN(int(std::min(4u, nu - i0)));
    size_t at = j0 * stride + i0;
    Sheared a = load(at), b = load(at + 1);
    for (uint32_t r = 0; r < rows; ++r) {
      at += stride;
      const Sheared d = load(at), c = load(at + 1);
      const F4 diagonal = edgeOf(a, c);
      triangles(edgeOf(c, b), diagonal, edgeOf(b, a), a, b, c, live, i0, j0 + r, false);
      triangles(edgeOf(d, c), edgeOf(a, d), -diagonal, a, c, d, live, i0, j0 + r, true);
      a = d;
      b = c;
    }
  }
};

template <bool isMoving>
HWY_ATTR bool nearestOf(const trace::GridView& grid, const trace::GridRay& ray, float slack, trace::CellHit* hit) {
  CellSearch<isMoving> search{grid, ray, 1u << grid.eu, 1u << grid.ev, hit};
  const trace::GridBlocks& blocks = trace::GridBlocks::of(grid.eu, grid.ev);
  if (blocks.levels == 1) {
    search.block(0, 0);
    return search.any;
  }
  struct Entry {
    float t;
    uint16_t level, x, y;
  };
  Entry stack[64];
  int top = 0;
  stack[top++] = {ray.tMin, uint16_t(blocks.levels - 1), 0, 0};
  const int first[3] = {ray.d[0] < 0 ? 12 : 0, ray.d[1] < 0 ? 12 : 0, ray.d[2] < 0 ? 12 : 0};
  // lower sides are brought down, upper ones up
  const auto shifted = [&](int k, bool isUpper) { return isUpper ? ray.o[k] - slack : ray.o[k] + slack; };
  F4 nearFrom[3], farFrom[3], inverse[3];
  for (int k = 0; k < 3; ++k) {
    nearFrom[k] = F4(shifted(k, first[k] != 0));
    farFrom[k] = F4(shifted(k, first[k] == 0));
    inverse[k] = F4(ray.inverse[k]);
  }
  while (top) {
    const Entry e = stack[--top];
    if (e.t > hit->t) continue;
    if (e.level == 0) {
      search.block(4u * e.x, 4u * e.y);
      continue;
    }
    const uint32_t w = blocks.width[e.level], wBelow = blocks.width[e.level - 1];
    const uint32_t across = wBelow / w, down = blocks.height[e.level - 1] / blocks.height[e.level];
    const float* box = grid.boxes + 24 * size_t(blocks.first[e.level] + e.y * w + e.x);
    F4 near(ray.tMin), far(hit->t);
    for (int k = 0; k < 3; ++k) {
      // children that are not there have boxes that are none; their bits go below
      near = max(near, (search.between(box + first[k] + 4 * k) - nearFrom[k]) * inverse[k]);
      far = min(far, (search.between(box + (12 - first[k]) + 4 * k) - farFrom[k]) * inverse[k] * F4(1.000001f));
    }
    uint32_t bits = (near <= far).bits() & (across == 1 ? 5u : 15u) & (down == 1 ? 3u : 15u);
    if (!bits) continue;
    alignas(16) float t[4];
    near.store(t);
    const int begin = top;
    for (uint32_t c = 0; c < 4; ++c) {
      if (!(bits >> c & 1)) continue;
      const Entry child{t[c], uint16_t(e.level - 1), uint16_t(e.x * across + (c & 1)),
                        uint16_t(e.y * down + (c >> 1))};
      int at = top++;
      for (; at > begin && stack[at - 1].t < child.t; --at) stack[at] = stack[at - 1];
      stack[at] = child;  // the nearest on top
    }
  }
  return search.any;
}

HWY_ATTR bool nearestCell(const trace::GridView& grid, const trace::GridRay& ray, float slack, trace::CellHit* hit) {
  return grid.toNext ? nearestOf<true>(grid, ray, slack, hit) : nearestOf<false>(grid, ray, slack, hit);
}
#endif

KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::trace {

bool nearestCell(const GridView& grid, const GridRay& ray, float slack, CellHit* hit) {
  return N_AVX2::nearestCell(grid, ray, slack, hit);
}

}  // namespace kinora::trace
#endif
