#include "shade/medium_tracks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sampling/draw.h"
#include "shade/beer_lambert.h"

namespace kinora::shade {

namespace {

uint32_t bitsOf(float x) {
  uint32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}
}  // namespace

uint32_t mixedSeed(uint32_t a, uint32_t b) {
  uint32_t x = a ^ (b * 0x9E3779B9u + 0x85EBCA6Bu);
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  return x;
}

namespace {

// Points that are worked on at a time, on the stack.
constexpr uint32_t kChunk = 64;
struct alignas(64) Chunk {
  float x[3][kChunk];
  float* arrays[3] = {x[0], x[1], x[2]};
  Chunk() = default;
  Chunk(const Chunk&) = delete;
  Chunk& operator=(const Chunk&) = delete;
};

}  // namespace

void SpaceMedium::carryBack(uint32_t width, uint32_t n, float* const object[3], const float* time,
                            uint32_t* isInside) const {
  for (uint32_t first = 0; first < n; first += kChunk) {
    const uint32_t count = std::min(n - first, kChunk), all = padded(count);
    float* const p[3] = {object[0] + first, object[1] + first, object[2] + first};
    Chunk v;
    for (int k = 0; k < 3; ++k) std::fill_n(v.x[k], all, 0.f);
    if (velocity[0] && velocity[0] == velocity[1]) {
      velocity[0]->at(width, count, p, v.arrays);
    } else {
      for (int k = 0; k < 3; ++k) {
        float* const one[3] = {v.x[k], nullptr, nullptr};
        if (velocity[k]) velocity[k]->at(width, count, p, one);
      }
    }
    for (uint32_t i = 0; i < all; ++i) {
      const float since = opens + time[first + i] * lasts;
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        const float way = (velocityFactor * v.x[k][i] + constantVelocity[k]) * since;
        p[k][i] -= std::clamp(way, -farthest[k], farthest[k]);
        inside &= p[k][i] >= low[k] && p[k][i] <= high[k];
      }
      isInside[first + i] = inside;
    }
  }
}

float SpaceMedium::similarity(uint32_t bounces) const {
  constexpr uint32_t kMost = 64;
  float f = 1;
  for (uint32_t k = 0; extinctionByBounce < 1 && k < std::min(bounces, kMost); ++k) f *= extinctionByBounce;
  return f;
}

void SpaceMedium::productsAt(uint32_t width, uint32_t n, const float* const object[3], const float* time,
                             float* const extinction[3], uint32_t level) const {
  for (uint32_t first = 0; first < n; first += kChunk) {
    const uint32_t count = std::min(n - first, kChunk), all = padded(count);
    const float* p[3] = {object[0] + first, object[1] + first, object[2] + first};
    Chunk carried, numbers, colors;
    uint32_t isInside[kChunk];
    if (isCarried) {
      for (int k = 0; k < 3; ++k) {
        std::copy_n(p[k], all, carried.x[k]);
        p[k] = carried.x[k];
      }
      carryBack(width, count, carried.arrays, time + first, isInside);
    }
    std::fill_n(numbers.x[0], all, 1.f);
    std::fill_n(colors.x[0], all, 1.f);
    if (number) number->at(width, count, p, numbers.arrays, level);
    if (color) color->at(width, count, p, colors.arrays, level);
    if (number && number->components() == 3)
      for (uint32_t i = 0; i < all; ++i)
        numbers.x[0][i] = (numbers.x[0][i] + numbers.x[1][i] + numbers.x[2][i]) * (1.f / 3);
    const bool isGrey = !color || color->components() == 1;
    for (int k = 0; k < 3; ++k) {
      const float* const c = colors.x[isGrey ? 0 : k];
      float* const out = extinction[k] + first;
      for (uint32_t i = 0; i < all; ++i) {
        const float x = factor[k] * std::max(numbers.x[0][i], 0.f) * std::max(c[i], 0.f);
        out[i] = x < 1e30f && !(isCarried && !isInside[i]) ? x : 0.f;
      }
    }
  }
}

void setMediumHit(const Hits& hits, uint32_t entry, const SpaceMedium& medium, float t) {
  hits.t[entry] = t;
  hits.u[entry] = hits.v[entry] = 1.f / 3;
  for (int k = 0; k < 3; ++k) hits.ng[k][entry] = k == 2;
  hits.instance[entry] = medium.instance;
  hits.geometry[entry] = medium.geometry;
  hits.primitive[entry] = hits.level[entry] = 0;
}

MediumTracks::MediumTracks(GroupState& g, const std::vector<MediumCrossing>& crossings, const Rays& rays,
                           const float* ends, const uint32_t* seed, const uint32_t* index, const uint32_t* bounces,
                           uint32_t depth, uint32_t n, const uint32_t* entries, bool scatters, uint32_t part,
                           uint32_t parts)
    : g_(g), space_(*g.world().space), crossings_(crossings), rays_(rays), scatters_(scatters), depth_(depth) {
  const std::vector<MediumCrossing>& all = crossings;
  tracks_ = g.arena().make<Track>(n);
  Around* const arounds = g.arena().make<Around>(all.size() + 1);
  for (uint32_t at = 0; at < all.size();) {
    Track& t = tracks_[count_++];
    const uint32_t s = entries[all[at].ray];
    t.entry = s;
    t.first = t.next = at;
    const uint32_t ray = all[at].ray;
    while (at < all.size() && all[at].ray == ray) ++at;
    t.last = at;
    t.seed = mixedSeed(mixedSeed(seed[s], index[s]), 0x51ED270Bu + depth);
    if (!scatters)  // there are several from a vertex
      for (const float* const* d = rays.d; d != rays.d + 3; ++d) t.seed = mixedSeed(t.seed, bitsOf((*d)[s]));
    t.event = 0;
    t.bounces = bounces ? bounces[s] : 0;
    t.time = rays.time[s];
    t.radius = rays.radius[s];
    t.spread = rays.spread[s];
    t.t = 0;
    t.end = ends[s];
    t.left = -1;
    t.count = 0;
    t.around = arounds + t.first;
    for (int k = 0; k < 3; ++k) t.w[k] = t.path[k] = 1, t.even[k] = 0;
    // what is left before it is entered was around the ray from the beginning
    for (uint32_t k = t.first; k < t.last; ++k) {
      bool isFirst = true;
      for (uint32_t before = t.first; before < k && isFirst; ++before) isFirst = all[before].medium != all[k].medium;
      if (isFirst && !all[k].enters) enter(t, all[k].medium);
    }
  }
  g.counters.mediaRays += count_;
  if (scatters && count_) drawFirst(seed, index, part, parts);
}

float MediumTracks::number(Track& t) { return drawEvent(t.seed, 0, 0, t.event++); }

bool MediumTracks::advance(uint32_t i) {
  Track& t = tracks_[i];
  for (;;) {
    float until = border(t), even[3] = {0, 0, 0};
    t.bound = 0;
    for (uint32_t k = 0; k < t.count; ++k) {
      Around& a = t.around[k];
      const SpaceMedium& m = space_.media[a.medium];
      if (!scatters_ && m.isEven()) {
        for (int c = 0; c < 3; ++c) even[c] += a.scale * m.factor[c];
        a.most = 0;
        continue;
      }
      while (t.t >= a.coarserFrom) a.coarserFrom = m.coarserFrom(++a.level, t.radius, t.spread);
      until = std::min(until, a.coarserFrom);
      a.most = a.scale * m.boundsOf(a.level).at(a.o, a.d, a.inverse, t.t, until);
      t.bound += a.most;
    }
    if (t.bound > 0) {
      if (t.left < 0) {
        const float first = t.event == 0 ? (first_ ? first_[i] : -1) : -1;
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
    if (!pass(t, until)) return false;
  }
}

bool MediumTracks::pass(Track& t, float until) {
  const std::vector<MediumCrossing>& all = crossings_;
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
  return t.count || t.next < t.last;
}

void MediumTracks::stretch(const Track& t, Stretch& s) const {
  s.until = border(t);
  for (int c = 0; c < 3; ++c) s.extinction[c] = s.plain[c] = s.towards[c] = 0;
  for (uint32_t k = 0; k < t.count; ++k) {
    const Around& a = t.around[k];
    const SpaceMedium& m = space_.media[a.medium];
    const float mean = a.scale * m.majorants.mean(m.majorants.cellAt(a.o, a.d, a.inverse, t.t, s.until));
    for (int c = 0; c < 3; ++c) {
      const float here = mean * m.tint[c];
      s.extinction[c] += here;
      s.plain[c] += 2 * (1 - m.towardsLights) * here;
      s.towards[c] += 2 * m.towardsLights * here;
    }
  }
}

void MediumTracks::enter(Track& t, uint32_t medium) {
  for (uint32_t k = 0; k < t.count; ++k)
    if (t.around[k].medium == medium) return;
  if (t.count == kMostOverlapping) {
    ++g_.counters.mediaOverflows;
    return;
  }
  Around& a = t.around[t.count++];
  a.medium = medium;
  a.scale = space_.media[medium].similarity(t.bounces);
  a.level = 0;
  a.coarserFrom = space_.media[medium].coarserFrom(0, t.radius, t.spread);
  if (medium != lastMedium_) {
    const SpaceMedium& m = space_.media[medium];
    toLast_ = g_.toObject(m.instance, m.geometry, rays_.time[t.entry]);
    lastMedium_ = g_.world().world->instance(m.instance).keyCount < 2 ? medium : ~0u;
  }
  const trace::Affine& toObject = toLast_;
  float o[3], d[3];
  for (int k = 0; k < 3; ++k) o[k] = rays_.o[k][t.entry], d[k] = rays_.d[k][t.entry];
  toObject.point(o, a.o);
  for (int r = 0; r < 3; ++r) {
    a.d[r] = 0;
    for (int c = 0; c < 3; ++c) a.d[r] += toObject.m[r][c] * d[c];
    a.inverse[r] = a.d[r] != 0 ? 1 / a.d[r] : 0.f;
  }
}

void MediumTracks::leave(Track& t, uint32_t medium) {
  for (uint32_t k = 0; k < t.count; ++k)
    if (t.around[k].medium == medium) {
      t.around[k] = t.around[--t.count];
      return;
    }
}

void MediumTracks::drawFirst(const uint32_t* seed, const uint32_t* index, uint32_t part, uint32_t parts) {
  const uint32_t room = padded(count_);
  uint32_t *seeds = g_.arena().make<uint32_t>(room), *samples = g_.arena().make<uint32_t>(room);
  for (uint32_t i = 0; i < room; ++i) {
    const uint32_t s = tracks_[std::min(i, count_ - 1)].entry;
    seeds[i] = seed[s];
    samples[i] = index[s];
  }
  first_ = g_.arena().make<float>(room);
  towards_ = g_.arena().make<float>(room);
  drawSplit(g_.world().width)(g_.world().samples, room, seeds, samples, dimensionAt(depth_) + kDimMedium, part, parts,
                              first_, towards_);
}

MediumLookups::MediumLookups(Arena& arena, uint32_t room, bool wantsEmission) : emits_(wantsEmission) {
  for (float*& x : extinction) x = arena.make<float>(room);
  for (float*& x : emission) x = wantsEmission ? arena.make<float>(room) : nullptr;
  ask_ = arena.make<Ask>(room);
  products_ = arena.make<Product>(room);
  for (float*& x : place_) x = arena.make<float>(room + kPad);
  time_ = arena.make<float>(room + kPad);
}

void MediumLookups::add(const SpaceMedia& space, const Track& t, const Around& a) {
  const SpaceMedium& m = space.media[a.medium];
  const uint32_t at = count_++;
  // What emits is asked by its network, which knows no levels of the extinction.
  const bool emits = emits_ && m.mayEmit, isLookedUp = m.isProduct && (!emits || !m.levels.empty());
  if (isLookedUp) {
    const uint32_t i = productCount_++;
    for (int k = 0; k < 3; ++k) place_[k][i] = a.o[k] + a.d[k] * t.t;
    time_[i] = t.time;
    products_[i] = {at, a.medium, m.levelAt(t.t, t.radius, t.spread), a.scale};
  }
  if (emits || !isLookedUp) ask_[asked_++] = {at, t.entry, a.medium, t.t, a.scale, isLookedUp};
}

// Those of each medium and level together.
void MediumLookups::lookUpProducts(GroupState& g) {
  const uint32_t n = productCount_;
  if (!n) return;
  // what a kernel reads and writes behind the last place of some is the next ones', or room to spare
  const uint32_t room = padded(n) + kPad;
  Arena& arena = g.arena();
  float *P[3] = {place_[0], place_[1], place_[2]}, *time = time_, *found[3];
  for (float*& x : found) x = arena.make<float>(room);
  const auto isBefore = [](const Product& a, const Product& b) {
    return a.medium != b.medium ? a.medium < b.medium : a.level < b.level;
  };
  if (!std::is_sorted(products_, products_ + n, isBefore)) {
    uint32_t* const order = arena.make<uint32_t>(n);
    for (uint32_t i = 0; i < n; ++i) order[i] = i;
    std::stable_sort(order, order + n, [&](uint32_t a, uint32_t b) { return isBefore(products_[a], products_[b]); });
    Product* const sorted = arena.make<Product>(n);
    for (float*& x : P) x = arena.make<float>(room);
    time = arena.make<float>(room);
    for (uint32_t i = 0; i < n; ++i) {
      sorted[i] = products_[order[i]];
      for (int k = 0; k < 3; ++k) P[k][i] = place_[k][order[i]];
      time[i] = time_[order[i]];
    }
    products_ = sorted;
  }
  for (uint32_t i = n; i < room; ++i) {
    for (float* x : P) x[i] = x[n - 1];
    time[i] = time[n - 1];
  }
  for (uint32_t first = 0, end = 0; first < n; first = end) {
    const Product& like = products_[first];
    while (end < n && !isBefore(like, products_[end])) ++end;
    const float* const places[3] = {P[0] + first, P[1] + first, P[2] + first};
    float* const out[3] = {found[0] + first, found[1] + first, found[2] + first};
    g.world().space->media[like.medium].productsAt(g.world().width, end - first, places, time + first, out,
                                                   like.level);
  }
  for (uint32_t i = 0; i < n; ++i) {
    const Product& p = products_[i];
    for (int k = 0; k < 3; ++k) extinction[k][p.at] = p.scale * found[k][i];
    for (float* x : emission)
      if (x) x[p.at] = 0;
  }
}

void MediumLookups::run(GroupState& g, const Rays& rays, uint32_t depth) {
  lookUpProducts(g);
  if (!asked_) return;
  const SpaceMedia& space = *g.world().space;
  RayList& list = *g.makeRays(asked_);
  for (uint32_t i = 0; i < padded(asked_); ++i) {
    const Ask& a = ask_[std::min(i, asked_ - 1)];
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = rays.o[k][a.entry];
      list.rays.d[k][i] = rays.d[k][a.entry];
    }
    list.rays.time[i] = rays.time[a.entry];
    list.rays.radius[i] = rays.radius[a.entry];
    list.rays.spread[i] = rays.spread[a.entry];
    setMediumHit(list.hits, i, space.media[a.medium], a.t);
  }
  askMedia(g, list, asked_, depth, emits_, [&](uint32_t entry, int k, float lost, float emitted) {
    if (!ask_[entry].isLookedUp) extinction[k][ask_[entry].at] = ask_[entry].scale * lost;
    if (emits_) emission[k][ask_[entry].at] = emitted;
  });
}

void GroupState::lookUpMedium(uint32_t medium, uint32_t n, const float* const P[3], const float* time,
                              float* const extinction[3], float* const emission[3]) {
  RayList& list = *makeRays(n);
  for (uint32_t i = 0; i < padded(n); ++i) {
    const uint32_t from = std::min(i, n - 1);
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][i] = P[k][from];
      list.rays.d[k][i] = k == 2;
    }
    list.rays.time[i] = time[from];
    list.rays.radius[i] = list.rays.spread[i] = 0;
    setMediumHit(list.hits, i, world_.space->media[medium], 0);
  }
  askMedia(*this, list, n, 0, emission[0], [&](uint32_t entry, int k, float lost, float emitted) {
    extinction[k][entry] = lost;
    if (emission[0]) emission[k][entry] = emitted;
  });
}

}  // namespace kinora::shade
