// Curves as pieces that are traced as they are: linear ones as they come, cubic ones of any basis as Bezier pieces.
// Curves that keep their shape but have no length, or whose vertices do not fit their basis, are left out.
#include <array>
#include <cmath>

#include "geometry/makers.h"
#include "geometry/strand.h"

namespace kinora::geometry {

using Imath::V3d;

namespace {

// Bezier control points as mixtures of the four control points of a basis: row-major. With p(s) = a3 s^3 + a2 s^2 +
// a1 s
// + a0 they are a0, a0 + a1/3, a0 + 2 a1/3 + a2/3 and a0 + a1 + a2 + a3.
using Conversion = std::array<std::array<double, 4>, 4>;
Conversion toBezier(const std::array<float, 16>& basis) {
  Conversion out;
  for (size_t k = 0; k < 4; ++k) {
    const double a3 = basis[k], a2 = basis[4 + k], a1 = basis[8 + k], a0 = basis[12 + k];
    out[0][k] = a0;
    out[1][k] = a0 + a1 / 3;
    out[2][k] = a0 + 2 * a1 / 3 + a2 / 3;
    out[3][k] = a0 + a1 + a2 + a3;
  }
  for (auto& row : out)
    for (double& w : row)
      if (std::abs(w - std::round(w)) < 1e-6) w = std::round(w);  // 1/6 and the like come as rounded numbers
  return out;
}

// Whether a piece ends where the next one begins, whatever the control points are.
bool endsMeet(const Conversion& c, int step) {
  for (int k = 0; k < 4; ++k) {
    const double next = k >= step ? c[0][size_t(k - step)] : 0;
    if (std::abs(c[3][size_t(k)] - next) > 1e-6) return false;
  }
  for (int k = std::max(0, 4 - step); k < 4; ++k)
    if (std::abs(c[0][size_t(k)]) > 1e-6) return false;
  return true;
}

// Pieces of a curve of n vertices; 0 when they do not fit.
size_t piecesOf(int n, bool cubic, bool periodic, int step) {
  if (!cubic) return periodic ? (n >= 3 ? size_t(n) : 0) : n >= 2 ? size_t(n - 1) : 0;
  if (periodic) return n >= step && n >= 1 && n % step == 0 ? size_t(n / step) : 0;
  return n >= 4 && (n - 4) % step == 0 ? size_t((n - 4) / step + 1) : 0;
}

// A tangent that vanishes at an end (control points drawn together to pin a curve) leaves the width without a
// direction there: moves the inner control points a little way along the curve.
void openTangents(std::array<V3d, 4>& b, bool& changed) {
  const double atFirst = (b[1] - b[0]).length(), between = (b[2] - b[1]).length(), atLast = (b[3] - b[2]).length();
  const double length = atFirst + between + atLast;
  constexpr double kLeast = 1e-4, kNudge = 0.01;
  const bool first = atFirst < kLeast * length, last = atLast < kLeast * length;
  if (!first && !last) return;
  changed = true;
  const std::array<V3d, 4> old = b;
  const auto far = [&](const V3d& from, const V3d& inner, const V3d& end) {
    return (inner - from).length() < kLeast * length ? end - from : inner - from;
  };
  if (first) b[1] = old[0] + far(old[0], old[2], old[3]) * kNudge;
  if (last) b[2] = old[3] + far(old[3], old[1], old[0]) * kNudge;
}

// Curves seen thinner than `pixels` get that width, and a ray sees them the more seldom: a row of pixels then sees a thin
// curve in every one of them, and the mean of what it sees stays. Radii at all keys grow by the factor of the first.
void widen(const DiceRate& rate, double pixels, Mesh& mesh) {
  mesh.own.assign(mesh.vertexCount, 1.f);
  bool widened = false;
  for (uint32_t v = 0; v < mesh.vertexCount; ++v) {
    Imath::V4f& s = mesh.spine[v];
    const double pixel = rate.at(mesh.origin + V3d(s.x, s.y, s.z)) / rate.pixelsPerEdge, least = 0.5 * pixels * pixel;
    if (!std::isfinite(least) || !(double(s.w) < least)) continue;
    const double radius = double(s.w);
    mesh.own[v] = float(radius / least);
    for (size_t key = 0; key < size_t(mesh.keyCount()); ++key) {
      float& r = mesh.spine[key * mesh.vertexCount + v].w;
      r = radius > 0 ? float(double(r) * (least / radius)) : float(least);
    }
    widened = true;
  }
  if (!widened) std::vector<float>().swap(mesh.own);
}

}  // namespace

bool makeCurves(const scene::Primitive& primitive, const scene::Curves& shape, const DiceRate& rate,
                Diagnostics& diagnostics, Mesh& mesh) {
  const std::optional<PointKeys> points = readPoints(primitive, diagnostics);
  if (!points) return false;
  static const scene::Attributes kDefaults;
  const scene::Attributes& attributes = primitive.attributes ? *primitive.attributes : kDefaults;
  const int step = std::max(1, attributes.vStep);

  ClassCounts counts{shape.verticesPerCurve.size(), 0, 0, 0};
  size_t misfits = 0, firstMisfit = 0, total = 0, totalPieces = 0;
  for (size_t i = 0; i < shape.verticesPerCurve.size(); ++i) {
    const int n = shape.verticesPerCurve[i];
    const size_t pieces = piecesOf(n, shape.cubic, shape.periodic, step);
    if (!pieces && !misfits++) firstMisfit = i;
    totalPieces += pieces;
    counts.varying += pieces + (shape.periodic ? 0 : 1);
    total += size_t(std::max(0, n));
  }
  counts.vertex = total;
  counts.faceVarying = counts.varying;
  const auto refuse = [&](const char* code, const std::string& what) {
    diagnostics.error(code, primitive.pos, subject(primitive) + what, "the primitive is left out");
    return false;
  };
  if (total > points->count || total == 0)
    return refuse("GEOM-CURVE-COUNT", " names " + std::to_string(total) + " vertices and has " +
                                          std::to_string(points->count) + " points");
  if (misfits)
    diagnostics.warning("GEOM-CURVE-COUNT", primitive.pos,
                        std::to_string(misfits) + " curves of " + subject(primitive) + " have vertices that " +
                            (shape.cubic ? "the step " + std::to_string(step) + " of their basis does not fit"
                                         : std::string("make no line")) +
                            "; the first is curve " + std::to_string(firstMisfit) + " with " +
                            std::to_string(shape.verticesPerCurve[firstMisfit]),
                        "these curves are left out");

  const StrandSources sources(primitive, *points, counts, diagnostics);
  // dice:roundcurve says tube (1) or ribbon (0); without it curves with N are ribbons and others tubes (rib.md 7.5)
  const int round = attributes.getInt("dice:roundcurve", -1);
  const bool oriented = sources.hasNormals() && round != 1, tube = !oriented && round != 0;
  using Kind = Mesh::Kind;
  mesh.kind = oriented      ? Kind::OrientedRibbon
              : shape.cubic ? (tube ? Kind::CubicTube : Kind::CubicRibbon)
                            : (tube ? Kind::LinearTube : Kind::LinearRibbon);
  const bool cubic = mesh.isCubic();  // oriented ribbons are traced as cubic pieces
  const Conversion conversion =
      shape.cubic ? toBezier(attributes.vBasis)
                  : Conversion{{{1, 0, 0, 0}, {2.0 / 3, 1.0 / 3, 0, 0}, {1.0 / 3, 2.0 / 3, 0, 0}, {0, 1, 0, 0}}};
  const bool shares = !shape.cubic || endsMeet(conversion, step);

  const int count = cubic ? 4 : 2;
  const size_t stepOf = shape.cubic ? size_t(step) : 1;
  // A curve by where its values begin.
  struct CurvePlace {
    size_t curve = 0, vertex = 0, varying = 0, vertices = 0, pieces = 0, varyings = 0;
  };
  const auto enter = [&](CurvePlace& at) {
    at.vertices = size_t(std::max(0, shape.verticesPerCurve[at.curve]));
    at.pieces = piecesOf(int(at.vertices), shape.cubic, shape.periodic, step);
    at.varyings = at.pieces + (shape.periodic ? 0 : 1);
  };
  const auto advance = [&](CurvePlace& at) {
    at.vertex += at.vertices;
    at.varying += at.varyings;
    ++at.curve;
  };
  // Curves that close come back to their beginning; of the others no place is beyond the last.
  const auto within = [](size_t i, size_t n) { return i < n ? i : i % n; };
  const auto controlOf = [&](const CurvePlace& at, size_t piece, int k) {
    ControlSource x;
    x.curve = uint32_t(at.curve);
    x.between = float(k) / float(count - 1);
    for (size_t e = 0; e < 2; ++e) x.varying[e] = uint32_t(at.varying + within(piece + e, at.varyings));
    if (x.between == 1) {
      x.varying[0] = x.varying[1];
      x.between = 0;
    }
    if (cubic)
      for (size_t m = 0; m < 4; ++m) {
        x.vertex[m] = uint32_t(at.vertex + within(piece * stepOf + m, at.vertices));
        x.weight[m] = float(conversion[size_t(k)][m]);
      }
    else {
      x.vertex[0] = uint32_t(at.vertex + within(piece + size_t(k), at.vertices));
      x.weight[0] = 1;
    }
    return x;
  };

  mesh.indices.reserve(totalPieces);
  mesh.faceOfTriangle.reserve(totalPieces);
  mesh.along.reserve(totalPieces);
  std::vector<std::pair<uint32_t, std::vector<std::array<V3d, 4>>>> opened;  // first control, Bezier points by key
  std::vector<std::array<V3d, 4>> byKey(sources.keys());                     // of the piece being made
  size_t controls = 0, noLength = 0, notFinite = 0;
  for (CurvePlace at; at.curve < shape.verticesPerCurve.size(); advance(at)) {
    enter(at);
    bool bad = false;
    for (size_t v = 0; v < at.vertices && at.pieces; ++v) bad |= !sources.finite(uint32_t(at.vertex + v));
    bool joined = false, has = false;  // joined: the last control counted is where the next piece begins
    for (size_t piece = 0; piece < at.pieces && !bad; ++piece) {
      std::array<ControlSource, 4> c;
      for (int k = 0; k < count; ++k) c[size_t(k)] = controlOf(at, piece, k);
      bool length = false, width = false, open = false;
      const bool share = joined && shares;  // the first control is there already
      Imath::Box3d bounds;
      for (size_t key = 0; key < sources.keys(); ++key) {
        std::array<V3d, 4>& b = byKey[key];
        for (int k = 0; k < count; ++k) {
          b[size_t(k)] = sources.position(key, c[size_t(k)]);
          length |= Imath::V3f(b[size_t(k)]) != Imath::V3f(b[0]);
          const double radius = sources.radius(key, c[size_t(k)]);
          width |= radius > 0;
          if (share && k == 0) continue;
          bounds.extendBy(b[size_t(k)] - V3d(radius));
          bounds.extendBy(b[size_t(k)] + V3d(radius));
        }
        if (cubic) openTangents(b, open);
      }
      has |= length;
      if (!length || !width) {
        joined = false;
        continue;
      }
      mesh.bounds.extendBy(bounds);
      mesh.indices.push_back(uint32_t(controls - (share ? 1 : 0)));
      mesh.faceOfTriangle.push_back(uint32_t(at.curve));
      mesh.along.emplace_back(float(double(piece) / double(at.pieces)), float(double(piece + 1) / double(at.pieces)));
      if (open) opened.emplace_back(mesh.indices.back(), byKey);
      controls += size_t(count) - (share ? 1 : 0);
      joined = true;
    }
    notFinite += bad;
    noLength += at.pieces && !bad && !has;
  }
  if (notFinite)
    diagnostics.error(
        "GEOM-NOT-FINITE", primitive.pos,
        std::to_string(notFinite) + " curves of " + subject(primitive) + " have points that are not finite",
        "these curves are left out");
  if (noLength)
    diagnostics.warning("GEOM-CURVE-LENGTH", primitive.pos,
                        std::to_string(noLength) + " curves of " + subject(primitive) + " have no length",
                        "these curves are left out");
  if (mesh.indices.empty()) {
    if (!misfits && !notFinite && !noLength)
      diagnostics.warning("GEOM-ZERO-AREA", primitive.pos, subject(primitive) + " has no width",
                          "the primitive is left out");
    return false;
  }
  const auto walk = [&](const StrandSources::Visit& visit) {
    CurvePlace at;
    enter(at);
    uint32_t seen = 0;
    for (size_t p = 0; p < mesh.indices.size(); ++p) {
      while (at.curve < mesh.faceOfTriangle[p]) {
        advance(at);
        enter(at);
      }
      const auto piece = size_t(std::lround(double(mesh.along[p].x) * double(at.pieces)));
      std::array<ControlSource, 4> made;
      int n = 0;
      for (int k = int(seen - mesh.indices[p]); k < count; ++k) made[size_t(n++)] = controlOf(at, piece, k);
      visit({made.data(), size_t(n)});
      seen = mesh.indices[p] + uint32_t(count);
    }
  };
  sources.store(controls, walk, mesh);
  for (const auto& [first, byKey] : opened)
    for (size_t key = 0; key < byKey.size(); ++key)
      for (uint32_t k = 1; k < 3; ++k) {
        const Imath::V3f p(byKey[key][k] - mesh.origin);
        Imath::V4f& s = mesh.spine[key * mesh.vertexCount + first + k];
        s = Imath::V4f(p.x, p.y, p.z, s.w);
      }
  if (const double pixels = attributes.named.getFloat("hair:minwidth", 0); pixels > 0) widen(rate, pixels, mesh);
  return true;
}

}  // namespace kinora::geometry
