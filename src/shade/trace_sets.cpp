// Rays that see a subset of the objects (trace:reflectsubset and its like), and objects that are holes in the picture
// (Matte, trace:holdout). Worlds without either never come here.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/closest_by_mask.h"
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

MediaSight GroupState::mediaSeen(const RayList& list, uint32_t n, const uint32_t* entries) {
  const ListHost& host = ListHost::of(list);
  if (host.kind == RayKind::Camera) return {trace::kSeenByCamera};
  if (!world_.space->hasSubsets || !host.left.traceSet) return {trace::kSeenByIndirect};
  uint32_t* mask = arena_.make<uint32_t>(list.capacity);
  for (uint32_t i = 0; i < n; ++i) mask[entries[i]] = maskOf(list, entries[i], false);
  return {trace::kSeenByIndirect, mask};
}

MediaSight GroupState::mediaInShadows(const RayList& list, uint32_t n, const uint32_t* entries) {
  constexpr uint32_t kShadows = trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
  const VertexState& left = ListHost::of(list).left;
  if (!world_.space->hasSubsets || !left.traceSet) return {kShadows};
  uint32_t* mask = arena_.make<uint32_t>(list.capacity);
  for (uint32_t i = 0; i < n; ++i) {
    const TraceSet& set = world_.traceSets[left.traceSet[entries[i]]];
    mask[entries[i]] = set.opaqueShadow | set.clearShadow;
  }
  return {kShadows, mask};
}

void GroupState::closestInSets(const RayList& list, bool clearShadow, uint32_t n, const uint32_t* entries) {
  closestByMask(
      list, [&](uint32_t entry) { return maskOf(list, entry, clearShadow); }, n, entries);
}

void GroupState::occludedInSets(const ShadowRays& rays, const float* radius, const float* spread, uint32_t* blocked,
                                bool clear) {
  uint32_t* mask = arena_.make<uint32_t>(padded(rays.count));
  forEachRun(rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    for (uint32_t i = first; i < run.end; ++i) {
      const TraceSet& set = world_.traceSets[left.traceSet[rays.point[i]]];
      mask[i] = set.opaqueShadow | (clear ? set.clearShadow : 0u);
    }
  });
  occludedByMask(rays, mask, radius, spread, blocked);
}

void GroupState::occludedByMask(const ShadowRays& rays, const uint32_t* mask, const float* radius,
                                const float* spread, uint32_t* blocked) {
  const uint32_t m = padded(rays.count);
  float* x[10];
  for (float*& a : x) a = arena_.make<float>(m);
  uint32_t *list = arena_.make<uint32_t>(m), *answer = arena_.make<uint32_t>(m), *open = arena_.make<uint32_t>(m);
  for (uint32_t i = 0; i < rays.count; ++i) open[i] = i;
  for (uint32_t n = rays.count; n;) {
    const uint32_t asked = mask[open[0]];
    uint32_t k = 0, rest = 0;
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t i = open[j];
      if (mask[i] != asked) {
        open[rest++] = i;
        continue;
      }
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
    n = rest;
    const float *o[3] = {x[0], x[1], x[2]}, *d[3] = {x[3], x[4], x[5]};
    world_.world->occluded(k, o, d, x[6], x[7], asked, answer, radius ? x[8] : nullptr, radius ? x[9] : nullptr);
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
