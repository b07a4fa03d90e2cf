#include "trace/free_space.h"

#include <Imath/ImathVec.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "trace/packed_normal.h"
#include "trace/world_part.h"

namespace kinora::trace {

namespace {

// The point of a triangle that is next to p, by which of its corners, edges and inside that is (Ericson, "Real-Time
// Collision Detection", 2005, section 5.1.5).
Imath::V3f nearestPoint(const Imath::V3f& p, const Imath::V3f& a, const Imath::V3f& b, const Imath::V3f& c) {
  const Imath::V3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = ab ^ ap, d2 = ac ^ ap;
  if (d1 <= 0 && d2 <= 0) return a;
  const Imath::V3f bp = p - b;
  const float d3 = ab ^ bp, d4 = ac ^ bp;
  if (d3 >= 0 && d4 <= d3) return b;
  const float alongAb = d1 * d4 - d3 * d2;
  if (alongAb <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const Imath::V3f cp = p - c;
  const float d5 = ab ^ cp, d6 = ac ^ cp;
  if (d6 >= 0 && d5 <= d6) return c;
  const float alongAc = d5 * d2 - d1 * d6;
  if (alongAc <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const float alongBc = d3 * d6 - d5 * d4, toB = d4 - d3, toC = d5 - d6;
  if (alongBc <= 0 && toB >= 0 && toC >= 0) return b + (c - b) * (toB / (toB + toC));
  const float all = alongBc + alongAc + alongAb;
  return a + ab * (alongAc / all) + ac * (alongAb / all);
}

// In edges of a cell.
constexpr float kFarthest = 8;                   // surfaces beyond it are not looked for
constexpr float kPlaneBelow = 2;                 // surfaces nearer than this get a second ball
constexpr float kLargest = 1.5f;                 // radius of first balls where there is a second one
constexpr float kSmallest = 1, kFlattest = 256;  // radius of second balls, where they are no half-spaces
constexpr float kSlack = 0.015f;                 // what second balls leave of the way to the surface
// Surfaces nearer than this part of a distance that was found are looked for and no others: bounds a little too small
// are found with half the triangles.
constexpr float kKept = 0.85f;

// Shows the triangles of a shape within `radius` of a place to what looks for something among them, their corners
// relative to it. What it finds may shrink the radius; the last one is returned.
template <class Rule>
float askAround(const FreeSpace::Shape& shape, const float middle[3], float radius, Rule& rule) {
  struct Asked {
    const FreeSpace::Shape& shape;
    Rule& rule;
  } asked{shape, rule};
  const RTCPointQueryFunction show = [](RTCPointQueryFunctionArguments* a) {
    const auto& [s, r] = *static_cast<const Asked*>(a->userPtr);
    const uint32_t triangle = a->primID - s.firstTriangle;
    if (a->geomID != s.firstGeometry || triangle >= s.triangles) return false;
    Imath::V3f corner[3];
    for (uint32_t k = 0; k < 3; ++k) {
      const float* x = s.points + 3 * size_t(s.indices[3 * size_t(triangle) + k]);
      corner[k] = Imath::V3f(x[0], x[1], x[2]) - Imath::V3f(a->query->x, a->query->y, a->query->z);
    }
    return r.meet(corner, a->query->radius);
  };
  RTCPointQuery query{middle[0], middle[1], middle[2], 0, radius};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(shape.scene, &query, &context, show, &asked);
  return query.radius;
}

// The nearest triangle, or nearly.
struct Nearest {
  const float kept;      // part of a distance that is kept
  Imath::V3f point{0};   // of the triangle found last: that of its points which is next to the middle,
  Imath::V3f facing{0};  // and its normal, of any length
  bool meet(const Imath::V3f corner[3], float& radius) {
    const Imath::V3f p = nearestPoint(Imath::V3f(0), corner[0], corner[1], corner[2]);
    const float d = kept * p.length();
    if (!(d < radius)) return false;
    point = p;
    facing = (corner[1] - corner[0]) % (corner[2] - corner[0]);
    radius = d;
    return true;
  }
};

// How much the surface bends before a plane (to the side that the normal points away from) and behind it: of balls
// that touch it, those that hold no corner.
struct Bend {
  const Imath::V3f normal;
  const float distance[2];
  float curvature[2] = {0, 0};
  bool meet(const Imath::V3f corner[3], float&) {
    for (int k = 0; k < 3; ++k) {
      const float along = corner[k] ^ normal, square = std::max(corner[k].length2(), 1e-30f);
      curvature[0] = std::max(curvature[0], (distance[0] - along) / square);
      curvature[1] = std::max(curvature[1], (distance[1] + along) / square);
    }
    return false;
  }
};

// The nearest triangle that reaches into the second ball.
struct Within {
  const Imath::V3f normal;
  const float curvature, offset;
  bool meet(const Imath::V3f corner[3], float& radius) {
    const auto isOut = [&](const Imath::V3f& x, float bend) { return (x ^ normal) + bend * x.length2() >= offset; };
    if (isOut(corner[0], 0) && isOut(corner[1], 0) && isOut(corner[2], 0)) return false;
    if (curvature > 0) {
      const Imath::V3f center = normal * (-0.5f / curvature);
      if (isOut(nearestPoint(center, corner[0], corner[1], corner[2]), curvature)) return false;
    }
    const float d = 0.999f * nearestPoint(Imath::V3f(0), corner[0], corner[1], corner[2]).length();
    if (!(d < radius)) return false;
    radius = d;
    return true;
  }
};

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

FreeSpace::Cell FreeSpace::find(const Shape& shape, const float middle[3], float edge) {
  Nearest about{kKept};
  const float around = askAround(shape, middle, kFarthest * edge, about);
  if (around >= kPlaneBelow * edge) return {0, INFINITY, {around, 0}, {0, 0}};
  Nearest next{1};
  askAround(shape, middle, around * (1.001f / kKept), next);
  // Across the way to the surface; where the middle is nearly on it, the triangle's own.
  const float length = next.point.length(), area = next.facing.length();
  Imath::V3f normal(0, 0, 1);
  if (length > 0.02f * edge)
    normal = next.point / length;
  else if (area > 0)
    normal = next.facing / area;
  const uint32_t code = packed(normal);
  normal = unpacked(code);
  const float distance = next.point ^ normal, slack = kSlack * edge;
  Cell found{code, distance, {0, 0}, {0, 0}};
  Bend bend{normal, {distance - 0.5f * slack, -distance - 0.5f * slack}};
  askAround(shape, middle, kLargest * edge, bend);
  for (int side = 0; side < 2; ++side) {
    // what is behind lies in the cell at all
    if (side == 1 && distance + slack > 0.87f * edge) break;
    const float curvature = bend.curvature[side] * edge;
    if (curvature > 0) found.curvature[side] = std::clamp(curvature, 0.5f / kFlattest, 0.5f / kSmallest) / edge;
    Within within{side ? -normal : normal, found.curvature[side], (side ? -distance : distance) - slack};
    found.radius[side] = askAround(shape, middle, kLargest * edge, within);
  }
  return found;
}

FreeSpace::Region FreeSpace::region(const Shape& shape, const float p[3], float reach) const {
  Region r{};
  // the power of two in (reach / 2, reach]; numbers that are none, and lengths without meaning, have other exponents
  const uint32_t exponent = (std::bit_cast<uint32_t>(reach) >> 23) & 0xff;
  if (exponent < 40 || exponent > 214) return r;
  const float edge = std::bit_cast<float>(exponent << 23), perEdge = std::bit_cast<float>((254 - exponent) << 23);
  float cell[3], size = 0;
  uint64_t hash = mixed(uint64_t(shape.key) << 32 | exponent);
  for (int k = 0; k < 3; ++k) {
    cell[k] = std::floor(p[k] * perEdge);
    if (!(std::fabs(cell[k]) < 1e6f)) return r;  // so far away that coordinates are coarser than cells
    r.center[k] = (cell[k] + 0.5f) * edge;
    size = std::max(size, std::fabs(p[k]));
    hash = mixed(hash ^ uint64_t(int64_t(cell[k])) * 0x9e3779b97f4a7c15u);
  }
  Entry& e = entries_[hash & (kEntries - 1)];
  uint64_t word[3];
  for (int k = 0; k < 3; ++k) word[k] = e.word[k].load(std::memory_order_relaxed);
  if ((e.check.load(std::memory_order_relaxed) ^ word[0] ^ word[1] ^ word[2]) != hash) {
    const Cell found = find(shape, r.center, edge);
    const auto both = [](uint32_t a, float b) { return uint64_t(a) << 32 | std::bit_cast<uint32_t>(b); };
    word[0] = both(found.normal, found.distance);
    word[1] = both(std::bit_cast<uint32_t>(found.radius[0]), found.radius[1]);
    word[2] = both(std::bit_cast<uint32_t>(found.curvature[0]), found.curvature[1]);
    for (int k = 0; k < 3; ++k) e.word[k].store(word[k], std::memory_order_relaxed);
    e.check.store(hash ^ word[0] ^ word[1] ^ word[2], std::memory_order_relaxed);
  }
  // less what rounding makes of places and distances
  const float lost = 4e-6f * size, distance = std::bit_cast<float>(uint32_t(word[0]));
  const Imath::V3f at(p[0] - r.center[0], p[1] - r.center[1], p[2] - r.center[2]);
  bool isBehind = false;
  r.offset = 1;
  if (std::isfinite(distance)) {
    const Imath::V3f normal = unpacked(uint32_t(word[0] >> 32));
    const float along = at ^ normal, slack = (kSlack + 1e-4f) * edge + lost;
    isBehind = along > distance;
    r.curvature = std::bit_cast<float>(uint32_t(isBehind ? word[2] : word[2] >> 32));
    for (int k = 0; k < 3; ++k) r.normal[k] = isBehind ? -normal[k] : normal[k];
    r.offset = (isBehind ? -distance : distance) - slack;
    if (!((isBehind ? -along : along) + r.curvature * at.length2() < r.offset)) return r;
  }
  float own = std::bit_cast<float>(uint32_t(isBehind ? word[1] : word[1] >> 32));
  own = 0.9999f * own - lost;
  if (own > 0 && at.length2() < own * own) r.radius = own;
  return r;
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

void World::freeRegions(uint32_t n, const uint32_t* instances, const uint32_t* geometries, const float* const p[3],
                        const float* reach, const FreeRegions& out) const {
  uint32_t instance = kNone, geometry = kNone;
  bool isKnown = false, isPlaced = false;
  FreeSpace::Shape shape{};
  Affine toShape, toRender;
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
          toRender = *keys(placed);
          stretch = leastStretch(toRender.m);
          isKnown = stretch > 0;
          if (isKnown) toShape = toRender.inverse();
        }
      }
    }
    out.radius[i] = 0;
    if (!isKnown || !(reach[i] > 0 && reach[i] < 1e15f)) continue;
    const float at[3] = {p[0][i], p[1][i], p[2][i]};
    FreeSpace::Region r;
    if (isPlaced) {
      float inShape[3];
      toShape.point(at, inShape);
      r = freeSpace_->region(shape, inShape, reach[i] / stretch);
      if (!(r.radius > 0)) continue;
      float center[3], normal[3], length = 0;
      toRender.point(r.center, center);
      for (int k = 0; k < 3; ++k) {
        normal[k] = toShape.m[0][k] * r.normal[0] + toShape.m[1][k] * r.normal[1] + toShape.m[2][k] * r.normal[2];
        length += normal[k] * normal[k];
      }
      length = std::sqrt(length);
      const float size = std::max({std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])}), lost = 4e-6f * size;
      r.radius = 0.9999f * r.radius * stretch - lost;
      // the second ball, by a normal of length 1 again; at least as curved as what is left of it where stretches differ
      const float scale = length > 0 ? 1 / length : 0;
      r.offset = length > 0 ? r.offset * scale - 1e-4f * r.radius - lost : 1;
      r.curvature *= 1.0001f * scale / (stretch * stretch);
      for (int k = 0; k < 3; ++k) {
        r.center[k] = center[k];
        r.normal[k] = normal[k] * scale;
      }
      float way = 0, along = 0;
      for (int k = 0; k < 3; ++k) {
        way += (at[k] - center[k]) * (at[k] - center[k]);
        along += (at[k] - center[k]) * r.normal[k];
      }
      if (!(r.radius > 0 && way < r.radius * r.radius && along + r.curvature * way < r.offset)) continue;
    } else {
      r = freeSpace_->region(shape, at, reach[i]);
    }
    out.radius[i] = std::max(0.f, r.radius);
    out.curvature[i] = r.curvature;
    out.offset[i] = r.offset;
    for (int k = 0; k < 3; ++k) {
      out.center[k][i] = r.center[k];
      out.normal[k][i] = r.normal[k];
    }
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
