#include "render/adaptive.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace kinora::render {

ActiveBlocks::ActiveBlocks(const image::Window& window) : window_(window) {
  if (window.x1 <= window.x0 || window.y1 <= window.y0) return;
  firstX_ = window.x0 / kSide;
  firstY_ = window.y0 / kSide;
  columns_ = (window.x1 + kSide - 1) / kSide - firstX_;
  rows_ = (window.y1 + kSide - 1) / kSide - firstY_;
  isActive_.assign(size_t(columns_) * size_t(rows_), 1);
  activePixels_ = uint64_t(window.pixels());
}

bool ActiveBlocks::anyIn(int x0, int y0, int x1, int y1) const {
  for (int y = y0; y < y1; y += kSide)
    for (int x = x0; x < x1; x += kSide)
      if (isActive(x, y)) return true;
  return false;
}

uint64_t ActiveBlocks::pixelsOf(size_t block) const {
  const int x = (firstX_ + int(block % size_t(columns_))) * kSide,
            y = (firstY_ + int(block / size_t(columns_))) * kSide;
  const int w = std::min(x + kSide, window_.x1) - std::max(x, window_.x0);
  const int h = std::min(y + kSide, window_.y1) - std::max(y, window_.y0);
  return uint64_t(w) * uint64_t(h);
}

void ActiveBlocks::stop(size_t block) {
  if (!isActive_[block]) return;
  isActive_[block] = 0;
  activePixels_ -= pixelsOf(block);
}

double NoiseEstimate::relativeDeviation(size_t block, int even, int odd, float darkFalloff) const {
  if (even < 1 || odd < 1) return INFINITY;
  const int64_t* s = &sums_[block * kNumbers];
  // The two halves may differ by a sample: of means a and b of n and m samples (a - b)^2 n m / (n + m)^2 estimates
  // the variance of the mean of all.
  const double n = even, m = odd, share = n * m / ((n + m) * (n + m));
  double squares = 0, level = 0;
  for (int pixel = 0; pixel < ActiveBlocks::kPixels; ++pixel, s += 6)
    for (int c = 0; c < 3; ++c) {
      const double a = double(s[c]) * kStep / n, b = double(s[3 + c]) * kStep / m;
      squares += (a - b) * (a - b) * share;
      level += std::fabs(a * n + b * m) / (n + m);
    }
  constexpr double kValues = ActiveBlocks::kPixels * 3;
  return std::sqrt(squares / kValues) / (level / kValues + double(darkFalloff));
}

bool isDecisionPoint(int last) {
  if (last <= 0) return false;
  const uint32_t n = uint32_t(last), power = std::bit_floor(n);
  return n == power || (power >= 32 && n == power + power / 2);
}

bool stopQuietBlocks(const Adaptivity& wanted, const NoiseEstimate& noise, int first, int last,
                     ActiveBlocks& active) {
  if (last - first < wanted.least) return true;
  const int even = (last + 1) / 2 - (first + 1) / 2, odd = last / 2 - first / 2;
  bool isLeft = false;
  for (size_t b = 0; b < active.blocks(); ++b) {
    if (!active.isActive(b)) continue;
    if (noise.relativeDeviation(b, even, odd, wanted.darkFalloff) <= double(wanted.variance))
      active.stop(b);
    else
      isLeft = true;
  }
  return isLeft;
}

}  // namespace kinora::render
