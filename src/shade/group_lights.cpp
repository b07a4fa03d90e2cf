// Lights seen from a group: samples for points, lights met by rays, shadow rays through what lets light pass.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/keep_light_hits.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

void GroupState::lightSamples(const Context* c, uint32_t part, uint32_t parts, LightSamples* out, uint32_t of) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  float* u[4];
  for (float*& x : u) x = arena_.make<float>(c->padded);
  const uint32_t dim = dimensionAt(c->depth);
  const DrawSplit draw = drawSplit(world_.width);
  if (of != kNoLight) part += (of + 1) * kSequenceOfPart;
  if (of == kNoLight && world_.lights->hasChoice())
    draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLightChoice, part, parts, u[0], u[3]);
  draw(world_.samples, c->padded, c->sampleSeed, c->sampleIndex, dim + kDimLight, part, parts, u[1], u[2]);
  light::LightSet::Points p;
  p.count = c->count;
  p.padded = c->padded;
  const VertexState& state = ContextHost::of(c).state;
  for (int k = 0; k < 3; ++k) {
    p.P[k] = c->P[k];
    p.N[k] = state.lightN[k];
  }
  p.time = c->time;
  p.linkSet = state.linkSet;
  p.weights = group_.lightWeights;
  p.row = state.lightRow;
  p.uChoice[0] = u[0];
  p.uChoice[1] = u[3];
  p.u[0] = u[1];
  p.u[1] = u[2];
  p.wantsSpread = world_.world->hasUserGeometry();
  p.besideOwn = group_.besideOwnSamples;
  p.light = of;
  world_.lights->sample(world_.width, arena_, p, out);
  if (!world_.mediumLights.empty()) askMediumLights(c, out);
}

void GroupState::weighLights(const Context* c, const uint32_t* rows) {
  if (uint32_t* own = ContextHost::of(c).state.lightRow) std::copy_n(rows, c->padded, own);
}

// Samples of what media emit: how much that is where they lie. To path expressions it is not a light's.
void GroupState::askMediumLights(const Context* c, LightSamples* out) {
  const SpaceMedia& space = *world_.space;
  const bool isWanted = scattersInMedia && group_.paths.againstLights;
  uint32_t* found = arena_.make<uint32_t>(padded(c->count));
  uint32_t n = 0;
  for (uint32_t i = 0; i < c->padded; ++i)
    if (out->light[i] != kNoLight && out->light[i] >= world_.firstMediumLight) {
      if (isWanted && i < c->count && out->pdf[i] > 0) found[n++] = i;
      if (!isWanted) const_cast<float*>(out->pdf)[i] = 0;
    }
  if (!n) return;
  RayList& list = *makeRays(n);
  ListHost& host = ListHost::of(list);
  host.kind = RayKind::Indirect;
  const VertexState& state = ContextHost::of(c).state;
  uint32_t *medium = arena_.make<uint32_t>(padded(n)), *entries = arena_.make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t from = found[std::min(i, n - 1)];
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = c->P[k][from];
      list.rays.d[k][i] = out->wi[k][from];
    }
    list.rays.time[i] = c->time[from];
    list.rays.radius[i] = c->radius[from];
    list.rays.spread[i] = c->spread[from];
    if (state.traceSet) {
      host.left.traceSet[i] = state.traceSet[from];
      for (int k = 0; k < 3; ++k) host.left.Ng[k][i] = state.Ng[k][from];
    }
    medium[i] = world_.mediumLights[out->light[from] - world_.firstMediumLight];
    setMediumHit(list.hits, i, space.media[medium[i]], out->t[from]);
    entries[i] = i;
  }
  // Cells reach beyond what the medium fills; and rays that do not know of it would not find it by chance.
  findCrossings(list.rays, n, entries, mediaSeen(list, n, entries));
  bool* isInside = arena_.make<bool>(padded(n));
  std::fill_n(isInside, n, false);
  bool* isKnown = arena_.make<bool>(padded(n));
  std::fill_n(isKnown, n, false);
  for (const MediumCrossing& x : crossings_) {
    if (x.medium != medium[x.ray] || isKnown[x.ray]) continue;
    isInside[x.ray] = !x.enters;
    isKnown[x.ray] = x.t > list.hits.t[x.ray];
  }
  askMedia(*this, list, n, c->depth, true, [&](uint32_t entry, int k, float, float emitted) {
    const float factor = isInside[entry] && isKnown[entry] ? emitted : 0.f;
    const_cast<float*>(out->radiance[k])[found[entry]] *= factor;
    if (out->specularRadiance[k]) const_cast<float*>(out->specularRadiance[k])[found[entry]] *= factor;
  });
  for (uint32_t i = 0; i < n; ++i) const_cast<uint32_t*>(out->light)[found[i]] = kNoLight;
}

void GroupState::findLightNormals(const Context* c, const Program* program) {
  float* const* N = ContextHost::of(c).state.lightN;
  if (!N[0]) return;
  // Materials that let light through are lit from behind as well; how much is theirs to know.
  float scale = 0;
  if (program && !program->encloses && !program->tints) {
    scale = 1;
    for (uint32_t l = 0; program->traits && l < program->traits->lobeCount; ++l)
      if (program->traits->lobes[l].flags & kLobeTransmit) scale = 0.5f;
  }
  for (int k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < c->padded; ++i) N[k][i] = scale * c->N[k][i];
}

// The rays of a list as lights are to be weighed along them, up to tHit, by entry; see RayList::behind. `rays` is room
// for them.
light::LightSet::RayList GroupState::seenFromBegin(const RayList& list, uint32_t n, const uint32_t* entries,
                                                   float* tHit, Rays& rays) {
  const ListHost& host = ListHost::of(list);
  light::LightSet::RayList l;
  l.count = n;
  l.slots = entries;
  l.rays = &list.rays;
  l.tHit = tHit;
  l.linkSet = host.left.linkSet;
  l.origin = list.origin;
  for (int k = 0; k < 3; ++k) l.N[k] = host.left.lightN[k];
  l.weights = group_.lightWeights;
  l.row = host.left.lightRow;
  l.besideOwn = group_.besideOwnSamples;
  if (!list.behind || std::none_of(entries, entries + n, [&](uint32_t s) { return list.behind[s] > 0; })) return l;
  rays = list.rays;
  float* t = arena_.make<float>(list.capacity);
  for (int k = 0; k < 3; ++k) rays.o[k] = arena_.make<float>(list.capacity);
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t s = entries[i];
    const bool isBehind = list.behind[s] > 0;
    for (int k = 0; k < 3; ++k) rays.o[k][s] = isBehind ? list.begin[k][s] : list.rays.o[k][s];
    t[s] = isBehind ? tHit[s] + list.behind[s] : tHit[s];
  }
  l.rays = &rays;
  l.tHit = t;
  return l;
}

// Of lights found so: distances from where the rays left the bodies, and none from within.
void GroupState::seenFromOrigin(const RayList& list, const light::LightSet::RayList& l, LightHits* hits) {
  if (l.rays == &list.rays || !hits->count) return;
  keepLightHits(arena_, hits, [&](uint32_t i) {
    const float behind = list.behind[hits->slot[i]];
    return !(behind > 0) || !(hits->t[i] < behind);
  });
  float* t = arena_.make<float>(padded(hits->count) + kPad);
  for (uint32_t i = 0; i < hits->count; ++i) {
    const float behind = list.behind[hits->slot[i]];
    t[i] = behind > 0 ? hits->t[i] - behind : hits->t[i];
  }
  hits->t = t;
}

void GroupState::lightHits(const RayList& list, RayKind kind, uint32_t n, const uint32_t* entries, LightHits* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const ListHost& host = ListHost::of(list);
  Rays rays;
  const auto l = seenFromBegin(list, n, entries, host.surfaceT ? host.surfaceT : list.hits.t, rays);
  world_.lights->hits(world_.width, arena_, kind == RayKind::Camera, l, out);
  seenFromOrigin(list, l, out);
  if (host.surfaceT)  // lights that end a ray take what it has met behind them
    for (uint32_t i = 0; i < out->count; ++i)
      if (out->blocks[i]) {
        host.surfaceT[out->slot[i]] = out->t[i];
        if (list.hits.t[out->slot[i]] > out->t[i]) list.hits.t[out->slot[i]] = INFINITY;
      }
  if (out->count && world_.lights->hasShadowControls() && kind != RayKind::Camera) shadowLightHits(list, out);
  if (out->count && (world_.space || host.absorbed[0])) thinOutLights(list, out);
  if (hole_ && kind == RayKind::Camera && &list == &group_.paths && out->count) dropLightsBehindHoles(out);
}

void GroupState::lightEnds(LightEnds* ends) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const uint32_t n = ends->count, room = padded(n) + kPad;
  float *P[3], *N[3] = {nullptr, nullptr, nullptr}, *time = arena_.make<float>(room);
  uint32_t* sets = arena_.make<uint32_t>(room);
  uint32_t* rows = group_.lightWeights ? arena_.make<uint32_t>(room) : nullptr;
  if (rows) std::fill_n(rows, room, 0u);
  for (int k = 0; k < 3; ++k) {
    P[k] = arena_.make<float>(room);
    if (world_.lights->hasChoice()) N[k] = arena_.make<float>(room);
  }
  std::fill_n(sets, room, 0u);
  uint32_t done = 0;
  const auto put = [&](uint32_t at, uint32_t from, const float* const* p, const float* t, const VertexState& left) {
    for (int k = 0; k < 3; ++k) {
      P[k][at] = p[k][from];
      if (N[k]) N[k][at] = left.lightN[k][from];
    }
    time[at] = t[from];
    if (left.linkSet) sets[at] = left.linkSet[from];
    if (rows && left.lightRow) rows[at] = left.lightRow[from];
  };
  for (uint32_t r = 0, first = 0; r < ends->runCount; first = ends->runs[r++].end) {
    const ShadowRun& run = ends->runs[r];
    for (uint32_t i = first; i < run.end; ++i, ++done) {
      const uint32_t from = ends->point ? ends->point[i] : i - first;
      if (run.context)
        put(i, from, run.context->P, run.context->time, ContextHost::of(run.context).state);
      else
        put(i, from, run.list->rays.o, run.list->rays.time, ListHost::of(*run.list).left);
    }
  }
  for (uint32_t i = done; done && i < padded(n); ++i) {
    for (int k = 0; k < 3; ++k) {
      P[k][i] = P[k][done - 1];
      if (N[k]) N[k][i] = N[k][done - 1];
    }
    time[i] = time[done - 1];
    sets[i] = sets[done - 1];
    if (rows) rows[i] = rows[done - 1];
  }
  world_.lights->ends(world_.width, arena_, litPoints(n, P, N, time, sets, rows), ends);
}

light::LightSet::Points GroupState::litPoints(uint32_t n, const float* const P[3], const float* const N[3],
                                              const float* time, const uint32_t* linkSet, const uint32_t* row) const {
  light::LightSet::Points p{};
  p.count = n;
  p.padded = padded(n);
  for (int k = 0; k < 3; ++k) {
    p.P[k] = P[k];
    p.N[k] = N[k];
  }
  p.time = time;
  p.linkSet = linkSet;
  p.weights = group_.lightWeights;
  p.row = row;
  return p;
}

void GroupState::lightsBeyond(const RayList& rays, uint32_t n, const uint32_t* entries, LightHits* out) {
  *out = LightHits{};
  uint32_t* list = arena_.make<uint32_t>(padded(n));
  uint32_t m = 0;
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    if (std::isinf(rays.hits.t[s])) continue;
    if (world_.materials->tints(world_.materialOf(rays.hits.instance[s], rays.hits.geometry[s]))) list[m++] = s;
  }
  if (!m) return;
  for (uint32_t i = m; i < padded(m); ++i) list[i] = list[m - 1];
  lightsAlong(rays, m, list, out);
  // without those that lightHits() has told of: in front of the hit, or casting no shadows
  keepLightHits(arena_, out, [&](uint32_t i) {
    const light::LightSet& lights = *world_.lights;
    return lights.castsShadow(out->light[i]) && !lights.doesGlassBlock(out->light[i]) &&
           out->t[i] > rays.hits.t[out->slot[i]];
  });
}

void GroupState::lightsAlong(const RayList& rays, uint32_t n, const uint32_t* entries, LightHits* out) {
  const Clock clock(counters.nanoseconds[kTimeLights]);
  float* tHit = arena_.make<float>(rays.capacity);
  for (uint32_t i = 0; i < padded(n); ++i) tHit[entries[i]] = INFINITY;
  Rays from;
  const auto l = seenFromBegin(rays, n, entries, tHit, from);
  world_.lights->hits(world_.width, arena_, false, l, out);
  seenFromOrigin(rays, l, out);
}

void GroupState::findFootprints(const ShadowRays& rays, float** radius, float** spread) {
  if (!world_.world->hasUserGeometry()) return;
  // footprints where the rays begin choose the level
  float* at = *radius = arena_.make<float>(padded(rays.count));
  float* growth = *spread = arena_.make<float>(padded(rays.count));
  forEachRun(rays, [&](const ShadowRun& run, const VertexState&, uint32_t first) {
    const float* r = run.context ? run.context->radius : run.list->rays.radius;
    const float* s = run.context ? run.context->spread : run.list->rays.spread;
    for (uint32_t i = first; i < run.end; ++i) {
      at[i] = r[rays.point[i]];
      growth[i] = spreadAlong(rays, i, s[rays.point[i]]);
    }
  });
}

void GroupState::occluded(const ShadowRays& rays, uint32_t* blocked, bool clear) {
  const trace::World& w = *world_.world;
  float *radius = nullptr, *spread = nullptr;
  findFootprints(rays, &radius, &spread);
  if (!world_.traceSets.empty())
    occludedInSets(rays, radius, spread, blocked, clear);
  else
    w.occluded(rays.count, rays.o, rays.d, rays.tMax, rays.time,
               trace::kSeenByOpaqueShadow | (clear ? trace::kSeenByClearShadow : 0u), blocked, radius, spread);
}

void GroupState::shadow(uint32_t depth, const ShadowRays* rays) {
  const uint32_t n = rays->count;
  if (!n) return;
  ShadowRays own = *rays;
  rays = &own;
  if (!own.point) {
    uint32_t* point = arena_.make<uint32_t>(padded(n));
    for (uint32_t r = 0, i = 0; r < own.runCount; ++r)
      for (uint32_t p = 0; i < own.runs[r].end; ++i) point[i] = p++;
    own.point = point;
  }
  if (world_.movesShadowOrigins) moveShadowOrigins(&own);
  counters.shadowRays += n;
  if (listener) listener->shadow(depth, *rays);
  const Clock clock(counters.nanoseconds[kTimeTraceShadow]);
  shadowOfSurfaces(depth, *rays);
  if (world_.space) thinOutShadows(depth, *rays);
}

void GroupState::shadowOfSurfaces(uint32_t depth, const ShadowRays& rays) {
  if (rays.light && world_.lights->hasShadowControls()) {
    controlShadows(depth, rays);
    return;
  }
  uint32_t* blocked = arena_.make<uint32_t>(padded(rays.count));
  occluded(rays, blocked);
  for (uint32_t i = 0; i < rays.count; ++i) {
    const float t = blocked[i] ? 0.f : 1.f;
    for (int c = 0; c < 3; ++c) rays.transmittance[c][i] = t;
  }
  if (world_.world->hasClearShadows()) walkClearShadows(depth, rays, blocked);
}

}  // namespace kinora::shade
