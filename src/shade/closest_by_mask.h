// Nearest hits of rays that ask for different things. Internal to shade/.
#pragma once
#include <algorithm>

#include "shade/group.h"

namespace kinora::shade {

// maskOf(entry): what the ray sees. One call for each mask among the rays; a ray's answer does not depend on the others
// of its call.
template <class MaskOf>
void GroupState::closestByMask(const RayList& list, const MaskOf& maskOf, uint32_t n, const uint32_t* entries) {
  uint32_t* open = arena_.make<uint32_t>(padded(n));
  uint32_t* same = arena_.make<uint32_t>(padded(n));
  std::copy_n(entries, n, open);
  while (n) {
    const uint32_t mask = maskOf(open[0]);
    uint32_t rest = 0, count = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (maskOf(open[i]) == mask)
        same[count++] = open[i];
      else
        open[rest++] = open[i];
    }
    world_.world->closest(list.rays, list.hits, mask, count, same);
    n = rest;
  }
}

}  // namespace kinora::shade
