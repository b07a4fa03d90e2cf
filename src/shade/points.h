// The wide kernel that turns listed hits into the arrays of a context. Internal to shade/.
#pragma once
#include <cstdint>

namespace kinora::shade {

struct PointsArgs {
  uint32_t n;                         // padded; slots are repeated at the end
  const uint32_t* slots;
  // by slot
  const float* o[3];
  const float* d[3];
  const float* t;
  const float* radius;
  const float* spread;
  const float* time;
  const uint32_t* seed;
  const uint32_t* index;
  // by point: geometric normal in render space (not unit), side +-1; normal (unit, oriented) or null: Ng is taken
  const float* ng[3];
  const float* side;
  const float* smooth[3];
  // out, by point
  float* P[3];
  float* N[3];
  float* Ng[3];
  float* wo[3];
  float* outRadius;
  float* outSpread;
  float* outTime;
  float* bias;
  uint32_t* entering;
  uint32_t* outSeed;
  uint32_t* outIndex;
};

using PointsKernel = void (*)(const PointsArgs&);
PointsKernel pointsKernel(uint32_t width);

}  // namespace kinora::shade
