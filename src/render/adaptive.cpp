#include "render/adaptive.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace kinora::render {

namespace {

constexpr size_t kPixels = ActivePixels::kPixels;

template <class F>
void forEachBit(uint32_t mask, F&& f) {
  for (; mask; mask &= mask - 1) f(size_t(std::countr_zero(mask)));
}

}  // namespace

ActivePixels::ActivePixels(const image::Window& window) : window_(window) {
  if (window.x1 <= window.x0 || window.y1 <= window.y0) return;
  firstX_ = window.x0 / kSide;
  firstY_ = window.y0 / kSide;
  columns_ = (window.x1 + kSide - 1) / kSide - firstX_;
  rows_ = (window.y1 + kSide - 1) / kSide - firstY_;
  active_.assign(size_t(columns_) * size_t(rows_), kAll);
  count_ = uint64_t(window.pixels());
}

bool ActivePixels::anyIn(int x0, int y0, int x1, int y1) const {
  for (int y = y0; y < y1; y += kSide)
    for (int x = x0; x < x1; x += kSide)
      if (activeIn(x, y)) return true;
  return false;
}

ActivePixels::Mask ActivePixels::inWindow(size_t block) const {
  const int x = (firstX_ + int(block % size_t(columns_))) * kSide,
            y = (firstY_ + int(block / size_t(columns_))) * kSide;
  uint32_t mask = 0;
  for (int k = 0; k < kPixels; ++k) {
    const int px = x + k % kSide, py = y + k / kSide;
    const bool isIn = px >= window_.x0 && px < window_.x1 && py >= window_.y0 && py < window_.y1;
    mask |= uint32_t(isIn) << k;
  }
  return Mask(mask);
}

void ActivePixels::stop(size_t block, Mask pixels) {
  const uint32_t ending = active_[block] & pixels;
  active_[block] = Mask(active_[block] & ~ending);
  count_ -= uint64_t(std::popcount(ending & inWindow(block)));
}

void NoiseEstimate::endPart() {
  for (size_t b = 0; b < sums_.size(); b += kNumbers)
    for (size_t k = b; k < b + kTolerance; k += 6)
      for (size_t c = k; c < k + 3; ++c) sums_[c] += std::exchange(sums_[c + 3], 0);
}

void NoiseEstimate::squaredDeviations(size_t block, int earlier, int since, const int taken[], float darkFalloff,
                                      double out[]) const {
  std::fill_n(out, kPixels, double(INFINITY));
  if (earlier < 1 || since < 1) return;
  const int64_t* sums = &sums_[block * kNumbers];
  // Of means a and b of n and m samples (a - b)^2 n m / (n + m)^2 estimates the variance of the mean of all.
  const double n = earlier, m = since, share = n * m / ((n + m) * (n + m));
  double level = 0, samples = 0;
  for (size_t pixel = 0; pixel < kPixels; ++pixel) {
    const int64_t* s = sums + pixel * 6;
    double ofPixel = 0, squares = 0;
    for (int c = 0; c < 3; ++c) {
      const double a = double(s[c]) * kStep / n, b = double(s[3 + c]) * kStep / m;
      squares += (a - b) * (a - b) * share;
      ofPixel += std::fabs(double(s[c] + s[3 + c])) * kStep;
    }
    level += ofPixel / std::max(taken[pixel], 1);
    samples += taken[pixel];
    out[pixel] = squares / 3;
  }
  const double tolerance = double(sums[kTolerance]) / (kToleranceStep * std::max(samples, 1.));
  const double unit = (level / (3 * kPixels) + double(darkFalloff)) * tolerance;
  for (size_t pixel = 0; pixel < kPixels; ++pixel) out[pixel] /= unit * unit;
}

bool isDecisionPoint(int last) {
  if (last <= 0) return false;
  const uint32_t n = uint32_t(last), power = std::bit_floor(n);
  return n == power || (power >= 32 && n == power + power / 2);
}

Convergence::Convergence(const Adaptivity& wanted, int first, int most, size_t blocks)
    : wanted_(wanted),
      first_(first),
      most_(most),
      part_(first),
      ofSample_(blocks * kPixels, 0.f),
      lasting_(wanted.error > 0 ? blocks * kPixels : 0, 0.f),
      smoothed_(lasting_.size(), 0.f),
      taken_(blocks * kPixels, 0) {}

void Convergence::decide(NoiseEstimate& noise, int last, ActivePixels& active) {
  const int taken = last - first_;
  if (taken >= std::max(wanted_.least, 2) && part_ > first_) decideBy(noise, last, active);
  if (!std::has_single_bit(uint32_t(last))) return;
  noise.endPart();
  part_ = last;
}

void Convergence::decideBy(const NoiseEstimate& noise, int last, ActivePixels& active) {
  const int taken = last - first_;
  double squares = 0, pixels = 0, now[kPixels];
  for (size_t b = 0; b < active.blocks(); ++b) {
    const uint32_t on = active.active(b), in = active.inWindow(b);
    if (on) {
      int* const ofPixel = &taken_[b * kPixels];
      forEachBit(on, [&](size_t k) { ofPixel[k] = taken; });
      noise.squaredDeviations(b, part_ - first_, last - part_, ofPixel, wanted_.darkFalloff, now);
      forEachBit(on, [&](size_t k) { ofSample_[b * kPixels + k] = float(now[k] * taken); });
    }
    forEachBit(in, [&](size_t k) { squares += double(ofSample_[b * kPixels + k]) / taken_[b * kPixels + k]; });
    pixels += std::popcount(in);
  }
  error_ = std::sqrt(squares / std::max(pixels, 1.));
  if (wanted_.error > 0)
    decideByFrame(taken, active);
  else
    decideByBlock(taken, active);
}

void Convergence::decideByBlock(int taken, ActivePixels& active) {
  left_ = 0;
  const double wanted = double(wanted_.variance) * double(wanted_.variance);
  for (size_t b = 0; b < active.blocks(); ++b) {
    if (!active.active(b)) continue;
    double sum = 0;
    for (size_t k = 0; k < kPixels; ++k) sum += double(ofSample_[b * kPixels + k]);
    const double needed = sum / (kPixels * wanted);
    if (needed <= taken)
      active.stop(b);
    else
      left_ += std::popcount(active.inWindow(b)) * (std::min(needed, double(most_)) - taken);
  }
}

// The mean of a field of columns x rows values over each one and the eight around it. at(x, y): the value.
template <class At, class Put>
static void overNeighbours(int64_t columns, int64_t rows, const At& at, const Put& put) {
  for (int64_t y = 0; y < rows; ++y)
    for (int64_t x = 0; x < columns; ++x) {
      float sum = 0, count = 0;
      for (int64_t v = std::max<int64_t>(y - 1, 0); v <= std::min(y + 1, rows - 1); ++v)
        for (int64_t u = std::max<int64_t>(x - 1, 0); u <= std::min(x + 1, columns - 1); ++u, ++count)
          sum += at(u, v);
      put(x, y, sum / count);
    }
}

// A pixel that has been lucky so far, in missing a bright path that others know of, takes the word of its neighbours,
// and the fewer samples there are the more that of those further away.
void Convergence::smooth(int taken, const ActivePixels& active) {
  constexpr float kOfEarlier = 0.35f, kFar = 32;
  const auto columns = int64_t(active.columns()), rows = columns ? int64_t(active.blocks()) / columns : 0;
  std::vector<float> ofBlock(active.blocks()), around(active.blocks());
  for (size_t b = 0; b < active.blocks(); ++b) {
    forEachBit(active.active(b), [&](size_t k) {
      const float now = ofSample_[b * kPixels + k];
      float& x = lasting_[b * kPixels + k];
      x = x > 0 ? now + kOfEarlier * (x - now) : now;
    });
    for (size_t k = 0; k < kPixels; ++k) ofBlock[b] += lasting_[b * kPixels + k] / kPixels;
  }
  const float far = std::min(kFar / float(taken), 1.f);
  overNeighbours(
      columns, rows, [&](int64_t x, int64_t y) { return ofBlock[size_t(y * columns + x)]; },
      [&](int64_t x, int64_t y, float mean) { around[size_t(y * columns + x)] = far * mean; });
  constexpr int64_t kSide = ActivePixels::kSide;
  const auto indexOf = [&](int64_t x, int64_t y) {
    return size_t((y / kSide * columns + x / kSide) * int64_t(kPixels) + y % kSide * kSide + x % kSide);
  };
  overNeighbours(
      columns * kSide, rows * kSide, [&](int64_t x, int64_t y) { return lasting_[indexOf(x, y)]; },
      [&](int64_t x, int64_t y, float mean) {
        const size_t i = indexOf(x, y);
        smoothed_[i] = std::max({lasting_[i], mean, around[i / kPixels]});
      });
  // that says more than there is; the error of the picture stays what the last samples tell
  double told = 0, sum = 0;
  for (size_t b = 0; b < active.blocks(); ++b)
    forEachBit(active.inWindow(b), [&](size_t k) {
      const size_t i = b * kPixels + k;
      told += double(ofSample_[i]) / taken_[i];
      sum += double(smoothed_[i]) / taken_[i];
    });
  if (sum > told)
    for (float& x : smoothed_) x *= float(told / sum);
}

void Convergence::decideByFrame(int taken, ActivePixels& active) {
  smooth(taken, active);
  // What is left of the error of the whole when active pixels take `share` times their deviation, as far as that is more
  // than they have; pixels of nearly the same deviation together.
  struct Alike {
    double squares = 0, pixels = 0;
  };
  constexpr int kSteps = 32, kOctaves = 64;  // of the squares
  std::vector<Alike> alike(size_t(kSteps) * kOctaves);
  double ended = 0, pixels = 0;
  for (size_t b = 0; b < active.blocks(); ++b) {
    const uint32_t on = active.active(b);
    forEachBit(active.inWindow(b), [&](size_t k) {
      const double square = double(smoothed_[b * kPixels + k]);
      if (on >> k & 1) {
        const double step = kSteps * (std::log2(std::max(square, 1e-30)) + kOctaves / 2.);
        Alike& a = alike[size_t(std::clamp(step, 0., double(kSteps * kOctaves - 1)))];
        a.squares += square;
        ++a.pixels;
      } else {
        ended += square / taken_[b * kPixels + k];
      }
      ++pixels;
    });
  }
  std::erase_if(alike, [](const Alike& a) { return a.pixels == 0; });
  const auto needed = [&](double share, double square) {
    return std::clamp(share * std::sqrt(square), double(taken), double(std::max(most_, taken)));
  };
  const auto squaresAt = [&](double share) {
    double squares = ended;
    for (const Alike& a : alike) squares += a.squares / needed(share, a.squares / a.pixels);
    return squares;
  };
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
    uint32_t done = 0;
    const uint32_t in = active.inWindow(b);
    forEachBit(active.active(b), [&](size_t k) {
      const double samples = needed(high, double(smoothed_[b * kPixels + k]));
      if (samples < kNotWorth * taken)
        done |= 1u << k;
      else if (in >> k & 1)
        left_ += samples - taken;
    });
    active.stop(b, ActivePixels::Mask(done));
  }
}

}  // namespace kinora::render
