#include "geometry/winding_fill.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kinora::geometry {

using Imath::V3d;

namespace {

constexpr size_t kMostEdges = 512, kMostLevels = 1024;

class SlabFiller {
 public:
  SlabFiller(std::span<const V3d> corners, std::span<const int> loops, WindingFill& out)
      : corners_(corners), loops_(loops), out_(out) {}

  bool run() {
    if (corners_.size() > kMostEdges || !project()) return false;
    makeEdges();
    if (!makeLevels()) return false;
    for (size_t k = 0; k + 1 < levels_.size(); ++k) fillSlab(k);
    for (const Trapezoid& t : open_) close(t, levels_.size() - 1);
    return !out_.triangles.empty();
  }

 private:
  struct Edge {
    uint32_t from, to;  // corners, the lower one first
    double x0, y0, x1, y1;
    int up;  // 1: the loop goes up here; -1: down
    size_t loop;
    double xAt(double y) const { return x0 + (x1 - x0) * shareAt(y); }
    double shareAt(double y) const { return std::clamp((y - y0) / (y1 - y0), 0.0, 1.0); }
  };
  struct Trapezoid {
    uint32_t left, right;  // edges
    size_t bottom;         // level
  };

  // Along the axis on which the outer loop is largest. One that goes round as much to the left as to the right faces
  // as its largest corner does.
  bool project() {
    V3d sum(0), largest(0);
    const size_t n = size_t(loops_[0]);
    for (size_t i = 1; i + 1 < n; ++i) {
      const V3d c = (corners_[i] - corners_[0]).cross(corners_[i + 1] - corners_[0]);
      sum += c;
      if (c.length2() > largest.length2()) largest = c;
    }
    const V3d normal = sum.length2() > 1e-12 * largest.length2() ? sum : largest;
    const V3d size(std::abs(normal.x), std::abs(normal.y), std::abs(normal.z));
    const int drop = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    if (!(size[drop] > 0) || !std::isfinite(size[drop])) return false;
    int axisX = (drop + 1) % 3, axisY = (drop + 2) % 3;
    if (normal[drop] < 0) std::swap(axisX, axisY);
    for (const V3d& c : corners_) {
      x_.push_back(c[axisX] - corners_[0][axisX]);
      y_.push_back(c[axisY] - corners_[0][axisY]);
    }
    const auto [low, high] = std::minmax_element(x_.begin(), x_.end());
    least_ = 1e-12 * (*high - *low);
    return true;
  }

  // Level ones bound no slab from the side.
  void makeEdges() {
    uint32_t first = 0;
    for (size_t l = 0; l < loops_.size(); ++l) {
      const auto n = uint32_t(loops_[l]);
      for (uint32_t i = 0; i < n; ++i) {
        uint32_t a = first + i, b = first + (i + 1) % n;
        if (y_[a] == y_[b]) continue;
        const int up = y_[a] < y_[b] ? 1 : -1;
        if (up < 0) std::swap(a, b);
        edges_.push_back({a, b, x_[a], y_[a], x_[b], y_[b], up, l});
      }
      first += n;
    }
  }

  // Heights between which edges do not cross: those of corners and of crossings.
  bool makeLevels() {
    levels_ = y_;
    for (size_t i = 0; i < edges_.size(); ++i)
      for (size_t j = 0; j < i; ++j) {
        const Edge &a = edges_[i], &b = edges_[j];
        const double low = std::max(a.y0, b.y0), high = std::min(a.y1, b.y1);
        if (!(low < high)) continue;
        const double before = a.xAt(low) - b.xAt(low), after = a.xAt(high) - b.xAt(high);
        if (!((before < 0 && after > 0) || (before > 0 && after < 0))) continue;
        levels_.push_back(low + (high - low) * (before / (before - after)));
        if (levels_.size() > 16 * kMostLevels) return false;
      }
    std::sort(levels_.begin(), levels_.end());
    // crossings of several edges in one place are a rounding apart
    const double least = 1e-12 * (levels_.back() - levels_.front());
    levels_.erase(std::unique(levels_.begin(), levels_.end(), [&](double a, double b) { return b - a <= least; }),
                  levels_.end());
    return levels_.size() <= kMostLevels;
  }

  void fillSlab(size_t level) {
    const double middle = 0.5 * (levels_[level] + levels_[level + 1]);
    std::vector<std::pair<double, uint32_t>> across;
    for (uint32_t e = 0; e < edges_.size(); ++e)
      if (edges_[e].y0 < middle && edges_[e].y1 > middle) across.emplace_back(edges_[e].xAt(middle), e);
    std::sort(across.begin(), across.end());
    std::vector<int> turns(loops_.size(), 0);
    size_t holes = 0;  // that are gone round here
    bool isInside = false;
    uint32_t left = 0;
    std::vector<Trapezoid> next;
    for (const auto& [x, e] : across) {
      int& turn = turns[edges_[e].loop];
      const bool was = turn != 0;
      turn += edges_[e].up;
      if (edges_[e].loop > 0 && was != (turn != 0)) was ? --holes : ++holes;
      const bool isNow = turns[0] != 0 && holes == 0;
      if (isNow && !isInside) left = e;
      if (!isNow && isInside) {
        // what goes on between the same edges is one
        const auto same = std::find_if(open_.begin(), open_.end(),
                                       [&](const Trapezoid& t) { return t.left == left && t.right == e; });
        next.push_back({left, e, same == open_.end() ? level : same->bottom});
        if (same != open_.end()) open_.erase(same);
      }
      isInside = isNow;
    }
    for (const Trapezoid& t : open_) close(t, level);
    open_ = std::move(next);
  }

  void close(const Trapezoid& t, size_t top) {
    const uint32_t a = pointAt(t.left, t.bottom), b = pointAt(t.right, t.bottom), c = pointAt(t.right, top),
                   d = pointAt(t.left, top);
    const double y0 = levels_[t.bottom], y1 = levels_[top];
    const bool isWideBelow = a != b && edges_[t.right].xAt(y0) - edges_[t.left].xAt(y0) > least_,
               isWideAbove = c != d && edges_[t.right].xAt(y1) - edges_[t.left].xAt(y1) > least_;
    if (isWideBelow) out_.triangles.insert(out_.triangles.end(), {a, b, c});
    if (isWideAbove) out_.triangles.insert(out_.triangles.end(), {a, c, d});
  }

  // One for each corner, and for each edge and level.
  uint32_t pointAt(uint32_t edge, size_t level) {
    const Edge& e = edges_[edge];
    const double share = e.shareAt(levels_[level]);
    EdgePoint p{e.from, e.to, share};
    if (share < 1e-9) p = {e.from, e.from, 0};
    if (share > 1 - 1e-9) p = {e.to, e.to, 0};
    const auto key = p.from == p.to ? std::pair(p.from, ~size_t(0)) : std::pair(edge, level);
    const auto [it, isNew] = known_.try_emplace(key, uint32_t(out_.points.size()));
    if (isNew) out_.points.push_back(p);
    return it->second;
  }

  std::span<const V3d> corners_;
  std::span<const int> loops_;
  WindingFill& out_;
  std::vector<double> x_, y_, levels_;
  double least_ = 0;  // width of what is a point
  std::vector<Edge> edges_;
  std::vector<Trapezoid> open_;  // that reach the level above the last slab
  std::map<std::pair<uint32_t, size_t>, uint32_t> known_;
};

}  // namespace

bool fillByWinding(std::span<const V3d> corners, std::span<const int> loopSizes, WindingFill& out) {
  out.points.clear();
  out.triangles.clear();
  if (loopSizes.empty() || loopSizes[0] < 3) return false;
  if (SlabFiller(corners, loopSizes, out).run()) return true;
  out.points.clear();
  out.triangles.clear();
  return false;
}

}  // namespace kinora::geometry
