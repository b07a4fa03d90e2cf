// Patch, PatchMesh and NuPatch as tensor products of two Axis. Every piece gets its own grid, so that normals and
// primvars may break between pieces; positions on shared lines are computed once and copied, so that nothing cracks.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "geometry/build.h"
#include "geometry/makers.h"
#include "geometry/tensor_surface.h"
#include "geometry/trim_curves.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V4d;

namespace {

std::string describe(const scene::Primitive& primitive, size_t pointCount, TensorSurface& out) {
  // Before anything is made that is as large as the numbers say.
  auto tooFew = [&](int nu, int nv) {
    const double needed = double(nu) * double(nv);
    if (nu < 1 || nv < 1 || needed <= double(pointCount)) return std::string();
    return std::to_string(pointCount) + " points where " + std::to_string(nu) + " x " + std::to_string(nv) +
           " belong";
  };
  static const scene::Attributes kDefaults;
  const scene::Attributes& a = primitive.attributes ? *primitive.attributes : kDefaults;
  if (const auto* n = std::get_if<scene::NuPatch>(&primitive.shape)) {
    if (std::string few = tooFew(n->nu, n->nv); !few.empty()) return few;
    std::string wrong = Axis::nurbs(n->nu, n->uOrder, n->uKnots, n->uMin, n->uMax, out.u);
    return wrong.empty() ? Axis::nurbs(n->nv, n->vOrder, n->vKnots, n->vMin, n->vMax, out.v) : wrong;
  }
  scene::PatchMesh m;
  if (const auto* p = std::get_if<scene::Patch>(&primitive.shape)) {
    m.bicubic = p->bicubic;
    m.nu = m.nv = p->bicubic ? 4 : 2;
  } else {
    m = std::get<scene::PatchMesh>(primitive.shape);
  }
  if (std::string few = tooFew(m.nu, m.nv); !few.empty()) return few;
  if (!m.bicubic) {
    std::string wrong = Axis::linear(m.nu, m.uPeriodic, out.u);
    return wrong.empty() ? Axis::linear(m.nv, m.vPeriodic, out.v) : wrong;
  }
  std::string wrong = Axis::cubic(m.nu, m.uPeriodic, a.uBasis, a.uStep, out.u);
  return wrong.empty() ? Axis::cubic(m.nv, m.vPeriodic, a.vBasis, a.vStep, out.v) : wrong;
}

// A line of the grid along one axis: which piece and where in it.
struct Line {
  size_t span;
  double s;
};
// All lines of an axis once, in order; start[i] is the first line of span i. A periodic axis ends with its first
// line. Pieces that do not meet (of the power basis) have both their ends.
std::vector<Line> linesOf(const Axis& axis, const std::vector<int>& segments, std::vector<int>& start) {
  std::vector<Line> out;
  for (size_t i = 0; i < segments.size(); ++i) {
    start.push_back(int(out.size()));
    for (int k = 0; k < segments[i]; ++k) out.push_back({i, double(k) / segments[i]});
    if (!axis.meets()) out.push_back({i, 1});
  }
  if (!axis.meets()) return out;
  if (axis.periodic())
    out.push_back({0, 0});
  else
    out.push_back({segments.size() - 1, 1});
  return out;
}

// What becomes of all pieces: points and normals by key, and where each vertex lies.
struct Pieces {
  explicit Pieces(size_t keys) : points(keys), normals(keys) {}
  std::vector<std::vector<V3d>> points, normals;
  std::vector<PiecePlace> places;

  uint32_t count() const { return uint32_t(places.size()); }
  void add(const TensorSurface& surface, const PiecePlace& place, size_t key, const V3d& point) {
    points[key].push_back(point);
    normals[key].push_back(surface.normal(key, *place.a, place.s, *place.b, place.t));
  }
  void add(const PiecePlace& place, Mesh& mesh) {
    const Axis::Span &a = *place.a, &b = *place.b;
    places.push_back(place);
    mesh.vertexUV.emplace_back(float(a.u0 + (a.u1 - a.u0) * place.s), float(b.u0 + (b.u1 - b.u0) * place.t));
  }
  // But for sides drawn together to a point, which leave triangles without area.
  void addTriangle(const std::array<uint32_t, 3>& t, uint32_t face, Mesh& mesh) const {
    const std::vector<V3d>& p = points[0];
    if (points.size() == 1 && (p[t[0]] == p[t[1]] || p[t[1]] == p[t[2]] || p[t[2]] == p[t[0]])) return;
    mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
    mesh.faceOfTriangle.push_back(face);
  }
};

// The grids of all pieces.
void makeGrids(const TensorSurface& surface, const std::vector<int>& nu, const std::vector<int>& nv, Pieces& out,
               Mesh& mesh) {
  std::vector<int> startU, startV;
  const std::vector<Line> linesU = linesOf(surface.u, nu, startU), linesV = linesOf(surface.v, nv, startV);
  const size_t keys = surface.keys.size(), width = linesU.size();
  std::vector<std::vector<V3d>> global(keys);  // every crossing of lines once
  for (size_t k = 0; k < keys; ++k)
    for (const Line& y : linesV)
      for (const Line& x : linesU)
        global[k].push_back(surface.at(k, surface.u.spans()[x.span], x.s, surface.v.spans()[y.span], y.s));
  for (size_t j = 0; j < nv.size(); ++j)
    for (size_t i = 0; i < nu.size(); ++i) {
      const Axis::Span &a = surface.u.spans()[i], &b = surface.v.spans()[j];
      const uint32_t first = out.count(), columns = uint32_t(nu[i] + 1);
      for (int y = 0; y <= nv[j]; ++y)
        for (int x = 0; x <= nu[i]; ++x) {
          const PiecePlace place{&a, &b, x == nu[i] ? 1.0 : double(x) / nu[i], y == nv[j] ? 1.0 : double(y) / nv[j]};
          for (size_t k = 0; k < keys; ++k)
            out.add(surface, place, k, global[k][size_t(startV[j] + y) * width + size_t(startU[i] + x)]);
          out.add(place, mesh);
        }
      for (int y = 0; y < nv[j]; ++y)
        for (int x = 0; x < nu[i]; ++x) {
          const uint32_t p = first + uint32_t(y) * columns + uint32_t(x), q = p + 1, r = q + columns, s = p + columns;
          for (const auto& t : {std::array{p, q, r}, std::array{p, r, s}})
            out.addTriangle(t, uint32_t(b.cell * surface.u.cells() + a.cell), mesh);
        }
    }
}

// The same of what trim curves leave: vertices where they are used alone. A place that several pieces share is
// computed once.
class TrimmedGrids {
 public:
  TrimmedGrids(const TensorSurface& surface, Pieces& out, Mesh& mesh) : surface_(surface), out_(out), mesh_(mesh) {}

  void make(const TrimmedCells& cells, const std::vector<double>& linesU, const std::vector<double>& linesV,
            const std::vector<int>& nu, const std::vector<int>& nv) {
    const size_t columns = linesU.size() - 1;
    size_t startV = 0;
    for (size_t j = 0; j < nv.size(); startV += size_t(nv[j]), ++j) {
      size_t startU = 0;
      for (size_t i = 0; i < nu.size(); startU += size_t(nu[i]), ++i) {
        a_ = &surface_.u.spans()[i];
        b_ = &surface_.v.spans()[j];
        vertexAt_.clear();
        const uint32_t face = uint32_t(b_->cell * surface_.u.cells() + a_->cell);
        for (size_t y = startV; y < startV + size_t(nv[j]); ++y)
          for (size_t x = startU; x < startU + size_t(nu[i]); ++x) {
            const size_t cell = y * columns + x;
            if (cells.kind[cell] == TrimmedCells::Whole) {
              const uint32_t p = vertex({linesU[x], linesV[y]}), q = vertex({linesU[x + 1], linesV[y]}),
                             r = vertex({linesU[x + 1], linesV[y + 1]}), s = vertex({linesU[x], linesV[y + 1]});
              if (!follows(p, q, r, face)) {
                out_.addTriangle({p, q, r}, face, mesh_);
                out_.addTriangle({p, r, s}, face, mesh_);
              } else {
                out_.addTriangle({r, s, p}, face, mesh_);
                out_.addTriangle({r, p, q}, face, mesh_);
              }
            } else if (cells.kind[cell] == TrimmedCells::Cut) {
              for (size_t t = cells.first[cell]; t < cells.first[cell + 1]; ++t) {
                const uint32_t p = vertex(cells.triangles[3 * t]), q = vertex(cells.triangles[3 * t + 1]),
                               r = vertex(cells.triangles[3 * t + 2]);
                out_.addTriangle(follows(p, q, r, face) ? std::array{q, r, p} : std::array{p, q, r}, face, mesh_);
              }
            }
          }
      }
    }
  }

 private:
  struct Bits {
    size_t operator()(const std::pair<double, double>& p) const {
      const uint64_t a = std::bit_cast<uint64_t>(p.first), b = std::bit_cast<uint64_t>(p.second);
      return size_t((a * 0x9e3779b97f4a7c15u) ^ ((b * 0xc2b2ae3d27d4eb4fu) >> 7) ^ (a >> 29));
    }
  };
  using Places = std::unordered_map<std::pair<double, double>, uint32_t, Bits>;

  // Whether this triangle would pass for the other half of a quad that the last one begins: see Mesh::quads.
  bool follows(uint32_t p, uint32_t q, uint32_t, uint32_t face) const {
    const std::vector<uint32_t>& at = mesh_.indices;
    return at.size() >= 3 && at[at.size() - 3] == p && at[at.size() - 1] == q && mesh_.faceOfTriangle.back() == face;
  }

  uint32_t vertex(const Imath::V2d& uv) {
    const auto [it, isNew] = vertexAt_.try_emplace({uv.x, uv.y}, out_.count());
    if (!isNew) return it->second;
    const auto part = [](double x, double from, double to) { return x == to ? 1.0 : (x - from) / (to - from); };
    const PiecePlace place{a_, b_, part(uv.x, a_->u0, a_->u1), part(uv.y, b_->u0, b_->u1)};
    const auto [known, isFirst] = firstAt_.try_emplace({uv.x, uv.y}, out_.count());
    for (size_t k = 0; k < surface_.keys.size(); ++k)
      out_.add(surface_, place, k,
               isFirst ? surface_.at(k, *a_, place.s, *b_, place.t) : V3d(out_.points[k][known->second]));
    out_.add(place, mesh_);
    return it->second;
  }

  const TensorSurface& surface_;
  Pieces& out_;
  Mesh& mesh_;
  const Axis::Span *a_ = nullptr, *b_ = nullptr;
  Places vertexAt_;  // of the current piece
  Places firstAt_;   // of any
};

// The lines of all grids along one axis, 0 to 1.
std::vector<double> parametersOf(const Axis& axis, const std::vector<int>& segments) {
  std::vector<double> out;
  for (size_t i = 0; i < segments.size(); ++i)
    for (int k = 0; k < segments[i]; ++k) {
      const Axis::Span& span = axis.spans()[i];
      out.push_back(span.u0 + (span.u1 - span.u0) * k / segments[i]);
    }
  out.push_back(axis.spans().back().u1);
  return out;
}

// Cuts the grids along trim curves; false where nothing is left. `nu` and `nv` rise to what suits the curves.
bool makeTrimmed(const scene::Primitive& primitive, const TensorSurface& surface, const Trim& trim,
                 std::vector<int>& nu, std::vector<int>& nv, Pieces& out, Diagnostics& diagnostics, Mesh& mesh) {
  // cells that a few segments pass: more make long thin triangles, and places are rounded to parts of a cell
  size_t segments = 0;
  for (const auto& loop : trim.loops) segments += loop.size();
  constexpr double kLeastLines = 16, kMostLines = 256;
  const double least = std::clamp(2 * std::sqrt(double(segments)), kLeastLines, kMostLines);
  for (auto [axis, count] : {std::pair(&surface.u, &nu), std::pair(&surface.v, &nv)})
    for (size_t i = 0; i < count->size(); ++i) {
      const Axis::Span& span = axis->spans()[i];
      (*count)[i] = std::max((*count)[i], int(std::ceil(least * (span.u1 - span.u0))));
    }
  const std::vector<double> linesU = parametersOf(surface.u, nu), linesV = parametersOf(surface.v, nv);
  const TrimmedCells cells = trimCells(trim.loops, trim.keepInside, linesU, linesV);
  if (cells.tooMuch) {
    diagnostics.warning("GEOM-TRIM", primitive.pos,
                        "trim curves of " + subject(primitive) + " cross the surface too often to be followed",
                        "the whole surface is rendered");
    makeGrids(surface, nu, nv, out, mesh);
    return true;
  }
  if (cells.crosses)
    diagnostics.warning("GEOM-TRIM-CROSSING", primitive.pos, "trim curves of " + subject(primitive) + " cross",
                        "what they surround an odd number of times counts as inside");
  TrimmedGrids(surface, out, mesh).make(cells, linesU, linesV, nu, nv);
  if (mesh.indices.empty())
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, "trim curves of " + subject(primitive) + " leave nothing",
                        "the primitive is left out", "see Attribute \"trimcurve\" \"sense\"");
  return !mesh.indices.empty();
}

}  // namespace

bool makePatches(const scene::Primitive& primitive, const DiceRate& rate, Diagnostics& diagnostics, Mesh& mesh) {
  const std::optional<PointKeys> points = readPoints(primitive, diagnostics);
  if (!points) return false;
  auto refuse = [&](const char* code, const std::string& what) {
    diagnostics.error(code, primitive.pos, subject(primitive) + " has " + what, "the primitive is left out");
    return false;
  };
  for (size_t k = 0; k < points->keys.size(); ++k)  // a weight of 0 is legal here, unlike where points are projected
    for (const V4d& p : homogeneousPoints(primitive, k))
      if (!std::isfinite(p.x + p.y + p.z + p.w)) return refuse("GEOM-NOT-FINITE", "points that are not finite");
  TensorSurface surface;
  const std::string wrong = describe(primitive, points->count, surface);
  if (!wrong.empty()) return refuse("GEOM-PATCH-SHAPE", wrong);
  const size_t needed = size_t(surface.u.controls()) * size_t(surface.v.controls());
  for (size_t k = 0; k < points->keys.size(); ++k) surface.keys.push_back(homogeneousPoints(primitive, k));
  for (size_t k = 0; k < surface.keys.size(); ++k) {
    const scene::ParameterList& said = k == 0 ? primitive.primvars : primitive.motion[k - 1];
    surface.rational.push_back(said.find("Pw") != nullptr);
    if (surface.keys[k].size() < needed) {  // this key says nothing about the points
      surface.keys[k] = surface.keys[0];
      surface.rational[k] = surface.rational[0];
    }
  }

  std::vector<int> nu, nv;
  const size_t cells = size_t(surface.u.cells()) * surface.v.cells(), keys = surface.keys.size();
  const ClassCounts counts{cells, size_t(surface.u.varyings()) * surface.v.varyings(), needed, 4 * cells};
  const std::vector<SourcePrimvar> primvars = readPrimvars(primitive, counts, diagnostics);
  chooseRates(surface, primvars, rate, nu, nv);
  Trim trim;
  if (const auto* n = std::get_if<scene::NuPatch>(&primitive.shape))
    trim = readTrim(primitive, *n, surface, rate, diagnostics);
  Pieces pieces(keys);
  if (trim.loops.empty())
    makeGrids(surface, nu, nv, pieces, mesh);
  else if (!makeTrimmed(primitive, surface, trim, nu, nv, pieces, diagnostics, mesh))
    return false;
  std::vector<V3d> all;
  for (const auto& key : pieces.points) all.insert(all.end(), key.begin(), key.end());
  for (const V3d& p : all)
    if (!std::isfinite(p.x + p.y + p.z)) return refuse("GEOM-NOT-FINITE", "weights that make it infinite");
  if (keys > 1) mesh.times = points->times;
  mesh.quads = true;
  storePoints(all, keys, mesh);
  double area = 0;
  for (uint32_t t = 0; t < mesh.triangleCount(); ++t) area += geometricNormal(mesh, t).length();
  if (!(area > 0)) {
    diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no area",
                        "the primitive is left out");
    return false;
  }

  for (const SourcePrimvar& s : primvars) {
    const bool constant = s.storage == scene::StorageClass::Constant,
               uniform = s.storage == scene::StorageClass::Uniform;
    Primvar p = emptyPrimvar(s, constant || (uniform && cells == 1) ? Primvar::Rate::Constant
                                : uniform                           ? Primvar::Rate::PerFace
                                                                    : Primvar::Rate::PerVertex);
    if (constant || uniform)
      p.data = s.values;
    else
      for (const PiecePlace& place : pieces.places) interpolate(surface, s, place, p.data);
    mesh.primvars.push_back(std::move(p));
  }
  repairNormals(primitive, mesh, diagnostics);
  if (!mesh.find("N")) {
    Primvar n = Primvar::normals();
    for (const auto& key : pieces.normals)
      for (const V3d& v : key)
        for (int c = 0; c < 3; ++c) n.data.push_back(float(mesh.flipNormals ? -v[c] : v[c]));
    mesh.primvars.push_back(std::move(n));
  }
  joinTextureCoordinates(mesh);
  applyTextureCoordinates(primitive, mesh);
  return true;
}

}  // namespace kinora::geometry
