// Shadow rays through what lets part of the light pass.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/context_host.h"
#include "shade/light_shadows.h"

namespace kinora::shade {

// What shadow rays are asked with where they pass a surface or a medium: the state of the vertices that they left.
void GroupState::copyRays(const ShadowRays& rays, RayList& list) {
  const ListHost& host = ListHost::of(list);
  for (int c = 0; c < 3; ++c) {
    std::memcpy(list.rays.o[c], rays.o[c], rays.count * sizeof(float));
    std::memcpy(list.rays.d[c], rays.d[c], rays.count * sizeof(float));
  }
  std::memcpy(list.rays.tMax, rays.tMax, rays.count * sizeof(float));
  std::memcpy(list.rays.time, rays.time, rays.count * sizeof(float));
  forEachRun(rays, [&](const ShadowRun& run, const VertexState& left, uint32_t first) {
    const bool ofContext = run.context;
    const float* radius = ofContext ? run.context->radius : run.list->rays.radius;
    const float* spread = ofContext ? run.context->spread : run.list->rays.spread;
    const uint32_t* seed = ofContext ? run.context->sampleSeed : run.list->sampleSeed;
    const uint32_t* index = ofContext ? run.context->sampleIndex : run.list->sampleIndex;
    for (uint32_t i = first; i < run.end; ++i) {
      const uint32_t p = rays.point[i];
      list.rays.radius[i] = radius[p];
      list.rays.spread[i] = spread[p];
      list.sampleSeed[i] = seed[p];
      list.sampleIndex[i] = index[p];
      if (left.traceSet) host.left.traceSet[i] = left.traceSet[p];
      if (left.bounces) host.left.bounces[i] = left.bounces[p];
    }
  });
}

// The distance that a ray goes on beyond a hit to be past it, from where the hit was asked for.
float GroupState::distanceBeyond(const Rays& r, uint32_t s, float t) {
  float size = t;
  for (int c = 0; c < 3; ++c) size = std::max(size, std::fabs(r.o[c][s] + r.d[c][s] * t));
  return t + size * 8e-6f + 1e-7f;
}

RayList& GroupState::raysOfHits(const RayList& from, uint32_t n, const trace::World::CollectedHit* hits) {
  RayList& list = *makeRays(n);
  ListHost& host = ListHost::of(list);
  host.kind = ListHost::of(from).kind;
  host.left.media = nullptr;
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t s = hits[std::min(i, n - 1)].slot;
    copyRay(from, s, list, i);
    list.rays.tMax[i] = from.rays.tMax[s];
  }
  world_.world->resolve(list.rays, n, hits, list.hits);
  return list;
}

// Surfaces that rays pass next, as entries of a list; which ray each is of (null: of that of its own number).
struct GroupState::ClearSurfaces {
  RayList* list;
  uint32_t count;
  const uint32_t *entries, *owner;
};

// Of each open ray the nearest, or, by one walk of the hierarchy, as many as World::collectClear() gives. Rays that may
// pass more stay in `open`, with their last hit in list.hits.t.
GroupState::ClearSurfaces GroupState::nextClearSurfaces(RayList& list, uint32_t& openCount, uint32_t* open) {
  const trace::World& w = *world_.world;
  uint32_t going = 0;
  if (w.hasUserGeometry() || ListHost::of(list).left.traceSet || ListHost::of(list).clearMask) {
    closest(list, openCount, open);
    for (uint32_t i = 0; i < openCount; ++i)
      if (!std::isinf(list.hits.t[open[i]])) open[going++] = open[i];
    openCount = going;
    uint32_t* entries = arena_.make<uint32_t>(padded(going));  // `open` is thinned out while these are looked at
    std::copy_n(open, going, entries);
    return {&list, going, entries, nullptr};
  }
  uint32_t* beyond = arena_.make<uint32_t>(padded(openCount));
  w.collectClear(list.rays, openCount, open, collected_, beyond);
  // a surface is passed once where its triangles meet
  uint32_t n = 0, ray = 0;
  float past = 0;
  for (size_t k = 0; k < collected_.size(); ++k) {
    const trace::World::CollectedHit& hit = collected_[k];
    if (k == 0 || hit.slot != ray) past = 0;
    ray = hit.slot;
    list.hits.t[ray] = hit.t;
    if (hit.t < past) continue;
    past = distanceBeyond(list.rays, ray, hit.t);
    collected_[n++] = hit;
  }
  for (uint32_t i = 0; i < openCount; ++i)
    if (beyond[i]) open[going++] = open[i];
  openCount = going;
  uint32_t* entries = arena_.make<uint32_t>(padded(n));
  uint32_t* owner = arena_.make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    entries[i] = i;
    owner[i] = collected_[i].slot;
  }
  return {n ? &raysOfHits(list, n, collected_.data()) : &list, n, entries, owner};
}

// Shadow rays that nothing opaque blocks go through what lets light pass.
void GroupState::walkClearShadows(uint32_t depth, const ShadowRays& rays, const uint32_t* blocked,
                                  const ControlledShadows* controls) {
  const uint32_t n = rays.count;
  RayList& list = *makeRays(n);
  ListHost& host = ListHost::of(list);
  host.kind = RayKind::Transmission;
  host.left.media = nullptr;  // straight rays know no media
  float* passed = nullptr;    // of controlled shadows, which know distances
  if (controls) {
    host.clearMask = controls->clear;
    passed = arena_.make<float>(padded(n));
    std::fill_n(passed, n, 0.f);
  }
  copyRays(rays, list);
  for (uint32_t i = 0; i < n; ++i) list.rays.spread[i] = spreadAlong(rays, i, list.rays.spread[i]);
  uint32_t* open = arena_.make<uint32_t>(padded(n));
  uint32_t k = 0;
  for (uint32_t i = 0; i < n; ++i)
    if (!blocked[i] && rays.tMax[i] > 0) open[k++] = i;
  for (int pass = 0; k && pass < kMostPasses; ++pass) {
    const ClearSurfaces met = nextClearSurfaces(list, k, open);
    Context* const* contexts;
    const uint32_t count =
        shade(*met.list, kTraitEyePath | kTraitPresenceQuery, depth, met.count, met.entries, &contexts);
    for (uint32_t c = 0; c < count; ++c) {
      const Context* x = contexts[c];
      float* presence = x->alloc<float>(x->padded);
      if (x->bxdf->presence)
        x->bxdf->presence(x, presence);
      else
        std::fill_n(presence, x->padded, 1.f);
      float* keep[3] = {nullptr, nullptr, nullptr};
      if (rays.tinted && (x->traits & kTraitTinted)) {
        for (float*& q : keep) q = x->alloc<float>(x->padded);
        x->bxdf->thinShadow(x, keep);
      }
      // Rays to lights alone: they are found beyond such surfaces by rays as well (ShadowControls::areOthers).
      const int32_t colored = controls ? ContextHost::of(x).program->shadowColor : -1;
      const Value color = colored >= 0 ? x->param(uint32_t(colored)) : Value();
      for (uint32_t i = 0; i < x->count; ++i) {
        const uint32_t s = met.owner ? met.owner[x->path[i]] : x->path[i];
        for (int q = 0; q < 3; ++q) {
          const bool isTinted = keep[q] && (rays.tinted[s] == 1 || (rays.tinted[s] && !(x->traits & kTraitWalkable)));
          const float pass1 = (1.f - presence[i]) + (isTinted ? presence[i] * keep[q][i] : 0.f);
          float passes = std::clamp(pass1, 0.f, 1.f);
          if (colored >= 0 && controls->of[s]) {
            const float share = color.data[q][color.stride ? i : 0];
            passes += (1 - passes) * (share > 0 ? std::min(share, 1.f) : 0.f);
          }
          if (controls && controls->of[s])
            passes = 1 - (1 - passes) * controls->of[s]->strengthAt(passed[s] + met.list->hits.t[x->path[i]]);
          rays.transmittance[q][s] *= passes;
        }
      }
    }
    uint32_t lit = 0;
    for (uint32_t i = 0; i < k; ++i) {
      const uint32_t s = open[i];
      if (rays.transmittance[0][s] > 0 || rays.transmittance[1][s] > 0 || rays.transmittance[2][s] > 0)
        open[lit++] = s;
    }
    k = lit;
    passThrough(list, k, open, passed);
  }
  counters.endlessRays += k;
  for (uint32_t i = 0; i < k; ++i)
    for (float* T : rays.transmittance) T[open[i]] = 0;
}

}  // namespace kinora::shade
