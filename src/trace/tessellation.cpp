#include "trace/tessellation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

#include "trace/packed_normal.h"

namespace kinora::trace {

using Imath::V3f;

namespace {

constexpr uint32_t kBlock = 4;     // cells on a side
constexpr size_t kPadFloats = 16;  // kernels load whole vectors

struct Box {
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
  void add(const V3f& p) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
  }
  void add(const Box& b) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], b.lo[k]);
      hi[k] = std::max(hi[k], b.hi[k]);
    }
  }
};

constexpr GridBlocks blocksOf(uint32_t eu, uint32_t ev) {
  GridBlocks b;
  uint32_t w = std::max(1u, (1u << eu) / kBlock), h = std::max(1u, (1u << ev) / kBlock);
  for (;;) {
    b.width[b.levels] = w;
    b.height[b.levels] = h;
    b.first[b.levels] = b.nodes;
    if (b.levels > 0) b.nodes += w * h;
    ++b.levels;
    if (w == 1 && h == 1) return b;
    w = std::max(1u, w / 2);
    h = std::max(1u, h / 2);
  }
}

}  // namespace

bool meetsBox(const GridRay& r, const float box[6], float slack) {
  float near = r.tMin, far = r.tMax;
  for (int k = 0; k < 3; ++k) {
    float a = (box[k] - slack - r.o[k]) * r.inverse[k], b = (box[3 + k] + slack - r.o[k]) * r.inverse[k];
    if (a > b) std::swap(a, b);
    near = std::max(near, a);
    far = std::min(far, b * 1.000001f);
  }
  return near <= far;
}

float largestOf(const float box[6]) {
  float most = 0;
  for (int k = 0; k < 6; ++k) most = std::max(most, std::fabs(box[k]));
  return most;
}

float slackOf(const GridRay& ray, float largest) { return (ray.largest + largest) * 2e-6f; }

GridRay::GridRay(const float origin[3], const float direction[3], float nearest, float farthest, float atTime)
    : tMin(nearest), tMax(farthest), time(atTime) {
  for (int k = 0; k < 3; ++k) {
    o[k] = origin[k];
    d[k] = direction[k];
    inverse[k] = 1.f / (std::fabs(d[k]) > 1e-25f ? d[k] : std::copysign(1e-25f, d[k]));
  }
  largest = std::max(std::fabs(o[0]), std::max(std::fabs(o[1]), std::fabs(o[2])));
  kz = std::fabs(d[0]) > std::fabs(d[1]) ? (std::fabs(d[0]) > std::fabs(d[2]) ? 0 : 2)
                                         : (std::fabs(d[1]) > std::fabs(d[2]) ? 1 : 2);
  kx = (kz + 1) % 3;
  ky = (kz + 2) % 3;
  if (d[kz] < 0) std::swap(kx, ky);
  sz = 1.f / d[kz];
  sx = d[kx] * sz;
  sy = d[ky] * sz;
}

const GridBlocks& GridBlocks::of(int eu, int ev) {
  static constexpr auto kAll = [] {
    std::array<std::array<GridBlocks, Tessellation::kMostExponent + 1>, Tessellation::kMostExponent + 1> all;
    for (uint32_t u = 0; u < all.size(); ++u)
      for (uint32_t v = 0; v < all.size(); ++v) all[u][v] = blocksOf(u, v);
    return all;
  }();
  return kAll[size_t(eu)][size_t(ev)];
}

size_t Tessellation::floatsOfKey(int eu, int ev) {
  const size_t vertices = ((size_t(1) << eu) + 1) * ((size_t(1) << ev) + 1);
  return 4 * vertices + 24 * size_t(GridBlocks::of(eu, ev).nodes);
}

size_t Tessellation::bytesFor(int eu, int ev, uint32_t keys) {
  return sizeof(Tessellation) + (keys * floatsOfKey(eu, ev) + kPadFloats) * sizeof(float);
}

Tessellation::Ptr Tessellation::make(int eu, int ev, const V3f* points, const V3f* normals, uint32_t keys) {
  void* memory = ::operator new(bytesFor(eu, ev, keys));
  auto* t = new (memory) Tessellation(eu, ev, keys);
  Ptr owner(t);
  std::memset(t->plane(0, keys), 0, kPadFloats * sizeof(float));  // behind the last one
  for (uint32_t key = 0; key < keys; ++key) t->set(key, points + key * t->vertices(), normals + key * t->vertices());
  return owner;
}

void Tessellation::set(uint32_t key, const V3f* points, const V3f* normals) {
  const size_t n = vertices(), stride = (size_t(1) << eu_) + 1;
  for (int k = 0; k < 3; ++k)
    for (size_t i = 0; i < n; ++i) plane(k, key)[i] = points[i][k];
  for (size_t i = 0; i < n; ++i) normalsAt(key)[i] = packed(normals[i]);

  const GridBlocks& blocks = GridBlocks::of(eu_, ev_);
  const uint32_t nu = 1u << eu_, nv = 1u << ev_;
  std::vector<Box> below(size_t(blocks.width[0]) * blocks.height[0]), here;
  for (uint32_t y = 0; y < blocks.height[0]; ++y)
    for (uint32_t x = 0; x < blocks.width[0]; ++x) {
      Box& b = below[y * blocks.width[0] + x];
      for (uint32_t j = y * kBlock; j <= std::min(nv, (y + 1) * kBlock); ++j)
        for (uint32_t i = x * kBlock; i <= std::min(nu, (x + 1) * kBlock); ++i) b.add(points[j * stride + i]);
    }
  for (int level = 1; level < blocks.levels; ++level) {
    const uint32_t w = blocks.width[level], h = blocks.height[level], wBelow = blocks.width[level - 1];
    const uint32_t across = wBelow / w, down = blocks.height[level - 1] / h;
    here.assign(size_t(w) * h, Box());
    for (uint32_t y = 0; y < h; ++y)
      for (uint32_t x = 0; x < w; ++x) {
        float* node = boxes(key) + 24 * size_t(blocks.first[level] + y * w + x);
        for (uint32_t c = 0; c < 4; ++c) {
          const uint32_t cx = c & 1, cy = c >> 1;
          Box b;
          if (cx < across && cy < down) b = below[size_t(y * down + cy) * wBelow + x * across + cx];
          for (int k = 0; k < 3; ++k) {
            node[4 * k + int(c)] = b.lo[k];
            node[12 + 4 * k + int(c)] = b.hi[k];
          }
          here[y * w + x].add(b);
        }
      }
    below.swap(here);
  }
  Box all;
  for (int e = 0; e < 4; ++e) {
    Box b;
    const uint32_t count = e % 2 ? nv : nu;
    for (uint32_t i = 0; i <= count; ++i)
      b.add(e == 0   ? points[i]
            : e == 1 ? points[i * stride + nu]
            : e == 2 ? points[nv * stride + i]
                     : points[i * stride]);
    for (int k = 0; k < 3; ++k) {
      edgeBox_[e][k] = key ? std::min(edgeBox_[e][k], b.lo[k]) : b.lo[k];
      edgeBox_[e][3 + k] = key ? std::max(edgeBox_[e][3 + k], b.hi[k]) : b.hi[k];
    }
    all.add(b);
  }
  const float edges[6] = {all.lo[0], all.lo[1], all.lo[2], all.hi[0], all.hi[1], all.hi[2]};
  largest_ = std::max(key ? largest_ : 0.f, largestOf(edges));
}

void Tessellation::destroy(Tessellation* t) {
  if (!t) return;
  t->~Tessellation();
  ::operator delete(t);
}

V3f Tessellation::point(uint32_t i, uint32_t j, const Moment& at) const {
  const size_t n = size_t(j) * ((size_t(1) << eu_) + 1) + i;
  V3f p(plane(0, at.key)[n], plane(1, at.key)[n], plane(2, at.key)[n]);
  if (at.part > 0)
    for (int k = 0; k < 3; ++k) p[k] = at.mix(p[k], plane(k, at.key + 1)[n]);
  return p;
}

V3f Tessellation::normal(uint32_t i, uint32_t j, const Moment& at) const {
  const size_t k = size_t(j) * ((size_t(1) << eu_) + 1) + i;
  const V3f n = unpacked(normalsAt(at.key)[k]);
  return at.part > 0 ? n + (unpacked(normalsAt(at.key + 1)[k]) - n) * at.part : n;
}

// Fans between the grid's line along an edge and the coarser one, in cells' own order.
bool Tessellation::meetsStitches(int edge, int exponent, const Moment& moment, const GridRay& r, GridHit* hit,
                                 float* nearest) const {
  const bool alongU = edge % 2 == 0;
  const uint32_t steps = 1u << (alongU ? eu_ : ev_), wide = steps >> exponent, nu = 1u << eu_, nv = 1u << ev_;
  const auto at = [&](uint32_t k) {
    return edge == 0   ? point(k, 0, moment)
           : edge == 1 ? point(nu, k, moment)
           : edge == 2 ? point(k, nv, moment)
                       : point(0, k, moment);
  };
  struct Sheared {
    float x, y, z;
  };
  // as the kernel of cells has it, to the bit
  const auto sheared = [&](const V3f& p) {
    const float z = p[r.kz] - r.o[r.kz];
    return Sheared{(p[r.kx] - r.o[r.kx]) - r.sx * z, (p[r.ky] - r.o[r.ky]) - r.sy * z, z * r.sz};
  };
  const auto cross = [](const Sheared& a, const Sheared& b) { return a.x * b.y - a.y * b.x; };
  bool any = false;
  for (uint32_t first = 0; first < steps; first += wide) {
    const Sheared a = sheared(at(first));
    Sheared b = sheared(at(first + 1));
    for (uint32_t k = first + 1; k < first + wide; ++k) {
      const Sheared c = sheared(at(k + 1));
      const float u = cross(c, b), v = cross(a, c), w = cross(b, a);
      const Sheared was = b;
      b = c;
      if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0))) continue;
      const float det = u + v + w;
      if (det == 0) continue;
      const float t = (u * a.z + v * was.z + w * c.z) / det;
      if (!(t > r.tMin && t < *nearest)) continue;
      *nearest = t;
      any = true;
      const float along = (u * float(first) + v * float(k) + w * float(k + 1)) / (det * float(steps));
      const float place = std::clamp(along, 0.f, 1.f);
      hit->t = t;
      hit->u = edge == 0 || edge == 2 ? place : edge == 1 ? 1.f : 0.f;
      hit->v = edge == 1 || edge == 3 ? place : edge == 2 ? 1.f : 0.f;
      // where the cells go along the edge one way, this goes the other
      const V3f x = at(k) - at(first), y = at(k + 1) - at(first), n = edge < 2 ? y.cross(x) : x.cross(y);
      for (int axis = 0; axis < 3; ++axis) hit->ng[axis] = n[axis];
    }
  }
  return any;
}

bool Tessellation::intersect(const GridRay& ray, const std::array<uint8_t, 4>& steps, GridHit* hit) const {
  const Moment at = momentAt(ray.time, keys_);
  // boxes between two keys are rounded once more
  const float slack = slackOf(ray, largest_) * (at.part > 0 ? 1.5f : 1.f);
  CellHit cell;
  cell.t = ray.tMax;
  bool any = nearestCell(GridView(*this, at), ray, slack, &cell);
  float nearest = ray.tMax;
  if (any) {
    nearest = hit->t = cell.t;
    hit->u = (float(cell.i) + cell.u) / float(1u << eu_);
    hit->v = (float(cell.j) + cell.v) / float(1u << ev_);
    const V3f a = point(cell.i, cell.j, at), c = point(cell.i + 1, cell.j + 1, at);
    const V3f n = cell.isSecond ? (c - a).cross(point(cell.i, cell.j + 1, at) - a)
                                : (point(cell.i + 1, cell.j, at) - a).cross(c - a);
    for (int k = 0; k < 3; ++k) hit->ng[k] = n[k];
  }
  for (int e = 0; e < 4; ++e)
    if (steps[size_t(e)] < (e % 2 ? ev_ : eu_) && meetsBox(ray, edgeBox_[e], slack))
      any |= meetsStitches(e, steps[size_t(e)], at, ray, hit, &nearest);
  return any;
}

}  // namespace kinora::trace
