// Where random numbers come from, for plain code: the table, the addresses, the hashes. random.h draws from it in
// kernels.
#pragma once
#include <cstdint>

namespace kinora {
// sets x samples x and y coordinates as 32-bit fractions, set-major: x of sample i of set s is at
// xs[s * samples + i with its logSamples bits in reverse]. logSamples is at most 16.
struct SampleTable {
  const uint32_t* xs;
  const uint32_t* ys;
  uint32_t logSets, logSamples;  // both powers of two
  // Dimensions that are stratified with each other: `orders` has a row of `samples` entries for each, the place within
  // a set of the pixel's i-th sample. rowOf: by dimension below kMatchedDimensions; kHashedOrder: a hash shuffles.
  const uint32_t* orders;
  const uint8_t* rowOf;
};
inline constexpr uint32_t kMatchedDimensions = 80;
inline constexpr uint8_t kHashedOrder = 0xff;
// Or-ed to a dimension where the index is not that of a camera path among its pixel's, so that no other dimension can
// be matched with it: sub-samples of a split, light paths.
inline constexpr uint32_t kOwnIndex = 0x80000000u;
// The dimension of sub-sample `part` of `parts`, whose index is the sample's times `parts` plus `part`.
inline constexpr uint32_t subSampled(uint32_t dimension, uint32_t part, uint32_t parts) {
  return part || parts != 1 ? dimension | kOwnIndex : dimension;
}
// 32-bit mix of two words (constants of "lowbias32", C. Wellons, 2018).
inline uint32_t hashWords(uint32_t a, uint32_t b) {
  uint32_t x = a ^ (b * 0x9E3779B9u + 0x85EBCA6Bu);
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}
// Seed of a pixel; x and y are raster coordinates.
inline uint32_t pixelSeed(int x, int y, uint32_t frameSeed) {
  return hashWords(hashWords(frameSeed, uint32_t(x)), uint32_t(y) + 0x51633e2du);
}
// Sample indices below this number are a pixel's own; sub-samples that are sequences over its samples by themselves lie
// as many times that higher as their number says.
inline constexpr uint32_t kSequenceOfPart = 1u << 24;
// Dimensions: each names a pair of numbers. A path vertex at depth d owns kDimsPerDepth of them from dimensionAt(d).
inline constexpr uint32_t kDimFilter = 0, kDimLens = 1, kDimTime = 2, kDimFirstVertex = 8, kDimsPerDepth = 16;
inline constexpr uint32_t dimensionAt(uint32_t depth) { return kDimFirstVertex + depth * kDimsPerDepth; }
enum VertexDimension : uint32_t {  // offsets within a vertex's dimensions
  kDimBxdf = 0,
  kDimLobe = 1,
  kDimRoulette = 2,  // and, of the pair's second number, which light sample of several is followed
  kDimLightChoice = 3,
  kDimLight = 4,
  kDimGuide = 5,        // of directions that a frame has learned (guiding.h)
  kDimMedium = 6,       // where the ray on the way here is scattered
  kDimGuideChoice = 7,  // between those and the material's own
  kDimUser = 8,
  kDimPattern = 13,  // of patterns that trace, and the one behind it
  kDimBelow = 15     // of paths below the surface, and of directions that they come out in
};
}  // namespace kinora
