// Patch, PatchMesh and NuPatch as tensor products of two Axis. Every piece gets its own grid, so that normals and
// primvars may break between pieces; positions on shared lines are computed once and copied, so that nothing cracks.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/axis.h"
#include "geometry/build.h"
#include "geometry/dice.h"
#include "geometry/makers.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V4d;

namespace {

constexpr int kMostPatchSegments = 1024;  // a piece

struct ParametricSurface {
  Axis u, v;
  std::vector<std::vector<V4d>> keys;  // homogeneous control points, u fastest
  std::vector<char> rational;          // by key: the points have weights ("Pw")

  V3d at(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t, V3d* du = nullptr,
         V3d* dv = nullptr) const {
    double wu[64], wv[64], su[64], sv[64];
    u.weights(a, s, wu, su);
    v.weights(b, t, wv, sv);
    V4d p(0), pu(0), pv(0);
    for (int j = 0; j < v.order(); ++j) {
      const V4d* row = &keys[key][size_t(v.control(b, j)) * u.controls()];
      for (int i = 0; i < u.order(); ++i) {
        const V4d& c = row[u.control(a, i)];
        p += c * (wu[i] * wv[j]);
        pu += c * (su[i] * wv[j]);
        pv += c * (wu[i] * sv[j]);
      }
    }
    if (!rational[key]) {
      // the weights of a basis need not sum to one: tangents and coefficients are no points
      if (du) *du = V3d(pu.x, pu.y, pu.z);
      if (dv) *dv = V3d(pv.x, pv.y, pv.z);
      return V3d(p.x, p.y, p.z);
    }
    const V3d point = V3d(p.x, p.y, p.z) / p.w;
    if (du) *du = (V3d(pu.x, pu.y, pu.z) - point * pu.w) / p.w;
    if (dv) *dv = (V3d(pv.x, pv.y, pv.z) - point * pv.w) / p.w;
    return point;
  }
  // Unit dPdu x dPdv; where it vanishes (a side drawn together to a point), its limit from inside the piece.
  V3d normal(size_t key, const Axis::Span& a, double s, const Axis::Span& b, double t) const {
    for (double inward : {0.0, 1e-4, 1e-3, 1e-2, 0.1}) {
      V3d du, dv;
      at(key, a, s + (0.5 - s) * inward, b, t + (0.5 - t) * inward, &du, &dv);
      const V3d n = du.cross(dv);
      if (n.length() > 1e-9 * (du.length2() + dv.length2())) return n.normalized();
    }
    return V3d(0, 0, 1);
  }
};

std::string describe(const scene::Primitive& primitive, size_t pointCount, ParametricSurface& out) {
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

// One vertex of one piece, for interpolating primvars.
struct Place {
  const Axis::Span *a, *b;
  double s, t;
};

void interpolate(const ParametricSurface& surface, const SourcePrimvar& source, const Place& place,
                 std::vector<float>& out) {
  const int width = int(source.parameter->elementFloats());
  const Axis &u = surface.u, &v = surface.v;
  auto value = [&](int element, int k) { return double(source.values[size_t(element) * width + k]); };
  if (source.storage == scene::StorageClass::Vertex) {
    double wu[64], wv[64], unused[64];
    u.weights(*place.a, place.s, wu, unused);
    v.weights(*place.b, place.t, wv, unused);
    for (int k = 0; k < width; ++k) {
      double sum = 0;
      for (int j = 0; j < v.order(); ++j)
        for (int i = 0; i < u.order(); ++i)
          sum += wu[i] * wv[j] * value(v.control(*place.b, j) * u.controls() + u.control(*place.a, i), k);
      out.push_back(float(sum));
    }
    return;
  }
  // Bilinear over the cell that the piece is a part of.
  const double x = place.a->cell0 + (place.a->cell1 - place.a->cell0) * place.s;
  const double y = place.b->cell0 + (place.b->cell1 - place.b->cell0) * place.t;
  int corner[4];
  for (int c = 0; c < 4; ++c)
    corner[c] = source.storage == scene::StorageClass::Varying
                    ? v.varying(place.b->cell, c / 2) * u.varyings() + u.varying(place.a->cell, c % 2)
                    : 4 * (place.b->cell * u.cells() + place.a->cell) + c;
  for (int k = 0; k < width; ++k)
    out.push_back(float((1 - y) * ((1 - x) * value(corner[0], k) + x * value(corner[1], k)) +
                        y * ((1 - x) * value(corner[2], k) + x * value(corner[3], k))));
}

// Points, normals and values along a line of a piece.
struct Sample {
  V3d p, n;
  std::vector<float> values;
};

// By how much they miss the straight way from the first to the last: see segmentsForPlace().
double missOf(const std::vector<const Sample*>& line, double length, const std::vector<double>& range) {
  double most = 0;
  const Sample &first = *line.front(), &last = *line.back();
  for (size_t a = 1; a + 1 < line.size(); ++a) {
    const double t = double(a) / double(line.size() - 1);
    V3d off = line[a]->p - (first.p * (1 - t) + last.p * t);
    off -= line[a]->n * off.dot(line[a]->n);
    if (length > 0) most = std::max(most, off.length() / length);
    for (size_t c = 0; c < line[a]->values.size(); ++c)
      if (range[c] > 0)
        most = std::max(most,
                        std::abs(line[a]->values[c] - (first.values[c] * (1 - t) + last.values[c] * t)) / range[c]);
  }
  return most;
}

// Segments of each span of both axes: the finest that any piece along it asks for.
void chooseRates(const scene::Primitive& primitive, const ParametricSurface& s,
                 const std::vector<SourcePrimvar>& primvars, const DiceRate& rate, std::vector<int>& nu,
                 std::vector<int>& nv) {
  // only those of class vertex follow the basis; others are bilinear anyway
  std::vector<const SourcePrimvar*> curved;
  std::vector<double> range;
  for (const SourcePrimvar& v : primvars) {
    if (v.storage != scene::StorageClass::Vertex || v.values.empty()) continue;
    curved.push_back(&v);
    const size_t width = v.parameter->elementFloats();
    for (size_t c = 0; c < width; ++c) {
      float low = v.values[c], high = low;
      for (size_t i = c; i < v.values.size(); i += width) {
        low = std::min(low, v.values[i]);
        high = std::max(high, v.values[i]);
      }
      range.push_back(double(high) - double(low));
    }
  }
  const bool displaced = primitive.attributes && primitive.attributes->displacement;
  std::vector<double> wantU(s.u.spans().size(), 1), wantV(s.v.spans().size(), 1);
  constexpr int kSamples = 4;
  for (size_t key = 0; key < s.keys.size(); key += std::max<size_t>(1, s.keys.size() - 1))  // first and last
    for (size_t j = 0; j < wantV.size(); ++j)
      for (size_t i = 0; i < wantU.size(); ++i) {
        Sample at[kSamples + 1][kSamples + 1];
        double edge = std::numeric_limits<double>::infinity();
        for (int b = 0; b <= kSamples; ++b)
          for (int a = 0; a <= kSamples; ++a) {
            const double x = double(a) / kSamples, y = double(b) / kSamples;
            Sample& here = at[b][a];
            here.p = s.at(key, s.u.spans()[i], x, s.v.spans()[j], y);
            here.n = s.normal(key, s.u.spans()[i], x, s.v.spans()[j], y);
            for (const SourcePrimvar* v : curved)
              interpolate(s, *v, {&s.u.spans()[i], &s.v.spans()[j], x, y}, here.values);
            if (a % 2 == 0 && b % 2 == 0) edge = std::min(edge, rate.at(here.p));
          }
        for (int b = 0; b <= kSamples; ++b) {
          double lengthU = 0, turnU = 0, lengthV = 0, turnV = 0;
          std::vector<const Sample*> alongU, alongV;
          for (int a = 0; a <= kSamples; ++a) {
            alongU.push_back(&at[b][a]);
            alongV.push_back(&at[a][b]);
            if (a == kSamples) break;
            lengthU += (at[b][a + 1].p - at[b][a].p).length();
            turnU += turnBetween(at[b][a].n, at[b][a + 1].n);
            lengthV += (at[a + 1][b].p - at[a][b].p).length();
            turnV += turnBetween(at[a][b].n, at[a + 1][b].n);
          }
          wantU[i] = std::max({wantU[i], segmentsFor(lengthU, turnU, edge, displaced),
                               segmentsForPlace(missOf(alongU, lengthU, range), lengthU, edge)});
          wantV[j] = std::max({wantV[j], segmentsFor(lengthV, turnV, edge, displaced),
                               segmentsForPlace(missOf(alongV, lengthV, range), lengthV, edge)});
        }
      }
  for (double scale = 1;; scale *= 0.8) {
    double u = 0, v = 0;
    bool least = true;
    auto round = [&](const std::vector<double>& want, std::vector<int>& out, double& sum) {
      out.clear();
      for (double w : want) {
        out.push_back(int(std::ceil(std::clamp(w * scale - 1e-6, 1.0, double(kMostPatchSegments)))));
        sum += out.back();
        least &= out.back() == 1;
      }
    };
    round(wantU, nu, u);
    round(wantV, nv, v);
    if (least || 2 * u * v <= rate.maxTriangles) return;
  }
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
  ParametricSurface surface;
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
  if (const auto* n = std::get_if<scene::NuPatch>(&primitive.shape); n && !n->trim.empty())
    diagnostics.warning("GEOM-TRIM", primitive.pos,
                        subject(primitive) + " has trim curves, which are not rendered yet",
                        "the whole surface is rendered");

  std::vector<int> nu, nv, startU, startV;
  const size_t cells = size_t(surface.u.cells()) * surface.v.cells();
  const ClassCounts counts{cells, size_t(surface.u.varyings()) * surface.v.varyings(), needed, 4 * cells};
  const std::vector<SourcePrimvar> primvars = readPrimvars(primitive, counts, diagnostics);
  chooseRates(primitive, surface, primvars, rate, nu, nv);
  const std::vector<Line> linesU = linesOf(surface.u, nu, startU), linesV = linesOf(surface.v, nv, startV);
  const size_t keys = surface.keys.size(), width = linesU.size();
  std::vector<std::vector<V3d>> global(keys);  // every crossing of lines once
  for (size_t k = 0; k < keys; ++k)
    for (const Line& y : linesV)
      for (const Line& x : linesU)
        global[k].push_back(surface.at(k, surface.u.spans()[x.span], x.s, surface.v.spans()[y.span], y.s));

  std::vector<std::vector<V3d>> out(keys), normals(keys);
  std::vector<Place> places;
  for (size_t j = 0; j < nv.size(); ++j)
    for (size_t i = 0; i < nu.size(); ++i) {
      const Axis::Span &a = surface.u.spans()[i], &b = surface.v.spans()[j];
      const uint32_t first = uint32_t(out[0].size()), columns = uint32_t(nu[i] + 1);
      for (int y = 0; y <= nv[j]; ++y)
        for (int x = 0; x <= nu[i]; ++x) {
          const double s = x == nu[i] ? 1.0 : double(x) / nu[i], t = y == nv[j] ? 1.0 : double(y) / nv[j];
          for (size_t k = 0; k < keys; ++k) {
            out[k].push_back(global[k][size_t(startV[j] + y) * width + size_t(startU[i] + x)]);
            normals[k].push_back(surface.normal(k, a, s, b, t));
          }
          places.push_back({&a, &b, s, t});
          mesh.vertexUV.emplace_back(float(a.u0 + (a.u1 - a.u0) * s), float(b.u0 + (b.u1 - b.u0) * t));
        }
      for (int y = 0; y < nv[j]; ++y)
        for (int x = 0; x < nu[i]; ++x) {
          const uint32_t p = first + uint32_t(y) * columns + uint32_t(x), q = p + 1, r = q + columns, s = p + columns;
          for (const auto& t : {std::array{p, q, r}, std::array{p, r, s}}) {
            // Sides drawn together to a point leave triangles without area.
            const auto& o = out[0];
            if (keys == 1 && (o[t[0]] == o[t[1]] || o[t[1]] == o[t[2]] || o[t[2]] == o[t[0]])) continue;
            mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
            mesh.faceOfTriangle.push_back(uint32_t(b.cell * surface.u.cells() + a.cell));
          }
        }
    }
  std::vector<V3d> all;
  for (const auto& key : out) all.insert(all.end(), key.begin(), key.end());
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
      for (const Place& place : places) interpolate(surface, s, place, p.data);
    mesh.primvars.push_back(std::move(p));
  }
  repairNormals(primitive, mesh, diagnostics);
  if (!mesh.find("N")) {
    Primvar n;
    n.name = "N";
    n.type = scene::ValueType::Normal;
    n.width = 3;
    n.rate = Primvar::Rate::PerVertex;
    for (const auto& key : normals)
      for (const V3d& v : key)
        for (int c = 0; c < 3; ++c) n.data.push_back(float(mesh.flipNormals ? -v[c] : v[c]));
    mesh.primvars.push_back(std::move(n));
  }
  joinTextureCoordinates(mesh);
  applyTextureCoordinates(primitive, mesh);
  return true;
}

}  // namespace kinora::geometry
