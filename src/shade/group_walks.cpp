// What manifold walks ask of a group (kinora/manifold.h): nearest surfaces that they go through, and places on lights.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/passed_rays.h"

namespace kinora::shade {

void GroupState::traceWalks(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries) {
  const Clock clock(counters.nanoseconds[kTimeTraceIndirect]);
  const trace::World& w = *world_.world;
  ListHost& host = ListHost::of(list);
  const Hits& hits = list.hits;
  host.kind = RayKind::Indirect;
  w.closest(list.rays, hits, trace::kSeenByWalks, n, entries);
  counters.indirectRays += n;
  if (!host.left.media) return;
  uint32_t* open = arena_.make<uint32_t>(padded(n));
  std::memcpy(open, entries, n * sizeof(uint32_t));
  PassedRays passed(arena_, list, n, entries);
  uint32_t m = n;
  for (int pass = 0; m; ++pass) {
    uint32_t k = 0;
    for (uint32_t i = 0; i < m; ++i) {
      const uint32_t s = open[i];
      if (std::isinf(hits.t[s]) ||
          !world_.materials->encloses(world_.materialOf(hits.instance[s], hits.geometry[s])) ||
          !insideHigherPriority(list, s))
        continue;
      open[k++] = s;
    }
    m = k;
    if (!m) break;
    if (pass == kMostPasses) {
      counters.endlessRays += m;
      for (uint32_t i = 0; i < m; ++i) hits.t[open[i]] = INFINITY;
      break;
    }
    crossDisplaced(list, depth, m, open);
    passThrough(list, m, open, passed.remember(m, open));
    w.closest(list.rays, hits, trace::kSeenByWalks, m, open);
  }
  passed.restore();
}

void GroupState::walkTargets(uint32_t n, const float* const u[5], const float* time, WalkTargets* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  world_.lights->walkTargets(world_.width, arena_, n, u, time, out);
}

void GroupState::deltaLights(const RayList& list, uint32_t n, const uint32_t* entries, const uint32_t* light,
                             float* const radiance[3], float* specular) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  float *P[3], *value[3], *time = arena_.make<float>(padded(n) + kPad);
  uint32_t* which = arena_.make<uint32_t>(padded(n) + kPad);
  const uint32_t* sets = ListHost::of(list).left.linkSet;
  uint32_t* set = arena_.make<uint32_t>(padded(n) + kPad);
  for (int c = 0; c < 3; ++c) {
    P[c] = arena_.make<float>(padded(n) + kPad);
    value[c] = arena_.make<float>(padded(n) + kPad);
  }
  for (uint32_t i = 0; n && i < padded(n); ++i) {
    const uint32_t s = entries[std::min(i, n - 1)];
    for (int c = 0; c < 3; ++c) P[c][i] = list.rays.o[c][s];
    time[i] = list.rays.time[s];
    which[i] = light[s];
    set[i] = world_.hasLinks ? sets[s] : 0;
  }
  float* factor = arena_.make<float>(padded(n) + kPad);
  world_.lights->deltaLights(world_.width, arena_, n, P, time, which, set, value, factor);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    const bool isLit = world_.lights->isLinked(set[i], which[i]);
    for (int c = 0; c < 3; ++c) radiance[c][s] = isLit ? value[c][i] : 0.f;
    specular[s] = factor[i];
  }
}

}  // namespace kinora::shade
