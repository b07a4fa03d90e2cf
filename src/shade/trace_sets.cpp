// Rays that see a subset of the objects (trace:reflectsubset and its like), and objects that are holes in the picture
// (Matte, trace:holdout). Worlds without either never come here.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/context_host.h"
#include "shade/keep_light_hits.h"

namespace kinora::shade {

uint32_t GroupState::maskOf(const RayList& list, uint32_t entry, bool clearShadow) const {
  const VertexState& left = ListHost::of(list).left;
  const TraceSet& set = world_.traceSets[left.traceSet[entry]];
  if (clearShadow) return set.clearShadow;
  float side = 0;
  for (int c = 0; c < 3; ++c) side += list.rays.d[c][entry] * left.Ng[c][entry];
  return side < 0 ? set.transmit : set.reflect;
}

void GroupState::closestInSets(const RayList& list, bool clearShadow, uint32_t n, const uint32_t* entries) {
  // one call for each mask among the rays; a ray's answer does not depend on the others of its call
  uint32_t* open = arena_.make<uint32_t>(padded(n));
  uint32_t* same = arena_.make<uint32_t>(padded(n));
  std::copy_n(entries, n, open);
  while (n) {
    const uint32_t mask = maskOf(list, open[0], clearShadow);
    uint32_t rest = 0, count = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (maskOf(list, open[i], clearShadow) == mask)
        same[count++] = open[i];
      else
        open[rest++] = open[i];
    }
    world_.world->closest(list.rays, list.hits, mask, count, same);
    n = rest;
  }
}

void GroupState::occludedInSets(const ShadowRays& rays, const float* radius, const float* spread, uint32_t* blocked,
                                bool clear) {
  const uint32_t n = rays.count, m = padded(n);
  float* x[10];
  for (float*& a : x) a = arena_.make<float>(m);
  uint32_t* list = arena_.make<uint32_t>(m);
  uint32_t* answer = arena_.make<uint32_t>(m);
  uint32_t* setOf = arena_.make<uint32_t>(m);
  forEachRun(rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    for (uint32_t i = first; i < run.end; ++i) setOf[i] = left.traceSet[rays.point[i]];
  });
  for (const TraceSet& set : world_.traceSets) {
    uint32_t k = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (&world_.traceSets[setOf[i]] != &set) continue;
      for (int c = 0; c < 3; ++c) {
        x[c][k] = rays.o[c][i];
        x[3 + c][k] = rays.d[c][i];
      }
      x[6][k] = rays.tMax[i];
      x[7][k] = rays.time[i];
      if (radius) {
        x[8][k] = radius[i];
        x[9][k] = spread[i];
      }
      list[k++] = i;
    }
    if (!k) continue;
    const float *o[3] = {x[0], x[1], x[2]}, *d[3] = {x[3], x[4], x[5]};
    world_.world->occluded(k, o, d, x[6], x[7], set.opaqueShadow | (clear ? set.clearShadow : 0u), answer,
                           radius ? x[8] : nullptr, radius ? x[9] : nullptr);
    for (uint32_t i = 0; i < k; ++i) blocked[list[i]] = answer[i];
  }
}

// A hole ends its camera ray without a trace: what lies behind is hidden, lights in front are seen.
void GroupState::endAtHoles(const RayList& list, uint32_t n, const uint32_t* entries) {
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    hole_[s] = INFINITY;
    if (std::isinf(list.hits.t[s])) continue;
    if (!world_.placementOf(list.hits.instance[s], list.hits.geometry[s]).hole) continue;
    hole_[s] = list.hits.t[s];
    list.hits.t[s] = INFINITY;
  }
}

void GroupState::dropLightsBehindHoles(LightHits* l) {
  keepLightHits(arena_, l, [&](uint32_t i) { return l->t[i] < hole_[l->slot[i]] || std::isinf(hole_[l->slot[i]]); });
}

}  // namespace kinora::shade
