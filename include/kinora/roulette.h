// Russian roulette of paths.
#pragma once
#include <cstdint>

namespace kinora {

// From vertex `depth` on paths whose throughput is below the threshold go on with a probability in proportion to it; that
// of light paths, whose unit is the light's, as a share of what they began with. Weights of multiple importance sampling
// leave it out, which keeps their sum.
struct Roulette {
  uint32_t depth = 0xffffffffu;
  float threshold = 0;
};

}  // namespace kinora
