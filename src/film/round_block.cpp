#include "film/round_block.h"

#include <bit>
#include <cstring>

// Compiler vectors, so that no intrinsic is needed outside src/simd. The attribute is on each function: a -m flag for
// the file would leak instructions through shared inline functions.
#define KINORA_AVX2 __attribute__((target("avx2")))

namespace kinora::film {
namespace {

using V2i = int64_t __attribute__((vector_size(16), may_alias));
using V4d = double __attribute__((vector_size(32)));
using V4i = int64_t __attribute__((vector_size(32)));
using V4f = float __attribute__((vector_size(16)));
using V8f = float __attribute__((vector_size(32)));
using V8i = int32_t __attribute__((vector_size(32)));

// 1.5 x 2^52: adding it leaves the integer nearest (ties to even) in the low bits.
constexpr double kRounder = 6755399441055744.0;
constexpr int64_t kRounderBits = std::bit_cast<int64_t>(kRounder);

uint32_t bitsOf(const int32_t (&lanes)[kBlock]) {
  uint32_t bits = 0;
  for (int i = 0; i < kBlock; ++i) bits |= uint32_t(lanes[i] & 1) << i;
  return bits;
}

}  // namespace

int64_t roundToInt(double t) { return std::bit_cast<int64_t>(t + kRounder) - kRounderBits; }

KINORA_AVX2 void BlockCheck::look(const float* values, bool infinityAllowed, bool countNegative) {
  const V8i bound = V8i{} + (infinityAllowed ? 0x7f800000 : 0x7f7fffff);  // bits of infinity; of the largest float
  const V8i noted = V8i{} - int32_t(countNegative);
  for (int i = 0; i < kBlock; i += 8) {
    V8f x;
    V8i xBits, bad, negative;
    std::memcpy(&x, values + i, sizeof x);
    std::memcpy(&xBits, values + i, sizeof xBits);
    std::memcpy(&bad, bad_ + i, sizeof bad);
    std::memcpy(&negative, negative_ + i, sizeof negative);
    bad |= (xBits & 0x7fffffff) > bound;
    negative |= (x < 0.0f) & noted;
    std::memcpy(bad_ + i, &bad, sizeof bad);
    std::memcpy(negative_ + i, &negative, sizeof negative);
  }
}

KINORA_AVX2 bool isZeroBlock(const float* values) {
  V4i low, high;
  std::memcpy(&low, values, sizeof low);
  std::memcpy(&high, values + 8, sizeof high);
  low |= high;
  return (low[0] | low[1] | low[2] | low[3]) == 0;
}

uint32_t BlockCheck::bad() const { return bitsOf(bad_); }
uint32_t BlockCheck::negative() const { return bitsOf(negative_); }

KINORA_AVX2 bool roundBlock(const RoundInput* slots, int count, int64_t (*rounded)[kChunk]) {
  V4i clamped{};
  for (int s = 0; s < count; s += 2) {
    const RoundInput a = slots[s], b = slots[s + 1];
    const V4d highA = V4d{} + a.limit, highB = V4d{} + b.limit;
    for (int i = 0; i < kBlock; i += 4) {
      V4f fa, fb;
      V4d wa, wb;
      std::memcpy(&fa, a.values + i, sizeof fa);
      std::memcpy(&fb, b.values + i, sizeof fb);
      std::memcpy(&wa, a.weights + i, sizeof wa);
      std::memcpy(&wb, b.weights + i, sizeof wb);
      // float x float is exact in double, and the scale is a power of two: the rounding below is the only one
      const V4d ta = __builtin_convertvector(fa, V4d) * wa * a.scale;
      const V4d tb = __builtin_convertvector(fb, V4d) * wb * b.scale;
      V4d ua = ta < highA ? ta : highA, ub = tb < highB ? tb : highB;
      ua = ua > -highA ? ua : -highA;
      ub = ub > -highB ? ub : -highB;
      clamped |= ((V4i)ta ^ (V4i)ua) | ((V4i)tb ^ (V4i)ub);
      const V4i qa = (V4i)(ua + kRounder) - kRounderBits, qb = (V4i)(ub + kRounder) - kRounderBits;
      // from an array a float to the pixel's order: pairs of neighbouring slots
      const V4i even = __builtin_shuffle(qa, qb, V4i{0, 4, 2, 6}), odd = __builtin_shuffle(qa, qb, V4i{1, 5, 3, 7});
      *reinterpret_cast<V2i*>(&rounded[i][s]) = __builtin_shufflevector(even, even, 0, 1);
      *reinterpret_cast<V2i*>(&rounded[i + 1][s]) = __builtin_shufflevector(odd, odd, 0, 1);
      *reinterpret_cast<V2i*>(&rounded[i + 2][s]) = __builtin_shufflevector(even, even, 2, 3);
      *reinterpret_cast<V2i*>(&rounded[i + 3][s]) = __builtin_shufflevector(odd, odd, 2, 3);
    }
  }
  return (clamped[0] | clamped[1] | clamped[2] | clamped[3]) != 0;
}

KINORA_AVX2 void addRounded(int64_t* const* pixels, int n, const RoundedRun* runs, int runCount,
                            const int64_t (*rounded)[kChunk]) {
  for (int i = 0; i < n; ++i) {
    if (!pixels[i]) continue;
    for (int r = 0; r < runCount; ++r) {
      int64_t* sums = pixels[i] + runs[r].slot;
      const int64_t* add = rounded[i] + runs[r].from;
      const int count = runs[r].count;
      int k = 0;
      for (; k + 4 <= count; k += 4) {
        V4i s, a;
        std::memcpy(&s, sums + k, sizeof s);
        std::memcpy(&a, add + k, sizeof a);
        s += a;
        std::memcpy(sums + k, &s, sizeof s);
      }
      if (k < count) *reinterpret_cast<V2i*>(sums + k) += *reinterpret_cast<const V2i*>(add + k);
    }
  }
}

}  // namespace kinora::film
