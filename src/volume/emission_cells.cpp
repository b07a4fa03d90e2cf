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

bool EmissionCells::emits(const float object[3]) const {
  const float none[3] = {0, 0, 0};
  float end = 0;
  return cells_[cells_.cellAt(object, none, 0, end)] > 0;
}

void EmissionCells::sample(float u, float v, float w, float object[3]) const {
  const size_t at =
      std::min(size_t(std::upper_bound(sums_.begin(), sums_.end(), u) - sums_.begin()), sums_.size() - 1);
  const float before = at ? sums_[at - 1] : 0.f, share = sums_[at] - before;
  const float in[3] = {share > 0 ? std::clamp((u - before) / share, 0.f, 1.f) : 0.5f, v, w};
  float from[3], to[3];
  cells_.boundsOf(cellOf_[at], from, to);
  for (int k = 0; k < 3; ++k) object[k] = from[k] + in[k] * (to[k] - from[k]);
}

// f(from, to, density) for each cell that the ray passes, in order, until it returns false.
template <class F>
void EmissionCells::forCells(const float o[3], const float d[3], F&& f) const {
  float t = 0, last = 1e30f;
  for (int k = 0; k < 3; ++k) {
    if (d[k] == 0) {
      if (o[k] < low_[k] || o[k] > high_[k]) return;
      continue;
    }
    const float a = (low_[k] - o[k]) / d[k], b = (high_[k] - o[k]) / d[k];
    t = std::max(t, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  while (t < last) {
    float end = last;
    const size_t cell = cells_.cellAt(o, d, t, end);
    if (cells_[cell] > 0 && !f(t, end, cells_[cell])) return;
    t = end;
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
