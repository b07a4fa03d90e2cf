// Vertices: what a context knows stays when its path goes on, a record of a vertex shades to the same bits in any
// company, group and thread, and rays from vertices meet what lies on an object. An integrator of the test takes a
// digest of all that a point answers: geometry, built-ins, closure, light samples, their shadows, a ray onward.
// Misses points in space, which have no records.
#include <kinora/bxdf.h>
#include <kinora/integrator.h>
#include <kinora/pattern_author.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <random>

#include "tests/probes/probe_support.h"

namespace kinora::probes {
namespace {

enum class Task { Records, Contexts, Marks, Chords, ChordsOfSet, Places };
struct Kept {
  VertexRecord record;
  uint64_t digest;
};
// What the integrators of a render share; one test runs at a time.
struct Shared {
  Task task = Task::Records;
  std::mutex mutex;
  std::vector<Kept> kept;
  uint64_t compared = 0, different = 0, chords = 0, wrongCounts = 0;
  double worstLength = 0;
  void add(uint64_t digests, uint64_t others) {
    const std::lock_guard lock(mutex);
    compared += digests;
    different += others;
  }
} shared;

constexpr const char* kSetName = "pair";
constexpr Param kParams[] = {param::string("traceSet", kSetName).traceSet().help("Set of the chords.")};

struct Digest {
  uint64_t h = 0x9E3779B97F4A7C15u;
  void add(uint32_t w) { h = (h ^ w) * 0xff51afd7ed558ccdu ^ (h >> 31); }
  void add(float f) {
    uint32_t w;
    std::memcpy(&w, &f, 4);
    add(w);
  }
};

class Prober {
 public:
  Prober(Group* g, const Services* s) : g_(g), s_(s) {}
  float* floats(size_t n) { return static_cast<float*>(s_->alloc(g_, n * sizeof(float))); }
  uint32_t* words(size_t n) { return static_cast<uint32_t*>(s_->alloc(g_, n * sizeof(uint32_t))); }
  struct Direction {
    float* x[3];
  };

  std::vector<Digest> digests(const Context& c) {
    std::vector<Digest> d(c.count);
    const auto all = [&](auto&& of) {
      for (uint32_t i = 0; i < c.count; ++i) of(d[i], i);
    };
    const Value builtins[] = {c.builtin(Builtin::U),       c.builtin(Builtin::V),       c.builtin(Builtin::St),
                              c.builtin(Builtin::DPdu),    c.builtin(Builtin::Tangent), c.builtin(Builtin::Po),
                              c.builtin(Builtin::ObjectId)};
    Value own = c.fn->primvar(&c, "heat", nullptr);
    all([&](Digest& x, uint32_t i) {
      for (int k = 0; k < 3; ++k)
        for (const float* const* a : {c.P, c.N, c.Ng, c.wo}) x.add(a[k][i]);
      for (const float* a : {c.radius, c.spread, c.time, c.bias, c.outerIor, c.distance, c.place.u, c.place.v})
        x.add(a[i]);
      for (const uint32_t* a : {c.entering, c.sampleSeed, c.sampleIndex, c.place.instance, c.place.geometry,
                                c.place.primitive, c.place.level})
        x.add(a[i]);
      x.add(c.depth);
      x.add(c.traits);
      for (const Value& v : builtins)
        for (uint32_t k = 0; k < v.components; ++k) x.add(v.data[k][i * v.stride]);
      for (uint32_t k = 0; k < own.components; ++k) x.add(own.data[k][i * own.stride]);
    });
    // the closure, towards the light samples; what shadows them
    LightSamples ls;
    s_->lightSamples(g_, &c, 0, 1, &ls);
    EvaluateArgs e{};
    for (int k = 0; k < 3; ++k) e.wi[k] = ls.wi[k];
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (int k = 0; k < 3; ++k) e.weight[l][k] = floats(c.padded);
    e.pdf = floats(c.padded);
    c.bxdf->evaluate(&c, c.closure, &e);
    float *o[3], *T[3], *tMax = floats(c.padded);
    uint32_t* tinted = words(c.padded);
    for (int k = 0; k < 3; ++k) {
      o[k] = floats(c.padded);
      T[k] = floats(c.padded);
    }
    for (uint32_t i = 0; i < c.padded; ++i) {
      float side = 0;
      for (int k = 0; k < 3; ++k) side += c.Ng[k][i] * ls.wi[k][i];
      for (int k = 0; k < 3; ++k) o[k][i] = c.P[k][i] + (side < 0 ? -1.f : 1.f) * c.bias[i] * c.Ng[k][i];
      tMax[i] = std::min(ls.distance[i] * 0.999f, 1e30f);
      tinted[i] = 1;
    }
    const ShadowRun run{&c, nullptr, c.count};
    const ShadowRays rays{c.count, {o[0], o[1], o[2]}, {ls.wi[0], ls.wi[1], ls.wi[2]}, tMax, c.time, nullptr, 1, &run,
                          tinted,  {T[0], T[1], T[2]}};
    s_->shadow(g_, c.depth, &rays);
    all([&](Digest& x, uint32_t i) {
      x.add(ls.pdf[i]);
      x.add(ls.light[i]);
      x.add(e.pdf[i]);
      for (int k = 0; k < 3; ++k) {
        x.add(ls.wi[k][i]);
        x.add(T[k][i]);
        for (uint32_t l = 0; l < c.slotCount; ++l) x.add(e.weight[l][k][i]);
      }
    });
    // a ray onward, in a list of its own: what it meets and what the media around it let through
    RayList& list = *s_->makeRays(g_, c.count);
    std::vector<uint32_t> points(c.count), through(c.count);
    const Direction w = onward(c, list, points.data(), through.data());
    uint32_t* entries = words(padded(c.count));
    uint32_t n = 0;
    for (uint32_t i = 0; i < c.count; ++i)
      if (w.x[0][i] != 0 || w.x[1][i] != 0 || w.x[2][i] != 0) entries[n++] = i;
    for (uint32_t i = n; i < padded(n); ++i) entries[i] = entries[n - 1];
    float* open[3] = {floats(list.capacity), floats(list.capacity), floats(list.capacity)};
    if (n) s_->trace(g_, &list, RayKind::Indirect, c.depth + 1, n, entries, open);
    for (uint32_t j = 0; j < n; ++j) {
      const uint32_t i = entries[j];
      d[i].add(list.hits.t[i]);
      for (int k = 0; k < 3; ++k) d[i].add(open[k][i]);
    }
    return d;
  }

  // Directions that the bxdfs choose, as rays of `list` that leave the points; black where there is none.
  Direction onward(const Context& c, RayList& list, uint32_t* points, uint32_t* through) {
    const Generated made(g_, s_, c);
    for (int k = 0; k < 4; ++k)
      for (uint32_t i = 0; i < c.padded; ++i)
        made.u[k][i] =
            float((c.sampleSeed[i] * 747796405u + c.sampleIndex[i] * 2891336453u + uint32_t(k) * 277803737u) >> 8) /
            16777216.f;
    made.generate(c);
    float* const* wi = made.wi;
    std::vector<uint32_t> entries(c.count);
    for (uint32_t i = 0; i < c.count; ++i) {
      points[i] = entries[i] = i;
      through[i] = (made.flags[i] & kSampleTransmit) != 0;
      const bool some = made.slot[i] != kNoLobe && made.pdf[i] > 0;
      float side = 0;
      for (int k = 0; k < 3; ++k) side += c.Ng[k][i] * wi[k][i];
      for (int k = 0; k < 3; ++k) {
        if (!some) wi[k][i] = 0;
        list.rays.o[k][i] = c.P[k][i] + (side < 0 ? -1.f : 1.f) * c.bias[i] * c.Ng[k][i];
        list.rays.d[k][i] = wi[k][i];
      }
      list.rays.tMax[i] = 1e30f;
      list.rays.time[i] = c.time[i];
      list.rays.radius[i] = c.radius[i];
      list.rays.spread[i] = c.spread[i];
      list.origin[i] = made.flags[i] & kSampleDiscrete ? kFromDiscrete | kFromSpecular : 0;
    }
    s_->leave(g_, &list, &c, c.count, points, entries.data(), through);
    return {{wi[0], wi[1], wi[2]}};
  }

  // Contexts of camera hits, then of what their directions meet, `bounces` deep.
  std::vector<const Context*> path(uint32_t bounces) {
    std::vector<const Context*> all;
    RayList* list = &g_->paths;
    std::vector<RayList*> lists{list};
    uint32_t* live = words(g_->padded + kPad);
    for (uint32_t i = 0; i < g_->padded; ++i) live[i] = std::min(i, g_->count - 1);
    float* T[3] = {floats(g_->padded + kPad), floats(g_->padded + kPad), floats(g_->padded + kPad)};
    s_->trace(g_, list, RayKind::Camera, 0, g_->count, live, T);
    std::vector<const Context*> last = shadeHits(*list, g_->count, 0);
    all = last;
    for (uint32_t depth = 1; depth <= bounces; ++depth) {
      std::vector<const Context*> next;
      for (const Context* c : last) {
        RayList& own = *s_->makeRays(g_, c->count);
        std::vector<uint32_t> points(c->count), through(c->count);
        const Direction w = onward(*c, own, points.data(), through.data());
        uint32_t *entries = words(padded(c->count)), n = 0;
        for (uint32_t i = 0; i < c->count; ++i)
          if (w.x[0][i] != 0 || w.x[1][i] != 0 || w.x[2][i] != 0) entries[n++] = i;
        for (uint32_t i = n; i < padded(n); ++i) entries[i] = n ? entries[n - 1] : 0;
        float* open[3] = {floats(own.capacity), floats(own.capacity), floats(own.capacity)};
        for (uint32_t i = 0; i < c->count; ++i) own.hits.t[i] = INFINITY;
        if (n) s_->trace(g_, &own, RayKind::Indirect, depth, n, entries, open);
        const auto more = shadeHits(own, c->count, depth);
        next.insert(next.end(), more.begin(), more.end());
      }
      all.insert(all.end(), next.begin(), next.end());
      last = next;
    }
    return all;
  }

  std::vector<const Context*> shadeHits(RayList& list, uint32_t count, uint32_t depth) {
    uint32_t* hit = words(padded(count) + kPad);
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; ++i)
      if (!std::isinf(list.hits.t[i])) hit[n++] = i;
    for (uint32_t i = n; n && i < padded(n); ++i) hit[i] = hit[n - 1];
    Context* const* made;
    const uint32_t m = s_->shade(g_, &list, kTraitEyePath, depth, n, hit, &made);
    return {made, made + m};
  }

 private:
  Group* g_;
  const Services* s_;
};

void records(Group* g, const Services* s, uint32_t stage) {
  Prober p(g, s);
  if (stage == 0) {
    for (const Context* c : p.path(3)) {
      std::vector<uint32_t> points(c->count);
      for (uint32_t i = 0; i < c->count; ++i) points[i] = i;
      std::vector<VertexRecord> kept(c->count);
      s->keepVertices(g, c, c->count, points.data(), kept.data());
      const std::vector<Digest> d = p.digests(*c);
      const std::lock_guard lock(shared.mutex);
      for (uint32_t i = 0; i < c->count; ++i) shared.kept.push_back({kept[i], d[i].h});
    }
    return;
  }
  // a mixture of all groups' vertices, another for each group of this stage
  std::vector<Kept> mixture;
  {
    const std::lock_guard lock(shared.mutex);
    std::minstd_rand random(g->paths.sampleSeed[0] % 2147483646u + 1);
    for (int i = 0; i < 700; ++i) mixture.push_back(shared.kept[random() % shared.kept.size()]);
  }
  std::vector<VertexRecord> list;
  for (const Kept& k : mixture) list.push_back(k.record);
  Context* const* contexts;
  const uint32_t count = s->shadeVertices(g, uint32_t(list.size()), list.data(), &contexts);
  uint64_t different = 0, compared = 0;
  for (uint32_t c = 0; c < count; ++c) {
    const std::vector<Digest> d = p.digests(*contexts[c]);
    for (uint32_t i = 0; i < contexts[c]->count; ++i, ++compared)
      different += d[i].h != mixture[contexts[c]->path[i]].digest;
  }
  shared.add(compared, different);
}

// The same hits shaded twice; paths go on and are shaded again before the second contexts are asked anything.
void contexts(Group* g, const Services* s) {
  Prober p(g, s);
  p.path(0);
  const auto before = p.shadeHits(g->paths, g->count, 0);
  const auto after = p.shadeHits(g->paths, g->count, 0);
  std::vector<uint64_t> first;
  for (const Context* c : before)
    for (const Digest& d : p.digests(*c)) first.push_back(d.h);
  // onward from every point, in the very slots
  for (const Context* c : before) {
    std::vector<uint32_t> points(c->count), through(c->count, 1);
    uint32_t* slots = static_cast<uint32_t*>(s->alloc(g, padded(c->count) * 4));
    for (uint32_t i = 0; i < padded(c->count); ++i) {
      const uint32_t k = std::min(i, c->count - 1), slot = slots[i] = c->path[k];
      if (i < c->count) points[i] = i;
      for (int x = 0; x < 3; ++x) {
        g->paths.rays.o[x][slot] = c->P[x][k] - 2 * c->bias[k] * c->Ng[x][k];
        g->paths.rays.d[x][slot] = -c->wo[x][k];
      }
      g->paths.rays.tMax[slot] = 1e30f;
      g->paths.rays.time[slot] = 0.5f;
      g->paths.origin[slot] = kFromSpecular;
    }
    s->leave(g, &g->paths, c, c->count, points.data(), nullptr, through.data());
    float* T[3] = {p.floats(g->paths.capacity), p.floats(g->paths.capacity), p.floats(g->paths.capacity)};
    s->trace(g, &g->paths, RayKind::Indirect, 1, c->count, slots, T);
    uint32_t n = 0;
    for (uint32_t i = 0; i < c->count; ++i)
      if (!std::isinf(g->paths.hits.t[slots[i]])) slots[n++] = slots[i];
    for (uint32_t i = n; n && i < padded(n); ++i) slots[i] = slots[n - 1];
    Context* const* unused;
    s->shade(g, &g->paths, kTraitEyePath, 1, n, slots, &unused);
  }
  size_t at = 0;
  uint64_t different = 0;
  for (const Context* c : after)
    for (const Digest& d : p.digests(*c)) different += d.h != first[at++];
  shared.add(at, different);
}

// What contexts are asked for the first time lies in memory that is marked, given back, and used for something else; they
// are asked again.
void marks(Group* g, const Services* s) {
  Prober p(g, s);
  p.path(0);
  const auto contexts = p.shadeHits(g->paths, g->count, 0);
  std::vector<uint64_t> first;
  uint64_t different = 0, compared = 0;
  const MemoryMark outer = s->markMemory(g);
  for (int again = 0; again < 4; ++again) {
    s->alloc(g, 4096);
    const MemoryMark inner = s->markMemory(g);
    size_t at = 0;
    for (const Context* c : contexts)
      for (const Digest& d : p.digests(*c)) {
        if (!again)
          first.push_back(d.h);
        else
          different += d.h != first[at++];
        ++compared;
      }
    s->releaseMemory(g, again % 2 ? outer : inner);
    for (int i = 0; i < 400; ++i) std::memset(s->alloc(g, 16384), 0x5a, 16384);
    if (again % 2) s->releaseMemory(g, outer);
  }
  shared.add(compared, different);
}

// Points made of the places of camera hits and of what their rays met, shaded: as the hits themselves but for
// rounding, whichever side they were seen from. Places that are none are left out.
void places(Group* g, const Services* s) {
  Prober p(g, s);
  uint64_t count = 0, wrong = 0;
  for (const Context* c : p.path(2)) {
    const uint32_t n = c->count;
    std::vector<uint32_t> inside(n), which(n), instance(c->place.instance, c->place.instance + n),
        primitive(c->place.primitive, c->place.primitive + n);
    for (uint32_t i = 0; i < n; ++i) inside[i] = !c->entering[i];
    const uint32_t broken = n > 5 ? n / 2 : ~0u;
    if (broken < n) primitive[broken] = 0x7fffffff;
    if (broken < n) instance[broken - 1] = ~0u;
    const SurfacePlaces at{instance.data(), c->place.geometry, primitive.data(), c->place.u,    c->place.v,
                           c->time,         c->radius,         inside.data(),    c->sampleSeed, c->sampleIndex};
    std::vector<VertexRecord> records(n);
    const uint32_t made = s->makeVertices(g, n, &at, records.data(), which.data());
    std::vector<uint32_t> alone(n);  // which those are, without records
    wrong += s->makeVertices(g, n, &at, nullptr, alone.data()) != made ||
             !std::equal(alone.begin(), alone.begin() + made, which.begin());
    Context* const* contexts;
    const uint32_t contextCount = s->shadeVertices(g, made, records.data(), &contexts);
    for (uint32_t k = 0; k < contextCount; ++k) {
      const Context& d = *contexts[k];
      const Value st[2] = {c->builtin(Builtin::St), d.builtin(Builtin::St)},
                  du[2] = {c->builtin(Builtin::DPdu), d.builtin(Builtin::DPdu)},
                  heat[2] = {c->fn->primvar(c, "heat", nullptr), d.fn->primvar(&d, "heat", nullptr)};
      for (uint32_t j = 0; j < d.count; ++j, ++count) {
        const uint32_t i = which[d.path[j]];
        float apart = 0, turned = 0, size = 1e-6f;
        for (int x = 0; x < 3; ++x) {
          apart = std::max(apart, std::fabs(c->P[x][i] - d.P[x][j]));
          turned = std::max(turned, std::fabs(c->Ng[x][i] - d.Ng[x][j]));
          size = std::max(size, c->bias[i]);
        }
        bool isSame = i != broken && i + 1 != broken && apart < 10 * size && turned < 0.05f &&
                      c->entering[i] == d.entering[j] && c->bxdf == d.bxdf && c->time[i] == d.time[j] &&
                      c->place.instance[i] == d.place.instance[j] && c->radius[i] == d.radius[j];
        for (int x = 0; x < 2; ++x) isSame &= std::fabs(st[0].data[x][i] - st[1].data[x][j]) < 1e-4f;
        for (int x = 0; x < 3; ++x)
          isSame &= std::fabs(du[0].data[x][i] - du[1].data[x][j]) < 1e-3f * (1 + std::fabs(du[0].data[x][i]));
        for (uint32_t x = 0; x < heat[0].components; ++x)
          isSame &= std::fabs(heat[0].data[x][i] - heat[1].data[x][j]) < 1e-4f;
        wrong += !isSame;
      }
    }
    const uint32_t meshes = n - (broken < n ? 2 : 0);
    if (made > meshes) ++wrong;
  }
  const std::lock_guard lock(shared.mutex);
  shared.compared += count;
  shared.different += wrong;
}

// Where a ray enters and leaves the small sphere of the set; false: it passes, `isNear` then or there by little.
// o: from the centre of the unit sphere.
constexpr double kSmall[3] = {.2, .1, 0}, kSmallRadius = .3;
bool meetsSmall(const double o[3], const float d[3], double t[2], bool& isNear) {
  double along = 0, o2 = 0;
  for (int k = 0; k < 3; ++k) {
    along += (kSmall[k] - o[k]) * double(d[k]);
    o2 += (kSmall[k] - o[k]) * (kSmall[k] - o[k]);
  }
  const double apart = std::sqrt(std::max(0., o2 - along * along));
  isNear = std::fabs(apart - kSmallRadius) < .02;
  if (apart >= kSmallRadius || along < 0) return false;
  const double half = std::sqrt(kSmallRadius * kSmallRadius - apart * apart);
  t[0] = along - half;
  t[1] = along + half;
  return true;
}

// From each camera hit on the unit sphere a chord into it; what it meets of the sphere alone, or of the set that a
// small sphere inside belongs to as well.
void chords(Group* g, const Services* s) {
  Prober p(g, s);
  uint64_t count = 0, wrong = 0;
  double worst = 0;
  for (const Context* c : p.path(0)) {
    float* x[7];
    for (float*& f : x) f = p.floats(c->padded);
    std::vector<uint32_t> points(c->count);
    std::vector<float> length(c->count);
    for (uint32_t i = 0; i < c->count; ++i) {
      points[i] = i;
      std::minstd_rand random(c->sampleSeed[i] % 2147483646u + 1 + c->sampleIndex[i]);
      std::uniform_real_distribution<float> flat(-1, 1);
      float d[3], l2 = 0, cosine;
      do {
        l2 = cosine = 0;
        for (int k = 0; k < 3; ++k) {
          d[k] = flat(random);
          l2 += d[k] * d[k];
          cosine -= d[k] * c->N[k][i];
        }
        cosine /= std::sqrt(l2);
      } while (l2 > 1 || l2 < 0.01f || cosine < 0.2f);
      for (int k = 0; k < 3; ++k) {
        x[k][i] = c->P[k][i] - c->bias[i] * c->Ng[k][i];
        x[3 + k][i] = d[k] / std::sqrt(l2);
      }
      x[6][i] = 1e30f;
      length[i] = 2 * cosine;
    }
    Rays rays{};
    for (int k = 0; k < 3; ++k) {
      rays.o[k] = x[k];
      rays.d[k] = x[3 + k];
    }
    rays.tMax = x[6];
    rays.time = const_cast<float*>(c->time);
    ObjectHits hits{};
    hits.most = 4;
    const bool ofSet = shared.task == Task::ChordsOfSet;
    hits.traceSet = ofSet ? kSetName : nullptr;
    s->hitsOnObject(g, c, c->count, points.data(), &rays, &hits);
    for (uint32_t i = 0; i < c->count; ++i) {
      const float* t = hits.t + size_t(i) * 4;
      const uint32_t* instance = hits.instance + size_t(i) * 4;
      double small[2];
      bool isNear = false, meets = false;
      if (ofSet) {
        double o[3];
        for (int k = 0; k < 3; ++k) o[k] = double(c->N[k][i]) - double(c->bias[i]) * double(c->Ng[k][i]);
        const float d[3] = {x[3][i], x[4][i], x[5][i]};
        meets = meetsSmall(o, d, small, isNear);
        if (isNear) continue;
      }
      const uint32_t last = meets ? 2 : 0;
      ++count;
      wrong += hits.count[i] != last + 1 || hits.beyond[i] != 0;
      if (hits.count[i] <= last) continue;
      worst = std::max(worst, std::fabs(double(t[last]) - length[i]));
      for (uint32_t k = 0; k < last; ++k) {
        worst = std::max(worst, std::fabs(double(t[k]) - small[k]));
        wrong += instance[k] == c->place.instance[points[i]];
      }
      wrong += instance[last] != c->place.instance[points[i]];
    }
  }
  const std::lock_guard lock(shared.mutex);
  shared.chords += count;
  shared.wrongCounts += wrong;
  shared.worstLength = std::max(shared.worstLength, worst);
}

void integrate(const void*, uint32_t stage, Group* g, const Services* s) {
  switch (shared.task) {
    case Task::Records:
      records(g, s, stage);
      break;
    case Task::Contexts:
      if (stage == 0) contexts(g, s);
      break;
    case Task::Marks:
      return marks(g, s);
    case Task::Places:
      if (stage == 0) places(g, s);
      break;
    case Task::Chords:
    case Task::ChordsOfSet:
      if (stage == 0) chords(g, s);
      break;
  }
}
constexpr IntegratorFunctions kFunctions{&integrate};
constexpr IntegratorTraits kTraits{&cameraThenLightPaths};
constexpr Descriptor kProbe = probeOf<kFunctions>("ProbeVertex", "Digests of vertices.", kTraits, kParams, 1);

// Glass in water with absorption, a moving placed mesh with normals and primvars, bilinear quads, curves, a network,
// cut-outs, links, subsets of objects for reflections and shadows.
const char* const kRich = R"(
Hider "raytrace" "int maxsamples" [16]
Display "probe.exr" "openexr" "Ci,a"
Format 40 30 1
PixelFilter "box" 1 1
Projection "perspective" "fov" [45]
Shutter 0 1
Translate 0 -0.8 3.5
WorldBegin
  Light "PxrRectLight" "lamp" "float intensity" [6]
  AttributeBegin ConcatTransform [0.8 0 0 0  0 0 0.6 0  0 -1 0 0  -0.2 1.9 1 1] Light "PxrRectLight" "key" "float intensity" [6] AttributeEnd
  Light "PxrDomeLight" "sky" "float intensity" [0.4]
  Pattern "PxrChecker" "check" "color colorA" [.8 .7 .2] "color colorB" [.2 .3 .7]
  AttributeBegin
    Attribute "lighting" "string excludesubset" ["skip"]
    Attribute "trace" "string reflectexcludesubset" ["ball"] "string shadowexcludesubset" ["ball"]
    Bxdf "PxrDiffuse" "floor" "reference color diffuseColor" ["check:resultRGB"]
    Polygon "vertex point P" [-2 0 -1  2 0 -1  2 0 3  -2 0 3] "facevarying float[2] st" [0 0 1 0 1 1 0 1] "vertex float heat" [0 1 2 3]
  AttributeEnd
  AttributeBegin
    Attribute "grouping" "string membership" ["ball"]
    Bxdf "PxrSurface" "water" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] "float glassIor" [1.33] "color ssAlbedo" [.3 .5 .9]
    Bxdf "PxrGlass" "water" "float ior" [1.33] "color absorptionColor" [.3 .6 .9] "float absorptionDistance" [.5]
    Translate -0.3 0.6 0.8
    Sphere 0.55 -0.55 0.55 360
    Bxdf "PxrGlass" "glass" "float ior" [1.6] "float roughness" [0.2]
    Sphere 0.25 -0.25 0.25 360
  AttributeEnd
  AttributeBegin
    MotionBegin [0 1] Translate 0.9 0.3 0.6 Translate 1.1 0.5 0.6 MotionEnd
    Bxdf "PxrSurface" "shiny" "color specularEdgeColor" [.6 .6 .6] "float specularRoughness" [.4] "float presence" [.7]
    PointsPolygons [4 4] [0 1 2 3 3 2 4 5] "vertex point P" [-.4 -.3 0 .4 -.3 .2 .5 .2 -.1 -.3 .2 .3 .4 .6 .3 -.4 .7 .1]
      "vertex normal N" [-.2 0 -1 .2 0 -1 .2 .1 -1 -.2 .1 -1 .2 .3 -1 -.2 .3 -1] "vertex float heat" [1 2 3 4 5 6]
  AttributeEnd
  AttributeBegin
    Bxdf "PxrDiffuse" "hair"
    Curves "cubic" [4] "nonperiodic" "vertex point P" [-1.2 0 0  -1.1 .5 0  -1.3 .9 .1  -1 1.4 0] "constant float constantwidth" [.1]
  AttributeEnd
WorldEnd
)";

void renderProbe(const std::string& text, Task task, int threads, uint32_t width = 0) {
  shared.task = task;
  shared.kept.clear();
  shared.compared = shared.different = shared.chords = shared.wrongCounts = 0;
  shared.worstLength = 0;
  Workshop stage{&kProbe};
  render::Settings s;
  s.threads = threads;
  s.integrator = "ProbeVertex";
  if (width) s.width = width;
  const auto renderer = stage.load(sceneOf(text, stage.messages), s);
  ASSERT_EQ(renderer->renderFilm(), render::Outcome::Complete) << stage.said;
}

TEST(Vertex, RecordsShadeAgainToTheSameBits) {
  for (const uint32_t width : {1u, 8u}) {
    renderProbe(kRich, Task::Records, 2, width);
    EXPECT_GT(shared.kept.size(), 5000u);
    EXPECT_GT(shared.compared, 2000u);
    EXPECT_EQ(shared.different, 0u) << "of " << shared.compared << " at width " << width;
  }
}

TEST(Vertex, ContextsKeepWhatTheyKnowWhilePathsGoOn) {
  renderProbe(kRich, Task::Contexts, 1);
  EXPECT_GT(shared.compared, 2000u);
  EXPECT_EQ(shared.different, 0u) << "of " << shared.compared;
}

TEST(Vertex, ContextsKeepNothingInMemoryThatIsReleased) {
  for (const uint32_t width : {1u, 8u}) {
    renderProbe(kRich, Task::Marks, 1, width);
    EXPECT_GT(shared.compared, 2000u);
    EXPECT_EQ(shared.different, 0u) << "of " << shared.compared << " at width " << width;
  }
}

TEST(Vertex, ContextsOfPlacesThatNoRayFound) {
  for (const uint32_t width : {1u, 8u}) {
    renderProbe(kRich, Task::Places, 1, width);
    EXPECT_GT(shared.compared, 2000u);
    EXPECT_EQ(shared.different, 0u) << "of " << shared.compared << " at width " << width;
  }
}

// A window as wide as most of a unit sphere.
const std::string kUnderTheSky = R"(
Hider "raytrace" "int maxsamples" [4]
Display "probe.exr" "openexr" "Ci,a"
Format 32 32 1
PixelFilter "box" 1 1
ScreenWindow -.9 .9 -.9 .9
Projection "orthographic"
Translate 0 0 3
WorldBegin
  Light "PxrDomeLight" "sky"
  Bxdf "PxrDiffuse" "grey"
)";

TEST(Vertex, ChordsMeetTheirOwnObjectOnly) {
  renderProbe(kUnderTheSky + R"(  Sphere 1 -1 1 360
  AttributeBegin Translate .2 .1 0 Sphere .3 -.3 .3 360 AttributeEnd
  AttributeBegin Translate 0 0 1.5 Sphere .8 -.8 .8 360 AttributeEnd
  AttributeBegin Attribute "visibility" "int camera" [0] "int indirect" [0] "int transmission" [0] Translate -.4 0 0 Scale .2 .2 .2 Sphere 1 -1 1 360 AttributeEnd
WorldEnd
)",
              Task::Chords, 1);
  EXPECT_GT(shared.chords, 2000u);
  EXPECT_EQ(shared.wrongCounts, 0u) << "of " << shared.chords;
  EXPECT_LT(shared.worstLength, 0.02) << "the sphere is made of facets";
}

// Two members, one of them inside the other; what stands between belongs to no set, or cannot be seen.
TEST(Vertex, ChordsMeetTheMembersOfASet) {
  for (const uint32_t width : {1u, 8u}) {
    renderProbe(kUnderTheSky + R"(  AttributeBegin
    Attribute "grouping" "string membership" ["other pair"]
    Sphere 1 -1 1 360
    AttributeBegin Translate .2 .1 0 Sphere .3 -.3 .3 360 AttributeEnd
    AttributeBegin Attribute "visibility" "int indirect" [0] Translate -.3 0 0 Sphere .4 -.4 .4 360 AttributeEnd
  AttributeEnd
  AttributeBegin Translate 0 0 1.5 Sphere .8 -.8 .8 360 AttributeEnd
  AttributeBegin Attribute "grouping" "string membership" ["other"] Translate -.4 0 0 Sphere .2 -.2 .2 360 AttributeEnd
WorldEnd
)",
                Task::ChordsOfSet, 1, width);
    EXPECT_GT(shared.chords, 2000u);
    EXPECT_EQ(shared.wrongCounts, 0u) << "of " << shared.chords;
    EXPECT_LT(shared.worstLength, 0.02) << "spheres are made of facets";
  }
}

}  // namespace
}  // namespace kinora::probes
