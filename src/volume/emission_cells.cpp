#include "volume/emission_cells.h"

#include <algorithm>
#include <cmath>

namespace kinora::volume {

EmissionCells::EmissionCells(const float low[3], const float high[3], const int cells[3],
                             const std::vector<float>& emitted)
    : cells_(low, high, cells) {
  double total = 0;
  float from[3], to[3];
  cells_.boundsOf(0, from, to);
  cellVolume_ = (to[0] - from[0]) * (to[1] - from[1]) * (to[2] - from[2]);
  for (int k = 0; k < 3; ++k) {
    low_[k] = low[k];
    high_[k] = high[k];
    size_[k] = to[k] - from[k];
  }
  for (const float e : emitted)
    if (e > 0 && e < 1e30f) total += double(e);
  if (!(total > 0) || !(cellVolume_ > 0)) return;
  double sum = 0;
  for (size_t c = 0; c < cells_.count(); ++c) {
    const float e = emitted[c] > 0 && emitted[c] < 1e30f ? emitted[c] : 0.f;
    const double share = double(e) / total;
    cells_[c] = float(share / double(cellVolume_));
    if (!(cells_[c] > 0)) continue;
    sum += share;
    sums_.push_back(float(std::min(sum, 1.0)));
    cellOf_.push_back(uint32_t(c));
  }
  if (!sums_.empty()) sums_.back() = 1;
  bounds(around_[0], around_[1]);
}

void EmissionCells::bounds(float low[3], float high[3]) const {
  for (int k = 0; k < 3; ++k) {
    low[k] = high_[k];
    high[k] = low_[k];
  }
  for (const uint32_t c : cellOf_) {
    float from[3], to[3];
    cells_.boundsOf(c, from, to);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], from[k]);
      high[k] = std::max(high[k], to[k]);
    }
  }
}

bool EmissionCells::emits(const float object[3]) const { return cells_[cells_.cellAt(object)] > 0; }

void EmissionCells::sample(float u, float v, float w, float object[3]) const {
  const size_t at =
      std::min(size_t(std::upper_bound(sums_.begin(), sums_.end(), u) - sums_.begin()), sums_.size() - 1);
  const float before = at ? sums_[at - 1] : 0.f, share = sums_[at] - before;
  const float in[3] = {share > 0 ? std::clamp((u - before) / share, 0.f, 1.f) : 0.5f, v, w};
  float from[3], to[3];
  cells_.boundsOf(cellOf_[at], from, to);
  for (int k = 0; k < 3; ++k) object[k] = from[k] + in[k] * (to[k] - from[k]);
}

// f(from, to, density) for each cell that the ray passes, in order, until it returns false. Rays walk over the cells
// around all that emits, border by border of each axis (Amanatides and Woo 1987).
template <class F>
void EmissionCells::forCells(const float o[3], const float d[3], F&& f) const {
  float t = 0, last = 1e30f, by[3];
  for (int k = 0; k < 3; ++k) {
    by[k] = 1 / d[k];
    if (d[k] == 0) {
      if (o[k] < around_[0][k] || o[k] > around_[1][k]) return;
      continue;
    }
    const float a = (around_[0][k] - o[k]) * by[k], b = (around_[1][k] - o[k]) * by[k];
    t = std::max(t, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  if (!(t < last)) return;
  float next[3];
  int at[3], step[3];
  const auto toBorder = [&](int k) {
    next[k] = step[k] ? (low_[k] + float(at[k] + (step[k] > 0)) * size_[k] - o[k]) * by[k] : 1e30f;
  };
  for (int k = 0; k < 3; ++k) {
    step[k] = d[k] > 0 ? 1 : d[k] < 0 ? -1 : 0;
    const int from = cells_.cells(k);
    at[k] = std::clamp(int(std::floor((o[k] + d[k] * t - low_[k]) / size_[k])), 0, from - 1);
    toBorder(k);
  }
  while (t < last) {
    const int axis = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
    const float end = std::min(next[axis], last);
    const float density =
        cells_[(size_t(at[2]) * size_t(cells_.cells(1)) + size_t(at[1])) * size_t(cells_.cells(0)) + size_t(at[0])];
    if (density > 0 && end > t && !f(t, end, density)) return;
    t = std::max(t, end);
    at[axis] += step[axis];
    if (!step[axis] || at[axis] < 0 || at[axis] >= cells_.cells(axis)) return;
    toBorder(axis);
  }
}

EmissionCells::Along EmissionCells::along(const float o[3], const float d[3]) const {
  Along a{0, 0};
  forCells(o, d, [&](float from, float to, float density) {
    const float length = to - from;
    a.line += density * length;
    // (to^3 - from^3) / 3, without the difference of what is nearly the same
    a.squared += density * length * (from * from + from * to + to * to) * (1.f / 3);
    return true;
  });
  return a;
}

float EmissionCells::distance(const float o[3], const float d[3], float u, const Along& along, float& density) const {
  float rest = u * along.line, t = -1;
  forCells(o, d, [&](float from, float to, float here) {
    const float own = here * (to - from);
    density = here / along.line;
    t = from + (to - from) * std::min(rest / own, 1.f);
    rest -= own;
    return rest > 0;
  });
  return t;
}

}  // namespace kinora::volume
