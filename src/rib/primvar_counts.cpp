#include "rib/primvar_counts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace kinora::rib {

using namespace scene;

size_t PrimvarCounts::of(StorageClass c) const {
  switch (c) {
    case StorageClass::Constant:
      return 1;
    case StorageClass::Uniform:
      return uniform;
    case StorageClass::Varying:
      return varying;
    case StorageClass::Vertex:
      return vertex;
    default:
      return faceVarying;
  }
}

namespace {

// Sum of counts; negative when one of them is below `least`.
int64_t sum(const std::vector<int>& counts, int least) {
  int64_t total = 0;
  for (const int n : counts) {
    if (n < least) return -1;
    total += n;
  }
  return total;
}

std::string checkIndices(const std::vector<int>& indices, size_t positions) {
  for (const int v : indices)
    if (v < 0 || size_t(v) >= positions)
      return "has the vertex index " + std::to_string(v) + " and " + std::to_string(positions) + " points";
  return {};
}

size_t largest(const std::vector<int>& indices) {
  int m = -1;
  for (const int v : indices) m = std::max(m, v);
  return size_t(m + 1);
}

// Segments of a row of control points; -1 when the row has no whole number of them.
int64_t segments(int64_t n, bool cubic, bool periodic, int step) {
  if (!cubic) return periodic ? (n >= 3 ? n : -1) : n >= 2 ? n - 1 : -1;
  if (periodic) return n >= 4 || (n > 0 && n % step == 0 && n >= step) ? (n % step == 0 ? n / step : -1) : -1;
  return n >= 4 && (n - 4) % step == 0 ? (n - 4) / step + 1 : -1;
}

struct Check {
  size_t positions;
  std::string operator()(const Quadric& q) const {
    for (const float a : q.args)
      if (!std::isfinite(a)) return "has an argument that is no finite number";
    return {};
  }
  std::string operator()(const PolygonMesh& m) const {
    const int64_t corners = sum(m.verticesPerLoop, 3);
    if (m.verticesPerLoop.empty()) return "has no face";
    if (corners < 0) return "has a face or hole of fewer than 3 vertices";
    if (!m.loopsPerFace.empty()) {
      const int64_t loops = sum(m.loopsPerFace, 1);
      if (loops < 0) return "has a face without a loop";
      if (size_t(loops) != m.verticesPerLoop.size())
        return "names " + std::to_string(loops) + " loops and gives " + std::to_string(m.verticesPerLoop.size());
    }
    if (m.vertices.empty()) {
      if (size_t(corners) > positions)
        return "needs " + std::to_string(corners) + " points and has " + std::to_string(positions);
      return {};
    }
    if (size_t(corners) != m.vertices.size())
      return "names " + std::to_string(corners) + " corners and gives " + std::to_string(m.vertices.size()) +
             " indices";
    return checkIndices(m.vertices, positions);
  }
  std::string operator()(const SubdivisionMesh& m) const {
    if (m.verticesPerFace.empty()) return "has no face";
    const int64_t corners = sum(m.verticesPerFace, 3);
    if (corners < 0) return "has a face of fewer than 3 vertices";
    if (size_t(corners) != m.vertices.size())
      return "names " + std::to_string(corners) + " corners and gives " + std::to_string(m.vertices.size()) +
             " indices";
    if (m.scheme == "loop" && size_t(corners) != 3 * m.verticesPerFace.size())
      return "has the scheme loop and a face that is no triangle";
    return checkIndices(m.vertices, positions);
  }
  std::string operator()(const scene::Curves& c) const {
    const int64_t total = sum(c.verticesPerCurve, 1);
    if (c.verticesPerCurve.empty()) return "has no curve";
    if (total < 0) return "has a curve without vertices";
    if (size_t(total) != positions)
      return "names " + std::to_string(total) + " vertices and has " + std::to_string(positions) + " points";
    return {};
  }
  std::string operator()(const Points&) const { return positions == 0 ? "has no point" : std::string(); }
  std::string operator()(const Patch& p) const {
    const size_t wanted = p.bicubic ? 16 : 4;
    if (positions != wanted)
      return "needs " + std::to_string(wanted) + " points and has " + std::to_string(positions);
    return {};
  }
  std::string operator()(const PatchMesh& p) const {
    if (p.nu < 1 || p.nv < 1) return "has a size below 1";
    if (uint64_t(p.nu) * uint64_t(p.nv) != positions)
      return "needs " + std::to_string(uint64_t(p.nu) * uint64_t(p.nv)) + " points and has " +
             std::to_string(positions);
    return {};
  }
  std::string operator()(const NuPatch& p) const {
    const auto knots = [](const std::vector<float>& k, int n, int order) {
      if (k.size() != size_t(n) + size_t(order)) return false;
      for (size_t i = 0; i < k.size(); ++i)
        if (!std::isfinite(k[i]) || (i > 0 && k[i] < k[i - 1])) return false;
      return true;
    };
    constexpr int kMostOrder = 64;
    if (p.uOrder < 2 || p.vOrder < 2 || p.uOrder > kMostOrder || p.vOrder > kMostOrder)
      return "has an order outside 2 to 64";
    if (p.nu < p.uOrder || p.nv < p.vOrder) return "has fewer points than its order";
    if (!knots(p.uKnots, p.nu, p.uOrder) || !knots(p.vKnots, p.nv, p.vOrder))
      return "has knots that are not n + order increasing numbers";
    if (!(p.uMin < p.uMax) || !(p.vMin < p.vMax)) return "has an empty parameter range";
    if (uint64_t(p.nu) * uint64_t(p.nv) != positions)
      return "needs " + std::to_string(uint64_t(p.nu) * uint64_t(p.nv)) + " points and has " +
             std::to_string(positions);
    return {};
  }
  std::string operator()(const OtherPrimitive&) const { return {}; }
};

}  // namespace

std::string checkShape(const Shape& shape, size_t positions) { return std::visit(Check{positions}, shape); }

PrimvarCounts countsOf(const Shape& shape, size_t positions, const Attributes& attributes) {
  PrimvarCounts c;
  const auto mesh = [&](size_t faces, size_t corners, const std::vector<int>& vertices) {
    const size_t n = vertices.empty() ? corners : largest(vertices);
    c = {faces, n, n, corners, std::max(n, positions)};
  };
  if (const auto* m = std::get_if<PolygonMesh>(&shape)) {
    const size_t corners = size_t(std::max<int64_t>(0, sum(m->verticesPerLoop, 0)));
    mesh(m->loopsPerFace.empty() ? m->verticesPerLoop.size() : m->loopsPerFace.size(), corners, m->vertices);
  } else if (const auto* s = std::get_if<SubdivisionMesh>(&shape)) {
    mesh(s->verticesPerFace.size(), s->vertices.size(), s->vertices);
  } else if (const auto* k = std::get_if<scene::Curves>(&shape)) {
    size_t varying = 0;
    for (const int n : k->verticesPerCurve) {
      const int64_t segs = segments(n, k->cubic, k->periodic, attributes.vStep);
      varying += size_t(std::max<int64_t>(segs, 0)) + (k->periodic ? 0 : 1);
    }
    c = {k->verticesPerCurve.size(), varying, positions, varying, 0};
  } else if (std::get_if<Points>(&shape)) {
    c = {1, positions, positions, positions, 0};
  } else if (const auto* p = std::get_if<Patch>(&shape)) {
    c.vertex = p->bicubic ? 16 : 4;
  } else if (const auto* g = std::get_if<PatchMesh>(&shape)) {
    const int64_t nu = std::max<int64_t>(0, segments(g->nu, g->bicubic, g->uPeriodic, attributes.uStep));
    const int64_t nv = std::max<int64_t>(0, segments(g->nv, g->bicubic, g->vPeriodic, attributes.vStep));
    c = {size_t(nu * nv), size_t((nu + !g->uPeriodic) * (nv + !g->vPeriodic)), positions, size_t(4 * nu * nv), 0};
  } else if (const auto* n = std::get_if<NuPatch>(&shape)) {
    const size_t su = size_t(1 + n->nu - n->uOrder), sv = size_t(1 + n->nv - n->vOrder);
    c = {su * sv, (su + 1) * (sv + 1), positions, 4 * su * sv, 0};
  }
  return c;
}

}  // namespace kinora::rib
