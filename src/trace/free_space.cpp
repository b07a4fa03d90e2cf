#include "trace/free_space.h"

#include <Imath/ImathVec.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "trace/world_part.h"

namespace kinora::trace {

namespace {

// Squared distance to a triangle, by which of its corners, edges and inside is next to p (Ericson, "Real-Time Collision
// Detection", 2005, section 5.1.5).
float squaredDistance(const Imath::V3f& p, const Imath::V3f& a, const Imath::V3f& b, const Imath::V3f& c) {
  const Imath::V3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = ab ^ ap, d2 = ac ^ ap;
  if (d1 <= 0 && d2 <= 0) return ap.length2();
  const Imath::V3f bp = p - b;
  const float d3 = ab ^ bp, d4 = ac ^ bp;
  if (d3 >= 0 && d4 <= d3) return bp.length2();
  const float alongAb = d1 * d4 - d3 * d2;
  if (alongAb <= 0 && d1 >= 0 && d3 <= 0) return (ap - ab * (d1 / (d1 - d3))).length2();
  const Imath::V3f cp = p - c;
  const float d5 = ab ^ cp, d6 = ac ^ cp;
  if (d6 >= 0 && d5 <= d6) return cp.length2();
  const float alongAc = d5 * d2 - d1 * d6;
  if (alongAc <= 0 && d2 >= 0 && d6 <= 0) return (ap - ac * (d2 / (d2 - d6))).length2();
  const float alongBc = d3 * d6 - d5 * d4, toB = d4 - d3, toC = d5 - d6;
  if (alongBc <= 0 && toB >= 0 && toC >= 0) return (bp - (c - b) * (toB / (toB + toC))).length2();
  const float all = alongBc + alongAc + alongAb;
  return (ap - ab * (alongAc / all) - ac * (alongAb / all)).length2();
}

// Surfaces nearer than this part of a distance that was found are looked for and no others: bounds a little too small
// are found with half the triangles.
constexpr float kKept = 0.85f;
constexpr float kFarthest = 8;  // edges of a cell

bool meet(RTCPointQueryFunctionArguments* a) {
  const auto& s = *static_cast<const FreeSpace::Shape*>(a->userPtr);
  const uint32_t triangle = a->primID - s.firstTriangle;
  if (a->geomID != s.firstGeometry || triangle >= s.triangles) return false;
  const auto corner = [&](uint32_t k) {
    const float* x = s.points + 3 * size_t(s.indices[3 * size_t(triangle) + k]);
    return Imath::V3f(x[0], x[1], x[2]);
  };
  const float d =
      kKept * std::sqrt(squaredDistance({a->query->x, a->query->y, a->query->z}, corner(0), corner(1), corner(2)));
  if (!(d < a->query->radius)) return false;
  a->query->radius = d;
  return true;
}

uint64_t mixed(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace

FreeSpace::FreeSpace() {
  held_.add(kEntries * sizeof(Entry));
  entries_ = std::make_unique<Entry[]>(kEntries);
}

float FreeSpace::radius(const Shape& shape, const float p[3], float reach) const {
  int power;
  std::frexp(reach * 0.25f, &power);
  const float edge = std::ldexp(1.f, power);  // (reach / 4, reach / 2]
  float cell[3], middle[3], beside = 0, size = 0;
  uint64_t hash = mixed(uint64_t(shape.key) << 32 | uint32_t(power));
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::floor(p[k] / edge);
    if (!(std::fabs(cell[k]) < 1e6f)) return 0;  // so far away that coordinates are coarser than cells
    middle[k] = (cell[k] + 0.5f) * edge;
    beside += (p[k] - middle[k]) * (p[k] - middle[k]);
    size = std::max(size, std::fabs(p[k]));
    hash = mixed(hash ^ uint64_t(int64_t(cell[k])) * 0x9e3779b97f4a7c15u);
  }
  Entry& e = entries_[hash & (kEntries - 1)];
  uint64_t value = e.value.load(std::memory_order_relaxed);
  if ((e.check.load(std::memory_order_relaxed) ^ value) != hash) {
    RTCPointQuery query{middle[0], middle[1], middle[2], 0, kFarthest * edge};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(shape.scene, &query, &context, &meet, const_cast<Shape*>(&shape));
    uint32_t bits;
    std::memcpy(&bits, &query.radius, sizeof bits);
    value = bits;
    e.value.store(value, std::memory_order_relaxed);
    e.check.store(hash ^ value, std::memory_order_relaxed);
  }
  const auto bits = uint32_t(value);
  float known;
  std::memcpy(&known, &bits, sizeof known);
  // less what rounding makes of places and distances
  return std::max(0.f, 0.9999f * known - 1.0001f * std::sqrt(beside) - 4e-6f * size);
}

namespace {

// No direction shortens by more: of a matrix that turns, and scales before or after it does, exactly.
float leastStretch(const float m[3][3]) {
  double least = 0;
  for (const bool columns : {false, true}) {
    double bound = INFINITY;
    for (int i = 0; i < 3; ++i) {
      double row = 0;
      for (int j = 0; j < 3; ++j) {
        double x = 0;
        for (int k = 0; k < 3; ++k)
          x += columns ? double(m[k][i]) * double(m[k][j]) : double(m[i][k]) * double(m[j][k]);
        row += i == j ? x : -std::fabs(x);
      }
      bound = std::min(bound, row);
    }
    least = std::max(least, bound);
  }
  return float(std::sqrt(least));
}

}  // namespace

void World::freeRadii(uint32_t n, const uint32_t* instances, const uint32_t* geometries, const float* const p[3],
                      const float* reach, float* radius) const {
  uint32_t instance = kNone, geometry = kNone;
  bool isKnown = false, isPlaced = false;
  FreeSpace::Shape shape{};
  Affine toShape;
  float stretch = 1;
  for (uint32_t i = 0; i < n; ++i) {
    if (instances[i] != instance || geometries[i] != geometry) {
      instance = instances[i];
      geometry = geometries[i];
      isKnown = shapeOf(instance, geometry, shape);
      if (isKnown) {
        const Instance& placed = instance_[instance];
        isPlaced = !placed.baked;
        stretch = 1;
        if (isPlaced) {
          const Affine& toRender = *keys(placed);
          stretch = leastStretch(toRender.m);
          isKnown = stretch > 0;
          if (isKnown) toShape = toRender.inverse();
        }
      }
    }
    radius[i] = 0;
    if (!isKnown || !(reach[i] > 0 && reach[i] < 1e15f)) continue;
    const float at[3] = {p[0][i], p[1][i], p[2][i]};
    float inShape[3] = {at[0], at[1], at[2]};
    if (isPlaced) toShape.point(at, inShape);
    const float known = freeSpace_->radius(shape, inShape, reach[i] / stretch) * stretch;
    const float size = std::max({std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])});
    radius[i] = std::max(0.f, 0.9999f * known - 4e-6f * size);
  }
}

// Nothing is known of what moves, of curves and of geometry that meets rays itself; and bodies of several shapes have
// more than one surface.
bool World::shapeOf(uint32_t instance, uint32_t geometry, FreeSpace::Shape& out) const {
  if (!freeSpace_ || !bodies_.empty() || instance_[instance].keyCount > 1) return false;
  const geometry::Mesh& mesh = *meshes_[geometry];
  if (mesh.keyCount() > 1 || mesh.isStrand() || !mesh.triangleCount()) return false;
  const auto after = std::upper_bound(places_.begin(), places_.end(), geometry,
                                      [](uint32_t g, const PartPlace& p) { return g < p.firstGeometry; });
  const Part& part = *parts_[size_t(after - places_.begin()) - 1];
  const uint32_t index = geometry - (after - 1)->firstGeometry;
  if (part.users[index]) return false;
  const auto [id, firstTriangle] = part.placeOfShape[index];
  out = {part.scene,        geometry,           id, firstTriangle, uint32_t(mesh.triangleCount()),
         &mesh.points[0].x, mesh.indices.data()};
  return true;
}

}  // namespace kinora::trace
