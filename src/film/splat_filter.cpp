#include "film/splat_filter.h"

#include <kinora/sample_table.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinora::film {

SplatFilter::SplatFilter(const PixelFilter& filter) {
  const float width = std::max(filter.xWidth(), filter.yWidth());
  if (filter.name() == "box" && width <= 1) return;
  reach_ = int(std::ceil(width / 2));
  // values in the middle of cells, over all places within reach of a pixel's centre
  side_ = 2 * (reach_ + 1) * kCells;
  table_.resize(size_t(side_) * size_t(side_));
  double sum = 0;
  for (int j = 0; j < side_; ++j)
    for (int i = 0; i < side_; ++i) {
      const double v = filter.evaluate((i + 0.5) / kCells - (reach_ + 1), (j + 0.5) / kCells - (reach_ + 1));
      table_[size_t(j) * size_t(side_) + size_t(i)] = float(v);
      sum += v;
    }
  for (float& v : table_) v = float(v * double(kCells) * kCells / sum);
}

float SplatFilter::at(float dx, float dy) const {
  const int i = int((dx + float(reach_ + 1)) * kCells), j = int((dy + float(reach_ + 1)) * kCells);
  return table_[size_t(std::clamp(j, 0, side_ - 1)) * size_t(side_) + size_t(std::clamp(i, 0, side_ - 1))];
}

SplatFilter::Pixel SplatFilter::choose(float x, float y) const {
  const int32_t column = int32_t(std::floor(x)), row = int32_t(std::floor(y));
  if (!reach_) return {column, row, 1};
  float values[kMostAcross * kMostAcross], sum = 0;
  float* v = values;
  for (int j = -reach_; j <= reach_; ++j)
    for (int i = -reach_; i <= reach_; ++i, ++v) {
      *v = at(x - (float(column + i) + 0.5f), y - (float(row + j) + 0.5f));
      sum += std::fabs(*v);
    }
  if (!(sum > 0)) return {column, row, 0};
  const uint32_t hash = hashWords(std::bit_cast<uint32_t>(x), std::bit_cast<uint32_t>(y));
  float left = float(hash >> 8) * 0x1p-24f * sum;
  Pixel last{column, row, 0};
  v = values;
  for (int j = -reach_; j <= reach_; ++j)
    for (int i = -reach_; i <= reach_; ++i, ++v) {
      if (*v == 0) continue;
      last = {column + i, row + j, *v < 0 ? -sum : sum};
      left -= std::fabs(*v);
      if (left < 0) return last;
    }
  return last;
}

}  // namespace kinora::film
