// Adaptive sampling: where a frame still needs samples, decided at fixed counts of samples from the samples alone, so
// that threads, groups, crops and snapshots change no pixel. Frame asks ActivePixels which pixels a pass traces and
// hands retired samples to NoiseEstimate; Renderer asks between passes which pixels are done.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "image/image.h"

namespace kinora::render {

// What a frame wants of its pixels: one of the first two, or neither, and every pixel takes the same samples.
struct Adaptivity {
  float variance = 0;  // relative standard deviation at which a block of pixels is done; 0: not asked for
  float error =
      0;           // root mean square of that deviation over the picture at which the frame is done; 0: not asked for
  int least = 16;  // samples a pixel before the first decision
  float darkFalloff = 0.025f;  // added to the level that the deviation is relative to
  bool isOn() const { return variance > 0 || error > 0; }
  bool operator==(const Adaptivity&) const = default;
};

// Which pixels a pass traces, in blocks of 4 x 4: those of the raster's grid that touch the window, all of their pixels.
class ActivePixels {
 public:
  static constexpr int kSide = 4, kPixels = kSide * kSide;
  // Pixels of a block, row by row from the lowest bit.
  using Mask = uint16_t;
  static constexpr Mask kAll = 0xffff;
  // f(x, y) of those of a block by its first raster pixel.
  template <class F>
  static void forEach(Mask pixels, int x0, int y0, F&& f) {
    for (int k = 0; k < kPixels; ++k)
      if (pixels >> k & 1) f(x0 + k % kSide, y0 + k / kSide);
  }
  ActivePixels() = default;
  explicit ActivePixels(const image::Window& window);  // all are active
  // Of a block by its first raster pixel; blocks beside the window have none.
  Mask activeIn(int x, int y) const {
    const int64_t i = indexOf(x, y);
    return i < 0 ? Mask(0) : active_[size_t(i)];
  }
  bool anyIn(int x0, int y0, int x1, int y1) const;  // raster pixels, half open
  void stop(size_t block, Mask pixels = kAll);
  size_t blocks() const { return active_.size(); }
  size_t columns() const { return size_t(columns_); }  // blocks lie row by row
  Mask active(size_t block) const { return active_[block]; }
  Mask inWindow(size_t block) const;
  // -1: beside the window
  int64_t indexOf(int x, int y) const {
    const int bx = x / kSide - firstX_, by = y / kSide - firstY_;
    return x < 0 || y < 0 || bx < 0 || by < 0 || bx >= columns_ || by >= rows_ ? -1 : int64_t(by) * columns_ + bx;
  }
  uint64_t count() const { return count_; }  // active pixels within the window
  // Shows all that passes change to archive(value), which keeps or replaces it (render/checkpoint.cpp).
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.active_);
    archive(self.count_);
  }

 private:
  image::Window window_{};
  int firstX_ = 0, firstY_ = 0, columns_ = 0, rows_ = 0;
  std::vector<Mask> active_;
  uint64_t count_ = 0;
};

// The error of pixels from two parts of their samples: half the difference of two halves is an estimate of the pixel's
// error (the half-buffer estimate of Dammertz et al., "A Hierarchical Automatic Stopping Condition for Monte Carlo Global
// Illumination", 2010). The parts are those before and after the last power of two, each as evenly spread as so many
// samples can be; those of even and of odd index are not, and say up to 1.8 times the error. Sums are integers: any order
// of adding gives the same bits. Whole blocks are summed, also where a crop cuts them, so that a crop decides as the whole
// frame does.
class NoiseEstimate {
 public:
  explicit NoiseEstimate(size_t blocks) : sums_(blocks * kNumbers) {}
  static uint64_t bytesFor(size_t blocks) { return blocks * kNumbers * sizeof(int64_t); }
  // The calling thread owns the block until the pass ends. Values that are not finite count as 0. `tolerance`: how much
  // more noise than elsewhere is allowed where the sample is (attribute shade:relativepixelvariance), (0, 1000].
  void add(size_t block, int pixel, const float rgb[3], float tolerance) {
    int64_t* s = &sums_[block * kNumbers];
    s[kTolerance] += int64_t(tolerance * kToleranceStep + 0.5f);
    s += size_t(pixel) * 6 + 3;
    for (int c = 0; c < 3; ++c) s[c] += fixed(rgb[c]);
  }
  // All samples so far are earlier ones from now on.
  void endPart();
  // Squares of errors of means over the block's mean level plus `darkFalloff` and its mean tolerance, one a pixel and
  // the mean over channels; of pixels that have so many samples before and since the last endPart(). taken: samples of
  // each pixel, of all that count for the level.
  void squaredDeviations(size_t block, int earlier, int since, const int taken[ActivePixels::kPixels],
                         float darkFalloff, double out[ActivePixels::kPixels]) const;
  // See ActivePixels.
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.sums_);
  }

 private:
  static constexpr size_t kTolerance = ActivePixels::kPixels * 6;  // behind the sums by pixel, part, channel
  static constexpr size_t kNumbers = kTolerance + 1;
  static constexpr float kToleranceStep = 65536.f;
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

// The decisions. With Adaptivity::variance each block ends by itself, so that a crop decides as the whole frame does.
// With Adaptivity::error samples go where they lower the error of the whole picture most: in proportion to the
// deviation of a single sample (Neyman 1934), pixel by pixel. What few samples of a pixel say of that is little: its
// estimates of all decisions so far count, the last ones most; the eight pixels around it where they say more; and, the
// fewer samples there are the more, the blocks around it.
class Convergence {
 public:
  Convergence() = default;
  // `most`: samples a pixel at most, of a frame whose first has index `first`.
  Convergence(const Adaptivity& wanted, int first, int most, size_t blocks);
  static uint64_t bytesFor(size_t blocks) {
    return blocks * ActivePixels::kPixels * (3 * sizeof(float) + sizeof(int));
  }
  // Every active pixel has the samples up to index `last`, a decision point. Ends the pixels that are good enough, and
  // at powers of two the estimate's part.
  void decide(NoiseEstimate& noise, int last, ActivePixels& active);
  // As the last decision saw it: root mean square over pixels of the relative deviation, -1 before the first one, and
  // the samples that are expected to be taken from then on, pixel by pixel, -1 before the first one.
  double error() const { return error_; }
  double samplesLeft() const { return left_; }
  // See ActivePixels. What was asked for is not in it.
  template <class Self, class Archive>
  static void exchange(Self& self, Archive& archive) {
    archive(self.part_);
    archive(self.ofSample_);
    archive(self.lasting_);
    archive(self.smoothed_);
    archive(self.taken_);
    archive(self.error_);
    archive(self.left_);
  }

 private:
  void decideBy(const NoiseEstimate& noise, int last, ActivePixels& active);
  void decideByBlock(int taken, ActivePixels& active);
  void decideByFrame(int taken, ActivePixels& active);
  void smooth(int taken, const ActivePixels& active);
  Adaptivity wanted_;
  int first_ = 0, most_ = 0;
  int part_ = 0;  // index of the first sample of the estimate's newer part
  // By block and pixel, when it was last active: the squared relative deviation of one sample, as the last decision saw
  // it, as all of them did, and with its neighbours; how many samples it has.
  std::vector<float> ofSample_, lasting_, smoothed_;
  std::vector<int> taken_;
  double error_ = -1, left_ = -1;
};

}  // namespace kinora::render
