#include "volume/majorants.h"

#include <algorithm>
#include <cmath>

namespace kinora::volume {

Majorants::Majorants(const float low[3], const float high[3], const int cells[3]) {
  size_t count = 1;
  for (int k = 0; k < 3; ++k) {
    n_[k] = std::max(cells[k], 1);
    low_[k] = low[k];
    size_[k] = std::max((high[k] - low[k]) / float(n_[k]), 1e-30f);
    perSize_[k] = 1 / size_[k];
    count *= size_t(n_[k]);
  }
  most_.assign(count, 0.f);
  mean_.assign(count, 0.f);
}

void Majorants::boundsOf(size_t cell, float low[3], float high[3]) const {
  const size_t at[3] = {cell % size_t(n_[0]), cell / size_t(n_[0]) % size_t(n_[1]),
                        cell / (size_t(n_[0]) * size_t(n_[1]))};
  for (int k = 0; k < 3; ++k) {
    low[k] = low_[k] + float(at[k]) * size_[k];
    high[k] = low_[k] + float(at[k] + 1) * size_[k];
  }
}

float Majorants::largest() const { return *std::max_element(most_.begin(), most_.end()); }

size_t Majorants::cellAt(const float place[3]) const {
  const float none[3] = {0, 0, 0};
  float end = 0;
  return cellAt(place, none, none, 0, end);
}

size_t Majorants::cellAt(const float o[3], const float d[3], const float inverse[3], float t, float& end) const {
  if (most_.size() == 1) return 0;
  size_t cell = 0;
  float nearest = end;
  for (int k = 2; k >= 0; --k) {
    // beyond the box the outermost cells go on; what is not a number is in the first ones
    const float x = (o[k] + d[k] * t - low_[k]) * perSize_[k], last = float(n_[k] - 1);
    int at = int(x > 0 ? std::min(x, last) : 0.f);
    // a ray on the border of two cells is in the one that it goes to
    if (d[k] < 0 && at > 0 && float(at) == x) --at;
    cell = cell * size_t(n_[k]) + size_t(at);
    const int border = d[k] > 0 ? at + 1 : at;
    if (d[k] == 0 || border == 0 || border == n_[k]) continue;
    nearest = std::min(nearest, (low_[k] + float(border) * size_[k] - o[k]) * inverse[k]);
  }
  // rounding must not keep it where it is
  const float least = t + std::max(std::fabs(t) * 1e-6f, 1e-30f);
  end = std::max(nearest, std::min(end, least));
  return cell;
}

}  // namespace kinora::volume
