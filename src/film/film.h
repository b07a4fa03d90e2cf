// A sample becomes a pixel here: the frame's sums. render/ adds sample records as groups retire, integrators splat
// light paths, displays and shards read it at barriers. Every sample is rounded once to fixed point and added as
// integers, and every other reducer keeps exact state, so the result depends on the set of samples alone: not on
// order, threads, buckets, SIMD width, or on which machine added which part. It does not draw sample positions
// (pixel_filter.h), write files (shard.h, display_output.h) or judge noise.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "film/channel.h"
#include "image/image.h"
#include "image/status.h"

namespace kinora::film {

using image::Status;
using image::Window;

// Depth of a pixel in which nothing was hit, as pictures hold it (RenderMan's infinity; finite, so that compositing
// arithmetic does not make NaN of it). Records say +infinity.
constexpr float kNoDepth = 1e38f;

// n samples as structure of arrays. Samples outside the film's window are ignored (a camera packet is always traced
// whole, also where a crop cuts it).
struct SampleSpan {
  int n = 0;
  const int32_t* x = nullptr;  // pixel of the full raster
  const int32_t* y = nullptr;
  const uint32_t* sampleIndex = nullptr;
  const float* weight = nullptr;         // of the importance-sampled pixel filter: about +1 or -c
  const float* const* values = nullptr;  // one array for each float of the record (ChannelLayout::recordFloats)
  const float* zeros = nullptr;          // not null: `values` that point there are n zeros, and cost nothing
  // One array for each of ChannelLayout::filters(): what that filter weighs the samples. Null: `weight` for all.
  const float* const* filterWeights = nullptr;
};

// n contributions of light paths to one channel. Values are for one pass: divided by the number of light paths a pass
// traces, so that the mean over passes is the pixel.
struct SplatSpan {
  int n = 0;
  int channel = 0;  // one with Channel::splats
  const int32_t* x = nullptr;
  const int32_t* y = nullptr;
  const uint32_t* pathIndex = nullptr;   // for messages only
  const float* const* values = nullptr;  // one array for each of the channel's floats
};

// A sample that held NaN or infinity and was dropped with its weight.
struct BadSample {
  int32_t y = 0, x = 0;
  uint32_t sampleIndex = 0;
  int32_t channel = 0;  // the first of the layout's channels that was not finite; -1: the weight
  float value = 0;
  bool isSplat = false;
};

struct FilmCounters {
  uint64_t nonFinite = 0;           // samples dropped
  uint64_t negative = 0;            // samples with a colour below 0 (kept)
  std::vector<uint64_t> saturated;  // a channel: values clamped to its limit
  std::vector<BadSample> bad;       // the first 16 by (y, x, sample index): the same for any order of adding
};

// What two states of one slot become together.
enum class SlotRule : uint8_t {
  Add,
  Maximum,  // extremes are encoded so that the larger integer wins and 0 is "no sample yet"
  Key,      // decides for the payload slots of its group: the larger key wins
  Payload
};

class Film {
 public:
  // Slots that every pixel begins with.
  static constexpr int kWeight = 0, kWeightEven = 1, kCount = 2, kCountEven = 3, kHeaderSlots = 4;
  static constexpr int kWeightStepLog2 = -30;
  static constexpr int kMaxResolution = 1 << 17;
  static constexpr size_t kKeptBad = 16;

  // Checks sizes and takes the memory, at most `maxBytes` of it. Null with the reason in `status`.
  static std::unique_ptr<Film> create(int width, int height, const Window& window, const ChannelLayout& layout,
                                      Status& status, uint64_t maxBytes = uint64_t(1) << 40);
  static uint64_t bytesNeeded(const Window& window, const ChannelLayout& layout);

  // No lock, no atomic: the calling thread owns the pixels of the span until it hands them on at a barrier.
  void addSamples(const SampleSpan& span);
  // From any thread, to any pixel, together with addSamples of others.
  void splat(const SplatSpan& span);
  void addSplatPasses(int64_t n) { splatPasses_.fetch_add(n, std::memory_order_relaxed); }

  // Adds the state of a film with the same raster, window and layout.
  Status merge(const Film& other);
  void clear();

  // While no thread adds. A pixel without samples is 0 in every channel.
  void resolvePixel(int channel, int x, int y, float* out) const;
  image::Image resolve(int channel) const;  // channels named "0", "1" ...; display_output.h gives them their names

  FilmCounters counters() const;
  int64_t splatPasses() const { return splatPasses_.load(std::memory_order_relaxed); }

  const ChannelLayout& layout() const { return layout_; }
  int width() const { return width_; }
  int height() const { return height_; }
  const Window& window() const { return window_; }
  uint64_t bytes() const;

  // Raw state, for shards, checkpoints and adaptivity.
  int slots() const { return slots_; }    // integers a pixel
  int stride() const { return stride_; }  // from pixel to pixel, in integers
  int firstSlot(int channel) const { return firstSlot_[size_t(channel)]; }
  int firstSplatSlot(int channel) const { return firstSplatSlot_[size_t(channel)]; }  // -1: takes no splats
  const int64_t* pixel(int x, int y) const { return state_.get() + offsetOf(x, y); }
  int64_t* pixel(int x, int y) { return state_.get() + offsetOf(x, y); }
  int64_t sampleCount(int x, int y) const { return pixel(x, y)[kCount]; }
  void addCounters(const FilmCounters& c, int64_t splatPasses);

 private:
  struct Free {
    void operator()(int64_t* p) const { std::free(p); }
  };
  // Three of each: all samples, even ones, odd ones. "Negative" are the weights below 0, turned positive. Filters of
  // channels follow, six of each: their weights and the negative ones.
  enum WeightKind : uint8_t {
    kFilter,
    kFilterEven,
    kFilterOdd,
    kOne,
    kOneEven,
    kOneOdd,
    kNegative,
    kNegativeEven,
    kNegativeOdd,
    kOwnFilters
  };
  static constexpr int kWeightKinds = kOwnFilters + 6 * ChannelLayout::kMaxFilters;
  static int kindOf(int filter) { return filter < 0 ? int(kFilter) : kOwnFilters + 6 * filter; }
  static int negativeKindOf(int filter) { return filter < 0 ? int(kNegative) : kOwnFilters + 6 * filter + 3; }
  // Steps of squares, for variances: a square of `limit` 2^20 (colours), 2^38 (data) still fits.
  static int squareStepLog2(const Channel& c) { return c.isData ? -8 : -26; }
  enum class SumOf : uint8_t {
    Value,
    Square,  // of value x weight, where the weights are alike
    Moment   // of value^2 x weight, where they are not
  };
  // A slot that takes value x weight, rounded: one float of a Sum, Average or Total channel.
  struct SumSlot {
    int record;      // float of the sample record; kTheWeight, kItsSquare
    uint8_t weight;  // WeightKind and on
    SumOf what;
    bool isAgain;  // of values that another slot sums too: saturation was counted there
    int16_t channel;
    double scale;  // 1 / step
    double limit;  // in steps
  };
  static constexpr int kTheWeight = -1, kItsSquare = -2;
  // What a channel of a filter needs beside the sums of value x weight; slots, -1: none.
  struct FilterSlots {
    int weight = -1;          // sum of the own filter's weights; without one the frame's are in the header
    int negative = -1;        // a filter with negative lobes: the channel's sums over the negative weights alone,
    int negativeWeight = -1;  // the sum of those,
    int weightSquares = -1;   // and for variances those of squared weights, of all and of the negative ones
    int negativeSquares = -1;
    int plain = -1;  // an own filter may weigh every sample 0: the plain sums stand in
  };
  struct ExtremeSlot {
    int slot, record;
    Half half;
    bool isMin;
  };
  struct Nearest {  // ZMin (0) or ZMax (1), of one Half each
    int keySlot = -1;
    Half half = Half::Both;
    bool isFar = false;
    std::vector<std::pair<int, int>> payload;  // slot, record float
  };

  Film() = default;
  void plan();
  size_t offsetOf(int x, int y) const {
    return (size_t(y - window_.y0) * size_t(window_.width()) + size_t(x - window_.x0)) * size_t(stride_);
  }
  void prefetchBlock(const SampleSpan& span, int first) const;
  void addBlock(const SampleSpan& span, int first, int n);
  uint32_t inspect(const SampleSpan& span, int first, int n);
  int channelReading(int record) const;
  void resolveFiltered(int channel, const int64_t* pixel, double count, double weight, double* out) const;
  double varianceOfMean(int channel, const int64_t* pixel, double weight, int component) const;
  void reportBad(const BadSample& bad);
  void countSaturated(const SampleSpan& span, int first, int n, int64_t* const* pixels, const double (*weights)[16]);
  void addExtremes(const SampleSpan& span, int first, int n, int64_t* const* pixels);
  void mergeNearest(const Nearest& group, int64_t* mine, int64_t key, const int64_t* payload) const;

  int width_ = 0, height_ = 0;
  Window window_;
  ChannelLayout layout_;
  int slots_ = 0, stride_ = 0;
  std::vector<SlotRule> rules_;
  std::vector<int> firstSlot_, firstSplatSlot_;
  std::vector<SumSlot> sums_;             // slot kHeaderSlots + i
  std::vector<FilterSlots> filterSlots_;  // by channel
  std::vector<ExtremeSlot> extremes_;
  std::vector<Nearest> nearest_;
  std::vector<uint8_t> infinityAllowed_;  // a record float: only extremes read it, so +-infinity is a value
  std::vector<uint8_t> countNegative_;    // a record float: read by a colour
  std::unique_ptr<int64_t, Free> state_;
  std::atomic<int64_t> splatPasses_{0};
  std::atomic<uint64_t> negative_{0}, nonFinite_{0};
  std::unique_ptr<std::atomic<uint64_t>[]> saturated_;
  mutable std::mutex badMutex_;  // taken only when something is wrong
  std::vector<BadSample> bad_;
};

}  // namespace kinora::film
