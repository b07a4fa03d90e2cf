// Alpha of camera rays that escape through media, for integrators.
#pragma once
#include <kinora/integrator.h>

namespace kinora {

// Covers the listed slots whose rays met nothing by what media have taken of what is behind: of the mean channel.
// `media`: transmittance by slot, from trace() at depth 0. Before lights that the camera sees, which cover all.
inline void coverByMedia(Group* g, const Services* services, uint32_t n, const uint32_t* slots,
                         const float* const media[3]) {
  uint32_t* covered = static_cast<uint32_t*>(services->alloc(g, (n + kPad) * sizeof(uint32_t)));
  float* alpha = static_cast<float*>(services->alloc(g, (n + kPad) * sizeof(float)));
  uint32_t m = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const float through = (media[0][s] + media[1][s] + media[2][s]) * (1.f / 3.f);
    if (g->paths.hits.t[s] < 3e38f || through > 0.9999f) continue;
    covered[m] = s;
    alpha[m++] = 1.f - through;
  }
  if (m) services->cover(g, m, covered, alpha);
}

}  // namespace kinora
