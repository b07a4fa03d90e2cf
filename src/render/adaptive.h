// Adaptive sampling: where a frame still needs samples, decided at fixed counts of samples from the samples alone, so
// that threads, groups, crops and snapshots change no pixel. Frame asks ActiveBlocks which blocks a pass traces and
// hands retired samples to NoiseEstimate; Renderer asks between passes which blocks are done.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "image/image.h"

namespace kinora::render {

// What a frame wants of its pixels.
struct Adaptivity {
  // Relative standard deviation at which a block of pixels is done; 0: every pixel takes the same samples.
  float variance = 0;
  int least = 16;              // samples a pixel before the first decision
  float darkFalloff = 0.025f;  // added to the level that the deviation is relative to
  bool isOn() const { return variance > 0; }
};

// Which blocks of 4 x 4 pixels a pass traces: those of the raster's grid that touch the window.
class ActiveBlocks {
 public:
  static constexpr int kSide = 4, kPixels = kSide * kSide;
  ActiveBlocks() = default;
  explicit ActiveBlocks(const image::Window& window);  // all are active
  // Of the block that a raster pixel is in; blocks beside the window are not active.
  bool isActive(int x, int y) const {
    const int64_t i = indexOf(x, y);
    return i >= 0 && isActive_[size_t(i)];
  }
  bool anyIn(int x0, int y0, int x1, int y1) const;  // raster pixels, half open
  void stop(size_t block);
  size_t blocks() const { return isActive_.size(); }
  bool isActive(size_t block) const { return isActive_[block]; }
  // -1: beside the window
  int64_t indexOf(int x, int y) const {
    const int bx = x / kSide - firstX_, by = y / kSide - firstY_;
    return x < 0 || y < 0 || bx < 0 || by < 0 || bx >= columns_ || by >= rows_ ? -1 : int64_t(by) * columns_ + bx;
  }
  uint64_t activePixels() const { return activePixels_; }  // within the window

 private:
  uint64_t pixelsOf(size_t block) const;
  image::Window window_{};
  int firstX_ = 0, firstY_ = 0, columns_ = 0, rows_ = 0;
  std::vector<uint8_t> isActive_;
  uint64_t activePixels_ = 0;
};

// The error of blocks from two halves of their samples, those of even and of odd index: half their difference is an
// estimate of the pixel's error (the half-buffer estimate of Dammertz et al., "A Hierarchical Automatic Stopping
// Condition for Monte Carlo Global Illumination", 2010). Sums are integers: any order of adding gives the same bits.
// Whole blocks are summed, also where a crop cuts them, so that a crop decides as the whole frame does.
class NoiseEstimate {
 public:
  explicit NoiseEstimate(size_t blocks) : sums_(blocks * kNumbers) {}
  static uint64_t bytesFor(size_t blocks) { return blocks * kNumbers * sizeof(int64_t); }
  // The calling thread owns the block until the pass ends. Values that are not finite count as 0.
  void add(size_t block, int pixel, uint32_t sampleIndex, const float rgb[3]) {
    int64_t* s = &sums_[block * kNumbers + size_t(pixel) * 6 + (sampleIndex & 1u) * 3];
    for (int c = 0; c < 3; ++c) s[c] += fixed(rgb[c]);
  }
  // Of a block whose pixels have so many samples of even and of odd index: the root mean square over pixels and
  // channels of the error of the mean, over the block's mean level plus `darkFalloff`.
  double relativeDeviation(size_t block, int even, int odd, float darkFalloff) const;

 private:
  static constexpr size_t kNumbers = ActiveBlocks::kPixels * 6;  // by pixel, half, channel
  static constexpr float kStep = 1.f / (1 << 20), kLimit = 65536.f;
  static int64_t fixed(float v) {
    // clamps NaN to 0 as well
    const float c = v > -kLimit ? (v < kLimit ? v : kLimit) : v <= -kLimit ? -kLimit : 0.f;
    return int64_t(c * (1.f / kStep));
  }
  std::vector<int64_t> sums_;
};

// Whether decisions are taken where every active pixel has the samples up to index `last`: powers of two and, from 32
// on, halfway between them. Passes end there however they are cut (Frame::passes).
bool isDecisionPoint(int last);
// Ends the blocks that are good enough. Returns whether some are left.
bool stopQuietBlocks(const Adaptivity& wanted, const NoiseEstimate& noise, int first, int last, ActiveBlocks& active);

}  // namespace kinora::render
