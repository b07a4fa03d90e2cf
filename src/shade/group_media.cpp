// The stack of nested media that each path of a group carries.
#include <algorithm>

#include "shade/beer_lambert.h"
#include "shade/context_host.h"

namespace kinora::shade {

bool GroupState::insideHigherPriority(uint32_t slot) const {
  const MediaStack& m = media_[slot];
  if (!m.count) return false;
  const uint32_t inst = group_.hits.instance[slot];
  const int own = world_.placements[world_.world->instance(inst).user].priority;
  for (uint32_t i = 0; i < m.count; ++i)
    if (m.entries[i].object != inst && m.entries[i].priority > own) return true;
  return false;
}

void GroupState::media(uint32_t n, const uint32_t* slots, float* const transmittance[3]) {
  // Beer and Lambert along the segment just traced, in the innermost medium of the highest priority
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    const MediaStack& m = media_[s];
    if (!m.count) continue;
    uint32_t top = m.count - 1;
    for (uint32_t k = m.count; k-- > 0;)
      if (m.entries[k].priority > m.entries[top].priority) top = k;
    const float* a = m.entries[top].absorption;
    const float t = group_.hits.t[s];
    // a ray that escapes from inside a medium crosses it without end
    for (int c = 0; c < 3; ++c) transmittance[c][s] *= beerLambert(a[c], t);
  }
}

void GroupState::cross(const Context* c, uint32_t n, const uint32_t* points) {
  if (!media_ || !c->bxdf->interior) return;
  const ContextHost& h = ContextHost::of(c);
  if (!h.program->encloses) return;
  float* x[4];
  for (float*& y : x) y = c->alloc<float>(c->padded);
  const InteriorArgs a{x[0], {x[1], x[2], x[3]}};
  c->bxdf->interior(c, &a);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i], s = c->path[p];
    MediaStack& m = media_[s];
    const uint32_t object = group_.hits.instance[s];
    if (c->entering[p]) {
      if (m.count == MediaStack::kDepth) {
        ++counters.mediaOverflow;
        continue;
      }
      const PlacementInfo& place = world_.placements[world_.world->instance(object).user];
      m.entries[m.count++] = {object, place.priority, x[0][p], {x[1][p], x[2][p], x[3][p]}};
    } else {
      for (uint32_t k = m.count; k-- > 0;)
        if (m.entries[k].object == object) {
          for (uint32_t j = k; j + 1 < m.count; ++j) m.entries[j] = m.entries[j + 1];
          --m.count;
          break;
        }
    }
  }
}

}  // namespace kinora::shade
