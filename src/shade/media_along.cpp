// What media are along rays, without tracking: Services::meanTransmittance, mediumIntervals and
// mediaAt.
#include <algorithm>
#include <cmath>

#include "shade/beer_lambert.h"
#include "shade/clock.h"
#include "shade/context_host.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

void GroupState::meanTransmittance(uint32_t n, const float* const o[3], const float* const d[3], const float* length,
                                   const float* time, float* out) {
  std::fill_n(out, n, 1.f);
  if (!world_.space || !n) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const ArenaScope memory(arena_);
  RayList& list = *makeRays(n);
  uint32_t* entries = arena_.make<uint32_t>(padded(n));
  float* ends = arena_.make<float>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t from = std::min(i, n - 1);
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = o[k][from];
      list.rays.d[k][i] = d[k][from];
    }
    list.rays.time[i] = time[from];
    list.rays.radius[i] = list.rays.spread[i] = 0;
    list.sampleSeed[i] = list.sampleIndex[i] = 0;
    entries[i] = i;
    ends[i] = std::min(length[from], 1e30f);
  }
  // whatever rays see them: those of the other techniques see them otherwise
  findCrossings(list.rays, n, entries, {~0u});
  MediumTracks tracks(*this, crossings_, list.rays, ends, list.sampleSeed, list.sampleIndex, nullptr, 0, n, entries,
                      false);
  MediumTracks::Stretch s;
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    Track& t = tracks[i];
    float depth[3] = {0, 0, 0};
    do {
      tracks.stretch(t, s);
      for (int c = 0; c < 3; ++c) depth[c] += s.extinction[c] > 0 ? s.extinction[c] * (s.until - t.t) : 0.f;
    } while (tracks.pass(t, s.until));
    float sum = 0;
    for (const float x : depth) sum += beerLambert(x, 1.f);
    constexpr float kLeast = 1e-20f;  // a weight may be 0 by rounding, but no quotient of two of them undefined
    out[t.entry] = std::max(sum * (1.f / 3), kLeast);
  }
}

void GroupState::mediumIntervals(const RayList& list, uint32_t n, const uint32_t* entries, MediumIntervals* out) {
  uint32_t* first = arena_.make<uint32_t>(padded(n + 1));
  std::fill_n(first, padded(n + 1), 0u);
  *out = {0, first, nullptr, nullptr, first, nullptr};
  if (!world_.space || !n) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  findCrossings(list.rays, n, entries, mediaSeen(list, n, entries));
  if (crossings_.empty()) return;
  const float* ends = clippedEnds(arena_, list, list.hits.t, n, entries);
  MediumTracks tracks(*this, crossings_, list.rays, ends, list.sampleSeed, list.sampleIndex, nullptr, 0, n, entries,
                      false);
  // there are no more than one before each crossing and one behind the last
  const uint32_t most = uint32_t(crossings_.size()) + tracks.count();
  float *from = arena_.make<float>(most), *to = arena_.make<float>(most);
  uint32_t *firstMedium = arena_.make<uint32_t>(most + 1), *medium = arena_.make<uint32_t>(most * kMostOverlapping);
  uint32_t count = 0, media = 0, ray = 0;
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    Track& t = tracks[i];
    for (; ray <= crossings_[t.first].ray; ++ray) first[ray] = count;
    for (bool goesOn = t.t < t.end; goesOn;) {
      const float until = tracks.border(t);
      if (t.count && until > t.t) {
        from[count] = t.t;
        to[count] = until;
        firstMedium[count++] = media;
        for (uint32_t k = 0; k < t.count; ++k) medium[media + k] = world_.space->media[t.around[k].medium].instance;
        std::sort(medium + media, medium + media + t.count);
        media += t.count;
      }
      goesOn = tracks.pass(t, until);
    }
  }
  for (; ray <= n; ++ray) first[ray] = count;
  firstMedium[count] = media;
  *out = {count, first, from, to, firstMedium, medium};
}

void GroupState::mediaAt(const RayList& from, uint32_t depth, uint32_t n, const uint32_t* entries, const float* t,
                         MediaAt* out) {
  *out = MediaAt{};
  if (!world_.space || !n) return;
  const Clock clock(counters.nanoseconds[kTimeLights]);
  const SpaceMedia& space = *world_.space;
  const ListHost& source = ListHost::of(from);
  const auto copy = [&](RayList& list, uint32_t to, uint32_t s) {
    copyRay(from, s, list, to);
    const VertexState& left = ListHost::of(list).left;
    if (left.bounces && source.left.bounces) left.bounces[to] = source.left.bounces[s];
    if (left.media && source.left.media) left.media[to] = source.left.media[s];
    if (!source.left.traceSet) return;
    left.traceSet[to] = source.left.traceSet[s];
    for (int c = 0; c < 3; ++c) left.Ng[c][to] = source.left.Ng[c][s];
  };
  RayList& rays = *makeRays(n);
  uint32_t* all = arena_.make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    copy(rays, i, entries[std::min(i, n - 1)]);
    all[i] = i;
  }
  ListHost::of(rays).kind = source.kind;
  findCrossings(rays.rays, n, all, mediaSeen(rays, n, all));
  MediumTracks tracks(*this, crossings_, rays.rays, t, rays.sampleSeed, rays.sampleIndex,
                      ListHost::of(rays).left.bounces, depth, n, all, false);
  uint32_t found = 0;
  MediumTracks::Stretch s;
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    Track& x = tracks[i];
    do tracks.stretch(x, s);
    while (tracks.pass(x, s.until));
    if (x.t < x.end) x.count = 0;  // it has left them all before
    found += x.count;
  }
  if (!found) return;
  MediumLookups media(arena_, padded(found), space.mayEmit);
  RayList& list = *makeRays(found);
  ListHost::of(list).kind = source.kind;
  uint32_t *point = arena_.make<uint32_t>(padded(found)), *numbers = arena_.make<uint32_t>(padded(found)), at = 0;
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    const Track& x = tracks[i];
    for (uint32_t k = 0; k < x.count; ++k, ++at) {
      media.add(space, x, x.around[k]);
      copy(list, at, entries[x.entry]);
      setMediumHit(list.hits, at, space.media[x.around[k].medium], x.t);
      point[at] = x.entry;
    }
  }
  media.run(*this, rays.rays, depth);
  counters.mediaLookups += found;
  for (uint32_t i = 0; i < padded(found); ++i) numbers[i] = std::min(i, found - 1);
  *out = {&list,
          found,
          numbers,
          point,
          {media.extinction[0], media.extinction[1], media.extinction[2]},
          {media.emission[0], media.emission[1], media.emission[2]}};
}

}  // namespace kinora::shade
