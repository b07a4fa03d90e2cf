#include "geometry/triangulate.h"

#include <algorithm>
#include <cmath>

namespace kinora::geometry {

using Imath::V3d;

// Twice the signed area. The coordinates are floats widened to double, less the first corner: differences are exact
// and the sign is right but for pathological cases, which the fallbacks of clip() survive.
double Triangulator::turn(int a, int b, int c) const {
  const Node &p = nodes_[a], &q = nodes_[b], &r = nodes_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

// Picks the two axes on which the outer loop is largest and runs counter-clockwise.
bool Triangulator::project(std::span<const V3d> corners, int outerSize) {
  base_ = corners[0];
  V3d n(0);
  for (int i = 1; i + 1 < outerSize; ++i) n += (corners[i] - base_).cross(corners[i + 1] - base_);
  const V3d size(std::abs(n.x), std::abs(n.y), std::abs(n.z));
  const int drop = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  if (!(size[drop] > 0) || !std::isfinite(size[drop])) return false;
  axisX_ = (drop + 1) % 3;
  axisY_ = (drop + 2) % 3;
  if (n[drop] < 0) std::swap(axisX_, axisY_);
  return true;
}

// Links a loop so that the outer one runs counter-clockwise and holes clockwise; returns one of its nodes, or -1.
int Triangulator::addLoop(std::span<const V3d> corners, int first, int size, bool hole) {
  const int begin = int(nodes_.size());
  double area = 0;
  for (int i = 0; i < size; ++i) {
    const V3d p = corners[first + i] - base_, q = corners[first + (i + 1) % size] - base_;
    area += p[axisX_] * q[axisY_] - p[axisY_] * q[axisX_];
  }
  if (hole && area == 0) return -1;
  const bool backwards = hole && area > 0;
  for (int i = 0; i < size; ++i) {
    const int corner = first + (backwards ? size - 1 - i : i);
    const V3d p = corners[corner] - base_;
    nodes_.push_back({p[axisX_], p[axisY_], uint32_t(corner), begin + (i + size - 1) % size, begin + (i + 1) % size});
  }
  return begin;
}

void Triangulator::unlink(int node) {
  nodes_[nodes_[node].prev].next = nodes_[node].next;
  nodes_[nodes_[node].next].prev = nodes_[node].prev;
}

// Joins a hole to the ring of `outer`; `hole` is its rightmost node. Returns false when the hole lies outside.
bool Triangulator::bridge(int outer, int hole, int holeSize) {
  // A hole that touches the ring in a corner is joined there: any other bridge would cut the face in two.
  int i = hole;
  for (int k = 0; k < holeSize; ++k, i = nodes_[i].next) {
    const auto found = ring_.find({nodes_[i].x, nodes_[i].y});
    if (found == ring_.end()) continue;
    splice(openCorner(outer, found->second, nodes_[i].next), i);
    return true;
  }
  // D. Eberly, "Triangulation by ear clipping", 2002, section 3: the first edge to the right, then the corner inside
  // the triangle between that edge and the ray which is seen under the least angle.
  const Node m = nodes_[hole];
  double bestX = INFINITY;
  int target = -1;
  i = outer;
  do {
    ++work_;
    const Node &a = nodes_[i], &b = nodes_[a.next];
    if (a.y <= m.y && b.y >= m.y && a.y != b.y) {
      const double x = a.x + (m.y - a.y) * (b.x - a.x) / (b.y - a.y);
      if (x >= m.x && x < bestX) {
        bestX = x;
        target = b.y == m.y ? a.next : a.y == m.y ? i : a.x > b.x ? i : a.next;
      }
    }
    i = a.next;
  } while (i != outer);
  if (target < 0) return false;

  const double tx = nodes_[target].x, ty = nodes_[target].y;
  if (!(tx == bestX && ty == m.y)) {
    double bestSlope = INFINITY, bestDistance = INFINITY;
    const int first = target;
    i = outer;
    do {
      ++work_;
      const Node& p = nodes_[i];
      const double dx = p.x - m.x, dy = std::abs(p.y - m.y);
      if (i != first && dx > 0 && p.x <= tx && turnAt(i) <= 0) {
        // Inside (m, (bestX, m.y), target): on target's side of the ray, below the line m-target, left of the edge.
        const double side = ty > m.y ? 1 : -1;
        const bool inside = (p.y - m.y) * side >= 0 && ((tx - m.x) * (p.y - m.y) - (ty - m.y) * dx) * side <= 0 &&
                            ((tx - bestX) * (p.y - m.y) - (ty - m.y) * (p.x - bestX)) * side >= 0;
        const double slope = dy / dx;
        if (inside && (slope < bestSlope || (slope == bestSlope && dx < bestDistance))) {
          bestSlope = slope;
          bestDistance = dx;
          target = i;
        }
      }
      i = p.next;
    } while (i != outer);
  }
  splice(openCorner(outer, target, hole), hole);
  return true;
}

// Several ring nodes may lie at one place since earlier bridges ended there: the one whose corner opens towards
// `seen`.
int Triangulator::openCorner(int outer, int at, int seen) {
  int i = outer;
  do {
    ++work_;
    if (same(i, at)) {
      const int p = nodes_[i].prev, n = nodes_[i].next;
      const bool left = turn(p, i, seen) > 0, right = turn(i, n, seen) > 0;
      if (turn(p, i, n) > 0 ? left && right : left || right) return i;
    }
    i = nodes_[i].next;
  } while (i != outer);
  return at;
}

// target -> hole -> ... -> second hole node -> second target node -> what followed target
void Triangulator::splice(int target, int hole) {
  int i = hole;
  do {
    ring_.try_emplace({nodes_[i].x, nodes_[i].y}, i);
    i = nodes_[i].next;
  } while (i != hole);
  const int target2 = int(nodes_.size()), hole2 = target2 + 1;
  nodes_.push_back(nodes_[target]);
  nodes_.push_back(nodes_[hole]);
  const int after = nodes_[target].next, beforeHole = nodes_[hole].prev;
  nodes_[target].next = hole;
  nodes_[hole].prev = target;
  nodes_[beforeHole].next = hole2;
  nodes_[hole2].prev = beforeHole;
  nodes_[hole2].next = target2;
  nodes_[target2].prev = hole2;
  nodes_[target2].next = after;
  nodes_[after].prev = target2;
}

void Triangulator::buildGrid(int start, int count) {
  blockers_.clear();
  minX_ = minY_ = INFINITY;
  double maxX = -INFINITY, maxY = -INFINITY;
  int i = start;
  do {
    Node& n = nodes_[i];
    minX_ = std::min(minX_, n.x), maxX = std::max(maxX, n.x);
    minY_ = std::min(minY_, n.y), maxY = std::max(maxY, n.y);
    n.blocker = !(turnAt(i) > 0);
    if (n.blocker) blockers_.push_back(i);
    i = n.next;
  } while (i != start);
  cellsX_ = cellsY_ = 0;
  if (count <= 64 || blockers_.size() <= 32) return;
  // About one blocker a cell, cells as square as the bounds allow.
  const double w = std::max(maxX - minX_, 1e-300), h = std::max(maxY - minY_, 1e-300), n = double(blockers_.size());
  cellsX_ = int(std::clamp(std::sqrt(n * w / h), 1.0, 4096.0));
  cellsY_ = int(std::clamp(n / cellsX_, 1.0, 4096.0));
  perX_ = cellsX_ / w;
  perY_ = cellsY_ / h;
  auto cell = [&](const Node& p) {
    return std::min(cellsY_ - 1, int((p.y - minY_) * perY_)) * cellsX_ +
           std::min(cellsX_ - 1, int((p.x - minX_) * perX_));
  };
  cellStart_.assign(size_t(cellsX_) * cellsY_ + 1, 0);
  for (int b : blockers_) ++cellStart_[cell(nodes_[b]) + 1];
  for (size_t c = 1; c < cellStart_.size(); ++c) cellStart_[c] += cellStart_[c - 1];
  cellNodes_.resize(blockers_.size());
  std::vector<int> fill(cellStart_.begin(), cellStart_.end() - 1);
  for (int b : blockers_) cellNodes_[fill[cell(nodes_[b])]++] = b;
}

bool Triangulator::isEar(int node, bool strict) {
  const int a = nodes_[node].prev, c = nodes_[node].next;
  const Node &pa = nodes_[a], &pb = nodes_[node], &pc = nodes_[c];
  auto blocks = [&](int p) {
    ++work_;
    const Node& q = nodes_[p];
    if (!q.blocker || p == a || p == node || p == c || same(p, a) || same(p, node) || same(p, c)) return false;
    const double s = turn(a, node, p), t = turn(node, c, p), u = turn(c, a, p);
    return strict ? s > 0 && t > 0 && u > 0 : s >= 0 && t >= 0 && u >= 0;
  };
  if (cellsX_ == 0) {
    for (int p : blockers_)
      if (blocks(p)) return false;
    return true;
  }
  const double x0 = std::min({pa.x, pb.x, pc.x}), x1 = std::max({pa.x, pb.x, pc.x});
  const double y0 = std::min({pa.y, pb.y, pc.y}), y1 = std::max({pa.y, pb.y, pc.y});
  const int i0 = std::min(cellsX_ - 1, int((x0 - minX_) * perX_)),
            i1 = std::min(cellsX_ - 1, int((x1 - minX_) * perX_));
  const int j0 = std::min(cellsY_ - 1, int((y0 - minY_) * perY_)),
            j1 = std::min(cellsY_ - 1, int((y1 - minY_) * perY_));
  for (int j = j0; j <= j1; ++j) {
    work_ += i1 - i0 + 1;
    for (int k = cellStart_[j * cellsX_ + i0]; k < cellStart_[j * cellsX_ + i1 + 1]; ++k)
      if (blocks(cellNodes_[k])) return false;
  }
  return true;
}

// Returns false when an ear had to be forced.
bool Triangulator::clip(int start, int left, std::vector<uint32_t>& triangles) {
  buildGrid(start, left);
  bool clean = true;
  int node = start, tried = 0, mode = 0;  // 0: closed test, 1: open test, 2: any convex corner, 3: any corner
  while (left >= 3) {
    if (work_ > workLimit_) mode = std::max(mode, 2);
    const int a = nodes_[node].prev, c = nodes_[node].next;
    const double area = turn(a, node, c);
    bool remove = false, emit = false;
    if (area == 0 && (same(a, node) || same(node, c) || same(a, c))) {
      remove = true;  // a doubled corner or a spike: encloses nothing
    } else if (area > 0 && (mode >= 2 || isEar(node, mode == 1))) {
      remove = emit = true;
      clean &= mode < 2;
    } else if (area < 0 && mode == 3) {
      remove = emit = true;
      clean = false;
    }
    if (!remove) {
      node = c;
      if (++tried < left) continue;
      tried = 0;
      if (++mode > 3) break;  // what is left lies on a line
      continue;
    }
    if (emit) {
      const uint32_t ia = nodes_[a].corner, ib = nodes_[node].corner, ic = nodes_[c].corner;
      if (area > 0)
        triangles.insert(triangles.end(), {ia, ib, ic});
      else
        triangles.insert(triangles.end(), {ia, ic, ib});
    }
    unlink(node);
    nodes_[node].blocker = false;
    --left;
    for (int k : {a, c})
      if (nodes_[k].blocker && turnAt(k) > 0) nodes_[k].blocker = false;
    node = emit ? nodes_[c].next : c;  // leave one corner out: fewer slivers than a fan
    tried = 0;
    if (work_ <= workLimit_) mode = 0;
  }
  return clean;
}

Triangulator::Outcome Triangulator::run(std::span<const V3d> corners, std::span<const int> loopSizes,
                                        std::vector<uint32_t>& triangles) {
  const size_t firstTriangle = triangles.size();
  nodes_.clear();
  nodes_.reserve(corners.size() + 2 * loopSizes.size());
  if (loopSizes.empty() || loopSizes[0] < 3 || !project(corners, loopSizes[0])) return Outcome::NoArea;
  const double n = double(corners.size());
  work_ = 0;
  workLimit_ = int64_t(400 * n * std::log2(n + 2) + 1e6);
  const int outer = addLoop(corners, 0, loopSizes[0], false);
  int count = loopSizes[0];
  bool clean = true;

  if (loopSizes.size() == 1) {
    bool convex = true;
    // A star polygon turns left everywhere too, but goes round twice: x then changes direction more than twice.
    int flips = 0, last = 0, firstSign = 0;
    for (int i = 0; i < count && convex; ++i) {
      convex = turnAt(i) > 0;
      const double dx = nodes_[nodes_[i].next].x - nodes_[i].x;
      const int s = dx > 0 ? 1 : dx < 0 ? -1 : 0;
      if (s != 0) {
        if (last == 0)
          firstSign = s;
        else
          flips += s != last;
        last = s;
      }
    }
    flips += last != firstSign;
    if (convex && flips <= 2) {
      for (int i = 1; i + 1 < count; ++i) triangles.insert(triangles.end(), {0u, uint32_t(i), uint32_t(i + 1)});
      return Outcome::Good;
    }
  } else {
    std::vector<int> holes;
    for (size_t l = 1, first = size_t(loopSizes[0]); l < loopSizes.size(); first += size_t(loopSizes[l]), ++l) {
      if (loopSizes[l] < 3) continue;
      const int begin = addLoop(corners, int(first), loopSizes[l], true);
      if (begin < 0) continue;
      int rightmost = begin;
      for (int i = begin; i < begin + loopSizes[l]; ++i)
        if (nodes_[i].x > nodes_[rightmost].x ||
            (nodes_[i].x == nodes_[rightmost].x && nodes_[i].y < nodes_[rightmost].y))
          rightmost = i;
      holes.push_back(rightmost);
    }
    std::stable_sort(holes.begin(), holes.end(), [&](int a, int b) { return nodes_[a].x > nodes_[b].x; });
    ring_.clear();
    for (int k = 0; k < loopSizes[0]; ++k) ring_.try_emplace({nodes_[k].x, nodes_[k].y}, k);
    for (int hole : holes) {
      int size = 0, i = hole;
      do ++size, i = nodes_[i].next;
      while (i != hole);
      // Bridges cost holes x corners; the limit is some seconds.
      if (work_ < workLimit_ + int64_t(2e9) && bridge(outer, hole, size))
        count += size + 2;
      else
        clean = false;
    }
    work_ = 0;
  }

  double expected = 0;
  int i = outer;
  do {
    const Node &p = nodes_[i], &q = nodes_[p.next];
    expected += p.x * q.y - p.y * q.x;
    i = p.next;
  } while (i != outer);
  clean &= clip(outer, count, triangles);
  double covered = 0;
  for (size_t t = firstTriangle; t < triangles.size(); t += 3) {
    auto at = [&](size_t k) {
      const V3d p = corners[triangles[t + k]] - base_;
      return std::pair(p[axisX_], p[axisY_]);
    };
    const auto [ax, ay] = at(0);
    const auto [bx, by] = at(1);
    const auto [cx, cy] = at(2);
    covered += (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  }
  if (triangles.size() == firstTriangle) return Outcome::NoArea;
  if (std::abs(covered - expected) > 1e-6 * covered) clean = false;
  return clean ? Outcome::Good : Outcome::Tangled;
}

}  // namespace kinora::geometry
