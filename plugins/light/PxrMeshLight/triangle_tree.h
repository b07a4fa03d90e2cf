// The triangles of a mesh light and a tree of boxes over them: which one a ray meets first with its emitting side. Where
// triangles move boxes hold them at all times of the shutter.
// Plain code in single precision, one ray at a time: the same bits whoever calls it. Used by PxrMeshLight alone.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

namespace kinora::pxrMeshLight {

struct Triangles {
  // v0, e1, e2 and unit normal, each component an array: of one key after the other. Normals are those of keys alone.
  std::vector<float> v0[3], e1[3], e2[3], normal[3];
  uint32_t keyCount = 1;
  uint32_t count() const { return uint32_t(v0[0].size()) / keyCount; }
  bool moves() const { return keyCount > 1; }
};

// The keys around a time of the shutter (0 to 1, held outside): where those of both begin, and the part of the second.
struct TriangleKeys {
  uint32_t first = 0, second = 0;
  float part = 0;
  TriangleKeys(const Triangles& t, float time) {
    if (!t.moves()) return;
    const float x = (time > 0.f ? time < 1.f ? time : 1.f : 0.f) * float(t.keyCount - 1);
    const uint32_t key = std::min(uint32_t(x), t.keyCount - 2);
    first = key * t.count();
    second = first + t.count();
    part = x - float(key);
  }
  float mix(const std::vector<float>& x, uint32_t i) const {
    return x[first + i] + part * (x[second + i] - x[first + i]);
  }
};

class TriangleTree {
 public:
  static constexpr uint32_t kNone = 0xffffffffu;
  // Reorders the triangles, so that those of a leaf stand together.
  void build(Triangles& triangles);
  // The first triangle whose emitting side the ray of that time meets before tMax, or kNone; t gets its distance.
  uint32_t first(const Triangles& triangles, const float o[3], const float d[3], float time, float tMax,
                 float& t) const;

 private:
  struct Node {
    float low[3], high[3];
    uint32_t begin = 0,
             count = 0;  // leaf: its triangles; else count 0 and begin the second child (the first follows)
  };
  uint32_t split(std::vector<uint32_t>& order, const std::vector<float>& boxes, uint32_t begin, uint32_t end);
  std::vector<Node> nodes_;
};

inline void TriangleTree::build(Triangles& t) {
  const uint32_t n = t.count();
  std::vector<float> boxes(size_t(n) * 6);
  for (uint32_t i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) {
      float &low = boxes[size_t(i) * 6 + c], &high = boxes[size_t(i) * 6 + 3 + c];
      for (uint32_t key = 0; key < t.keyCount; ++key) {
        const size_t at = size_t(key) * n + i;
        const float a = t.v0[c][at], b = a + t.e1[c][at], d = a + t.e2[c][at];
        const float least = std::min(a, std::min(b, d)), most = std::max(a, std::max(b, d));
        low = key ? std::min(low, least) : least;
        high = key ? std::max(high, most) : most;
      }
    }
  std::vector<uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  nodes_.clear();
  if (n) split(order, boxes, 0, n);
  for (std::vector<float>* group : {t.v0, t.e1, t.e2, t.normal})
    for (int c = 0; c < 3; ++c) {
      std::vector<float> sorted(size_t(n) * t.keyCount);
      for (uint32_t key = 0; key < t.keyCount; ++key)
        for (uint32_t i = 0; i < n; ++i) sorted[size_t(key) * n + i] = group[c][size_t(key) * n + order[i]];
      group[c] = std::move(sorted);
    }
}

// Halves at the median of the longest axis: depth is bounded, and lights are small.
inline uint32_t TriangleTree::split(std::vector<uint32_t>& order, const std::vector<float>& boxes, uint32_t begin,
                                    uint32_t end) {
  const uint32_t at = uint32_t(nodes_.size());
  nodes_.emplace_back();
  Node node;
  for (int c = 0; c < 3; ++c) {
    node.low[c] = std::numeric_limits<float>::infinity();
    node.high[c] = -node.low[c];
    for (uint32_t i = begin; i < end; ++i) {
      node.low[c] = std::min(node.low[c], boxes[size_t(order[i]) * 6 + c]);
      node.high[c] = std::max(node.high[c], boxes[size_t(order[i]) * 6 + 3 + c]);
    }
  }
  // rays that graze a box by rounding must not miss what lies on its side
  for (int c = 0; c < 3; ++c) {
    const float room = 4e-7f * std::max(std::fabs(node.low[c]), std::fabs(node.high[c])) + 1e-30f;
    node.low[c] -= room;
    node.high[c] += room;
  }
  constexpr uint32_t kLeaf = 4;
  if (end - begin <= kLeaf) {
    node.begin = begin;
    node.count = end - begin;
    nodes_[at] = node;
    return at;
  }
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (node.high[c] - node.low[c] > node.high[axis] - node.low[axis]) axis = c;
  const uint32_t middle = (begin + end) / 2;
  const auto centre = [&](uint32_t i) { return boxes[size_t(i) * 6 + axis] + boxes[size_t(i) * 6 + 3 + axis]; };
  std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                   [&](uint32_t a, uint32_t b) { return centre(a) != centre(b) ? centre(a) < centre(b) : a < b; });
  split(order, boxes, begin, middle);
  node.begin = split(order, boxes, middle, end);
  nodes_[at] = node;
  return at;
}

inline uint32_t TriangleTree::first(const Triangles& t, const float o[3], const float d[3], float time, float tMax,
                                    float& tHit) const {
  const bool moves = t.moves();
  const TriangleKeys keys(t, time);
  uint32_t best = kNone, stack[64];
  float nearest = tMax;
  int top = 0;
  if (nodes_.empty()) return kNone;
  float inverse[3];
  for (int c = 0; c < 3; ++c) inverse[c] = 1.f / (std::fabs(d[c]) > 1e-20f ? d[c] : std::copysign(1e-20f, d[c]));
  stack[top++] = 0;
  while (top) {
    const uint32_t at = stack[--top];
    const Node& node = nodes_[at];
    float enter = 0, leave = nearest;
    for (int c = 0; c < 3; ++c) {
      const float a = (node.low[c] - o[c]) * inverse[c], b = (node.high[c] - o[c]) * inverse[c];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b) * 1.000001f);
    }
    if (!(enter <= leave)) continue;
    if (!node.count) {
      stack[top++] = node.begin;
      stack[top++] = at + 1;
      continue;
    }
    for (uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      // Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997); the emitting side alone
      float v0[3], e1[3], e2[3];
      for (int c = 0; c < 3; ++c) {
        v0[c] = moves ? keys.mix(t.v0[c], i) : t.v0[c][i];
        e1[c] = moves ? keys.mix(t.e1[c], i) : t.e1[c][i];
        e2[c] = moves ? keys.mix(t.e2[c], i) : t.e2[c][i];
      }
      const float p[3] = {d[1] * e2[2] - d[2] * e2[1], d[2] * e2[0] - d[0] * e2[2], d[0] * e2[1] - d[1] * e2[0]};
      const float det = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
      if (!(det > 1e-37f)) continue;
      const float s[3] = {o[0] - v0[0], o[1] - v0[1], o[2] - v0[2]};
      const float u = s[0] * p[0] + s[1] * p[1] + s[2] * p[2], slack = 2e-6f * det;
      if (u < -slack || u > det + slack) continue;
      const float q[3] = {s[1] * e1[2] - s[2] * e1[1], s[2] * e1[0] - s[0] * e1[2], s[0] * e1[1] - s[1] * e1[0]};
      const float v = d[0] * q[0] + d[1] * q[1] + d[2] * q[2];
      if (v < -slack || u + v > det + slack) continue;
      const float distance = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det;
      // ties go to the lower index, whatever the order of visits
      if (distance > 0 && (distance < nearest || (distance == nearest && i < best && best != kNone))) {
        nearest = distance;
        best = i;
      }
    }
  }
  tHit = nearest;
  return best;
}

}  // namespace kinora::pxrMeshLight
