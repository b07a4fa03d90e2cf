#include "shade/beer_lambert.h"

#include "shade/one_lane.h"

namespace kinora::shade {

float beerLambert(float absorption, float distance) {
  if (!(absorption > 0)) return 1;
  const float depth = absorption * distance;
  return depth < 100 ? oneLane::exp(-depth) : 0;  // e^-88 is the least normal number
}
float freeDepth(float u) { return -oneLane::log(1.f - u); }

}  // namespace kinora::shade
