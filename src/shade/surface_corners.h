// What is stored around W points of a surface, loaded lane by lane and mixed in lanes: corners of their triangles and quads,
// and the placements that lead to render space. For the kernels of surface_points.h. Included per target.
#include <kinora/simd/wide.h>

#include "shade/group.h"
#include "shade/surface_points.h"

#ifndef KINORA_SURFACE_CORNERS_ONCE
#define KINORA_SURFACE_CORNERS_ONCE
namespace kinora::shade {
inline Spot SurfaceArgs::spot(uint32_t i) const {
  Spot s;
  s.mesh = &world->world->mesh(at.geometry[i]);
  s.info = &world->geometries[at.geometry[i]];
  s.primitive = at.primitive[i];
  s.strand = strand ? strand[i] : nullptr;
  s.quad = quad[0] && quad[0][i] >= 0 ? s.mesh->quadOf(s.primitive) : geometry::Mesh::kNoQuad;
  return s;
}
inline trace::Affine SurfaceArgs::toRender(uint32_t i) const {
  return world->world->objectToRender(at.instance[i], time[i]);
}
}  // namespace kinora::shade
#endif

#if defined(KINORA_SURFACE_CORNERS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SURFACE_CORNERS_H_TARGET
#undef KINORA_SURFACE_CORNERS_H_TARGET
#else
#define KINORA_SURFACE_CORNERS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace shade;

// Three floats by lane, filled one by one.
template <int W>
struct Lanes3 {
  alignas(64) float x[3][W];
  void set(int lane, const float v[3]) {
    for (int k = 0; k < 3; ++k) x[k][lane] = v[k];
  }
  KN_INLINE Vec3<W> get() const { return {Float<W>::load(x[0]), Float<W>::load(x[1]), Float<W>::load(x[2])}; }
};

// Object to render space. Lanes of objects that are there already keep what they have.
template <int W>
struct Placing {
  Lanes3<W> row[3], move;
  bool any = false;
  Mask<W> placed;
  HWY_ATTR Placing(const SurfaceArgs& a, uint32_t i) {
    const trace::Instance& first = a.world->world->instance(a.at.instance[i]);
    // one placement of all lanes that does not move is asked for once
    if (first.keyCount < 2 && (Int<W>::load(a.at.instance + i) == Int<W>(a.at.instance[i])).all()) {
      any = !first.baked;
      placed = Mask<W>(any);
      if (!any) return;
      const trace::Affine m = a.toRender(i);
      for (int k = 0; k < 3; ++k) {
        for (int c = 0; c < 3; ++c) Float<W>(m.m[k][c]).store(row[k].x[c]);
        Float<W>(m.t[k]).store(move.x[k]);
      }
      return;
    }
    alignas(64) uint32_t is[W];
    for (int l = 0; l < W; ++l) {
      const bool isPlaced = !a.world->world->instance(a.at.instance[i + uint32_t(l)]).baked;
      is[l] = isPlaced ? 1 : 0;
      any |= isPlaced;
      if (!isPlaced) continue;
      const trace::Affine m = a.toRender(i + uint32_t(l));
      for (int k = 0; k < 3; ++k) row[k].set(l, m.m[k]);
      move.set(l, m.t);
    }
    placed = Int<W>::load(is) != Int<W>(0);
  }
  KN_INLINE Vec3<W> direction(Vec3<W> d) const {
    if (!any) return d;
    const Vec3<W> x = row[0].get(), y = row[1].get(), z = row[2].get();
    return select(placed,
                  Vec3<W>(x.x * d.x + x.y * d.y + x.z * d.z, y.x * d.x + y.y * d.y + y.z * d.z,
                          z.x * d.x + z.y * d.y + z.z * d.z),
                  d);
  }
  KN_INLINE Vec3<W> point(Vec3<W> p) const { return any ? select(placed, direction(p) + move.get(), p) : p; }
  // The inverse transpose times the size of the determinant: normals keep their side.
  struct Normals {
    Vec3<W> x, y, z;
    Mask<W> mirrors;
    KN_INLINE Normals() {}
    KN_INLINE Normals(Vec3<W> a, Vec3<W> b, Vec3<W> c, Mask<W> m) : x(a), y(b), z(c), mirrors(m) {}
  };
  KN_INLINE Normals cofactors() const {
    const Vec3<W> x = row[0].get(), y = row[1].get(), z = row[2].get();
    const auto product = [](Vec3<W> a, Vec3<W> b) {
      return Vec3<W>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    };
    const Vec3<W> cx = product(y, z), cy = product(z, x), cz = product(x, y);
    return {cx, cy, cz, (x.x * cx.x + x.y * cx.y + x.z * cx.z < Float<W>(0.f)) & placed};
  }
  KN_INLINE Vec3<W> normal(const Normals& c, Vec3<W> n) const {
    return select(placed,
                  Vec3<W>(c.x.x * n.x + c.x.y * n.y + c.x.z * n.z, c.y.x * n.x + c.y.y * n.y + c.y.z * n.z,
                          c.z.x * n.x + c.z.y * n.y + c.z.z * n.z),
                  n);
  }
};

// Weights of the corners of a triangle, and parameters of a quad.
template <int W>
struct Inside {
  Float<W> b0, b1, b2, u, v;
  // onFacets: of the micropolygons, where points lie on such, else of the mesh.
  KN_INLINE Inside(const SurfaceArgs& a, uint32_t i, bool onFacets = true)
      : b1(Float<W>::load(a.at.u + i)), b2(Float<W>::load(a.at.v + i)) {
    if (a.quad[0]) {
      u = Float<W>::load(a.quad[0] + i);
      v = Float<W>::load(a.quad[1] + i);
    }
    if (onFacets && a.facet) {
      alignas(64) float x[4][W];
      b1.store(x[0]);
      b2.store(x[1]);
      u.store(x[2]);
      v.store(x[3]);
      for (int l = 0; l < W; ++l)
        if (const trace::UserFacet* f = a.facet[i + uint32_t(l)]) {
          x[0][l] = f->b1;
          x[1][l] = f->b2;
          x[2][l] = f->u;
          x[3][l] = f->v;
        }
      b1 = Float<W>::load(x[0]);
      b2 = Float<W>::load(x[1]);
      u = Float<W>::load(x[2]);
      v = Float<W>::load(x[3]);
    }
    b0 = Float<W>(1.f) - b1 - b2;
  }
  KN_INLINE Float<W> overTriangle(Float<W> a, Float<W> b, Float<W> c) const { return b0 * a + b1 * b + b2 * c; }
  KN_INLINE Float<W> overQuad(const Float<W> c[4]) const {
    const Float<W> one(1.f);
    return (one - v) * ((one - u) * c[0] + u * c[1]) + v * ((one - u) * c[3] + u * c[2]);
  }
  KN_INLINE Float<W> alongU(const Float<W> c[4]) const {
    return (Float<W>(1.f) - v) * (c[1] - c[0]) + v * (c[2] - c[3]);
  }
  KN_INLINE Float<W> alongV(const Float<W> c[4]) const {
    return (Float<W>(1.f) - u) * (c[3] - c[0]) + u * (c[2] - c[1]);
  }
};

// Which corner stands where: three of triangles, four of quads where `whole`.
struct CornersOf {
  const MeshView& view;
  uint32_t triangle, quad = geometry::Mesh::kNoQuad;
  CornersOf(const SurfaceArgs& a, uint32_t point, bool whole)
      : view(a.world->tables.meshes[a.at.geometry[point]]), triangle(a.at.primitive[point]) {
    if (whole && a.quad[0] && a.quad[0][point] >= 0) quad = view.mesh->quadOf(triangle);
  }
  bool isOnQuad() const { return quad != geometry::Mesh::kNoQuad; }
  int count() const { return isOnQuad() ? 4 : 3; }
  size_t operator[](int k) const {
    return isOnQuad() ? geometry::Mesh::quadCorner(quad, k) : 3 * size_t(triangle) + size_t(k);
  }
};

// Values at the corners by lane, and which lanes have four.
template <int W>
struct CornerLanes {
  Lanes3<W> at[4];
  alignas(64) uint32_t quad[W];
  bool anyQuad = false;
  void setQuad(int lane, const CornersOf& corners) {
    quad[lane] = corners.isOnQuad();
    anyQuad |= corners.isOnQuad();
  }
  void clear(int lane) {
    constexpr float zero[3] = {0, 0, 0};
    for (Lanes3<W>& c : at) c.set(lane, zero);
  }
  // Of the micropolygon that the point lies on, where it lies on one.
  bool setFacet(const SurfaceArgs& a, uint32_t point, int lane, bool whole,
                const float (trace::UserFacet::*corners)[4][3]) {
    const trace::UserFacet* f = a.facet ? a.facet[point] : nullptr;
    if (!f) return false;
    quad[lane] = whole;
    anyQuad |= whole;
    clear(lane);
    const float(&values)[4][3] = f->*corners;
    for (int k = 0; k < (whole ? 4 : 3); ++k) at[k].set(lane, values[!whole && k > 0 && f->isSecond ? k + 1 : k]);
    return true;
  }
  // `stride` floats lead from the first key to the second.
  void set(int lane, int corner, const float* v, size_t stride, const geometry::Mesh::KeyPair& keys) {
    if (!(keys.part > 0)) return at[corner].set(lane, v);
    const float* next = v + stride;
    const float moved[3] = {keys.mix(v[0], next[0]), keys.mix(v[1], next[1]), keys.mix(v[2], next[2])};
    at[corner].set(lane, moved);
  }
  // What the first lane has goes to all.
  KN_INLINE void spread() {
    for (Lanes3<W>& c : at)
      for (auto& x : c.x) Float<W>(x[0]).store(x);
    Int<W>(quad[0]).store(quad);
  }
  KN_INLINE Mask<W> onQuad() const { return Int<W>::load(quad) != Int<W>(0); }
};

// Whether W points lie on one triangle, or on one quad where `whole`, and on no micropolygon: what is stored at corners
// is loaded once then. So it is where surfaces are diced, and where rays see large faces.
template <int W>
KN_INLINE bool areOnOneFace(const SurfaceArgs& a, uint32_t i, bool whole) {
  if (a.facet || !(Int<W>::load(a.at.geometry + i) == Int<W>(a.at.geometry[i])).all()) return false;
  const Int<W> primitive = Int<W>::load(a.at.primitive + i);
  const uint32_t first = a.at.primitive[i];
  if (whole && a.quad[0]) {
    const Mask<W> onQuads = Float<W>::load(a.quad[0] + i) >= Float<W>(0.f);
    if (onQuads.all() && a.world->tables.meshes[a.at.geometry[i]].mesh->quadPairs)
      return ((primitive | Int<W>(1)) == Int<W>(first | 1)).all();
    if (!onQuads.none() && !onQuads.all()) return false;
  }
  return (primitive == Int<W>(first)).all();
}

// Positions at the points' times.
template <int W>
CornerLanes<W> cornerPositions(const SurfaceArgs& a, uint32_t i, bool whole, bool undeformed = false) {
  CornerLanes<W> out;
  const MeshView& mesh = a.world->tables.meshes[a.at.geometry[i]];
  const bool isOnce =
      (undeformed || !mesh.isMoving) && areOnOneFace<W>(a, i, whole || (undeformed && a.isByParameter));
  for (int l = 0; l < (isOnce ? 1 : W); ++l) {
    const uint32_t point = i + uint32_t(l);
    if (!undeformed && out.setFacet(a, point, l, whole, &trace::UserFacet::P)) continue;
    // where a place is given by its parameters the quad is one piece
    const bool isOne = undeformed && (a.isByParameter || (a.facet && a.facet[point]));
    const CornersOf corners(a, point, whole || isOne);
    const MeshView& m = corners.view;
    out.setQuad(l, corners);
    out.clear(l);
    if (!m.points) continue;
    const bool moves = m.isMoving && !undeformed;
    const geometry::Mesh::KeyPair keys = moves ? m.mesh->keysAt(a.time[point]) : geometry::Mesh::KeyPair();
    const Imath::V3f* points = undeformed && !m.mesh->rest.empty() ? m.mesh->rest.data() : m.points;
    for (int k = 0; k < corners.count(); ++k)
      out.set(l, k, &points[keys.first + m.indices[corners[k]]].x, 3 * (keys.second - keys.first), keys);
  }
  if (isOnce) out.spread();
  return out;
}

// Normals at the points' times; 0 where the mesh has none.
template <int W>
CornerLanes<W> cornerNormals(const SurfaceArgs& a, uint32_t i, bool whole) {
  using Rate = geometry::Primvar::Rate;
  CornerLanes<W> out;
  const bool isOnce = !a.world->tables.meshes[a.at.geometry[i]].movesNormals && areOnOneFace<W>(a, i, whole);
  for (int l = 0; l < (isOnce ? 1 : W); ++l) {
    const uint32_t point = i + uint32_t(l);
    if (out.setFacet(a, point, l, whole, &trace::UserFacet::N)) continue;
    const CornersOf corners(a, point, whole);
    const MeshView& m = corners.view;
    out.setQuad(l, corners);
    out.clear(l);
    if (!m.normals) continue;
    const geometry::Mesh::KeyPair keys = m.movesNormals ? m.mesh->keysAt(a.time[point]) : geometry::Mesh::KeyPair();
    for (int k = 0; k < corners.count(); ++k) {
      const size_t of = m.rateOfNormals == Rate::PerVertex   ? m.indices[corners[k]]
                        : m.rateOfNormals == Rate::PerCorner ? corners[k]
                        : m.rateOfNormals == Rate::PerFace   ? m.mesh->faceOf(corners.triangle)
                                                             : 0;
      out.set(l, k, m.normals + 3 * (keys.first + of), 3 * (keys.second - keys.first), keys);
    }
  }
  if (isOnce) out.spread();
  return out;
}

template <int W>
KN_INLINE Vec3<W> interpolate(const CornerLanes<W>& corners, const Inside<W>& inside) {
  Float<W> out[3];
  for (int k = 0; k < 3; ++k) {
    const Float<W> c[4] = {Float<W>::load(corners.at[0].x[k]), Float<W>::load(corners.at[1].x[k]),
                           Float<W>::load(corners.at[2].x[k]), Float<W>::load(corners.at[3].x[k])};
    out[k] = inside.overTriangle(c[0], c[1], c[2]);
    if (corners.anyQuad) out[k] = select(corners.onQuad(), inside.overQuad(c), out[k]);
  }
  return {out[0], out[1], out[2]};
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
