#include "light/light_boxes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kinora::light {

namespace {
constexpr uint32_t kMostInLeaf = 4;
}

LightBoxes::LightBoxes(const std::vector<LightBox3>& boxes, const std::vector<uint32_t>& lights) {
  if (boxes.empty()) return;
  std::vector<uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(boxes.size());
  nodes_.resize(1);
  fill(0, boxes, order, 0, uint32_t(order.size()), 0);
  nodes_.shrink_to_fit();
  lights_.reserve(order.size());
  for (const uint32_t i : order) lights_.push_back(lights[i]);
}

// Cut in the middle of the boxes' centres along the axis on which they lie farthest apart, in equal parts where that
// leaves a side empty or goes too deep.
void LightBoxes::fill(uint32_t at, const std::vector<LightBox3>& boxes, std::vector<uint32_t>& order, uint32_t from,
                      uint32_t to, uint32_t depth) {
  Node n{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, from, to - from};
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  const auto center = [&](uint32_t i, int c) { return 0.5f * (boxes[i].low[c] + boxes[i].high[c]); };
  for (uint32_t k = from; k < to; ++k)
    for (int c = 0; c < 3; ++c) {
      const LightBox3& b = boxes[order[k]];
      n.low[c] = std::min(n.low[c], b.low[c]);
      n.high[c] = std::max(n.high[c], b.high[c]);
      low[c] = std::min(low[c], center(order[k], c));
      high[c] = std::max(high[c], center(order[k], c));
    }
  if (to - from <= kMostInLeaf) {
    nodes_[at] = n;
    return;
  }
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (high[c] - low[c] > high[axis] - low[axis]) axis = c;
  const float middle = 0.5f * (low[axis] + high[axis]);
  uint32_t cut = from;
  if (depth < kMostDepth / 2)
    cut = uint32_t(std::stable_partition(order.begin() + from, order.begin() + to,
                                         [&](uint32_t i) { return center(i, axis) < middle; }) -
                   order.begin());
  if (cut == from || cut == to) cut = from + (to - from) / 2;
  n.first = uint32_t(nodes_.size());
  n.count = 0;
  nodes_[at] = n;
  nodes_.resize(n.first + 2);
  fill(n.first, boxes, order, from, cut, depth + 1);
  fill(n.first + 1, boxes, order, cut, to, depth + 1);
}

}  // namespace kinora::light
