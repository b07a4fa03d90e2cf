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
    const auto linksOf = [&](uint32_t i) { return m.filterLinks.empty() ? ~0ull : m.filterLinks[linkSet[i]]; };
    uint32_t *open = arena.make<uint32_t>(c->padded), *list = arena.make<uint32_t>(c->padded);
    for (uint32_t i = 0; i < c->count; ++i) open[i] = i;
    // points with the same filters on their objects at a time
    for (uint32_t n = c->count; n;) {
      const uint64_t links = linksOf(open[0]);
      uint32_t k = 0, rest = 0;
      for (uint32_t j = 0; j < n; ++j) {
        const uint32_t i = open[j];
        if (linksOf(i) == links)
          list[k++] = i;
        else
          open[rest++] = i;
      }
      n = rest;
      for (uint32_t j = 0; j < padded(k); ++j) {
        const uint32_t i = list[std::min(j, k - 1)];
        float to[3], length2 = 0;
        for (int q = 0; q < 3; ++q) {
          of.in[q][j] = c->P[q][i];
          to[q] = m.center[q] - c->P[q][i];
          length2 += to[q] * to[q];
        }
        const float length = std::sqrt(length2);
        for (int q = 0; q < 3; ++q) of.in[3 + q][j] = length > 0 ? to[q] / length : c->N[q][i];
        of.in[6][j] = length;
        of.in[7][j] = c->time[i];
      }
      of.apply(width, m.filters, k, list, out, {FilterUse::LitPoints, false, links});
    }
  }
  for (int k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < c->count; ++i)
      out[k][i] = m.mark.color[k] * (m.mark.isInverted ? 1 - out[k][i] : out[k][i]);
}

}  // namespace kinora::light
