// What media that fill space let through of shadow rays and of light that rays meet: by the expected factor of each tentative
// collision (ratio tracking), and exactly where media are the same everywhere.
#include <algorithm>
#include <cmath>

#include "shade/beer_lambert.h"
#include "shade/context_host.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

namespace {

constexpr float kFaint = 0.02f, kSurvives = 0.25f;  // transmittance below which a shadow ray may be ended

// Of the crossings of a ray from `first` to `last`, those of the medium that the first is of: the length of the ray
// inside up to `end`. As tracks have it: who leaves first was inside, and nobody enters who does not leave.
float lengthInside(const MediumCrossing* first, const MediumCrossing* last, float end) {
  const uint32_t medium = first->medium;
  bool isInside = !first->enters;
  float since = 0, length = 0;
  for (const MediumCrossing* c = first; c != last && since < end; ++c) {
    if (c->medium != medium) continue;
    if (!c->enters) {
      if (isInside) length += std::max(std::min(c->t, end) - since, 0.f);
      isInside = false;
    } else if (!isInside) {
      isInside = std::any_of(c, last, [&](const MediumCrossing& x) { return x.medium == medium && !x.enters; });
      since = c->t;
    }
  }
  return length;
}

}  // namespace

// thinOut() of the crossings that were found, where all media are even: their lengths are all there is to know.
void GroupState::thinOutEvenly(const float* ends, const uint32_t* bounces, uint32_t n, const uint32_t* entries,
                               float* const transmittance[3]) {
  const ArenaScope memory(arena_);
  float* depth[3];
  for (float*& x : depth) x = arena_.make<float>(padded(n));
  uint32_t *entry = arena_.make<uint32_t>(n), count = 0;
  const MediumCrossing *c = crossings_.data(), *const end = c + crossings_.size();
  while (c != end) {
    const uint32_t ray = c->ray, s = entries[ray];
    const MediumCrossing* last = c;
    while (last != end && last->ray == ray) ++last;
    float sum[3] = {0, 0, 0};
    for (const MediumCrossing* k = c; k != last; ++k) {
      if (std::any_of(c, k, [&](const MediumCrossing& x) { return x.medium == k->medium; })) continue;
      const SpaceMedium& m = world_.space->media[k->medium];
      const float length = lengthInside(k, last, ends[s]) * m.similarity(bounces ? bounces[s] : 0);
      for (int x = 0; x < 3; ++x)
        if (m.factor[x] > 0) sum[x] += m.factor[x] * length;
    }
    for (int x = 0; x < 3; ++x) depth[x][count] = sum[x];
    entry[count++] = s;
    c = last;
  }
  counters.mediaRays += count;
  for (int x = 0; x < 3; ++x) {
    for (uint32_t i = count; i < padded(count); ++i) depth[x][i] = 0;
    letThrough(world_.width, count, depth[x]);
    for (uint32_t i = 0; i < count; ++i) transmittance[x][entry[i]] *= depth[x][i];
  }
}

// Multiplies by what media let through as far as each ray goes (ends). By entry.
void GroupState::thinOut(const Rays& rays, const float* ends, const MediaSight& sight, const uint32_t* seed,
                         const uint32_t* index, const uint32_t* bounces, uint32_t depth, uint32_t n,
                         const uint32_t* entries, float* const transmittance[3]) {
  const SpaceMedia& space = *world_.space;
  findCrossings(rays, n, entries, sight);
  if (space.areEven) return thinOutEvenly(ends, bounces, n, entries, transmittance);
  MediumTracks tracks(*this, crossings_, rays, ends, seed, index, bounces, depth, n, entries, false);
  uint32_t* open = arena_.make<uint32_t>(tracks.count() + 1);
  uint32_t m = tracks.count();
  for (uint32_t i = 0; i < m; ++i) open[i] = i;
  while (m) {
    const ArenaScope memory(arena_);
    m = advanceAll(tracks, m, open, counters.endlessTracks, [&](const Track& t) {
      for (int c = 0; c < 3; ++c) transmittance[c][t.entry] *= t.w[c] * beerLambert(t.even[c], 1.f);
    });
    uint32_t asked = 0;
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k) asked += tracks[open[i]].around[k].most > 0;
    if (!asked) continue;
    MediumLookups found(arena_, padded(asked), false);
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k)
        if (tracks[open[i]].around[k].most > 0) found.add(space, tracks[open[i]], tracks[open[i]].around[k]);
    found.run(*this, rays, depth);
    counters.mediaLookups += asked;
    uint32_t going = 0;
    for (uint32_t i = 0, at = 0; i < m; ++i) {
      Track& t = tracks[open[i]];
      float sum[3] = {0, 0, 0};
      for (uint32_t k = 0; k < t.count; ++k) {
        if (!(t.around[k].most > 0)) continue;
        noteExcess(t.around[k].medium, t.around[k].most, found.extinction, at);
        for (int c = 0; c < 3; ++c) sum[c] += found.extinction[c][at];
        ++at;
      }
      float largest = 0;
      for (int c = 0; c < 3; ++c) {
        t.w[c] *= 1 - sum[c] / t.bound;
        largest = std::max(largest, std::fabs(t.w[c]));
      }
      if (largest < kFaint) {
        const bool isOver = !(largest > 0) || !(tracks.number(t) < kSurvives);
        for (float& w : t.w) w = isOver ? 0 : w / kSurvives;
        if (isOver) {
          for (float* x : {transmittance[0], transmittance[1], transmittance[2]}) x[t.entry] = 0;
          continue;
        }
      }
      open[going++] = open[i];
    }
    m = going;
  }
}

void GroupState::thinOutShadows(uint32_t depth, const ShadowRays& rays) {
  uint32_t* open = arena_.make<uint32_t>(padded(rays.count));
  uint32_t m = 0;
  for (uint32_t i = 0; i < rays.count; ++i) {
    float most = 0;
    for (int c = 0; c < 3; ++c) most = std::max(most, rays.transmittance[c][i]);
    if (most > 0 && rays.tMax[i] > 0) open[m++] = i;
  }
  if (!m) return;
  const ArenaScope memory(arena_);
  RayList& list = *makeRays(rays.count);
  copyRays(rays, list);
  for (uint32_t i = 0; i < rays.count; ++i) list.rays.spread[i] = spreadAlong(rays, i, list.rays.spread[i]);
  thinOut(list.rays, list.rays.tMax, mediaInShadows(list, m, open), list.sampleSeed, list.sampleIndex,
          ListHost::of(list).left.bounces, depth, m, open, rays.transmittance);
}

// What light met by rays has lost on its way, and which of them the rays were ended before.
void GroupState::thinOutLights(const RayList& list, LightHits* l) {
  const uint32_t n = l->count, room = padded(n) + kPad;
  float *T[3], *radiance[3];
  for (int c = 0; c < 3; ++c) {
    T[c] = arena_.make<float>(room);
    radiance[c] = arena_.make<float>(room);
  }
  const ListHost& host = ListHost::of(list);
  for (uint32_t i = 0; i < n; ++i)
    for (int c = 0; c < 3; ++c) T[c][i] = host.absorbed[c] ? host.absorbed[c][l->slot[i]] : 1.f;
  if (world_.space) {
    RayList& rays = *makeRays(n);
    // What light samples might have found has lost what they would have: the same to whoever asks. Mirrors see light
    // as they see everything.
    const bool areShadows = world_.space->areShadowsOthers && host.kind != RayKind::Camera;
    uint32_t *entries = arena_.make<uint32_t>(room), *shadows = arena_.make<uint32_t>(room), m = 0, k = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = l->slot[i];
      for (int c = 0; c < 3; ++c) {
        rays.rays.o[c][i] = list.rays.o[c][s];
        rays.rays.d[c][i] = list.rays.d[c][s];
      }
      // lights are seen beyond clipping planes, which cut the media off before them
      rays.rays.tMax[i] = std::min({l->t[i], host.kind == RayKind::Camera ? list.rays.tMax[s] : 1e30f, 1e30f});
      rays.rays.time[i] = list.rays.time[s];
      rays.rays.radius[i] = list.rays.radius[s];
      rays.rays.spread[i] = list.rays.spread[s];
      rays.sampleSeed[i] = list.sampleSeed[s];
      rays.sampleIndex[i] = mixedSeed(list.sampleIndex[s], l->light[i]);
      const VertexState& left = ListHost::of(rays).left;
      if (const uint32_t* b = host.left.bounces) left.bounces[i] = b[s];
      if (const uint32_t* x = host.left.traceSet) {
        left.traceSet[i] = x[s];
        for (int c = 0; c < 3; ++c) left.Ng[c][i] = host.left.Ng[c][s];
      }
      if (areShadows && !(list.origin[s] & kFromDiscrete))
        shadows[k++] = i;
      else
        entries[m++] = i;
    }
    ListHost::of(rays).kind = host.kind;
    const auto thin = [&](const MediaSight& sight, uint32_t count, const uint32_t* which) {
      if (count)
        thinOut(rays.rays, rays.rays.tMax, sight, rays.sampleSeed, rays.sampleIndex, ListHost::of(rays).left.bounces,
                0x10000, count, which, T);
    };
    thin(mediaSeen(rays, m, entries), m, entries);
    thin(mediaInShadows(rays, k, shadows), k, shadows);
  }
  for (int c = 0; c < 3; ++c) {
    for (uint32_t i = 0; i < n; ++i) radiance[c][i] = l->radiance[c][i] * T[c][i];
    l->radiance[c] = radiance[c];
    if (!l->specularRadiance[c]) continue;
    float* specular = arena_.make<float>(room);
    for (uint32_t i = 0; i < n; ++i) specular[i] = l->specularRadiance[c][i] * T[c][i];
    l->specularRadiance[c] = specular;
  }
}

}  // namespace kinora::shade
