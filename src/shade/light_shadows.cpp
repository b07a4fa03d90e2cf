// Shadows of lights that say what casts them, how far, and what they leave (light::ShadowControls): of shadow rays, and
// of rays that found such a light behind whatever may shadow it. What media take of the light is apart from all this.
#include "shade/light_shadows.h"

#include <algorithm>
#include <cmath>

#include "shade/closest_by_mask.h"
#include "shade/context_host.h"
#include "shade/keep_light_hits.h"

namespace kinora::shade {

// Occluders in front of the controls' farthest: of those that fade, the nearest opaque one counts, and each that lets
// light through. `rays` reach as far as occluders count.
void GroupState::controlShadows(uint32_t depth, const ShadowRays& rays) {
  const uint32_t n = rays.count, room = padded(n);
  auto** of = arena_.make<const light::ShadowControls*>(room);
  uint32_t *opaque = arena_.make<uint32_t>(room), *clear = arena_.make<uint32_t>(room);
  float* reach = arena_.make<float>(room);
  const TraceSet plain;
  forEachRun(rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    for (uint32_t i = first; i < run.end; ++i) {
      const uint32_t light = rays.light[i];
      const light::ShadowControls* c = of[i] = light == kNoLight ? nullptr : world_.lights->shadowControls(light);
      const TraceSet& set = left.traceSet ? world_.traceSets[left.traceSet[rays.point[i]]] : plain;
      const bool isNamed = c && c->opaque;
      opaque[i] = isNamed ? c->opaque : set.opaqueShadow;
      clear[i] = isNamed ? c->clear : set.clearShadow;
      reach[i] = c ? std::min(rays.tMax[i], c->farthest) : rays.tMax[i];
    }
  });
  const ControlledShadows controls{of, opaque, clear};
  ShadowRays near = rays;
  near.tMax = reach;
  uint32_t* blocked = arena_.make<uint32_t>(room);
  float *radius = nullptr, *spread = nullptr;
  findFootprints(near, &radius, &spread);
  occludedByMask(near, opaque, radius, spread, blocked);
  for (uint32_t i = 0; i < n; ++i) {
    const float t = blocked[i] ? 0.f : 1.f;
    for (float* T : rays.transmittance) T[i] = t;
  }
  fadeShadows(near, controls, blocked);
  if (world_.world->hasClearShadows()) walkClearShadows(depth, near, blocked, &controls);
  for (uint32_t i = 0; i < n; ++i)
    for (int c = 0; of[i] && c < 3; ++c) {
      float& t = rays.transmittance[c][i];
      t += (1 - t) * of[i]->color[c];
    }
}

// What opaque occluders leave of light whose shadows fade; rays that some comes through are not blocked.
void GroupState::fadeShadows(const ShadowRays& rays, const ControlledShadows& controls, uint32_t* blocked) {
  uint32_t* fading = arena_.make<uint32_t>(padded(rays.count));
  uint32_t m = 0;
  for (uint32_t i = 0; i < rays.count; ++i)
    if (blocked[i] && controls.of[i] && controls.of[i]->fade > 0) fading[m++] = i;
  if (!m) return;
  RayList& list = *makeRays(rays.count);
  copyRays(rays, list);
  for (uint32_t i = 0; i < rays.count; ++i) list.rays.spread[i] = spreadAlong(rays, i, list.rays.spread[i]);
  closestByMask(
      list, [&](uint32_t entry) { return controls.opaque[entry]; }, m, fading);
  for (uint32_t k = 0; k < m; ++k) {
    const uint32_t i = fading[k];
    const float t = 1 - controls.of[i]->strengthAt(list.hits.t[i]);
    for (float* T : rays.transmittance) T[i] = t;
    blocked[i] = !(t > 0);
  }
}

// Lights with controls that rays found where their samples could have: past what is in the way, which shadows them here
// as it does their samples.
void GroupState::shadowLightHits(const RayList& list, LightHits* hits) {
  // What needs no shadow ray: where shadows are the scene's own, the ray often says itself what one would find.
  enum class Way { Free, Blocked, Unknown };
  const ListHost& host = ListHost::of(list);
  const bool isFreeBefore = !world_.areShadowsUnseen && !world_.hasPresence && !world_.hasMedia;
  const auto wayOf = [&](uint32_t i) {
    const light::ShadowControls* c = world_.lights->shadowControls(hits->light[i]);
    const uint32_t s = hits->slot[i];
    if (!c || list.origin[s] & kFromDiscrete) return Way::Free;
    if (c->areSaid() || host.surfaceT) return Way::Unknown;
    if (!(hits->t[i] > list.hits.t[s])) return isFreeBefore ? Way::Free : Way::Unknown;
    const uint32_t asked =
        host.left.traceSet ? world_.traceSets[host.left.traceSet[s]].opaqueShadow : TraceSet().opaqueShadow;
    const PlacementInfo& met = world_.placementOf(list.hits.instance[s], list.hits.geometry[s]);
    return met.shadowCast & asked ? Way::Blocked : Way::Unknown;
  };
  keepLightHits(arena_, hits, [&](uint32_t i) { return wayOf(i) != Way::Blocked; });
  const uint32_t room = padded(hits->count) + kPad;
  uint32_t* at = arena_.make<uint32_t>(room);
  uint32_t n = 0;
  for (uint32_t i = 0; i < hits->count; ++i)
    if (wayOf(i) == Way::Unknown) at[n++] = i;
  if (!n) return;
  float *o[3], *d[3], *T[3], *radiance[3];
  for (int c = 0; c < 3; ++c) {
    o[c] = arena_.make<float>(room);
    d[c] = arena_.make<float>(room);
    T[c] = arena_.make<float>(room);
    radiance[c] = arena_.make<float>(room);
    std::copy_n(hits->radiance[c], hits->count, radiance[c]);
  }
  float *tMax = arena_.make<float>(room), *time = arena_.make<float>(room);
  uint32_t *slot = arena_.make<uint32_t>(room), *light = arena_.make<uint32_t>(room);
  uint32_t* tinted = arena_.make<uint32_t>(room);
  for (uint32_t k = 0; k < n; ++k) {
    const uint32_t i = at[k], s = slot[k] = hits->slot[i];
    for (int c = 0; c < 3; ++c) {
      o[c][k] = list.rays.o[c][s];
      d[c][k] = list.rays.d[c][s];
    }
    tMax[k] = hits->t[i] < 1e30f ? hits->t[i] * 0.99999f : 1e30f;
    time[k] = list.rays.time[s];
    light[k] = hits->light[i];
    tinted[k] = (list.origin[s] & kFromTintedLight) && !world_.lights->doesGlassBlock(light[k]);
  }
  const ShadowRun run{nullptr, &list, n};
  ShadowRays rays{n, {o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tMax, time, slot, 1, &run, tinted, {T[0], T[1], T[2]}};
  rays.light = light;
  if (world_.movesShadowOrigins) moveShadowOrigins(&rays);
  counters.shadowRays += n;
  const uint32_t depth = ListHost::of(list).depth;
  controlShadows(depth ? depth - 1 : 0, rays);
  for (uint32_t k = 0; k < n; ++k)
    for (int c = 0; c < 3; ++c) radiance[c][at[k]] *= T[c][k];
  for (int c = 0; c < 3; ++c) {
    hits->radiance[c] = radiance[c];
    if (!hits->specularRadiance[c]) continue;
    float* specular = arena_.make<float>(room);
    std::copy_n(hits->specularRadiance[c], hits->count, specular);
    for (uint32_t k = 0; k < n; ++k) specular[at[k]] *= T[c][k];
    hits->specularRadiance[c] = specular;
  }
}

}  // namespace kinora::shade
