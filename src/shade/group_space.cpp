// Rays through media that fill space, between the crossings that group_crossings.cpp finds: where they are scattered, and
// what media emit on the way. Distances are drawn by delta tracking (Woodcock et al. 1965) with weights for channels that differ (Kutz et al.,
// "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", 2017): at a tentative collision the ray
// is scattered with a probability in proportion to what the mean channel loses there, and goes on else; the factors
// on its channels make up for it. What media emit is summed at the tentative collisions. Random numbers are hashes of the
// ray's address, its direction and the number of the event, so that a ray's way is its own.
#include <algorithm>
#include <cmath>

#include "shade/beer_lambert.h"
#include "shade/context_host.h"
#include "shade/medium_light.h"
#include "shade/medium_tracks.h"

namespace kinora::shade {

trace::Affine GroupState::toObject(uint32_t instance, uint32_t geometry, float time) const {
  const trace::World& w = *world_.world;
  const trace::Instance& placed = w.instance(instance);
  if (placed.keyCount < 2) return world_.spaceOf(instance, geometry).fromRender;
  trace::Affine a = w.objectToRender(instance, time).inverse();
  const Imath::V3d& origin = w.mesh(geometry).origin;
  for (int k = 0; k < 3; ++k) a.t[k] += float(origin[k]);
  return a;
}

// The factor on a track's path before, by which chances go: of sum 1 where it is known.
void GroupState::setPathOf(const RayList& list, Track& t) {
  float sum = 0;
  for (int c = 0; c < 3 && list.throughput[c]; ++c) sum += std::fabs(list.throughput[c][t.entry]);
  if (sum > 0 && sum < 1e30f)
    for (int c = 0; c < 3; ++c) t.path[c] = std::fabs(list.throughput[c][t.entry]) / sum;
}

// What each of the rays counts of the emission that light samples may find too: by crossing, where a ray meets a
// medium for the first time. The power heuristic over directions, as for all lights (see RayList::againstLights).
const float* GroupState::sharesOfGlow(const RayList& list, MediumTracks& tracks) {
  if (world_.lightOfMedium.empty()) return nullptr;
  const uint32_t room = padded(uint32_t(crossings_.size())) + kPad;
  float *share = arena_.make<float>(room), *P[3], *N[3] = {nullptr, nullptr, nullptr},
        *chosen = arena_.make<float>(room), *time = arena_.make<float>(room);
  uint32_t *light = arena_.make<uint32_t>(room), *set = arena_.make<uint32_t>(room),
           *row = arena_.make<uint32_t>(room), *crossing = arena_.make<uint32_t>(room),
           *entry = arena_.make<uint32_t>(room), n = 0;
  const ListHost& host = ListHost::of(list);
  for (int k = 0; k < 3; ++k) {
    P[k] = arena_.make<float>(room);
    if (host.left.lightN[k]) N[k] = arena_.make<float>(room);
  }
  for (uint32_t i = 0; i < tracks.count(); ++i) {
    const Track& t = tracks[i];
    for (uint32_t k = t.first; k < t.last; ++k) {
      share[k] = 1;
      const uint32_t medium = crossings_[k].medium;
      if (world_.lightOfMedium[medium] == kNoLight) continue;
      // what it does not light finds nothing of it by chance either, but mirrors show all
      if (host.left.linkSet && !(list.origin[t.entry] & kFromDiscrete) &&
          !world_.lights->isLinked(host.left.linkSet[t.entry], world_.lightOfMedium[medium])) {
        share[k] = 0;
        continue;
      }
      if (!(list.againstLights[t.entry] < 1e30f)) continue;
      bool isFirst = true;
      for (uint32_t before = t.first; before < k && isFirst; ++before) isFirst = crossings_[before].medium != medium;
      if (!isFirst) continue;
      const bool isBehind = list.behind && list.behind[t.entry] > 0;
      for (int c = 0; c < 3; ++c) {
        P[c][n] = isBehind ? list.begin[c][t.entry] : list.rays.o[c][t.entry];
        if (N[c]) N[c][n] = host.left.lightN[c][t.entry];
      }
      time[n] = list.rays.time[t.entry];
      set[n] = host.left.linkSet ? host.left.linkSet[t.entry] : 0;
      row[n] = host.left.lightRow ? host.left.lightRow[t.entry] : 0;
      light[n] = world_.lightOfMedium[medium];
      entry[n] = t.entry;
      crossing[n++] = k;
    }
  }
  if (!n) return share;
  for (uint32_t i = n; i < padded(n); ++i) {
    for (int c = 0; c < 3; ++c) {
      P[c][i] = P[c][n - 1];
      if (N[c]) N[c][i] = N[c][n - 1];
    }
    set[i] = set[n - 1];
    row[i] = row[n - 1];
    light[i] = light[n - 1];
  }
  world_.lights->probabilities(world_.width, litPoints(n, P, N, time, set, row), light, chosen);
  for (uint32_t i = 0; i < n; ++i) {
    const auto& l = *static_cast<const MediumLight*>(world_.lights->instanceOf(light[i]));
    const float o[3] = {P[0][i], P[1][i], P[2][i]};
    const float d[3] = {list.rays.d[0][entry[i]], list.rays.d[1][entry[i]], list.rays.d[2][entry[i]]};
    const float r = chosen[i] * l.density(o, d, time[i]) / list.againstLights[entry[i]];
    share[crossing[i]] = list.share[entry[i]] / (1 + r * r);
  }
  return share;
}

// Of a medium around a track: the above where light samples may lie, else all.
float GroupState::shareOfGlow(const Track& t, const Around& a, const float* shares) const {
  const uint32_t light = world_.lightOfMedium[a.medium];
  if (light == kNoLight) return 1;
  float p[3];
  for (int k = 0; k < 3; ++k) p[k] = a.o[k] + a.d[k] * t.t;
  if (!static_cast<const MediumLight*>(world_.lights->instanceOf(light))->emits(p)) return 1;
  uint32_t k = t.first;
  while (crossings_[k].medium != a.medium) ++k;
  return shares[k];
}

// Ends some of the listed rays in media, before what they hit. Their hits are then of the medium.
void GroupState::scatterInSpace(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries,
                                float* const transmittance[3]) {
  const SpaceMedia& space = *world_.space;
  const ListHost& host = ListHost::of(list);
  const Hits& hits = list.hits;
  findCrossings(list.rays, n, entries, mediaSeen(list, n, entries));
  const float* ends = clippedEnds(arena_, list, host.surfaceT, n, entries);
  MediumTracks tracks(*this, crossings_, list.rays, ends, list.sampleSeed, list.sampleIndex, host.left.bounces, depth,
                      n, entries, true);
  uint32_t* open = arena_.make<uint32_t>(tracks.count() + 1);
  uint32_t m = tracks.count();
  for (uint32_t i = 0; i < m; ++i) {
    open[i] = i;
    setPathOf(list, tracks[i]);
  }
  const auto isHole = [&, mayBe = hole_ && host.kind == RayKind::Camera](uint32_t medium) {
    return mayBe && world_.placements[world_.world->instance(space.media[medium].instance).info].hole;
  };
  // stretches of constant factors, as they end
  float* since = list.wantsWays ? arena_.make<float>(m + 1) : nullptr;
  waySteps_.clear();
  const auto endStretch = [&](const Track& t, float* next) {
    if (t.t > *next && (t.w[0] != 0 || t.w[1] != 0 || t.w[2] != 0))
      waySteps_.push_back({t.entry, *next, t.t, {t.w[0], t.w[1], t.w[2]}});
    *next = t.t;
  };
  for (uint32_t i = 0; since && i < m; ++i) since[i] = tracks[i].count ? 0.f : crossings_[tracks[i].first].t;
  const auto sinceOf = [&](const Track& t) { return since + (&t - &tracks[0]); };
  const float* glowShare = m && list.glow[0] && list.againstLights ? sharesOfGlow(list, tracks) : nullptr;
  while (m) {
    const ArenaScope memory(arena_);
    m = advanceAll(tracks, m, open, counters.endlessTracks, [&](const Track& t) {
      if (since) endStretch(t, sinceOf(t));
      for (int c = 0; c < 3; ++c) transmittance[c][t.entry] *= t.w[c];
    });
    uint32_t asked = 0;
    for (uint32_t i = 0; i < m; ++i) asked += tracks[open[i]].count;
    if (!asked) continue;
    MediumLookups found(arena_, padded(asked), list.glow[0]);
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k)
        found.add(space, tracks[open[i]], tracks[open[i]].around[k]);
    found.run(*this, list.rays, depth);
    counters.mediaLookups += asked;
    uint32_t going = 0;
    for (uint32_t i = 0, at = 0; i < m; at += tracks[open[i++]].count) {
      Track& t = tracks[open[i]];
      float sum[3] = {0, 0, 0};
      for (uint32_t k = 0; k < t.count; ++k) {
        noteExcess(t.around[k].medium, t.around[k].most, found.extinction, at + k);
        const float share = isHole(t.around[k].medium) ? 0.f
                            : glowShare                ? shareOfGlow(t, t.around[k], glowShare)
                                                       : 1.f;
        for (int c = 0; c < 3; ++c) {
          sum[c] += found.extinction[c][at + k];
          if (list.glow[0]) list.glow[c][t.entry] += share * t.w[c] * found.emission[c][at + k] / t.bound;
        }
      }
      float met = 0, missed = 0;
      for (int c = 0; c < 3; ++c) {
        met += t.path[c] * std::fabs(t.w[c]) * sum[c];
        missed += t.path[c] * std::fabs(t.w[c] * (t.bound - sum[c]));
      }
      const float all = met + missed;
      if (!(all > 0)) {  // no channel is left
        if (since) endStretch(t, sinceOf(t));
        for (float* x : {transmittance[0], transmittance[1], transmittance[2]}) x[t.entry] = 0;
        continue;
      }
      const float chance = met / all, u = tracks.number(t);
      if (!(u < chance)) {
        float factor[3], most = 0;
        for (int c = 0; c < 3; ++c) {
          factor[c] = (t.bound - sum[c]) / (t.bound * (1 - chance));
          most = std::max(most, std::fabs(factor[c] - 1));
        }
        constexpr float kSame = 1e-6f;  // of channels alike rounding alone is left
        if (since && most > kSame) endStretch(t, sinceOf(t));
        for (int c = 0; c < 3; ++c) t.w[c] *= factor[c];
        open[going++] = open[i];
        continue;
      }
      if (since) endStretch(t, sinceOf(t));
      // which medium it was: by what each takes of the mean channel
      float rest = tracks.number(t) * met, share = 0;
      uint32_t which = t.count;
      for (uint32_t k = 0; k < t.count; ++k) {
        float own = 0;
        for (int c = 0; c < 3; ++c) own += t.path[c] * std::fabs(t.w[c]) * found.extinction[c][at + k];
        if (!(own > 0)) continue;
        which = k;
        share = own;
        if (rest < own) break;
        rest -= own;
      }
      const float pick = share / met * chance * t.bound;
      const SpaceMedium& here = space.media[t.around[which].medium];
      const float brings = t.bounces ? here.contributionByBounce : 1.f;
      for (int c = 0; c < 3; ++c)
        transmittance[c][t.entry] *= brings * t.w[c] * found.extinction[c][at + which] / pick;
      absorbUntil(list, t.entry, t.t, transmittance);
      setMediumHit(hits, t.entry, space.media[t.around[which].medium], t.t);
    }
    m = going;
  }
  if (since) writeWays(list, n, entries);
}

// The stretches by ray, in the order along it: as they were found.
void GroupState::writeWays(RayList& list, uint32_t n, const uint32_t* entries) {
  const auto words = [&](size_t k) { return arena_.make<uint32_t>(k + 1); };
  const auto floats = [&](size_t k) { return arena_.make<float>(k + 1); };
  const size_t steps = waySteps_.size();
  uint32_t *first = words(list.capacity), *count = words(list.capacity);
  for (uint32_t i = 0; i < n; ++i) count[entries[i]] = 0;
  for (const WayStep& x : waySteps_) ++count[x.entry];
  uint32_t sum = 0;
  for (uint32_t i = 0; i < n; ++i) {
    first[entries[i]] = sum;
    sum += count[entries[i]];
    count[entries[i]] = 0;
  }
  float *from = floats(steps), *to = floats(steps), *factor[3] = {floats(steps), floats(steps), floats(steps)};
  for (const WayStep& x : waySteps_) {
    const uint32_t at = first[x.entry] + count[x.entry]++;
    from[at] = x.from;
    to[at] = x.to;
    for (int c = 0; c < 3; ++c) factor[c][at] = x.factor[c];
  }
  list.ways = {first, count, from, to, {factor[0], factor[1], factor[2]}, {nullptr, nullptr, nullptr}};
  const ListHost& host = ListHost::of(list);
  if (!host.left.media) return;
  float* absorption[3] = {floats(list.capacity), floats(list.capacity), floats(list.capacity)};
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    // as absorbUntil(): where nothing was passed on the way
    const float* a = media_[media_.filling(host.left.media[s])].absorption;
    for (int c = 0; c < 3; ++c)
      absorption[c][s] =
          host.left.media[s] && host.absorbed[c][s] == beerLambert(a[c], host.surfaceT[s]) ? a[c] : 0.f;
  }
  for (int c = 0; c < 3; ++c) list.ways.absorption[c] = absorption[c];
}

// A ray inside an absorbing object lost light as far as its surface; it ends before. (One that passed surfaces on the
// way keeps what it lost up to the last of them.)
void GroupState::absorbUntil(const RayList& list, uint32_t entry, float t, float* const transmittance[3]) const {
  const ListHost& host = ListHost::of(list);
  if (!host.left.media || !host.left.media[entry]) return;
  const float* a = media_[media_.filling(host.left.media[entry])].absorption;
  for (int c = 0; c < 3; ++c) {
    const float whole = host.absorbed[c][entry];
    if (whole != beerLambert(a[c], host.surfaceT[entry])) continue;
    // what is left of the path's factor when that is taken out; nothing came as far where it is 0
    transmittance[c][entry] = whole > 0 ? transmittance[c][entry] / whole * beerLambert(a[c], t) : 0.f;
  }
}

void GroupState::noteExcess(uint32_t medium, float bound, float* const extinction[3], uint32_t at) {
  const float most = std::max({extinction[0][at], extinction[1][at], extinction[2][at]});
  if (!(most > bound * 1.0001f) || !(most > bound * counters.excess)) return;
  counters.excess = bound > 0 ? most / bound : INFINITY;
  counters.excessMedium = medium;
}

void placesInMedia(const Context* c, float* const Po[3], float* scale) {
  const GroupState& group = *ContextHost::of(c).group;
  const ShadingWorld& w = group.world();
  for (uint32_t i = 0; i < c->padded; ++i) {
    const float P[3] = {c->P[0][i], c->P[1][i], c->P[2][i]};
    float p[3] = {P[0], P[1], P[2]};
    scale[i] = 1;
    if (c->place.instance) {
      group.toObject(c->place.instance[i], c->place.geometry[i], c->time[i]).point(P, p);
      scale[i] = w.spaceOf(c->place.instance[i], c->place.geometry[i]).scale;
    }
    for (int k = 0; k < 3; ++k) Po[k][i] = p[k];
  }
}

void fieldsInMedia(const Context* c, const char* name, uint32_t components, float* const value[3], float* has) {
  if (has) std::fill_n(has, c->padded, 0.f);
  const ShadingWorld& world = ContextHost::of(c).group->world();
  const SpaceMedia& space = *world.space;
  const Value Po = c->builtin(Builtin::Po);
  constexpr uint32_t kMost = 64;
  alignas(64) float place[3][kMost], found[3][kMost], time[kMost];
  uint32_t isInside[kMost];
  float *const P[3] = {place[0], place[1], place[2]}, *const v[3] = {found[0], found[1], found[2]};
  for (uint32_t first = 0, end = 0; first < c->padded; first = end) {
    // points of one medium
    while (end < c->padded && end - first < kMost && c->place.instance[end] == c->place.instance[first]) ++end;
    const SpaceMedium& medium = space.media[space.ofInstance.at(c->place.instance[first])];
    const auto it = medium.fields.find(std::string_view(name));
    if (it == medium.fields.end()) continue;
    const volume::MediumField& field = it->second;
    const uint32_t n = end - first;
    for (uint32_t i = 0; i < padded(n); ++i) {
      const uint32_t from = first + std::min(i, n - 1);
      for (int k = 0; k < 3; ++k) place[k][i] = Po.data[k][from];
      time[i] = c->time[from];
      isInside[i] = 1;
    }
    if (medium.isCarried) medium.carryBack(world.width, n, P, time, isInside);
    field.at(world.width, n, P, v);
    const bool isGrey = field.components() == 1, isMean = components == 1 && !isGrey;
    for (uint32_t i = 0; i < n; ++i) {
      if (has) has[first + i] = float(std::min(components, uint32_t(field.components())));
      const float mean = isMean ? (found[0][i] + found[1][i] + found[2][i]) * (1.f / 3) : 0.f;
      for (uint32_t k = 0; k < components; ++k)
        value[k][first + i] = !isInside[i] ? 0.f : isMean ? mean : found[isGrey ? 0 : k][i];
    }
  }
}

}  // namespace kinora::shade
