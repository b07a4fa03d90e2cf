#include "light/light_marks.h"

#include <algorithm>
#include <cmath>

namespace kinora::light {

void markValues(const MarkEntry& m, uint32_t width, Arena& arena, const Context* c, const uint32_t* linkSet,
                float* const out[3]) {
  for (int k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < c->count; ++i) out[k][i] = m.isLinked[linkSet[i]] ? 1.f : 0.f;
  if (!m.filters.empty()) {
    const LightFilters of(arena, c->count);
    uint32_t* all = arena.make<uint32_t>(c->padded);
    for (uint32_t i = 0; i < c->padded; ++i) {
      const uint32_t e = std::min(i, c->count - 1);
      all[i] = i;
      float to[3], length2 = 0;
      for (int k = 0; k < 3; ++k) {
        of.in[k][i] = c->P[k][e];
        to[k] = m.center[k] - c->P[k][e];
        length2 += to[k] * to[k];
      }
      const float length = std::sqrt(length2);
      for (int k = 0; k < 3; ++k) of.in[3 + k][i] = length > 0 ? to[k] / length : c->N[k][e];
      of.in[6][i] = length;
      of.in[7][i] = c->time[e];
    }
    of.apply(width, m.filters, c->count, all, out, {});
  }
  for (int k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < c->count; ++i)
      out[k][i] = m.mark.color[k] * (m.mark.isInverted ? 1 - out[k][i] : out[k][i]);
}

}  // namespace kinora::light
