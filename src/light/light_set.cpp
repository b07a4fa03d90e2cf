#include "light/light_set.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "light/choose.h"
#include "light/light_order.h"
#include "light/near_rays.h"

namespace kinora::light {

namespace {

constexpr uint32_t kMostNear = 8;   // lights that are tried one by one
constexpr uint32_t kBatch = 2048;   // pairs of a ray and a light that are asked at once
constexpr float kBeyond = 3.4e38f;  // distances past it are infinite

template <class T>
T* grown(Arena& arena, const T* old, uint32_t count, uint32_t room) {
  T* x = arena.make<T>(room + kPad);
  if (count) std::memcpy(x, old, count * sizeof(T));
  return x;
}

bool isUsable(const LightDescription& d) {
  bool is = std::isfinite(d.power) && (d.isInfinite || (d.radius >= 0 && std::isfinite(d.radius)));
  for (int c = 0; c < 3; ++c)
    is = is && std::isfinite(d.center[c]) && std::isfinite(d.low[c]) && std::isfinite(d.high[c]) &&
         std::isfinite(d.axis[c]);
  return is;
}

void padFloats(float* x, uint32_t n) {
  for (uint32_t i = n; n && i < padded(n); ++i) x[i] = x[n - 1];
}

}  // namespace

class LightSet::Order : public LightOrder {
 public:
  Order(const LightSet& set, uint32_t width, Arena& arena, uint32_t n, const uint32_t* light)
      : LightOrder(
            arena, uint32_t(set.kinds_.size()), set.size(), n, light,
            [&](uint32_t l) { return uint32_t(set.lights_[l].kind); },
            [&](uint32_t k) { return set.kinds_[k].byWidth[width]->mixes != 0; },
            [&](uint32_t l) { return set.lights_[l].instance; }) {}
};

LightSet::LightSet(std::vector<LightKind> kinds, std::vector<LightEntry> lights,
                   const std::vector<std::vector<uint32_t>>& linkSets, const float worldCenter[3], float worldRadius)
    : kinds_(std::move(kinds)), center_{worldCenter[0], worldCenter[1], worldCenter[2]}, radius_(worldRadius) {
  std::vector<LightDescription> descriptions;
  descriptions.reserve(lights.size());
  for (const LightEntry& l : lights) {
    descriptions.push_back(l.description);
    // a light that stands nowhere shines nowhere
    if (!isUsable(l.description)) descriptions.back().power = 0;
  }
  tree_ = LightTree(descriptions);
  links_ = LinkSets(tree_, linkSets.empty() ? std::vector<std::vector<uint32_t>>(1) : linkSets);

  std::vector<LightBox3> boxes;
  std::vector<uint32_t> boxed;
  std::vector<double> power;
  double total = 0;
  lights_.reserve(lights.size());
  for (uint32_t i = 0; i < lights.size(); ++i) {
    LightEntry& l = lights[i];
    const LightDescription& d = l.description;
    const bool isLit = tree_.places()[i].leaf != LightTree::kNone;
    Record r{l.instance, std::move(l.owner), d.diffuse, d.specular, l.group, kNoFilters, uint16_t(l.kind), 0};
    r.flags = uint8_t((l.castsShadow ? kCastsShadow : 0) | (l.visibility & kLightSeenByCamera ? kSeenByCamera : 0) |
                      (l.visibility & kLightSeenByMirrors ? kSeenByMirrors : 0) | (d.isDelta ? kDelta : 0) |
                      (d.isInfinite ? kInfinite : 0) | (isLit ? 0 : kBlack));
    if (!l.filters.empty()) {
      r.filters = uint32_t(filters_.size());
      filters_.push_back(std::move(l.filters));
    }
    if (isLit && !d.isDelta) {
      isCameraSeen_ = isCameraSeen_ || (r.flags & kSeenByCamera);
      isShadowless_ = isShadowless_ || !(r.flags & kCastsShadow);
      if (d.isInfinite) {
        distant_.push_back(i);
      } else {
        LightBox3 b;
        const bool isBoxed = d.low[0] < d.high[0] || d.low[1] < d.high[1] || d.low[2] < d.high[2];
        for (int c = 0; c < 3; ++c) {
          b.low[c] = isBoxed ? d.low[c] : d.center[c] - d.radius * 1.0001f;
          b.high[c] = isBoxed ? d.high[c] : d.center[c] + d.radius * 1.0001f;
        }
        boxes.push_back(b);
        boxed.push_back(i);
      }
    }
    // half by power, half evenly: a light of little power may still be the one next to the point
    power.push_back(isLit ? std::min(double(descriptions[i].power), 1e24) *
                                (d.isInfinite ? 3.14159265358979 * double(radius_) * double(radius_) : 1)
                          : -1);
    if (isLit) total += power.back();
    lights_.push_back(std::move(r));
  }
  if (boxed.size() <= kMostNear) {
    for (const uint32_t i : boxed) {
      const LightDescription& d = descriptions[i];
      near_.push_back({i, {d.center[0], d.center[1], d.center[2]}, d.radius * d.radius * 1.0001f});
    }
  } else {
    boxes_ = LightBoxes(boxes, boxed);
  }
  const auto lit = double(std::count_if(power.begin(), power.end(), [](double p) { return p >= 0; }));
  double sum = 0;
  emission_.reserve(power.size());
  for (const double p : power) {
    if (p >= 0) sum += total > 0 ? 0.5 * p / total + 0.5 / lit : 1 / lit;
    emission_.push_back(float(std::min(sum, 1.0)));
  }
  for (size_t i = emission_.size(); lit > 0 && i-- > 0;) {  // the last that emits takes what rounding left
    emission_[i] = 1;
    if (power[i] >= 0) break;
  }
}

size_t LightSet::bytes() const {
  size_t n = lights_.size() * sizeof(Record) + tree_.nodeCount() * sizeof(TreeNode) +
             tree_.places().size() * sizeof(LightTree::Place) + links_.bytes() + boxes_.bytes() +
             near_.size() * sizeof(Sphere) + (distant_.size() + emission_.size()) * 4;
  for (const auto& f : filters_) n += sizeof f + f.size() * sizeof(LightFilterEntry);
  return n;
}

bool LightSet::hasChoice() const { return tree_.topCount() > 1 || tree_.isDeep() || !links_.areAllWhole(); }

bool LightSet::isLinked(uint32_t linkSet, uint32_t light) const {
  const uint32_t leaf = tree_.places()[light].leaf;
  return leaf != LightTree::kNone && links_.has(linkSet, leaf);
}

void LightSet::probabilities(uint32_t width, const Points& p, const uint32_t* light, float* out) const {
  if (!p.count) return;
  if (!hasChoice()) {
    for (uint32_t i = 0; i < p.count; ++i) out[i] = tree_.places()[light[i]].leaf != LightTree::kNone ? 1.f : 0.f;
    return;
  }
  ChooseArgs a{};
  a.tree = &tree_;
  a.links = &links_;
  a.n = p.count;
  for (int c = 0; c < 3; ++c) {
    a.P[c] = p.P[c];
    a.N[c] = p.N[c];
  }
  a.linkSet = p.linkSet;
  a.light = const_cast<uint32_t*>(light);
  a.probability = out;
  probabilityKernel(width)(a);
}

// Multiplies radiance by the lights' filters: the same numbers for a sample and for a ray that met the light.
void LightSet::filterRadiance(uint32_t width, Arena& arena, uint32_t count, const uint32_t* light,
                              const float* const P[3], const float* const wi[3], const float* distance,
                              const float* time, float* const radiance[3], bool uniformOnly) const {
  if (filters_.empty()) return;
  uint32_t* list = arena.make<uint32_t>(padded(count) + kPad);
  uint32_t n = 0;
  for (uint32_t i = 0; i < count; ++i)
    if (light[i] != kNoLight && lights_[light[i]].filters != kNoFilters) list[n++] = i;
  if (!n) return;
  std::sort(list, list + n,
            [&](uint32_t a, uint32_t b) { return light[a] != light[b] ? light[a] < light[b] : a < b; });
  float *x[8], *factor[3];
  for (float*& f : x) f = arena.make<float>(padded(n) + kPad);
  for (float*& f : factor) f = arena.make<float>(padded(n) + kPad);
  for (uint32_t from = 0, to; from < n; from = to) {
    const uint32_t l = light[list[from]];
    for (to = from; to < n && light[list[to]] == l;) ++to;
    const uint32_t m = to - from;
    for (uint32_t i = 0; i < padded(m); ++i) {
      const uint32_t e = list[from + std::min(i, m - 1)];
      for (int c = 0; c < 3; ++c) {
        x[c][i] = P[c][e];
        x[3 + c][i] = wi[c][e];
      }
      x[6][i] = distance[e];
      x[7][i] = time ? time[e] : 0.f;
    }
    for (const LightFilterEntry& f : filters_[lights_[l].filters]) {
      if (uniformOnly && !f.isUniform) continue;
      const LightFilterArgs a{
          m, {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, x[6], x[7], {factor[0], factor[1], factor[2]}};
      f.byWidth[width]->factor(f.instance, &a);
      for (int c = 0; c < 3; ++c)
        for (uint32_t i = 0; i < m; ++i) radiance[c][list[from + i]] *= factor[c][i];
    }
  }
}

void LightSet::sample(uint32_t width, Arena& arena, const Points& p, LightSamples* out) const {
  const uint32_t n = p.padded;
  float* wi[3];
  float* radiance[3];
  for (int c = 0; c < 3; ++c) {
    out->wi[c] = wi[c] = arena.make<float>(n);
    out->radiance[c] = radiance[c] = arena.make<float>(n);
  }
  float* distance = arena.make<float>(n);
  float* pdf = arena.make<float>(n);
  float* diffuse = arena.make<float>(n);
  float* specular = arena.make<float>(n);
  uint32_t* flags = arena.make<uint32_t>(n);
  uint32_t* light = arena.make<uint32_t>(n);
  out->distance = distance;
  out->pdf = pdf;
  out->diffuse = diffuse;
  out->specular = specular;
  out->flags = flags;
  out->light = light;
  if (!p.count) return;

  const Arena::Mark mark = arena.mark();
  float* choice = nullptr;
  if (tree_.topCount() && hasChoice()) {
    choice = arena.make<float>(n);
    ChooseScratch scratch{};
    if (tree_.isDeep()) {
      for (float** x : {&scratch.x, &scratch.spare, &scratch.spent}) *x = arena.make<float>(n + kPad);
      for (uint32_t** x : {&scratch.list, &scratch.first, &scratch.second, &scratch.few})
        *x = arena.make<uint32_t>(n + kPad);
    }
    chooseKernel(width)({&tree_,
                         &links_,
                         n,
                         {p.P[0], p.P[1], p.P[2]},
                         {p.N[0], p.N[1], p.N[2]},
                         p.linkSet,
                         {p.uChoice[0], p.uChoice[1]},
                         light,
                         choice,
                         scratch});
  } else {
    std::fill_n(light, n, tree_.topCount() ? tree_.nodes()[tree_.top()[0].node].child & ~kLeaf : kNoLight);
  }
  if (tree_.isDeep()) {
    // of many lights each is met seldom: what they are made of is on its way before it is read
    for (uint32_t i = 0; i < p.count; ++i) __builtin_prefetch(&lights_[light[i] != kNoLight ? light[i] : 0]);
    for (uint32_t i = 0; i < p.count; ++i)
      if (light[i] != kNoLight)
        for (uint32_t line = 0; line < 5; ++line)
          __builtin_prefetch(static_cast<const char*>(lights_[light[i]].instance) + 64 * line);
  }
  const Order order(*this, width, arena, p.count, light);
  const float* const in[6] = {order.take(p.P[0]), order.take(p.P[1]), order.take(p.P[2]),
                              order.take(p.time), order.take(p.u[0]), order.take(p.u[1])};
  float* const outputs[8] = {wi[0], wi[1], wi[2], distance, radiance[0], radiance[1], radiance[2], pdf};
  float* ordered[8];
  for (int k = 0; k < 8; ++k) ordered[k] = order.room(outputs[k]);
  uint32_t* orderedFlags = order.room(flags);
  for (uint32_t r = 0; r < order.runCount(); ++r) {
    const LightOrder::Run& run = order.run(r);
    LightSampleArgs a{};
    order.setLights(a, run);
    setWorld(a);
    a.count = run.count;
    const uint32_t at = run.from;
    for (int c = 0; c < 3; ++c) {
      a.P[c] = in[c] + at;
      a.wi[c] = ordered[c] + at;
      a.radiance[c] = ordered[4 + c] + at;
    }
    a.time = in[3] + at;
    a.u[0] = in[4] + at;
    a.u[1] = in[5] + at;
    a.distance = ordered[3] + at;
    a.pdf = ordered[7] + at;
    a.flags = orderedFlags + at;
    kinds_[run.kind].byWidth[width]->sample(&a);
  }
  for (int k = 0; k < 8; ++k) order.put(ordered[k], outputs[k]);
  order.put(orderedFlags, flags);
  for (uint32_t i = 0; i < p.count; ++i) {
    if (light[i] != kNoLight) continue;
    for (float* x : outputs) x[i] = 0;
    wi[2][i] = 1;
    flags[i] = 0;
  }
  filterRadiance(width, arena, p.count, light, p.P, wi, distance, p.time, radiance, false);
  for (uint32_t i = 0; i < p.count; ++i) {
    const bool some = light[i] != kNoLight;
    diffuse[i] = some ? lights_[light[i]].diffuse : 0.f;
    specular[i] = some ? lights_[light[i]].specular : 0.f;
    if (some && !(lights_[light[i]].flags & kCastsShadow)) distance[i] = 0;
    // the choice's probability divides the estimate: discrete lights carry it in pdf too
    if (choice) pdf[i] *= choice[i];
  }
  arena.release(mark);
  for (float* x : outputs) padFloats(x, p.count);
  padFloats(diffuse, p.count);
  padFloats(specular, p.count);
  for (uint32_t i = p.count; i < n; ++i) {
    flags[i] = flags[p.count - 1];
    light[i] = light[p.count - 1];
  }
}

// How far a ray of the list looks for a light.
float LightSet::reachOf(const Record& light, bool camera, const RayList& list, uint32_t slot) const {
  if (camera) return list.tHit[slot];
  const bool inMirrors = light.flags & kSeenByMirrors;
  if (list.origin && (list.origin[slot] & kFromDiscrete)) return inMirrors ? list.tHit[slot] : 0.f;
  return light.flags & kCastsShadow ? list.tHit[slot] : INFINITY;
}

// Lights met, growing: `ray` is the index in the list. And the rays that wait to be asked of a light each.
struct LightSet::Found {
  uint32_t count = 0, room = 0;
  uint32_t *ray = nullptr, *light = nullptr;
  float *t = nullptr, *pdf = nullptr, *radiance[3] = {};
  struct Waiting {
    uint32_t count = 0, room = 0;
    float *o[3], *d[3], *time, *t;
    uint32_t *ray, *light;
  } waiting;
  Found(Arena& arena, uint32_t rays) {
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
  }
};

// Asks whether the waiting rays hit their lights, and of those that do what they bring.
void LightSet::askWaiting(uint32_t width, Arena& arena, bool areInfinite, Found& found) const {
  Found::Waiting& w = found.waiting;
  uint32_t n = w.count;
  w.count = 0;
  if (!n) return;
  found.reserve(arena, n);
  const Arena::Mark mark = arena.mark();
  float* const arrays[8] = {w.o[0], w.o[1], w.o[2], w.d[0], w.d[1], w.d[2], w.time, w.t};
  for (float* x : arrays) padFloats(x, n);
  // a run's part of the rays: origins, directions and times in order
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
    const float* in[7];
    for (int k = 0; k < 7; ++k) in[k] = order.take(arrays[k]);
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
    const float* in[8];
    for (int k = 0; k < 8; ++k) in[k] = order.take(arrays[k]);
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
    if (!filters_.empty()) {
      // as sample() says it: infinite lights are infinitely far
      float* far = w.t;
      if (areInfinite) {
        far = arena.make<float>(padded(n) + kPad);
        std::fill_n(far, padded(n), INFINITY);
      }
      filterRadiance(width, arena, n, w.light, w.o, w.d, far, w.time, radiance, false);
    }
    for (uint32_t i = 0; i < n; ++i) {
      if (areInfinite && radiance[0][i] == 0 && radiance[1][i] == 0 && radiance[2][i] == 0) continue;
      const uint32_t e = found.count++;
      found.ray[e] = w.ray[i];
      found.light[e] = w.light[i];
      found.t[e] = w.t[i];
      found.pdf[e] = pdf[i];
      for (int c = 0; c < 3; ++c) found.radiance[c][e] = radiance[c][i];
    }
  }
  arena.release(mark);
}

// The rays of the list that come near one light.
void LightSet::addNearRays(uint32_t width, Arena& arena, bool camera, const RayList& list, uint32_t light,
                           const Sphere* sphere, Found& found) const {
  const Record& l = lights_[light];
  if (camera && !(l.flags & kSeenByCamera)) return;
  Found::Waiting& w = found.waiting;
  if (w.count + padded(list.count) > w.room) askWaiting(width, arena, !sphere, found);
  const Arena::Mark mark = arena.mark();
  const float* tHit = list.tHit;
  if (!camera && (l.flags & (kCastsShadow | kSeenByMirrors)) != (kCastsShadow | kSeenByMirrors)) {
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
  for (uint32_t i = 0; i < list.count && near_.empty(); ++i) {
    const uint32_t s = list.slots[i];
    const float o[3] = {list.rays->o[0][s], list.rays->o[1][s], list.rays->o[2][s]},
                d[3] = {list.rays->d[0][s], list.rays->d[1][s], list.rays->d[2][s]}, most = list.rays->tMax[s];
    const float limit = isShadowless_ && !camera ? most : std::min(list.tHit[s], most);
    boxes_.pass(o, d, limit, [&](uint32_t l) {
      if (camera && !(lights_[l].flags & kSeenByCamera)) return;
      const float reach = std::min(reachOf(lights_[l], camera, list, s), most);
      if (!(reach > 0)) return;
      if (w.count == w.room) askWaiting(width, arena, false, found);
      for (int c = 0; c < 3; ++c) {
        w.o[c][w.count] = o[c];
        w.d[c][w.count] = d[c];
      }
      w.time[w.count] = list.rays->time[s];
      w.t[w.count] = reach;
      w.ray[w.count] = i;
      w.light[w.count++] = l;
    });
  }
  askWaiting(width, arena, false, found);
  for (const uint32_t l : distant_) addNearRays(width, arena, camera, list, l, nullptr, found);
  askWaiting(width, arena, true, found);
}

void LightSet::hits(uint32_t width, Arena& arena, bool camera, const RayList& list, LightHits* out) const {
  *out = LightHits{};
  if (!list.count || (camera && !isCameraSeen_)) return;
  Found found(arena, list.count);
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
  uint32_t m = 0;
  const auto keep = [&](uint32_t e, bool isBlocking) {
    slot[m] = list.slots[found.ray[e]];
    light[m] = found.light[e];
    t[m] = found.t[e];
    pdf[m] = found.pdf[e];
    for (int c = 0; c < 3; ++c) radiance[c][m] = found.radiance[c][e];
    diffuse[m] = lights_[light[m]].diffuse;
    specular[m] = lights_[light[m]].specular;
    blocks[m++] = isBlocking;
  };
  if (camera) {
    // only the nearest light is seen; it hides the surface, and whatever infinite light is behind
    for (uint32_t from = 0, to; from < found.count; from = to) {
      const uint32_t ray = found.ray[order[from]];
      uint32_t nearest = kNone;
      for (to = from; to < found.count && found.ray[order[to]] == ray; ++to) {
        const uint32_t e = order[to];
        if (lights_[found.light[e]].flags & kInfinite) continue;
        if (nearest == kNone || found.t[e] < found.t[nearest]) nearest = e;
      }
      if (nearest != kNone) {
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
      for (uint32_t i = 0; i < padded(m); ++i) {
        const uint32_t s = slot[std::min(i, m - 1)];
        for (int c = 0; c < 3; ++c) {
          x[c][i] = list.rays->o[c][s];
          x[3 + c][i] = list.N[0] ? list.N[c][s] : 0.f;
        }
        if (sets) sets[i] = list.linkSet[s];
        if (i >= m) light[i] = light[m - 1];
      }
      Points p{};
      p.count = m;
      for (int c = 0; c < 3; ++c) {
        p.P[c] = x[c];
        p.N[c] = x[3 + c];
      }
      p.linkSet = sets;
      probabilities(width, p, light, probability);
      for (uint32_t i = 0; i < m; ++i) pdf[i] *= probability[i];
      arena.release(mark);
    }
  }
  out->count = m;
  out->slot = slot;
  for (int c = 0; c < 3; ++c) out->radiance[c] = radiance[c];
  out->pdf = pdf;
  out->t = t;
  out->diffuse = diffuse;
  out->specular = specular;
  out->light = light;
  out->blocks = blocks;
}

void LightSet::emit(uint32_t width, Arena& arena, uint32_t n, const float* uChoice, const float* const u[4],
                    const float* time, float* const o[3], float* const d[3], float* const throughput[3],
                    uint32_t* light) const {
  // light paths come from all lights
  if (!tree_.topCount()) {
    for (int c = 0; c < 3; ++c) std::fill_n(throughput[c], padded(n), 0.f);
    std::fill_n(light, padded(n), kNoLight);
    return;
  }
  if (!n) return;
  const uint32_t room = padded(n) + kPad;
  uint32_t* chosen = arena.make<uint32_t>(room);
  float* choice = arena.make<float>(room);
  for (uint32_t i = 0; i < n; ++i) {
    const size_t k =
        std::min<size_t>(size_t(std::upper_bound(emission_.begin(), emission_.end(), uChoice[i]) - emission_.begin()),
                         emission_.size() - 1);
    chosen[i] = light[i] = uint32_t(k);
    choice[i] = emission_[k] - (k ? emission_[k - 1] : 0.f);
  }
  for (uint32_t i = n; i < padded(n); ++i) chosen[i] = chosen[n - 1];
  const Order order(*this, width, arena, n, chosen);
  const float* in[5] = {order.take(u[0]), order.take(u[1]), order.take(u[2]), order.take(u[3]), order.take(time)};
  float *outputs[14], *ordered[14];
  for (int k = 0; k < 14; ++k) {
    outputs[k] = arena.make<float>(room);
    ordered[k] = order.room(outputs[k]);
  }
  for (uint32_t r = 0; r < order.runCount(); ++r) {
    const LightOrder::Run& run = order.run(r);
    LightEmitArgs a{};
    order.setLights(a, run);
    setWorld(a);
    a.count = run.count;
    for (int k = 0; k < 4; ++k) a.u[k] = in[k] + run.from;
    a.time = in[4] ? in[4] + run.from : nullptr;
    for (int c = 0; c < 3; ++c) {
      a.o[c] = ordered[c] + run.from;
      a.d[c] = ordered[3 + c] + run.from;
      a.N[c] = ordered[6 + c] + run.from;
      a.radiance[c] = ordered[9 + c] + run.from;
    }
    a.pdfPosition = ordered[12] + run.from;
    a.pdfDirection = ordered[13] + run.from;
    kinds_[run.kind].byWidth[width]->emit(&a);
  }
  for (int k = 0; k < 14; ++k) order.put(ordered[k], outputs[k]);
  // a factor that depends on the lit point is not known yet
  filterRadiance(width, arena, n, chosen, outputs, outputs + 3, time, time, outputs + 9, true);
  for (uint32_t i = 0; i < n; ++i) {
    float cosine = 0;
    for (int c = 0; c < 3; ++c) {
      o[c][i] = outputs[c][i];
      d[c][i] = outputs[3 + c][i];
      cosine += outputs[3 + c][i] * outputs[6 + c][i];
    }
    const float pdf = outputs[12][i] * outputs[13][i] * choice[i];
    const float scale = pdf > 0 && cosine > 0 ? cosine / pdf : 0.f;
    for (int c = 0; c < 3; ++c) throughput[c][i] = outputs[9 + c][i] * scale;
  }
}

}  // namespace kinora::light
