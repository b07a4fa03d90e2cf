#include "trace/unread_bounds.h"

#include <algorithm>
#include <cmath>

#include "trace/unread_notes.h"

namespace kinora::trace {

namespace {

constexpr float kLongestRay = 1e37f;  // of a ray's length

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
  if (!order.empty()) build(order, 0, order.size());
}

// Halved three times, each by the middles along the longest axis.
uint32_t UnreadBounds::build(std::vector<uint32_t>& order, size_t first, size_t last) {
  std::vector<std::pair<size_t, size_t>> runs{{first, last}};
  const auto split = [&](std::pair<size_t, size_t> run) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};  // of middles
    const auto middle = [&](uint32_t i, int k) { return 0.5f * boxes_[i].lower[k] + 0.5f * boxes_[i].upper[k]; };
    for (size_t i = run.first; i < run.second; ++i)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], middle(order[i], k));
        high[k] = std::max(high[k], middle(order[i], k));
      }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const size_t half = run.first + (run.second - run.first) / 2;
    std::nth_element(order.begin() + long(run.first), order.begin() + long(half), order.begin() + long(run.second),
                     [&](uint32_t a, uint32_t b) {
                       const float x = middle(a, axis), y = middle(b, axis);
                       return x != y ? x < y : a < b;
                     });
    return half;
  };
  for (int level = 0; level < 3; ++level) {
    std::vector<std::pair<size_t, size_t>> halves;
    for (const auto& run : runs) {
      if (run.second - run.first < 2) {
        halves.push_back(run);
        continue;
      }
      const size_t half = split(run);
      halves.emplace_back(run.first, half);
      halves.emplace_back(half, run.second);
    }
    runs = std::move(halves);
  }
  const auto at = uint32_t(nodes_.size());
  nodes_.push_back({});
  for (uint32_t c = 0; c < kChildren; ++c) {
    Box all{{3e38f, 3e38f, 3e38f}, {3e38f, 3e38f, 3e38f}};
    uint32_t child = kNone;
    if (c < runs.size()) {
      const auto& [from, to] = runs[c];
      all = boxes_[order[from]];
      for (size_t i = from; i < to; ++i)
        for (int k = 0; k < 3; ++k) {
          all.lower[k] = std::min(all.lower[k], boxes_[order[i]].lower[k]);
          all.upper[k] = std::max(all.upper[k], boxes_[order[i]].upper[k]);
        }
      child = to - from == 1 ? order[from] | kIsBox : build(order, from, to);
    }
    Node& n = nodes_[at];
    n.child[c] = child;
    for (int k = 0; k < 3; ++k) {
      n.lower[k][c] = all.lower[k];
      n.upper[k][c] = all.upper[k];
    }
  }
  return at;
}

uint32_t UnreadBounds::firstOf(const float o[3], const float d[3], float length) const {
  if (nodes_.empty() || !(length > 0)) return kNone;
  float inverse[3];
  for (int k = 0; k < 3; ++k) inverse[k] = 1.f / d[k];
  constexpr float kRounding = 1.f + 8e-7f;
  uint32_t found = kNone;
  float best = std::min(length, kLongestRay);
  struct Entry {
    float t;
    uint32_t node;
  } stack[16 * kChildren];
  uint32_t depth = 0;
  stack[depth++] = {0, 0};
  while (depth) {
    const Entry e = stack[--depth];
    if (e.t > best) continue;
    const Node& n = nodes_[e.node];
    float near[kChildren], far[kChildren];
    for (uint32_t c = 0; c < kChildren; ++c) {
      near[c] = 0;
      far[c] = best;
    }
    // written so that a coordinate along which the ray does not run (0 / 0) says nothing
    for (int k = 0; k < 3; ++k)
      for (uint32_t c = 0; c < kChildren; ++c) {
        const float a = (n.lower[k][c] - o[k]) * inverse[k], b = (n.upper[k][c] - o[k]) * inverse[k];
        const float first = a < b ? a : b, last = a < b ? b : a;
        near[c] = first > near[c] ? first : near[c];
        far[c] = last < far[c] ? last : far[c];
      }
    const uint32_t begin = depth;
    for (uint32_t c = 0; c < kChildren; ++c) {
      if (!(near[c] <= far[c] * kRounding) || near[c] > best) continue;
      if (n.child[c] & kIsBox) {
        if (n.child[c] == kNone) continue;
        const uint32_t box = n.child[c] & ~kIsBox;
        if (near[c] < best || found == kNone || box < found) found = box;
        best = near[c];
        continue;
      }
      // the nearest last, to be looked at next
      uint32_t place = depth++;
      for (; place > begin && stack[place - 1].t < near[c]; --place) stack[place] = stack[place - 1];
      stack[place] = {near[c], n.child[c]};
    }
  }
  return found;
}

void UnreadBounds::note(uint32_t box) const {
  noted_[box].store(1, std::memory_order_relaxed);
  ++notesOfThread();
  if (const UnreadNotes& own = UnreadNotes::ofThread(); box / 64 < own.count)
    own.words[box / 64] |= uint64_t(1) << (box % 64);
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

UnreadNotes& UnreadNotes::ofThread() {
  static thread_local UnreadNotes notes;
  return notes;
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
