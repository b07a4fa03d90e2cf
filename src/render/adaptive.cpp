#include "render/adaptive.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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

void NoiseEstimate::endPart() {
  for (size_t b = 0; b < sums_.size(); b += kNumbers)
    for (size_t k = b; k < b + kTolerance; k += 6)
      for (size_t c = k; c < k + 3; ++c) sums_[c] += std::exchange(sums_[c + 3], 0);
}

double NoiseEstimate::relativeDeviation(size_t block, int earlier, int since, float darkFalloff) const {
  if (earlier < 1 || since < 1) return INFINITY;
  const int64_t* s = &sums_[block * kNumbers];
  const double tolerance = double(s[kTolerance]) / (kToleranceStep * ActiveBlocks::kPixels * double(earlier + since));
  // Of means a and b of n and m samples (a - b)^2 n m / (n + m)^2 estimates the variance of the mean of all.
  const double n = earlier, m = since, share = n * m / ((n + m) * (n + m));
  double squares = 0, level = 0;
  for (int pixel = 0; pixel < ActiveBlocks::kPixels; ++pixel, s += 6)
    for (int c = 0; c < 3; ++c) {
      const double a = double(s[c]) * kStep / n, b = double(s[3 + c]) * kStep / m;
      squares += (a - b) * (a - b) * share;
      level += std::fabs(a * n + b * m) / (n + m);
    }
  constexpr double kValues = ActiveBlocks::kPixels * 3;
  return std::sqrt(squares / kValues) / ((level / kValues + double(darkFalloff)) * tolerance);
}

bool isDecisionPoint(int last) {
  if (last <= 0) return false;
  const uint32_t n = uint32_t(last), power = std::bit_floor(n);
  return n == power || (power >= 32 && n == power + power / 2);
}

Convergence::Convergence(const Adaptivity& wanted, int first, int most, size_t blocks)
    : wanted_(wanted), first_(first), most_(most), part_(first), ofSample_(blocks, 0.), taken_(blocks, 0) {}

void Convergence::decide(NoiseEstimate& noise, int last, ActiveBlocks& active) {
  const int taken = last - first_;
  if (taken >= std::max(wanted_.least, 2) && part_ > first_) decideBy(noise, last, active);
  if (!std::has_single_bit(uint32_t(last))) return;
  noise.endPart();
  part_ = last;
}

void Convergence::decideBy(const NoiseEstimate& noise, int last, ActiveBlocks& active) {
  const int taken = last - first_;
  double squares = 0, pixels = 0;
  for (size_t b = 0; b < active.blocks(); ++b) {
    if (active.isActive(b)) {
      const double deviation = noise.relativeDeviation(b, part_ - first_, last - part_, wanted_.darkFalloff);
      ofSample_[b] = deviation * deviation * taken;
      taken_[b] = taken;
    }
    squares += double(active.pixelsOf(b)) * ofSample_[b] / taken_[b];
    pixels += double(active.pixelsOf(b));
  }
  error_ = std::sqrt(squares / std::max(pixels, 1.));
  if (wanted_.error > 0)
    decideByFrame(taken, active);
  else
    decideByBlock(taken, active);
}

void Convergence::decideByBlock(int taken, ActiveBlocks& active) {
  left_ = 0;
  const double wanted = double(wanted_.variance) * double(wanted_.variance);
  for (size_t b = 0; b < active.blocks(); ++b) {
    if (!active.isActive(b)) continue;
    const double needed = ofSample_[b] / wanted;
    if (needed <= taken)
      active.stop(b);
    else
      left_ += double(active.pixelsOf(b)) * (std::min(needed, double(most_)) - taken);
  }
}

void Convergence::decideByFrame(int taken, ActiveBlocks& active) {
  const auto columns = int64_t(active.columns()), rows = columns ? int64_t(active.blocks()) / columns : 0;
  // A block that has been lucky so far, in missing a bright path that its neighbours know of, takes their word.
  std::vector<double> deviation(active.blocks());
  for (int64_t y = 0, b = 0; y < rows; ++y)
    for (int64_t x = 0; x < columns; ++x, ++b) {
      double sum = 0, count = 0;
      for (int64_t v = std::max<int64_t>(y - 1, 0); v <= std::min(y + 1, rows - 1); ++v)
        for (int64_t u = std::max<int64_t>(x - 1, 0); u <= std::min(x + 1, columns - 1); ++u, ++count)
          sum += ofSample_[size_t(v * columns + u)];
      deviation[size_t(b)] = std::sqrt(std::max(ofSample_[size_t(b)], sum / count));
    }
  // What is left of the error of the whole when active blocks take `share` times their deviation, as far as that is
  // more than they have.
  const auto needed = [&](size_t b, double share) {
    return std::clamp(share * deviation[b], double(taken), double(std::max(most_, taken)));
  };
  const auto squaresAt = [&](double share) {
    double squares = 0;
    for (size_t b = 0; b < active.blocks(); ++b)
      squares += double(active.pixelsOf(b)) * deviation[b] * deviation[b] /
                 (active.isActive(b) ? needed(b, share) : double(taken_[b]));
    return squares;
  };
  double pixels = 0;
  for (size_t b = 0; b < active.blocks(); ++b) pixels += double(active.pixelsOf(b));
  const double wanted = double(wanted_.error) * double(wanted_.error) * pixels;
  double low = 0, high = 1;
  while (high < 1e12 && squaresAt(high) > wanted) high *= 4;
  if (squaresAt(low) <= wanted) high = 0;
  for (int i = 0; i < 40 && high > 0; ++i) {
    const double middle = 0.5 * (low + high);
    (squaresAt(middle) > wanted ? low : high) = middle;
  }
  // Decisions lie a factor of up to 1.5 apart: who wants less than the middle of it is done.
  constexpr double kNotWorth = 1.2;
  left_ = 0;
  for (size_t b = 0; b < active.blocks(); ++b) {
    if (!active.isActive(b)) continue;
    const double samples = needed(b, high);
    if (samples < kNotWorth * taken)
      active.stop(b);
    else
      left_ += double(active.pixelsOf(b)) * (samples - taken);
  }
}

}  // namespace kinora::render
