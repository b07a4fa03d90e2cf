// What manifold walks are asked to do; see manifold.h. Plain: set-up code of integrators fills it.
#pragma once
#include <cstdint>

namespace kinora {

struct ManifoldOptions {
  static constexpr uint32_t kMostInterfaces = 16;
  uint32_t interfaces = 0;     // boundaries that a path goes through at most; 0: no walks. At most kMostInterfaces
  uint32_t iterations = 20;    // Newton steps of a walk, those that were halved included
  bool findsAll = true;        // false: only what walks find that start straight towards the light; the rest is lost
  uint32_t mostTrials = 1000;  // after which a path counts as if it had been found again
};

}  // namespace kinora
