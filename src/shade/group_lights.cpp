// Lights seen from a group: samples for points, lights met by rays, shadow rays through what lets light pass.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/keep_light_hits.h"

namespace kinora::shade {

void GroupState::lightSamples(const Context* c, uint32_t part, uint32_t parts, LightSamples* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  float* u[4];
  for (float*& x : u) x = arena_.make<float>(c->padded);
  const uint32_t dim = dimensionAt(c->depth);
  const DrawSplit draw = drawSplit(world_.width);
  if (world_.lights->hasChoice())
    draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLightChoice, part, parts, u[0], u[3]);
  draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLight, part, parts, u[1], u[2]);
  light::LightSet::Points p;
  p.count = c->count;
  p.padded = c->padded;
  for (int k = 0; k < 3; ++k) {
    p.P[k] = c->P[k];
    p.N[k] = ContextHost::of(c).lightN[k];
  }
  p.time = c->time;
  if (world_.hasLinks) {
    uint32_t* sets = arena_.make<uint32_t>(c->padded);
    for (uint32_t i = 0; i < c->padded; ++i) sets[i] = linkSet_[c->path[i]];
    p.linkSet = sets;
  }
  p.uChoice[0] = u[0];
  p.uChoice[1] = u[3];
  p.u[0] = u[1];
  p.u[1] = u[2];
  world_.lights->sample(world_.width, arena_, p, out);
}

void GroupState::setLightNormals(Context* c, const Program* program) {
  if (!lightN_[0]) return;
  // Materials that let light through are lit from behind as well; how much is theirs to know.
  float scale = 0;
  if (program && !program->encloses && !program->tints) {
    scale = 1;
    for (uint32_t l = 0; program->traits && l < program->traits->lobeCount; ++l)
      if (program->traits->lobes[l].flags & kLobeTransmit) scale = 0.5f;
  }
  ContextHost& h = ContextHost::of(c);
  for (int k = 0; k < 3; ++k) {
    float* n = arena_.make<float>(c->padded);
    for (uint32_t i = 0; i < c->padded; ++i) n[i] = scale * c->N[k][i];
    for (uint32_t i = 0; i < c->count; ++i) lightN_[k][c->path[i]] = n[i];
    h.lightN[k] = n;
  }
}

void GroupState::lightHits(RayKind kind, uint32_t n, const uint32_t* slots, LightHits* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  light::LightSet::RayList l;
  l.count = n;
  l.slots = slots;
  l.rays = &group_.rays;
  l.tHit = group_.hits.t;
  l.linkSet = linkSet_;
  l.origin = group_.origin;
  for (int k = 0; k < 3; ++k) l.N[k] = lightN_[k];
  world_.lights->hits(world_.width, arena_, kind == RayKind::Camera, l, out);
  if (hole_ && kind == RayKind::Camera && out->count) dropLightsBehindHoles(out);
}

void GroupState::lightsBeyond(uint32_t n, const uint32_t* slots, LightHits* out) {
  *out = LightHits{};
  uint32_t* list = arena_.make<uint32_t>(padded(n));
  uint32_t m = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = slots[i];
    if (std::isinf(group_.hits.t[s])) continue;
    if (world_.materials->tints(world_.materialOf(group_.hits.instance[s]))) list[m++] = s;
  }
  if (!m) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  // all along the ray, then without those that lightHits() has told of: in front of the hit, or casting no shadows
  float* tHit = arena_.make<float>(group_.padded + kPad);
  for (uint32_t i = 0; i < m; ++i) tHit[list[i]] = INFINITY;
  light::LightSet::RayList l;
  l.count = m;
  l.slots = list;
  l.rays = &group_.rays;
  l.tHit = tHit;
  l.linkSet = linkSet_;
  l.origin = group_.origin;
  for (int k = 0; k < 3; ++k) l.N[k] = lightN_[k];
  world_.lights->hits(world_.width, arena_, false, l, out);
  keepLightHits(arena_, out, [&](uint32_t i) {
    return world_.lights->castsShadow(out->light[i]) && out->t[i] > group_.hits.t[out->slot[i]];
  });
}

void GroupState::shadow(uint32_t depth, const ShadowRays* rays) {
  const uint32_t n = rays->count;
  if (!n) return;
  ShadowRays lifted;
  if (lift_[0]) {
    lifted = *rays;
    liftShadows(&lifted);
    rays = &lifted;
  }
  counters.shadowRays += n;
  if (listener) listener->shadow(depth, *rays);
  const Clock clock(counters.nanoseconds[kTimeTraceShadow]);
  const trace::World& w = *world_.world;
  uint32_t* blocked = arena_.make<uint32_t>(padded(n));
  float *radius = nullptr, *spread = nullptr;
  if (w.hasUserGeometry()) {
    // footprints where the paths' own rays ended choose the level
    radius = arena_.make<float>(padded(n));
    spread = arena_.make<float>(padded(n));
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = rays->slot[i];
      const float t = group_.hits.t[s];
      spread[i] = group_.rays.spread[s];
      radius[i] = group_.rays.radius[s] + (std::isinf(t) ? 0.f : t * spread[i]);
    }
  }
  if (traceSet_)
    occludedInSets(*rays, radius, spread, blocked);
  else
    w.occluded(n, rays->o, rays->d, rays->tMax, rays->time, trace::kSeenByOpaqueShadow, blocked, radius, spread);
  for (uint32_t i = 0; i < n; ++i) {
    const float t = blocked[i] ? 0.f : 1.f;
    for (int c = 0; c < 3; ++c) rays->transmittance[c][i] = t;
  }
  if (!w.hasClearShadows()) return;
  // Survivors walk through what lets light pass, nearest first, in a ray list of their own that borrows the group.
  const Rays keepRays = group_.rays;
  const Hits keepHits = group_.hits;
  uint32_t *const keepSeed = seed_, *const keepIndex = index_;
  uint32_t* const keepLinks = linkSet_;
  uint32_t* const keepSets = traceSet_;
  uint32_t* sets = traceSet_ ? arena_.make<uint32_t>(padded(n) + kPad) : nullptr;
  MediaStack* const keepMedia = media_;
  const uint32_t m = padded(n) + kPad;
  const auto f = [&] { return arena_.make<float>(m); };
  const auto u = [&] { return arena_.make<uint32_t>(m); };
  Rays r;
  Hits h;
  for (int c = 0; c < 3; ++c) {
    r.o[c] = f();
    r.d[c] = f();
    h.ng[c] = f();
    std::memcpy(r.o[c], rays->o[c], n * 4);
    std::memcpy(r.d[c], rays->d[c], n * 4);
  }
  r.tMax = f();
  r.time = f();
  r.radius = f();
  r.spread = f();
  h.t = f();
  h.u = f();
  h.v = f();
  h.instance = u();
  h.geometry = u();
  h.primitive = u();
  h.level = u();
  uint32_t *seed = u(), *index = u(), *open = u(), *links = u();
  uint32_t k = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = rays->slot[i];
    r.tMax[i] = rays->tMax[i];
    r.time[i] = rays->time[i];
    r.radius[i] = keepRays.radius[s];
    r.spread[i] = keepRays.spread[s];
    seed[i] = keepSeed[s];
    index[i] = keepIndex[s];
    if (sets) sets[i] = keepSets[s];
    if (!blocked[i] && rays->tMax[i] > 0) open[k++] = i;
  }
  group_.rays = r;
  group_.hits = h;
  seed_ = seed;
  index_ = index;
  linkSet_ = links;
  traceSet_ = sets;
  media_ = nullptr;
  for (int pass = 0; k && pass < kMostPasses; ++pass) {
    if (traceSet_)
      closestInSets(true, k, open);
    else
      w.closest(group_.rays, group_.hits, trace::kSeenByClearShadow, k, open);
    uint32_t* hit = arena_.make<uint32_t>(padded(k));
    uint32_t hitCount = 0;
    for (uint32_t i = 0; i < k; ++i)
      if (!std::isinf(h.t[open[i]])) hit[hitCount++] = open[i];
    Context* const* contexts;
    const RayKind before = rayKind_;
    rayKind_ = RayKind::Transmission;
    const uint32_t count = shade(kTraitEyePath | kTraitPresenceQuery, depth, hitCount, hit, &contexts);
    rayKind_ = before;
    uint32_t* next = arena_.make<uint32_t>(padded(hitCount));
    uint32_t nextCount = 0;
    for (uint32_t c = 0; c < count; ++c) {
      const Context* x = contexts[c];
      float* presence = x->alloc<float>(x->padded);
      if (x->bxdf->presence)
        x->bxdf->presence(x, presence);
      else
        std::fill_n(presence, x->padded, 1.f);
      float* keep[3] = {nullptr, nullptr, nullptr};
      if (rays->tinted && (x->traits & kTraitTinted)) {
        for (float*& q : keep) q = x->alloc<float>(x->padded);
        x->bxdf->thinShadow(x, keep);
      }
      for (uint32_t i = 0; i < x->count; ++i) {
        const uint32_t s = x->path[i];
        float most = 0;
        for (int q = 0; q < 3; ++q) {
          const float pass1 = (1.f - presence[i]) + (keep[q] && rays->tinted[s] ? presence[i] * keep[q][i] : 0.f);
          rays->transmittance[q][s] *= std::clamp(pass1, 0.f, 1.f);
          most = std::max(most, rays->transmittance[q][s]);
        }
        if (most > 0) next[nextCount++] = s;
      }
    }
    passThrough(nextCount, next, nullptr);
    open = next;
    k = nextCount;
  }
  group_.rays = keepRays;
  group_.hits = keepHits;
  seed_ = keepSeed;
  index_ = keepIndex;
  linkSet_ = keepLinks;
  traceSet_ = keepSets;
  media_ = keepMedia;
}

}  // namespace kinora::shade
