// LightSet: lights that rays meet.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "light/light_set_order.h"
#include "light/near_rays.h"

namespace kinora::light {

namespace {

constexpr float kBeyond = 3.4e38f;  // distances past it are infinite
constexpr uint32_t kBatch = 2048;   // pairs of a ray and a light that are asked at once

template <class T>
T* grown(Arena& arena, const T* old, uint32_t count, uint32_t room) {
  T* x = arena.make<T>(room + kPad);
  if (count) std::memcpy(x, old, count * sizeof(T));
  return x;
}

}  // namespace

// How far a ray of the list looks for a light.
float LightSet::reachOf(const Record& light, bool camera, const RayList& list, uint32_t slot) const {
  if (camera) return list.tHit[slot];
  if (list.origin && (list.origin[slot] & kFromDiscrete)) {
    const uint32_t seen =
        list.origin[slot] & kFromTransmission ? kSeenByMirrors | kSeenByLenses : uint32_t(kSeenByMirrors);
    return (light.flags & seen) == seen ? list.tHit[slot] : 0.f;
  }
  return light.flags & kCastsShadow ? list.tHit[slot] : INFINITY;
}

// Lights met, growing: `ray` is the index in the list. And the rays that wait to be asked of a light each.
struct LightSet::Found {
  uint32_t count = 0, room = 0;
  uint32_t *ray = nullptr, *light = nullptr;
  float *t = nullptr, *pdf = nullptr, *radiance[3] = {}, *specular[3] = {};  // specular: null unless filters split
  struct Waiting {
    uint32_t count = 0, room = 0;
    float *o[3], *d[3], *time, *t;
    uint32_t *ray, *light;
  } waiting;
  bool splits;
  Found(Arena& arena, uint32_t rays, bool splits_) : splits(splits_) {
    waiting.room = std::max(kBatch, padded(rays));
    const uint32_t n = waiting.room + 2 * kPad;
    for (int c = 0; c < 3; ++c) {
      waiting.o[c] = arena.make<float>(n);
      waiting.d[c] = arena.make<float>(n);
    }
    waiting.time = arena.make<float>(n);
    waiting.t = arena.make<float>(n);
    waiting.ray = arena.make<uint32_t>(n);
    waiting.light = arena.make<uint32_t>(n);
  }
  void reserve(Arena& arena, uint32_t more) {
    if (count + more <= room) return;
    room = std::max(2 * room, count + more + 256);
    ray = grown(arena, ray, count, room);
    light = grown(arena, light, count, room);
    t = grown(arena, t, count, room);
    pdf = grown(arena, pdf, count, room);
    for (float*& x : radiance) x = grown(arena, x, count, room);
    for (float*& x : specular)
      if (splits) x = grown(arena, x, count, room);
  }
};

// Asks whether the waiting rays hit their lights, and of those that do what they bring.
void LightSet::askWaiting(uint32_t width, Arena& arena, bool camera, const RayList& list, bool areInfinite,
                          Found& found) const {
  Found::Waiting& w = found.waiting;
  uint32_t n = w.count;
  w.count = 0;
  if (!n) return;
  found.reserve(arena, n);
  const Arena::Mark mark = arena.mark();
  float* const arrays[8] = {w.o[0], w.o[1], w.o[2], w.d[0], w.d[1], w.d[2], w.time, w.t};
  for (float* x : arrays) padFloats(x, n);
  // the rays where lights that move rest; then a run's part of them: origins, directions and times in order
  const float* rest[8];
  const auto carryRays = [&] {
    toRest(arena, n, w.light, w.time, LightVector::Point, arrays, rest);
    toRest(arena, n, w.light, w.time, LightVector::Direction, arrays + 3, rest + 3);
    rest[6] = w.time;
    rest[7] = w.t;
  };
  const auto raysOf = [&](const Order& order, const LightOrder::Run& run, const float* const* in, float* t) {
    LightRayArgs a{};
    order.setLights(a, run);
    setWorld(a);
    a.count = run.count;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = in[c] + run.from;
      a.d[c] = in[3 + c] + run.from;
    }
    a.time = in[6] + run.from;
    a.t = t + run.from;
    return a;
  };
  if (!areInfinite) {
    uint32_t* met = arena.make<uint32_t>(padded(n) + kPad);
    const Order order(*this, width, arena, n, w.light);
    carryRays();
    const float* in[7];
    for (int k = 0; k < 7; ++k) in[k] = order.take(rest[k]);
    float* t = const_cast<float*>(order.take(w.t));
    uint32_t* hit = order.room(met);
    for (uint32_t r = 0; r < order.runCount(); ++r) {
      const LightOrder::Run& run = order.run(r);
      LightRayArgs a = raysOf(order, run, in, t);
      a.hit = hit + run.from;
      if (const auto intersect = kinds_[run.kind].byWidth[width]->intersect)
        intersect(&a);
      else
        std::fill_n(a.hit, padded(run.count), 0u);
    }
    order.put(t, w.t);
    order.put(hit, met);
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; ++i) {
      if (!met[i]) continue;
      if (m != i) {
        for (float* x : arrays) x[m] = x[i];
        w.ray[m] = w.ray[i];
        w.light[m] = w.light[i];
      }
      ++m;
    }
    n = m;
    for (float* x : arrays) padFloats(x, n);
  }
  if (n) {
    float *radiance[3], *pdf = arena.make<float>(padded(n) + kPad);
    for (float*& x : radiance) x = arena.make<float>(padded(n) + kPad);
    const Order order(*this, width, arena, n, w.light);
    carryRays();
    const float* in[8];
    for (int k = 0; k < 8; ++k) in[k] = order.take(rest[k]);
    float* const outputs[4] = {radiance[0], radiance[1], radiance[2], pdf};
    float* ordered[4];
    for (int k = 0; k < 4; ++k) ordered[k] = order.room(outputs[k]);
    for (uint32_t r = 0; r < order.runCount(); ++r) {
      const LightOrder::Run& run = order.run(r);
      LightRayArgs a = raysOf(order, run, in, const_cast<float*>(in[7]));
      for (int c = 0; c < 3; ++c) a.radiance[c] = ordered[c] + run.from;
      a.pdf = ordered[3] + run.from;
      kinds_[run.kind].byWidth[width]->evaluate(&a);
    }
    for (int k = 0; k < 4; ++k) order.put(ordered[k], outputs[k]);
    float* specular[3] = {};
    for (int c = 0; splitsFilters_ && c < 3; ++c) {
      specular[c] = arena.make<float>(padded(n) + kPad);
      std::copy_n(radiance[c], n, specular[c]);
    }
    if (!filters_.empty()) {
      // as sample() says it: infinite lights are infinitely far
      float* far = w.t;
      if (areInfinite) {
        far = arena.make<float>(padded(n) + kPad);
        std::fill_n(far, padded(n), INFINITY);
      }
      uint32_t* set = list.linkSet && !filterLinks_.empty() ? arena.make<uint32_t>(n) : nullptr;
      for (uint32_t i = 0; set && i < n; ++i) set[i] = list.linkSet[list.slots[w.ray[i]]];
      filterRadiance(width, arena, n, w.light, w.o, w.d, far, w.time, set, radiance,
                     camera ? FilterUse::Camera : FilterUse::LitPoints);
      if (splitsFilters_)
        filterRadiance(width, arena, n, w.light, w.o, w.d, far, w.time, set, specular,
                       camera ? FilterUse::Camera : FilterUse::LitPoints, true);
    }
    for (uint32_t i = 0; i < n; ++i) {
      const auto isBlack = [i](float* const x[3]) { return x[0][i] == 0 && x[1][i] == 0 && x[2][i] == 0; };
      if (areInfinite && isBlack(radiance) && (!splitsFilters_ || isBlack(specular))) continue;
      const uint32_t e = found.count++;
      found.ray[e] = w.ray[i];
      found.light[e] = w.light[i];
      found.t[e] = w.t[i];
      found.pdf[e] = pdf[i];
      for (int c = 0; c < 3; ++c) found.radiance[c][e] = radiance[c][i];
      for (int c = 0; splitsFilters_ && c < 3; ++c) found.specular[c][e] = specular[c][i];
    }
  }
  arena.release(mark);
}

// The rays of the list that come near one light.
void LightSet::addNearRays(uint32_t width, Arena& arena, bool camera, const RayList& list, uint32_t light,
                           const Sphere* sphere, Found& found) const {
  const Record& l = recordOf(light);
  if (camera && !(l.flags & kSeenByCamera)) return;
  Found::Waiting& w = found.waiting;
  if (w.count + padded(list.count) > w.room) askWaiting(width, arena, camera, list, !sphere, found);
  const Arena::Mark mark = arena.mark();
  const float* tHit = list.tHit;
  constexpr uint32_t kPlain = kCastsShadow | kSeenByMirrors | kSeenByLenses;
  if (!camera && (l.flags & kPlain) != kPlain) {
    uint32_t slots = 0;
    for (uint32_t i = 0; i < list.count; ++i) slots = std::max(slots, list.slots[i] + 1);
    float* reach = arena.make<float>(padded(slots) + kPad);
    for (uint32_t i = 0; i < list.count; ++i) reach[list.slots[i]] = reachOf(l, camera, list, list.slots[i]);
    tHit = reach;
  }
  const uint32_t at = w.count;
  NearRaysArgs a{list.count,
                 list.slots,
                 list.rays,
                 tHit,
                 !sphere,
                 {},
                 0,
                 {w.o[0] + at, w.o[1] + at, w.o[2] + at},
                 {w.d[0] + at, w.d[1] + at, w.d[2] + at},
                 w.time + at,
                 w.t + at,
                 w.ray + at};
  if (sphere) {
    for (int c = 0; c < 3; ++c) a.center[c] = sphere->center[c];
    a.radius2 = sphere->radius2;
  }
  const uint32_t k = nearRaysKernel(width)(a);
  std::fill_n(w.light + at, k, light);
  w.count += k;
  arena.release(mark);
}

void LightSet::findLights(uint32_t width, Arena& arena, bool camera, const RayList& list, Found& found) const {
  for (const Sphere& s : near_) addNearRays(width, arena, camera, list, s.light, &s, found);
  Found::Waiting& w = found.waiting;
  const auto wait = [&](uint32_t i, uint32_t l, float most, bool isInfinite) {
    if (camera && !(recordOf(l).flags & kSeenByCamera)) return;
    const uint32_t s = list.slots[i];
    const float reach = reachOf(recordOf(l), camera, list, s);
    if (isInfinite ? !(reach > kBeyond) : !(reach > 0)) return;
    if (w.count == w.room) askWaiting(width, arena, camera, list, isInfinite, found);
    for (int c = 0; c < 3; ++c) {
      w.o[c][w.count] = list.rays->o[c][s];
      w.d[c][w.count] = list.rays->d[c][s];
    }
    w.time[w.count] = list.rays->time[s];
    w.t[w.count] = std::min(reach, most);
    w.ray[w.count] = i;
    w.light[w.count++] = l;
  };
  for (uint32_t i = 0; i < list.count && near_.empty(); ++i) {
    const uint32_t s = list.slots[i];
    const float o[3] = {list.rays->o[0][s], list.rays->o[1][s], list.rays->o[2][s]},
                d[3] = {list.rays->d[0][s], list.rays->d[1][s], list.rays->d[2][s]}, most = list.rays->tMax[s];
    const float limit = isShadowless_ && !camera ? most : std::min(list.tHit[s], most);
    boxes_.pass(o, d, limit, [&](uint32_t l) { wait(i, l, most, false); });
  }
  askWaiting(width, arena, camera, list, false, found);
  for (const uint32_t l : distant_) addNearRays(width, arena, camera, list, l, nullptr, found);
  for (uint32_t i = 0; i < list.count && !directions_.isEmpty(); ++i) {
    const uint32_t s = list.slots[i];
    if (!isShadowless_ && !(list.tHit[s] > kBeyond)) continue;
    // where the direction lies
    const float d[3] = {list.rays->d[0][s], list.rays->d[1][s], list.rays->d[2][s]};
    directions_.pass(d, d, 0, [&](uint32_t l) { wait(i, l, list.rays->tMax[s], true); });
  }
  askWaiting(width, arena, camera, list, true, found);
}

void LightSet::hits(uint32_t width, Arena& arena, bool camera, const RayList& list, LightHits* out) const {
  *out = LightHits{};
  if (!list.count || (camera && !isCameraSeen_)) return;
  Found found(arena, list.count, splitsFilters_);
  findLights(width, arena, camera, list, found);
  if (!found.count) return;
  // by ray; a ray's own lights come in an order that its group does not change
  uint32_t* order = arena.make<uint32_t>(found.count);
  bool isSorted = true;
  for (uint32_t e = 0; e < found.count; ++e) {
    order[e] = e;
    isSorted = isSorted && (!e || found.ray[e - 1] <= found.ray[e]);
  }
  if (!isSorted) {
    uint32_t* at = arena.make<uint32_t>(list.count + 1);
    std::fill_n(at, list.count + 1, 0u);
    for (uint32_t e = 0; e < found.count; ++e) ++at[found.ray[e] + 1];
    for (uint32_t i = 0; i < list.count; ++i) at[i + 1] += at[i];
    for (uint32_t e = 0; e < found.count; ++e) order[at[found.ray[e]]++] = e;
  }

  const uint32_t room = padded(found.count) + kPad;
  uint32_t *slot = arena.make<uint32_t>(room), *light = arena.make<uint32_t>(room);
  uint32_t* blocks = arena.make<uint32_t>(room);
  float *pdf = arena.make<float>(room), *t = arena.make<float>(room), *radiance[3];
  for (float*& r : radiance) r = arena.make<float>(room);
  float *diffuse = arena.make<float>(room), *specular = arena.make<float>(room);
  float* specularRadiance[3] = {};
  for (int c = 0; splitsFilters_ && c < 3; ++c) specularRadiance[c] = arena.make<float>(room);
  uint32_t m = 0;
  const auto keep = [&](uint32_t e, bool isBlocking) {
    slot[m] = list.slots[found.ray[e]];
    light[m] = found.light[e];
    t[m] = found.t[e];
    pdf[m] = found.pdf[e];
    for (int c = 0; c < 3; ++c) radiance[c][m] = found.radiance[c][e];
    for (int c = 0; splitsFilters_ && c < 3; ++c) specularRadiance[c][m] = found.specular[c][e];
    diffuse[m] = recordOf(light[m]).diffuse;
    specular[m] = recordOf(light[m]).specular;
    blocks[m++] = isBlocking;
  };
  if (camera) {
    // only the nearest light is seen; it hides the surface, and whatever infinite light is behind
    for (uint32_t from = 0, to; from < found.count; from = to) {
      const uint32_t ray = found.ray[order[from]];
      uint32_t nearest = LightTree::kNone;
      for (to = from; to < found.count && found.ray[order[to]] == ray; ++to) {
        const uint32_t e = order[to];
        if (recordOf(found.light[e]).flags & kInfinite) continue;
        if (nearest == LightTree::kNone || found.t[e] < found.t[nearest]) nearest = e;
      }
      if (nearest != LightTree::kNone) {
        keep(nearest, true);
        list.tHit[list.slots[ray]] = INFINITY;
      } else {
        for (uint32_t k = from; k < to; ++k) keep(order[k], false);
      }
    }
  } else {
    for (uint32_t k = 0; k < found.count; ++k) {
      const uint32_t e = order[k], s = list.slots[found.ray[e]];
      // a light that is not linked to the surface which the ray left does not light it, however it is found
      if (isLinked(list.linkSet ? list.linkSet[s] : 0, found.light[e])) keep(e, false);
    }
    if (m && hasChoice()) {
      const Arena::Mark mark = arena.mark();
      float *x[6], *probability = arena.make<float>(room);
      for (float*& y : x) y = arena.make<float>(room);
      uint32_t* sets = list.linkSet ? arena.make<uint32_t>(room) : nullptr;
      uint32_t* rows = list.weights && list.row ? arena.make<uint32_t>(room) : nullptr;
      for (uint32_t i = 0; i < padded(m); ++i) {
        const uint32_t s = slot[std::min(i, m - 1)];
        for (int c = 0; c < 3; ++c) {
          x[c][i] = list.rays->o[c][s];
          x[3 + c][i] = list.N[0] ? list.N[c][s] : 0.f;
        }
        if (sets) sets[i] = list.linkSet[s];
        if (rows) rows[i] = list.row[s];
        if (i >= m) light[i] = light[m - 1];
      }
      Points p{};
      p.count = m;
      for (int c = 0; c < 3; ++c) {
        p.P[c] = x[c];
        p.N[c] = x[3 + c];
      }
      p.linkSet = list.besideOwn ? setsBesideOwn(arena, padded(m), sets) : sets;
      p.weights = list.weights;
      p.row = rows;
      probabilities(width, p, light, probability);
      for (uint32_t i = 0; i < m; ++i) pdf[i] *= probability[i] + ownShare(light[i], list.besideOwn);
      arena.release(mark);
    } else if (list.besideOwn) {
      for (uint32_t i = 0; i < m; ++i) pdf[i] *= 1.f + ownShare(light[i], list.besideOwn);
    }
  }
  out->count = m;
  out->slot = slot;
  for (int c = 0; c < 3; ++c) {
    out->radiance[c] = radiance[c];
    out->specularRadiance[c] = specularRadiance[c];
  }
  out->pdf = pdf;
  out->t = t;
  out->diffuse = diffuse;
  out->specular = specular;
  out->light = light;
  out->blocks = blocks;
}

}  // namespace kinora::light
