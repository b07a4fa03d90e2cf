// Rays through media that fill space: where they cross their boundaries, where they are scattered, what gets through.
// Distances are drawn by delta tracking (Woodcock et al. 1965) with weights for channels that differ (Kutz et al.,
// "Spectral and Decomposition Tracking for Rendering Heterogeneous Volumes", 2017): at a tentative collision the ray
// is scattered with a probability in proportion to what the mean channel loses there, and goes on else; the factors
// on its channels make up for it. Shadow rays take the expected factor of each tentative collision (ratio tracking),
// and of media that are the same everywhere the exact transmittance. What media emit is summed at the tentative
// collisions. Random numbers are hashes of the ray's address, its direction and the number of the event, so that a
// ray's way is its own.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "sampling/draw.h"
#include "shade/beer_lambert.h"
#include "shade/clock.h"
#include "shade/context_host.h"

namespace kinora::shade {

namespace {

constexpr uint32_t kMostAtOnce = 8;                 // media that overlap
constexpr uint32_t kMostCollisions = 1u << 16;      // tentative ones of a ray
constexpr int kMostWalks = 64;                      // through the hierarchy of boundaries, for eight crossings each
constexpr float kFaint = 0.02f, kSurvives = 0.25f;  // transmittance below which a shadow ray may be ended

uint32_t bitsOf(float x) {
  uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}
uint32_t mixed(uint32_t a, uint32_t b) {
  uint32_t x = a ^ (b * 0x9E3779B9u + 0x85EBCA6Bu);
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  return x;
}

// A medium around a ray, with the ray in its object space: the same distances lead to the same places.
struct Around {
  uint32_t medium;
  float o[3], d[3];
  float most;  // the bound where the ray is
};

struct Track {
  uint32_t entry;        // of the list
  uint32_t first, next;  // of crossings: this ray's first, and the next one to come
  uint32_t last;         // one behind its last
  uint32_t seed, event;
  float t, end;
  float left;     // of the optical depth to the next tentative collision; below 0: not drawn yet
  float bound;    // at that collision, of all media together
  float w[3];     // the factors on its channels
  float path[3];  // the same of its path before, which chances go by as well: else channels drift apart
  float even[3];  // optical depth of what is known exactly, for rays that are not scattered
  uint32_t count;
  Around around[kMostAtOnce];
};

}  // namespace

void SpaceMedium::productAt(const float object[3], float extinction[3]) const {
  float n = 1, c[3] = {1, 1, 1};
  if (number) {
    float v[3] = {};
    number->at(object, v);
    n = number->components() == 3 ? (v[0] + v[1] + v[2]) * (1.f / 3) : v[0];
  }
  if (color) {
    color->at(object, c);
    if (color->components() == 1) c[1] = c[2] = c[0];
  }
  for (int k = 0; k < 3; ++k) {
    const float x = factor[k] * std::max(n, 0.f) * std::max(c[k], 0.f);
    extinction[k] = x < 1e30f ? x : 0.f;
  }
}

// All crossings of the listed rays (by number in the list) into crossings_, ray by ray in order of distance, whatever
// the rays hit: who is inside a medium where he begins sees that by the way out.
void GroupState::findCrossings(const Rays& rays, uint32_t n, const uint32_t* entries, uint32_t visibility) {
  crossings_.clear();
  const SpaceMedia& space = *world_.space;
  const trace::World& boundaries = *space.boundaries;
  RayList& list = *makeRays(n);
  uint32_t *open = arena_.make<uint32_t>(padded(n)), *beyond = arena_.make<uint32_t>(padded(n));
  float* passed = arena_.make<float>(padded(n));
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t s = entries[i];
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = rays.o[k][s];
      list.rays.d[k][i] = rays.d[k][s];
    }
    list.rays.tMax[i] = 1e30f;
    list.rays.time[i] = rays.time[s];
    list.rays.radius[i] = list.rays.spread[i] = 0;
    open[i] = i;
    passed[i] = 0;
  }
  uint32_t m = n;
  for (int walk = 0; m && walk < kMostWalks; ++walk) {
    boundaries.collectClear(list.rays, m, open, collected_, beyond);
    if (const uint32_t found = uint32_t(collected_.size())) {
      const RayList& hits = *makeRays(found);
      boundaries.resolve(list.rays, found, collected_.data(), hits.hits);
      for (uint32_t k = 0; k < found; ++k) {
        const uint32_t ray = collected_[k].slot, at = boundaries.instance(hits.hits.instance[k]).user;
        const SpaceMedium& medium = space.media[at];
        list.hits.t[ray] = collected_[k].t;
        if (!(medium.visibility & visibility)) continue;
        const trace::Affine toObject =
            boundaries.objectToRender(hits.hits.instance[k], list.rays.time[ray]).inverse();
        float out = 0;
        for (int r = 0; r < 3; ++r) {
          float d = 0;
          for (int c = 0; c < 3; ++c) d += toObject.m[r][c] * list.rays.d[c][ray];
          out += d * hits.hits.ng[r][k];
        }
        crossings_.push_back({ray, passed[ray] + collected_[k].t, at, out * medium.side < 0});
      }
    }
    uint32_t going = 0;
    for (uint32_t i = 0; i < m; ++i)
      if (beyond[i]) open[going++] = open[i];
    passThrough(list, going, open, passed);
    m = going;
  }
  counters.endlessRays += m;
  const auto isBefore = [](const MediumCrossing& a, const MediumCrossing& b) {
    return a.ray != b.ray ? a.ray < b.ray : a.t < b.t;
  };
  if (!std::is_sorted(crossings_.begin(), crossings_.end(), isBefore))
    std::stable_sort(crossings_.begin(), crossings_.end(), isBefore);
}

// The tracks of a list of rays, from one tentative collision to the next.
class GroupState::Tracker {
 public:
  // ends: by entry, how far each ray goes. `scatters`: rays are ended by what they meet.
  Tracker(GroupState& g, const Rays& rays, const float* ends, const uint32_t* seed, const uint32_t* index,
          uint32_t visibility, uint32_t depth, uint32_t n, const uint32_t* entries, bool scatters)
      : g_(g), space_(*g.world_.space), rays_(rays), scatters_(scatters), depth_(depth) {
    g.findCrossings(rays, n, entries, visibility);
    const std::vector<MediumCrossing>& all = g.crossings_;
    tracks_ = g.arena_.make<Track>(n);
    for (uint32_t at = 0; at < all.size();) {
      Track& t = tracks_[count_++];
      const uint32_t s = entries[all[at].ray];
      t.entry = s;
      t.first = t.next = at;
      const uint32_t ray = all[at].ray;
      while (at < all.size() && all[at].ray == ray) ++at;
      t.last = at;
      t.seed = mixed(mixed(seed[s], index[s]), 0x51ED270Bu + depth);
      if (!scatters)  // there are several from a vertex
        for (const float* const* d = rays.d; d != rays.d + 3; ++d) t.seed = mixed(t.seed, bitsOf((*d)[s]));
      t.event = 0;
      t.t = 0;
      t.end = ends[s];
      t.left = -1;
      t.count = 0;
      for (int k = 0; k < 3; ++k) t.w[k] = t.path[k] = 1, t.even[k] = 0;
      // what is left before it is entered was around the ray from the beginning
      for (uint32_t k = t.first; k < t.last; ++k) {
        bool isFirst = true;
        for (uint32_t before = t.first; before < k && isFirst; ++before)
          isFirst = all[before].medium != all[k].medium;
        if (isFirst && !all[k].enters) enter(t, all[k].medium);
      }
    }
    g.counters.mediaRays += count_;
    if (scatters && count_) firstNumbers(seed, index);
  }

  uint32_t count() const { return count_; }
  Track& operator[](uint32_t i) { return tracks_[i]; }
  float number(Track& t) { return drawEvent(t.seed, 0, 0, t.event++); }
  // Numbers of a ray's first flight are of the samples' sequences: they cover the distances evenly.
  float firstNumber(uint32_t i) const { return first_ ? first_[i] : -1; }

  // To the next tentative collision. False: the ray has come to its end.
  bool advance(uint32_t i) {
    Track& t = tracks_[i];
    const std::vector<MediumCrossing>& all = g_.crossings_;
    for (;;) {
      const float border = t.next < t.last ? std::min(all[t.next].t, t.end) : t.end;
      float until = border, even[3] = {0, 0, 0};
      t.bound = 0;
      for (uint32_t k = 0; k < t.count; ++k) {
        Around& a = t.around[k];
        const SpaceMedium& m = space_.media[a.medium];
        if (!scatters_ && m.isEven()) {
          for (int c = 0; c < 3; ++c) even[c] += m.factor[c];
          a.most = 0;
          continue;
        }
        a.most = m.majorants.at(a.o, a.d, t.t, until);
        t.bound += a.most;
      }
      if (t.bound > 0) {
        if (t.left < 0) {
          const float first = t.event == 0 ? firstNumber(i) : -1;
          t.left = freeDepth(first >= 0 ? first : number(t));
          if (first >= 0) ++t.event;
        }
        const float step = t.left / t.bound;
        if (t.t + step < until) {
          for (int c = 0; c < 3; ++c) t.even[c] += even[c] > 0 ? even[c] * step : 0.f;
          t.t += step;
          t.left = -1;
          return true;
        }
        t.left -= (until - t.t) * t.bound;
        t.left = std::max(t.left, 0.f);
      }
      for (int c = 0; c < 3; ++c) t.even[c] += even[c] > 0 ? even[c] * (until - t.t) : 0.f;
      t.t = until;
      if (!(t.t < t.end)) return false;
      while (t.next < t.last && all[t.next].t <= t.t) {
        const MediumCrossing& c = all[t.next++];
        // through a hole in its boundary, or past a corner, no ray is inside for ever
        if (!c.enters)
          leave(t, c.medium);
        else if (std::any_of(all.begin() + t.next, all.begin() + t.last,
                             [&](const MediumCrossing& x) { return x.medium == c.medium && !x.enters; }))
          enter(t, c.medium);
      }
      if (!t.count && t.next == t.last) return false;
    }
  }

 private:
  void enter(Track& t, uint32_t medium) {
    for (uint32_t k = 0; k < t.count; ++k)
      if (t.around[k].medium == medium) return;
    if (t.count == kMostAtOnce) {
      ++g_.counters.mediaOverflows;
      return;
    }
    Around& a = t.around[t.count++];
    a.medium = medium;
    const trace::Affine toObject =
        g_.toObject(space_.media[medium].instance, space_.media[medium].geometry, rays_.time[t.entry]);
    float o[3], d[3];
    for (int k = 0; k < 3; ++k) o[k] = rays_.o[k][t.entry], d[k] = rays_.d[k][t.entry];
    toObject.point(o, a.o);
    for (int r = 0; r < 3; ++r) {
      a.d[r] = 0;
      for (int c = 0; c < 3; ++c) a.d[r] += toObject.m[r][c] * d[c];
    }
  }
  static void leave(Track& t, uint32_t medium) {
    for (uint32_t k = 0; k < t.count; ++k)
      if (t.around[k].medium == medium) {
        t.around[k] = t.around[--t.count];
        return;
      }
  }
  void firstNumbers(const uint32_t* seed, const uint32_t* index) {
    const uint32_t room = padded(count_);
    uint32_t *seeds = g_.arena_.make<uint32_t>(room), *samples = g_.arena_.make<uint32_t>(room);
    for (uint32_t i = 0; i < room; ++i) {
      const uint32_t s = tracks_[std::min(i, count_ - 1)].entry;
      seeds[i] = seed[s];
      samples[i] = index[s];
    }
    first_ = g_.arena_.make<float>(room);
    float* unused = g_.arena_.make<float>(room);
    drawSplit(g_.world_.width)(g_.world_.samples, room, seeds, samples, dimensionAt(depth_) + kDimMedium, 0, 1,
                               first_, unused);
  }

  GroupState& g_;
  const SpaceMedia& space_;
  const Rays& rays_;
  const bool scatters_;
  const uint32_t depth_;
  Track* tracks_ = nullptr;
  uint32_t count_ = 0;
  float* first_ = nullptr;
};

trace::Affine GroupState::toObject(uint32_t instance, uint32_t geometry, float time) const {
  const trace::World& w = *world_.world;
  const trace::Instance& placed = w.instance(instance);
  if (placed.keyCount < 2) return world_.spaceOf(instance, geometry).fromRender;
  trace::Affine a = w.objectToRender(instance, time).inverse();
  const Imath::V3d& origin = w.mesh(geometry).origin;
  for (int k = 0; k < 3; ++k) a.t[k] += float(origin[k]);
  return a;
}

// What media are at places along rays, all places that are asked for at once: those whose extinction is a product are
// looked up, for the others their networks run.
class MediumLookups {
 public:
  MediumLookups(Arena& arena, uint32_t room, bool wantsEmission) : emits_(wantsEmission) {
    for (float*& x : extinction) x = arena.make<float>(room);
    for (float*& x : emission) x = wantsEmission ? arena.make<float>(room) : nullptr;
    ask_ = arena.make<Ask>(room);
  }
  // Of media around a track; entries of the same numbers answer.
  uint32_t add(const SpaceMedia& space, const Track& t, const Around& a) {
    const SpaceMedium& m = space.media[a.medium];
    const uint32_t at = count_++;
    const bool emits = emits_ && m.mayEmit;
    if (m.isProduct && !emits) {
      float p[3], v[3];
      for (int k = 0; k < 3; ++k) p[k] = a.o[k] + a.d[k] * t.t;
      m.productAt(p, v);
      for (int k = 0; k < 3; ++k) extinction[k][at] = v[k];
      for (float* x : emission)
        if (x) x[at] = 0;
    } else {
      ask_[asked_++] = {at, t.entry, a.medium, t.t};
    }
    return at;
  }
  // Runs the networks. radius, spread: footprints of the rays, by entry.
  void run(GroupState& g, const Rays& rays, const float* radius, const float* spread, uint32_t depth) {
    if (!asked_) return;
    const SpaceMedia& space = *g.world().space;
    RayList& list = *g.makeRays(asked_);
    uint32_t* entries = g.arena().make<uint32_t>(padded(asked_));
    for (uint32_t i = 0; i < padded(asked_); ++i) {
      const Ask& a = ask_[std::min(i, asked_ - 1)];
      for (int k = 0; k < 3; ++k) {
        list.rays.o[k][i] = rays.o[k][a.entry];
        list.rays.d[k][i] = rays.d[k][a.entry];
      }
      list.rays.time[i] = rays.time[a.entry];
      list.rays.radius[i] = radius ? radius[a.entry] : 0.f;
      list.rays.spread[i] = spread ? spread[a.entry] : 0.f;
      list.sampleSeed[i] = list.sampleIndex[i] = 0;
      setMediumHit(list.hits, i, space.media[a.medium], a.t);
      entries[i] = std::min(i, asked_ - 1);
    }
    Context* const* contexts;
    const uint32_t count =
        g.shade(list, kTraitEyePath | kTraitInSpace | kTraitPresenceQuery, depth, asked_, entries, &contexts);
    for (uint32_t c = 0; c < count; ++c) {
      const Context* x = contexts[c];
      const auto f = [&] { return x->alloc<float>(x->padded); };
      const MediumArgs args{{f(), f(), f()},
                            {emits_ ? f() : nullptr, emits_ ? f() : nullptr, emits_ ? f() : nullptr}};
      x->bxdf->medium(x, &args);
      for (uint32_t i = 0; i < x->count; ++i) {
        const uint32_t at = ask_[x->path[i]].at;
        for (int k = 0; k < 3; ++k) {
          const float e = args.extinction[k][i], l = emits_ ? args.emission[k][i] : 0;
          extinction[k][at] = e > 0 && e < 1e30f ? e : 0.f;
          if (emits_) emission[k][at] = l > 0 && l < 1e30f ? l : 0.f;
        }
      }
    }
  }
  uint32_t count() const { return count_; }
  float *extinction[3], *emission[3];

 private:
  struct Ask {
    uint32_t at, entry, medium;
    float t;
  };
  Ask* ask_;
  uint32_t count_ = 0, asked_ = 0;
  bool emits_;
};

void setMediumHit(const Hits& hits, uint32_t entry, const SpaceMedium& medium, float t) {
  hits.t[entry] = t;
  hits.u[entry] = hits.v[entry] = 1.f / 3;
  for (int k = 0; k < 3; ++k) hits.ng[k][entry] = k == 2;
  hits.instance[entry] = medium.instance;
  hits.geometry[entry] = medium.geometry;
  hits.primitive[entry] = hits.level[entry] = 0;
}

void GroupState::lookUpMedium(uint32_t medium, uint32_t n, const float* const P[3], const float* time,
                              float* const extinction[3], float* const emission[3]) {
  RayList& list = *makeRays(n);
  uint32_t* entries = arena_.make<uint32_t>(padded(n));
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t from = std::min(i, n - 1);
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = P[k][from];
      list.rays.d[k][i] = k == 2;
    }
    list.rays.time[i] = time[from];
    list.rays.radius[i] = list.rays.spread[i] = 0;
    list.sampleSeed[i] = list.sampleIndex[i] = 0;
    setMediumHit(list.hits, i, world_.space->media[medium], 0);
    entries[i] = from;
  }
  Context* const* contexts;
  const uint32_t count = shade(list, kTraitEyePath | kTraitInSpace | kTraitPresenceQuery, 0, n, entries, &contexts);
  for (uint32_t c = 0; c < count; ++c) {
    const Context* x = contexts[c];
    MediumArgs args;
    for (int k = 0; k < 3; ++k) {
      args.extinction[k] = x->alloc<float>(x->padded);
      args.emission[k] = emission ? x->alloc<float>(x->padded) : nullptr;
    }
    x->bxdf->medium(x, &args);
    for (uint32_t i = 0; i < x->count; ++i)
      for (int k = 0; k < 3; ++k) {
        extinction[k][x->path[i]] = args.extinction[k][i];
        if (emission) emission[k][x->path[i]] = args.emission[k][i];
      }
  }
}

// Ends some of the listed rays in media, before what they hit. Their hits are then of the medium.
void GroupState::scatterInSpace(const RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries,
                                float* const transmittance[3]) {
  const SpaceMedia& space = *world_.space;
  const ListHost& host = ListHost::of(list);
  const uint32_t visibility =
      host.kind == RayKind::Camera ? uint32_t(trace::kSeenByCamera) : uint32_t(trace::kSeenByIndirect);
  const Hits& hits = list.hits;
  Tracker tracks(*this, list.rays, host.surfaceT, list.sampleSeed, list.sampleIndex, visibility, depth, n, entries,
                 true);
  uint32_t* open = arena_.make<uint32_t>(tracks.count() + 1);
  uint32_t m = tracks.count();
  for (uint32_t i = 0; i < m; ++i) {
    open[i] = i;
    Track& t = tracks[i];
    float sum = 0;
    for (int c = 0; c < 3 && list.throughput[c]; ++c) sum += std::fabs(list.throughput[c][t.entry]);
    if (sum > 0 && sum < 1e30f)
      for (int c = 0; c < 3; ++c) t.path[c] = std::fabs(list.throughput[c][t.entry]) / sum;
  }
  while (m) {
    const ArenaScope memory(arena_);
    uint32_t going = 0;
    for (uint32_t i = 0; i < m; ++i) {
      Track& t = tracks[open[i]];
      if (t.event > kMostCollisions) {
        ++counters.endlessTracks;
        for (float& w : t.w) w = 0;
      } else if (tracks.advance(open[i])) {
        open[going++] = open[i];
        continue;
      }
      for (int c = 0; c < 3; ++c) transmittance[c][t.entry] *= t.w[c];
    }
    m = going;
    uint32_t asked = 0;
    for (uint32_t i = 0; i < m; ++i) asked += tracks[open[i]].count;
    if (!asked) continue;
    MediumLookups found(arena_, padded(asked), list.glow[0]);
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k)
        found.add(space, tracks[open[i]], tracks[open[i]].around[k]);
    found.run(*this, list.rays, list.rays.radius, list.rays.spread, depth);
    counters.mediaLookups += asked;
    going = 0;
    for (uint32_t i = 0, at = 0; i < m; at += tracks[open[i++]].count) {
      Track& t = tracks[open[i]];
      float sum[3] = {0, 0, 0};
      for (uint32_t k = 0; k < t.count; ++k) {
        noteExcess(t.around[k].medium, t.around[k].most, found.extinction, at + k);
        for (int c = 0; c < 3; ++c) {
          sum[c] += found.extinction[c][at + k];
          if (list.glow[0]) list.glow[c][t.entry] += t.w[c] * found.emission[c][at + k] / t.bound;
        }
      }
      float met = 0, missed = 0;
      for (int c = 0; c < 3; ++c) {
        met += t.path[c] * std::fabs(t.w[c]) * sum[c];
        missed += t.path[c] * std::fabs(t.w[c] * (t.bound - sum[c]));
      }
      const float all = met + missed;
      if (!(all > 0)) {  // no channel is left
        for (float* x : {transmittance[0], transmittance[1], transmittance[2]}) x[t.entry] = 0;
        continue;
      }
      const float chance = met / all, u = tracks.number(t);
      if (!(u < chance)) {
        for (int c = 0; c < 3; ++c) t.w[c] *= (t.bound - sum[c]) / (t.bound * (1 - chance));
        open[going++] = open[i];
        continue;
      }
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
      for (int c = 0; c < 3; ++c) transmittance[c][t.entry] *= t.w[c] * found.extinction[c][at + which] / pick;
      absorbUntil(list, t.entry, t.t, transmittance);
      setMediumHit(hits, t.entry, space.media[t.around[which].medium], t.t);
    }
    m = going;
  }
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

// Multiplies by what media let through to each ray's tMax. Seeds, samples by entry.
void GroupState::thinOut(const Rays& rays, uint32_t visibility, const uint32_t* seed, const uint32_t* index,
                         uint32_t depth, uint32_t n, const uint32_t* entries, float* const transmittance[3]) {
  const SpaceMedia& space = *world_.space;
  Tracker tracks(*this, rays, rays.tMax, seed, index, visibility, depth, n, entries, false);
  uint32_t* open = arena_.make<uint32_t>(tracks.count() + 1);
  uint32_t m = tracks.count();
  for (uint32_t i = 0; i < m; ++i) open[i] = i;
  while (m) {
    const ArenaScope memory(arena_);
    uint32_t going = 0;
    for (uint32_t i = 0; i < m; ++i) {
      Track& t = tracks[open[i]];
      if (t.event > kMostCollisions) {
        ++counters.endlessTracks;
        for (float& w : t.w) w = 0;
      } else if (tracks.advance(open[i])) {
        open[going++] = open[i];
        continue;
      }
      for (int c = 0; c < 3; ++c) transmittance[c][t.entry] *= t.w[c] * beerLambert(t.even[c], 1.f);
    }
    m = going;
    uint32_t asked = 0;
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k) asked += tracks[open[i]].around[k].most > 0;
    if (!asked) continue;
    MediumLookups found(arena_, padded(asked), false);
    for (uint32_t i = 0; i < m; ++i)
      for (uint32_t k = 0; k < tracks[open[i]].count; ++k)
        if (tracks[open[i]].around[k].most > 0) found.add(space, tracks[open[i]], tracks[open[i]].around[k]);
    found.run(*this, rays, rays.radius, rays.spread, depth);
    counters.mediaLookups += asked;
    going = 0;
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
  thinOut(list.rays, trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow, list.sampleSeed, list.sampleIndex, depth,
          m, open, rays.transmittance);
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
    uint32_t* entries = arena_.make<uint32_t>(room);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = l->slot[i];
      for (int c = 0; c < 3; ++c) {
        rays.rays.o[c][i] = list.rays.o[c][s];
        rays.rays.d[c][i] = list.rays.d[c][s];
      }
      rays.rays.tMax[i] = std::min(l->t[i], 1e30f);
      rays.rays.time[i] = list.rays.time[s];
      rays.rays.radius[i] = list.rays.radius[s];
      rays.rays.spread[i] = list.rays.spread[s];
      rays.sampleSeed[i] = list.sampleSeed[s];
      rays.sampleIndex[i] = mixed(list.sampleIndex[s], l->light[i]);
      entries[i] = i;
    }
    const uint32_t visibility =
        host.kind == RayKind::Camera ? uint32_t(trace::kSeenByCamera) : uint32_t(trace::kSeenByIndirect);
    thinOut(rays.rays, visibility, rays.sampleSeed, rays.sampleIndex, 0x10000, n, entries, T);
  }
  for (int c = 0; c < 3; ++c) {
    for (uint32_t i = 0; i < n; ++i) radiance[c][i] = l->radiance[c][i] * T[c][i];
    l->radiance[c] = radiance[c];
  }
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

void fieldsInMedia(const Context* c, const char* name, uint32_t components, float* const value[3]) {
  const SpaceMedia& space = *ContextHost::of(c).group->world().space;
  const volume::MediumField* field = nullptr;
  const Value Po = c->builtin(Builtin::Po);
  for (uint32_t i = 0; i < c->padded; ++i) {
    if (i == 0 || c->place.instance[i] != c->place.instance[i - 1]) {
      const auto& fields = space.media[space.ofInstance.at(c->place.instance[i])].fields;
      const auto it = fields.find(std::string_view(name));
      field = it == fields.end() ? nullptr : &it->second;
    }
    if (!field) continue;
    const float p[3] = {Po.data[0][i], Po.data[1][i], Po.data[2][i]};
    float v[3] = {};
    field->at(p, v);
    if (field->components() == 1) v[1] = v[2] = v[0];
    if (components == 1 && field->components() == 3) v[0] = (v[0] + v[1] + v[2]) * (1.f / 3);
    for (uint32_t k = 0; k < components; ++k) value[k][i] = v[k];
  }
}

}  // namespace kinora::shade
