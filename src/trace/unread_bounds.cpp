#include "trace/unread_bounds.h"

#include <algorithm>
#include <cmath>

namespace kinora::trace {

namespace {

// Distance at which a ray enters a box; beyond `length`: it does not. Comparisons are written so that a coordinate
// along which the ray does not run (0 / 0) says nothing.
float entry(const float lower[3], const float upper[3], const float o[3], const float inverse[3], float length) {
  float near = 0, far = length;
  for (int k = 0; k < 3; ++k) {
    const float a = (lower[k] - o[k]) * inverse[k], b = (upper[k] - o[k]) * inverse[k];
    const float first = a < b ? a : b, last = a < b ? b : a;
    if (first > near) near = first;
    if (last < far) far = last;
  }
  constexpr float kRounding = 1.f + 8e-7f;
  return near <= far * kRounding ? near : INFINITY;
}

}  // namespace

UnreadBounds::UnreadBounds(std::vector<Box> boxes)
    : boxes_(std::move(boxes)), noted_(new std::atomic<uint8_t>[std::max<size_t>(1, boxes_.size())]) {
  // whatever rounding does to a ray that touches what lies on a face
  for (Box& b : boxes_) {
    float size = 0;
    for (int k = 0; k < 3; ++k)
      size = std::max({size, b.upper[k] - b.lower[k], std::fabs(b.lower[k]), std::fabs(b.upper[k])});
    for (int k = 0; k < 3; ++k) {
      b.lower[k] -= size * 1e-6f + 1e-30f;
      b.upper[k] += size * 1e-6f + 1e-30f;
    }
  }
  std::vector<uint32_t> order(boxes_.size());
  for (uint32_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    noted_[i] = 0;
  }
  nodes_.reserve(2 * order.size());
  if (!order.empty()) build(order, 0, order.size());
}

// Halves by the middles along the longest axis.
uint32_t UnreadBounds::build(std::vector<uint32_t>& order, size_t first, size_t last) {
  const auto at = uint32_t(nodes_.size());
  Node n{};
  float low[3], high[3];  // of middles
  for (int k = 0; k < 3; ++k) {
    n.lower[k] = low[k] = INFINITY;
    n.upper[k] = high[k] = -INFINITY;
    for (size_t i = first; i < last; ++i) {
      const Box& b = boxes_[order[i]];
      const float middle = 0.5f * (b.lower[k] + b.upper[k]);
      n.lower[k] = std::min(n.lower[k], b.lower[k]);
      n.upper[k] = std::max(n.upper[k], b.upper[k]);
      low[k] = std::min(low[k], middle);
      high[k] = std::max(high[k], middle);
    }
  }
  n.box = order[first];
  nodes_.push_back(n);
  if (last - first == 1) return at;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
  const size_t half = first + (last - first) / 2;
  const auto middle = [&](uint32_t i) { return boxes_[i].lower[axis] + boxes_[i].upper[axis]; };
  std::nth_element(order.begin() + long(first), order.begin() + long(half), order.begin() + long(last),
                   [&](uint32_t a, uint32_t b) { return middle(a) != middle(b) ? middle(a) < middle(b) : a < b; });
  build(order, first, half);
  const uint32_t right = build(order, half, last);
  nodes_[at].right = right;
  return at;
}

uint32_t UnreadBounds::firstOf(const float o[3], const float d[3], float length) const {
  if (nodes_.empty() || !(length > 0)) return kNone;
  length = std::min(length, 3e38f);  // infinity is the distance of what is not entered
  float inverse[3];
  for (int k = 0; k < 3; ++k) inverse[k] = 1.f / d[k];
  uint32_t found = kNone;
  float best = length;
  uint32_t stack[64], depth = 0;
  if (entry(nodes_[0].lower, nodes_[0].upper, o, inverse, best) <= best) stack[depth++] = 0;
  while (depth) {
    const uint32_t at = stack[--depth];
    const Node& n = nodes_[at];
    const float t = entry(n.lower, n.upper, o, inverse, best);
    if (!(t <= best)) continue;
    if (!n.right) {
      if (t < best || found == kNone || n.box < found) found = n.box;
      best = t;
      continue;
    }
    const uint32_t left = at + 1;
    const float a = entry(nodes_[left].lower, nodes_[left].upper, o, inverse, best),
                b = entry(nodes_[n.right].lower, nodes_[n.right].upper, o, inverse, best);
    // the nearer one last, to be looked at next
    const bool isLeftNear = a <= b;
    for (const uint32_t child : {isLeftNear ? n.right : left, isLeftNear ? left : n.right})
      if ((child == left ? a : b) <= best) stack[depth++] = child;
  }
  return found;
}

void UnreadBounds::note(uint32_t box) const {
  noted_[box].store(1, std::memory_order_relaxed);
  ++notesOfThread();
}

void UnreadBounds::meet(const Rays& rays, const Hits& hits, uint32_t n, const uint32_t* slots) const {
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots ? slots[i] : i;
    const float o[3] = {rays.o[0][s], rays.o[1][s], rays.o[2][s]}, d[3] = {rays.d[0][s], rays.d[1][s], rays.d[2][s]};
    const uint32_t box = firstOf(o, d, std::min(hits.t[s], rays.tMax[s]));
    if (box == kNone) continue;
    hits.t[s] = INFINITY;
    note(box);
  }
}

void UnreadBounds::meet(uint32_t n, const float* const o[3], const float* const d[3], const float* length,
                        uint32_t* blocked) const {
  for (uint32_t i = 0; i < n; ++i) {
    if (blocked[i]) continue;
    const float from[3] = {o[0][i], o[1][i], o[2][i]}, along[3] = {d[0][i], d[1][i], d[2][i]};
    const uint32_t box = firstOf(from, along, length[i]);
    if (box == kNone) continue;
    blocked[i] = 1;
    note(box);
  }
}

uint64_t& UnreadBounds::notesOfThread() {
  static thread_local uint64_t notes = 0;
  return notes;
}

std::vector<uint32_t> UnreadBounds::noted() const {
  std::vector<uint32_t> out;
  for (uint32_t i = 0; i < boxes_.size(); ++i)
    if (noted_[i].load(std::memory_order_relaxed)) out.push_back(i);
  return out;
}

}  // namespace kinora::trace
