// Light that light paths bring to any place of the picture, through the pixel filter that places camera samples: the
// pixel which gets it is drawn by the filter's values at the pixels around, so that on average each gets its share.
// Nothing but the place decides the draw. Built once a frame, read by all workers.
#pragma once
#include <cstdint>
#include <vector>

#include "film/pixel_filter.h"

namespace kinora::film {

class SplatFilter {
 public:
  struct Pixel {
    int32_t x, y;
    float weight;
  };
  SplatFilter() = default;  // of pixels that take what falls into them
  explicit SplatFilter(const PixelFilter& filter);
  Pixel choose(float x, float y) const;

 private:
  static constexpr int kCells = 32;       // of a table, a pixel's width
  static constexpr int kMostAcross = 65;  // pixels under the widest filter, 64
  float at(float dx, float dy) const;
  int reach_ = 0;  // of the filter, whole pixels to each side of the one that a place is in; 0: a box of one pixel
  int side_ = 0;   // of the table
  std::vector<float> table_;  // values at (x, y) of a pixel's centre, normalised
};

}  // namespace kinora::film
