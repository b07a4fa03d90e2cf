// A pixel filter of a channel's own, over samples that the frame's filter placed: the weight with which such a sample
// counts for that channel. Built once a frame; render/ asks it beside PixelFilter::sample, with the same numbers.
// Where the frame's filter puts no sample the channel's own one is cut off.
#pragma once
#include <algorithm>
#include <vector>

#include "film/pixel_filter.h"

namespace kinora::film {

class FilterRatio {
 public:
  FilterRatio(const PixelFilter& frame, const PixelFilter& own);
  // Weight of the sample that frame.sample(u, v) made; the mean over u and v is 1.
  float weight(float u, float v) const {
    const int i = std::min(int(u * float(cells_)), cells_ - 1), j = std::min(int(v * float(cells_)), cells_ - 1);
    return weights_[size_t(j) * size_t(cells_) + size_t(i)];
  }
  // Mean of what the weights lie below 0, as PixelFilter::negativeMean.
  double negativeMean() const;
  // Share of the own filter (by its absolute value) that lies where the frame's filter puts samples.
  double covered() const { return covered_; }

 private:
  static constexpr int kMostCells = 128;
  int cells_ = 0;
  std::vector<float> weights_;
  double covered_ = 1;
};

}  // namespace kinora::film
