#include "geometry/grade.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

#include "geometry/facets.h"
#include "geometry/points_in_space.h"
#include "geometry/refine.h"
#include "geometry/vertex_means.h"

namespace kinora::geometry {

using Imath::V2f;
using Imath::V3d;

namespace {

// Grids follow rates that differ by less (see Refiner::findEdges); pieces of a face that is cut have less by far.
constexpr double kMostRatio = 64, kMostRatioOfPiece = 4;
constexpr size_t kMostCells = 1'000'000;

struct Cell {
  uint32_t v[4];
  V2f uv[4];
  uint32_t face;
  int n;
};

class Grader {
 public:
  Grader(const Mesh& mesh, const DiceRate& rate) : base_(mesh), rate_(rate), means_(out_) {
    Imath::Box3d bounds;
    for (const Imath::V3f& p : mesh.points) bounds.extendBy(V3d(p));
    leastRadius_ = 1e-6 * bounds.size().length();
    for (uint32_t t = 0; t < mesh.triangleCount();) {
      const bool isQuad = mesh.quadOf(t) == t;
      Cell c;
      c.n = isQuad ? 4 : 3;
      c.face = mesh.faceOf(t);
      for (int k = 0; k < c.n; ++k) {
        c.v[k] = mesh.indices[isQuad ? Mesh::quadCorner(t, k) : 3 * size_t(t) + size_t(k)];
        c.uv[k] = k == 3 ? mesh.uvOf(t + 1, 2) : mesh.uvOf(t, k);
      }
      cells_.push_back(c);
      t += isQuad ? 2 : 1;
    }
  }
  bool isNeeded() const {
    return std::any_of(cells_.begin(), cells_.end(), [&](const Cell& c) { return isTooUneven(base_, c); });
  }
  Mesh run() {
    const PointsInSpace places(base_);
    place_ = places.ofVertex;
    nextPlace_ = places.count;
    out_ = verticesOf(base_);
    std::vector<Cell> waiting;
    for (Cell& c : std::exchange(cells_, {})) (isTooUneven(out_, c) ? waiting : cells_).push_back(c);
    while (!waiting.empty() && cells_.size() + waiting.size() < kMostCells && !rate_.isStopped()) {
      std::vector<Cell> parts;
      for (const Cell& c : waiting) split(c, parts);
      waiting.clear();
      for (const Cell& c : parts) (isUneven(out_, c, kMostRatioOfPiece) ? waiting : cells_).push_back(c);
    }
    cells_.insert(cells_.end(), waiting.begin(), waiting.end());
    balance();
    for (const Cell& c : cells_) emit(c);
    out_.points.reserve(out_.points.size() + 2);  // for Embree, see trace/world.cpp
    return std::move(out_);
  }

 private:
  V3d at(const Mesh& mesh, uint32_t v) const { return V3d(mesh.points[v]) + mesh.origin; }
  // Whether micropolygons of the cell may be of lengths that differ by more than `ratio`. They are the same wherever
  // the cell is smaller than they are.
  bool isUneven(const Mesh& mesh, const Cell& c, double ratio) const {
    V3d middle(0);
    for (int k = 0; k < c.n; ++k) middle += at(mesh, c.v[k]) / c.n;
    double radius = 0;
    for (int k = 0; k < c.n; ++k) radius = std::max(radius, (at(mesh, c.v[k]) - middle).length());
    const double here = rate_.at(middle), change = rate_.slope * radius;
    if (!std::isfinite(here) || !std::isfinite(change)) return false;
    const double least = std::max(here - change, rate_.least);
    return here + change > ratio * least && radius > kLeastSteps * least && radius > leastRadius_;
  }
  // Whether a grid on the whole cell could not follow its rates.
  bool isTooUneven(const Mesh& mesh, const Cell& c) const {
    if (!isUneven(mesh, c, kMostRatio)) return false;
    double least = INFINITY, most = 0, size = 0;
    for (int k = 0; k < c.n; ++k) size = std::max(size, (at(mesh, c.v[(k + 1) % c.n]) - at(mesh, c.v[k])).length());
    for (int j = 0; j <= kSteps; ++j)
      for (int i = 0; i <= (c.n == 4 ? kSteps : kSteps - j); ++i) {
        const double s = double(i) / kSteps, t = double(j) / kSteps;
        const V3d a = at(mesh, c.v[0]), b = at(mesh, c.v[1]), d = at(mesh, c.v[c.n - 1]);
        const V3d p = c.n == 4 ? (a * (1 - s) + b * s) * (1 - t) + (d * (1 - s) + at(mesh, c.v[2]) * s) * t
                               : a * (1 - s - t) + b * s + d * t;
        const double here = rate_.at(p);
        least = std::min(least, here);
        most = std::max(most, here);
      }
    // as little as it may be between two of these places
    return most > kMostRatio * std::max({least - 0.75 * rate_.slope * size / kSteps, rate_.least, 0.0});
  }
  // between two vertices, with the place that all have who cut this edge
  uint32_t middleOf(uint32_t a, uint32_t b) {
    const uint32_t v = means_.between(a, b);
    if (v < place_.size()) return v;
    const auto [it, isNew] = cut_.try_emplace(pairOf(place_[a], place_[b]), nextPlace_);
    if (isNew) ++nextPlace_;
    place_.push_back(it->second);
    return v;
  }
  uint32_t centreOf(const Cell& c) {
    const uint32_t v = means_.of(c.v, c.n);
    place_.push_back(nextPlace_++);
    return v;
  }
  static V2f meanOf(const Cell& c) {
    V2f sum(0);
    for (int k = 0; k < c.n; ++k) sum += c.uv[k] / float(c.n);
    return sum;
  }
  void split(const Cell& c, std::vector<Cell>& into) {
    uint32_t m[4];
    V2f uv[4];
    for (int k = 0; k < c.n; ++k) {
      m[k] = middleOf(c.v[k], c.v[(k + 1) % c.n]);
      uv[k] = (c.uv[k] + c.uv[(k + 1) % c.n]) * 0.5f;
    }
    if (c.n == 3) {
      for (int k = 0; k < 3; ++k)
        into.push_back({{c.v[k], m[k], m[(k + 2) % 3], 0}, {c.uv[k], uv[k], uv[(k + 2) % 3], V2f(0)}, c.face, 3});
      into.push_back({{m[0], m[1], m[2], 0}, {uv[0], uv[1], uv[2], V2f(0)}, c.face, 3});
      return;
    }
    // corner k of each stays corner k, so that what runs along u and v does so in all
    const uint32_t centre = centreOf(c);
    const V2f uvCentre = meanOf(c);
    for (int k = 0; k < 4; ++k) {
      const int next = (k + 1) % 4, far = (k + 2) % 4, before = (k + 3) % 4;
      Cell part;
      part.v[k] = c.v[k], part.v[next] = m[k], part.v[far] = centre, part.v[before] = m[before];
      part.uv[k] = c.uv[k], part.uv[next] = uv[k], part.uv[far] = uvCentre, part.uv[before] = uv[before];
      part.face = c.face;
      part.n = 4;
      into.push_back(part);
    }
  }
  // The place in the middle of an edge, ~0 where it is not cut.
  uint32_t cutOf(uint32_t a, uint32_t b) const {
    const auto it = cut_.find(pairOf(a, b));
    return it == cut_.end() ? ~0u : it->second;
  }
  // Cuts what has a neighbour that is cut twice.
  void balance() {
    for (bool isDone = false; !isDone && !rate_.isStopped();) {
      isDone = true;
      std::vector<Cell> next;
      next.reserve(cells_.size());
      for (const Cell& c : cells_) {
        bool isTwice = false;
        for (int k = 0; k < c.n && !isTwice; ++k) {
          const uint32_t a = place_[c.v[k]], b = place_[c.v[(k + 1) % c.n]], m = cutOf(a, b);
          isTwice = m != ~0u && (cutOf(a, m) != ~0u || cutOf(m, b) != ~0u);
        }
        if (isTwice) {
          split(c, next);
          isDone = false;
        } else {
          next.push_back(c);
        }
      }
      cells_ = std::move(next);
    }
  }
  void emit(const Cell& c) {
    uint32_t outline[8];
    V2f uv[8];
    int count = 0;
    for (int k = 0; k < c.n; ++k) {
      const int next = (k + 1) % c.n;
      outline[count] = c.v[k];
      uv[count++] = c.uv[k];
      if (cutOf(place_[c.v[k]], place_[c.v[next]]) == ~0u) continue;
      outline[count] = middleOf(c.v[k], c.v[next]);
      uv[count++] = (c.uv[k] + c.uv[next]) * 0.5f;
    }
    if (count == c.n) {
      std::array<uint32_t, 4> v{};
      std::array<V2f, 4> place;
      for (int k = 0; k < c.n; ++k) v[size_t(k)] = c.v[k], place[size_t(k)] = c.uv[k];
      appendFacet(out_, c.face, v, place, c.n);
      return;
    }
    const uint32_t centre = centreOf(c);
    const V2f uvCentre = meanOf(c);
    for (int i = 0; i < count; ++i) {
      const int next = (i + 1) % count;
      appendFacet(out_, c.face, {outline[i], outline[next], centre, 0}, {uv[i], uv[next], uvCentre, V2f(0)}, 3);
    }
  }

  static constexpr int kSteps = 16;
  static constexpr double kLeastSteps = 8;  // a cell that is no larger is one grid
  const Mesh& base_;
  const DiceRate& rate_;
  Mesh out_;
  VertexMeans means_;
  std::vector<Cell> cells_;
  std::vector<uint32_t> place_;  // of vertices, as PointsInSpace has it
  uint32_t nextPlace_ = 0;
  double leastRadius_ = 0;                      // where the eye touches the surface there would be no end
  std::unordered_map<uint64_t, uint32_t> cut_;  // pairs of places -> the one between
};

}  // namespace

std::optional<Mesh> graded(const Mesh& mesh, const DiceRate& rate) {
  if (!(rate.slope > 0) || mesh.keyCount() > 1 || mesh.isStrand() || !mesh.triangleCount()) return {};
  if (!Grader(mesh, rate).isNeeded()) return {};
  const Mesh plain = refined(mesh, DiceRate());  // not cut: primvars by vertex
  return Grader(plain, rate).run();
}

}  // namespace kinora::geometry
