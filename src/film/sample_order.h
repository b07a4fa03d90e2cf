// How values that are chosen by their size stand in a film's integers: the larger integer wins, and 0 is "no sample
// yet". Written by film.cpp, read by film_resolve.cpp; shards keep them as they are.
#pragma once
#include <bit>
#include <cstdint>

namespace kinora::film {

// Order-preserving integer of a float: a < b exactly when ordered(a) < ordered(b). -0 is taken for +0.
inline uint32_t ordered(float f) {
  const uint32_t b = std::bit_cast<uint32_t>(f == 0.0f ? 0.0f : f);
  return b & 0x80000000u ? ~b : b | 0x80000000u;
}
inline float fromOrdered(uint32_t k) { return std::bit_cast<float>(k & 0x80000000u ? k & 0x7fffffffu : ~k); }

// Slots of extremes: the larger integer wins, 0 is "no sample".
inline int64_t encodeMin(float f) { return (int64_t(1) << 32) - ordered(f); }
inline float decodeMin(int64_t s) { return fromOrdered(uint32_t((int64_t(1) << 32) - s)); }
inline int64_t encodeMax(float f) { return int64_t(ordered(f)) + 1; }
inline float decodeMax(int64_t s) { return fromOrdered(uint32_t(s - 1)); }
// Depth above, sample index below, so that the lower index wins between equal depths. 31 bits of the index, so that
// the key stays positive.
inline int64_t encodeKey(float z, uint32_t sampleIndex, bool isFar) {
  const uint32_t depth = isFar ? ordered(z) : ~ordered(z);
  return int64_t((uint64_t(depth) << 31) | (~sampleIndex & 0x7fffffffu)) + 1;
}

}  // namespace kinora::film
