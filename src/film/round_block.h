// The inner loops of Film: a block of 16 samples is checked, rounded to fixed point and added. Called by film.cpp
// only. They need AVX2, which is the least CPU that Kinora runs on; the bits do not depend on the width, because
// every lane is rounded on its own by the same IEEE operations. Nothing here knows what a channel is.
#pragma once
#include <cstdint>

namespace kinora::film {

constexpr int kBlock = 16;
// Slots that are rounded before the block's pixels are touched: kBlock x kChunk x 8 bytes = 4 KiB stay in L1.
constexpr int kChunk = 32;

// The integer nearest to t, ties to even, for |t| < 2^51.
int64_t roundToInt(double t);

// Which of a block's samples hold something not finite, and which a negative value where that counts (bit i: sample
// i).
class BlockCheck {
 public:
  // 16 floats of one record entry. `infinityAllowed`: only NaN is bad. `countNegative`: values below 0 are noted.
  void look(const float* values, bool infinityAllowed, bool countNegative);
  uint32_t bad() const;
  uint32_t negative() const;

 private:
  alignas(32) int32_t bad_[kBlock] = {};
  alignas(32) int32_t negative_[kBlock] = {};
};

// True when all 16 floats are +0: adding them changes no sum.
bool isZeroBlock(const float* values);

// One float of the record for a block: values and weights of 16 samples, 1 / step, and the limit in steps.
struct RoundInput {
  const float* values;
  const double* weights;  // 16-byte aligned
  double scale, limit;
};

// rounded[sample][slot] = nearest integer of clamp(value x weight x scale, +-limit). `count` is even, at most kChunk.
// True when anything was clamped (or is not a number).
bool roundBlock(const RoundInput* slots, int count, int64_t (*rounded)[kChunk]);

// Neighbouring slots of a pixel, and where their values stand among those rounded.
struct RoundedRun {
  int slot, from, count;  // count even
};
// pixels[i][slot ..] += rounded[i][from ..] for each run and each of n samples whose pixel is not null; 16-byte
// aligned.
void addRounded(int64_t* const* pixels, int n, const RoundedRun* runs, int runCount,
                const int64_t (*rounded)[kChunk]);

}  // namespace kinora::film
