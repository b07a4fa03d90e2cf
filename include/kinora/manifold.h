// Manifold next-event estimation, for integrators: light that reaches a surface through mirrors and lenses, found from
// the surface. From a point y and a place z on a light, walks look for the specular path between them; what it brings
// is a light sample through the boundaries. Many walks at once, over the groups' services alone. Included per target.
//
// The unknown is the direction w in which the path leaves y. A ray in it is followed through the boundaries, each of
// which turns it about N (or about a facet of its own, drawn before, where it is rough); with the ray go its
// derivatives by w (Igehy, "Tracing ray differentials", SIGGRAPH 1999), for which the derivatives of N are needed. What
// it misses z by is brought to 0 by Newton's method (Hanika, Droske and Fascione, "Manifold next event estimation",
// EGSR 2015; Jakob and Marschner 2012), with steps that are halved where they do not help. The determinant of the
// derivatives is the ratio of the densities at y and at z, the generalised geometric term.
//
// There may be several such paths. The walk that starts straight towards z finds the same one each time: it counts as
// it is. Others are looked for from a random direction; how likely one is found is counted by looking for it again
// until it is found, which estimates the reciprocal of its probability without bias (Zeltner, Georgiev and Jakob,
// "Specular manifold sampling for rendering high-frequency caustics and glints", SIGGRAPH 2020). Rough boundaries: a
// facet for each is drawn before the walk (ibid., section 4.4).
//
// The light that is found so is that of paths which leave a vertex by a lobe that is no mirror, of a material that walks
// do not go through, and then meet at least one and at most `interfaces` walkable boundaries, by their walkable lobes,
// and a light with cheapCaustics. A path tracer must leave out just these (WalkedPaths).
#include <kinora/clamp_luminance.h>
#include <kinora/integrator.h>
#include <kinora/manifold_options.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>

#include <cmath>

#if defined(KINORA_MANIFOLD_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_MANIFOLD_H_TARGET
#undef KINORA_MANIFOLD_H_TARGET
#else
#define KINORA_MANIFOLD_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// N seen so flat that contexts may have bent it: its derivatives are not those of the surface.
template <int W>
KN_INLINE Mask<W> isSeenFlat(Vec3<W> N, Vec3<W> wo) {
  return dot(N, wo) < Float<W>(2e-3f);
}

// How many boundaries a path has come through since a vertex that walks start from, as one number: 0: walks do not
// find what follows, 1: it left that vertex, 2: one boundary later ...
struct WalkedPaths {
  // The points of a context where paths of state `before` scatter into slots: their state after it.
  template <int W>
  static KN_INLINE Int<W> after(const Context& c, uint32_t i, Int<W> slot, Mask<W> discrete, Int<W> before,
                                uint32_t interfaces) {
    if (!(c.traits & kTraitWalkable)) return select(discrete, Int<W>(0), Int<W>(1));
    Mask<W> walkable(false);
    for (uint32_t l = 0; l < c.slotCount; ++l)
      if (c.walkableSlots >> l & 1) walkable = walkable | (slot == Int<W>(l));
    walkable = walkable & ((before > Int<W>(0)) & (before < Int<W>(interfaces + 1))) &
               !isSeenFlat(Vec3<W>::load(c.N, i), Vec3<W>::load(c.wo, i));
    return select(walkable, before + Int<W>(1), Int<W>(0));
  }
  // Whether light that paths of that state meet is left to walks.
  static bool isWalked(uint32_t state) { return state > 1; }
};

// Where walks begin, where they go, and the rays on which they are followed; by walk. Arrays of the group's memory.
struct WalkStarts {
  // Walks begin at points of contexts, in their order.
  struct Run {
    const Context* c;
    uint32_t first, end;
  };
  uint32_t n_ = 0, runCount_ = 0;
  Run* runs_ = nullptr;
  uint32_t *point_, *slot_, *seed_, *sample_;
  float *P_[3], *Ng_[3], *bias_, *time_, *radius_, *spread_;
  WalkTargets to_{};
  RayList* rays_ = nullptr;
  // The rays' derivatives by the two directions across the one at y; what they miss their lights by, and Newton's step.
  float *dP_[2][3], *dD_[2][3], *miss_, *spreadOfPath_, *next_[3];
  uint32_t *passed_, *kinds_;  // boundaries so far, and a bit for each that light goes through
};

template <int W>
class ManifoldWalks : private WalkStarts {
 public:
  using F = Float<W>;
  using I = Int<W>;
  using V = Vec3<W>;
  using M = Mask<W>;
  ManifoldWalks(Group* group, const Services* services, const ManifoldOptions& options)
      : g_(group), sv_(services), o_(options) {
    if (!sv_->walkBoundCount) o_.interfaces = 0;
  }
  uint32_t interfaces() const { return o_.interfaces; }

  struct Paths {
    float* const* throughput;  // by slot of the group's paths
    const uint32_t* state;     // of light path expressions
    uint32_t bounces;          // that a path may have
    uint32_t clampDepth;       // see PathLoopOptions
    float clampLuminance;
    float clampCaustic;  // in all depths
  };
  // Contributes what walks find from the contexts' points; Context::path must be slots of the group's paths.
  void connect(uint32_t count, Context* const* contexts, uint32_t depth, const Paths& paths) {
    if (!o_.interfaces || depth >= paths.bounces) return;
    most_ = o_.interfaces < paths.bounces - depth ? o_.interfaces : paths.bounces - depth;
    depth_ = depth;
    paths_ = paths;
    const MemoryMark mark = sv_->markMemory(g_);
    begin(count, contexts);
    if (n_) {
      connectAll();
    }
    sv_->releaseMemory(g_, mark);
  }

 private:
  static constexpr float kConverged = 5e-6f;  // what a path may miss its light by at last, as an angle
  static constexpr float kFound = 1e-4f;      // and so that it counts: steps may end where floats do
  static constexpr float kSame = 1e-3f;       // distance of directions at y that are one path's
  static constexpr int kPastTarget = 16;      // see Walks::through
  static_assert(ManifoldOptions::kMostInterfaces <= kPastTarget);
  enum Event : uint32_t { kEventTypes = 0, kEventFacets = 1, kEventSeed = 40, kEventsOfTrial = 8 };

  float* floats(uint32_t n) const { return static_cast<float*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(float))); }
  uint32_t* words(uint32_t n) const {
    return static_cast<uint32_t*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(uint32_t)));
  }
  void floats(uint32_t n, float* out[3]) const {
    for (int c = 0; c < 3; ++c) out[c] = floats(n);
  }
  static void padList(uint32_t m, uint32_t* list) {
    for (uint32_t i = m; i < padded(m); ++i) list[i] = m ? list[m - 1] : 0;
  }
  static KN_INLINE M firstOf(uint32_t n, uint32_t i) {
    return M::firstN(int(n - i < uint32_t(W) ? n - i : uint32_t(W)));
  }

  // What paths bring, by walk.
  struct Found {
    float* value[3];  // light that arrives at y times the ratio of densities, over the density of z; 0: nothing
    float* transmittance[3];                            // of media along a segment
    uint32_t* event[ManifoldOptions::kMostInterfaces];  // of light path expressions, by boundary
  };

  // What a walk looks for, and what it has; by walk.
  struct Walks {
    float* d[3];     // direction at y that is being tried
    float* best[3];  // the one that missed least
    float* bestMiss;
    float* step[3];     // Newton's step from there, along directions across it
    float* damp;        // part of it that is tried
    uint32_t* through;  // a bit for each boundary: light goes through, else it is reflected. From bit kPastTarget on
                        // one for each: the ray that leaves it may pass the light and go on to a further boundary
    uint32_t* found;    // boundaries of the path; 0: none
    uint32_t* foundBits;  // their part of `through`
  };

  void begin(uint32_t count, Context* const* contexts) {
    runs_ = static_cast<Run*>(sv_->alloc(g_, (count + 1) * sizeof(Run)));
    runCount_ = n_ = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      // kTraitScattersOnce: nothing is followed from there
      if ((c.traits & (kTraitWalkable | kTraitScattersOnce)) || !c.bxdf || !c.bxdf->evaluate) continue;
      runs_[runCount_++] = {&c, n_, n_ + c.count};
      n_ += c.count;
    }
    if (!n_) return;
    makeStarts();
    for (uint32_t r = 0; r < runCount_; ++r) {
      const Context& c = *runs_[r].c;
      for (uint32_t p = 0; p < c.count; ++p) {
        const uint32_t i = runs_[r].first + p;
        point_[i] = p;
        slot_[i] = c.path[p];
        seed_[i] = c.sampleSeed[p];
        sample_[i] = c.sampleIndex[p];
        for (int x = 0; x < 3; ++x) {
          P_[x][i] = c.P[x][p];
          Ng_[x][i] = c.Ng[x][p];
        }
        bias_[i] = c.bias[p];
        time_[i] = c.time[p];
        radius_[i] = c.radius[p];
        spread_[i] = c.spread[p];
      }
    }
    padArrays();
    // places on lights
    const uint32_t dim = dimensionAt(depth_) + kDimUser;
    float* u[6];
    for (float*& x : u) x = floats(n_);
    for (uint32_t i = 0; i < n_; i += W)
      for (uint32_t k = 0; k < 3; ++k) {
        F a, b;
        draw2(sv_->samples, I::load(seed_ + i), I::load(sample_ + i), dim + k, a, b);
        a.store(u[2 * k] + i);
        b.store(u[2 * k + 1] + i);
      }
    const float* five[5] = {u[0], u[2], u[3], u[4], u[5]};
    sv_->walkTargets(g_, n_, five, time_, &to_);
    makeTracks();
  }
  void makeStarts() {
    point_ = words(n_);
    slot_ = words(n_);
    seed_ = words(n_);
    sample_ = words(n_);
    floats(n_, P_);
    floats(n_, Ng_);
    bias_ = floats(n_);
    time_ = floats(n_);
    radius_ = floats(n_);
    spread_ = floats(n_);
  }
  void makeTracks() {
    rays_ = sv_->makeRays(g_, n_);
    for (int s = 0; s < 2; ++s) {
      floats(rays_->capacity, dP_[s]);
      floats(rays_->capacity, dD_[s]);
    }
    miss_ = floats(n_);
    spreadOfPath_ = floats(n_);
    passed_ = words(n_);
    kinds_ = words(n_);
    floats(n_, next_);
  }
  // The listed walks of `from`, each `times` times, one behind the other.
  void repeat(const WalkStarts& from, uint32_t n, const uint32_t* list, uint32_t times) {
    n_ = n * times;
    runCount_ = 0;
    runs_ = static_cast<Run*>(sv_->alloc(g_, (from.runCount_ + 1) * sizeof(Run)));
    makeStarts();
    to_ = {};
    to_.light = words(n_);
    to_.flags = words(n_);
    floats(n_, to_.to);
    floats(n_, to_.N);
    to_.pdf = floats(n_);
    uint32_t run = 0, last = ~0u;
    for (uint32_t i = 0; i < n_; ++i) {
      const uint32_t s = list[i / times];
      while (s >= from.runs_[run].end) ++run;
      if (run != last) {
        runs_[runCount_++] = {from.runs_[run].c, i, i};
        last = run;
      }
      runs_[runCount_ - 1].end = i + 1;
      point_[i] = from.point_[s];
      slot_[i] = from.slot_[s];
      seed_[i] = from.seed_[s];
      sample_[i] = from.sample_[s];
      for (int c = 0; c < 3; ++c) {
        P_[c][i] = from.P_[c][s];
        Ng_[c][i] = from.Ng_[c][s];
        to_.to[c][i] = from.to_.to[c][s];
        to_.N[c][i] = from.to_.N[c][s];
      }
      bias_[i] = from.bias_[s];
      time_[i] = from.time_[s];
      radius_[i] = from.radius_[s];
      spread_[i] = from.spread_[s];
      to_.light[i] = from.to_.light[s];
      to_.flags[i] = from.to_.flags[s];
      to_.pdf[i] = from.to_.pdf[s];
    }
    padArrays();
    makeTracks();
  }
  void padArrays() {
    const auto pad = [&](auto* x) {
      for (uint32_t i = n_; i < padded(n_); ++i) x[i] = x[n_ - 1];
    };
    pad(point_);
    pad(slot_);
    pad(seed_);
    pad(sample_);
    for (int x = 0; x < 3; ++x) {
      pad(P_[x]);
      pad(Ng_[x]);
    }
    pad(bias_);
    pad(time_);
    pad(radius_);
    pad(spread_);
  }
  Walks makeWalks() const {
    Walks w;
    floats(n_, w.d);
    floats(n_, w.best);
    w.bestMiss = floats(n_);
    floats(n_, w.step);
    w.damp = floats(n_);
    w.through = words(n_);
    w.found = words(n_);
    w.foundBits = words(n_);
    return w;
  }

  void connectAll() {
    uint32_t* list = words(n_);
    // straight towards the light, through all that is in the way
    Walks straight = makeWalks();
    uint32_t m = 0;
    for (uint32_t i = 0; i < n_; ++i) {
      straight.found[i] = 0;
      if (to_.pdf[i] > 0) list[m++] = i;
    }
    padList(m, list);
    towardsTarget(m, list, straight);
    walk(m, list, straight);
    Found found = makeFound();
    uint32_t* some = words(n_);
    uint32_t k = 0;
    clear(m, list, found);
    for (uint32_t i = 0; i < m; ++i)
      if (straight.found[list[i]]) some[k++] = list[i];
    padList(k, some);
    follow(k, some, straight, found);
    contribute(k, some, straight, found, nullptr);
    note(m, list, straight, found, nullptr);
    if (!o_.findsAll) return;
    // from anywhere
    Walks other = makeWalks();
    uint32_t* first = words(n_);
    for (uint32_t i = 0; i < n_; ++i) first[i] = 0;
    aimAnywhere(m, list, other, first);
    walk(m, list, other);
    k = 0;
    clear(m, list, found);
    for (uint32_t i = 0; i < m; ++i)
      if (other.found[list[i]] && !isSame(straight, list[i], other, list[i])) some[k++] = list[i];
    padList(k, some);
    follow(k, some, other, found);
    uint32_t open = 0;
    uint32_t* again = words(n_);
    uint32_t* trials = words(n_);
    for (uint32_t i = 0; i < m; ++i) trials[list[i]] = 0;
    for (uint32_t i = 0; i < k; ++i) {
      const uint32_t s = some[i];
      if (found.value[0][s] != 0 || found.value[1][s] != 0 || found.value[2][s] != 0) again[open++] = s;
    }
    findAgain(open, again, other, trials);
    contribute(k, some, other, found, trials);
    note(m, list, other, found, trials);
  }

  // Which trial of each listed walk is the first to find its path again. Of few walks several trials run at once, to
  // fill the lanes: which is the first does not depend on it.
  void findAgain(uint32_t open, uint32_t* again, const Walks& w, uint32_t* trials) {
    constexpr uint32_t kEnough = 64, kMostAtOnce = 8;
    const WalkStarts whole = *this;
    for (uint32_t t = 1; open && t <= o_.mostTrials;) {
      const MemoryMark mark = sv_->markMemory(g_);
      uint32_t times = kEnough / open;
      times = times < 1 ? 1 : times > kMostAtOnce ? kMostAtOnce : times;
      if (times > o_.mostTrials + 1 - t) times = o_.mostTrials + 1 - t;
      repeat(whole, open, again, times);
      const Walks trial = makeWalks();
      uint32_t *list = words(n_), *number = words(n_);
      for (uint32_t i = 0; i < n_; ++i) {
        list[i] = i;
        number[i] = t + i % times;
      }
      padList(n_, list);
      aimAnywhere(n_, list, trial, number);
      walk(n_, list, trial);
      uint32_t rest = 0;
      for (uint32_t i = 0; i < open; ++i) {
        const uint32_t s = again[i];
        bool isFound = false;
        for (uint32_t j = 0; j < times && !isFound; ++j) {
          trials[s] = t + j;
          isFound = isSame(w, s, trial, i * times + j);
        }
        if (!isFound) again[rest++] = s;
      }
      open = rest;
      t += times;
      static_cast<WalkStarts&>(*this) = whole;
      sv_->releaseMemory(g_, mark);
    }
  }
  static void clear(uint32_t n, const uint32_t* list, const Found& found) {
    for (uint32_t i = 0; i < n; ++i)
      for (float* x : found.value) x[list[i]] = 0;
  }
  static bool isSame(const Walks& a, uint32_t i, const Walks& b, uint32_t j) {
    if (!a.found[i] || a.found[i] != b.found[j] || a.foundBits[i] != b.foundBits[j]) return false;
    float d2 = 0;
    for (int c = 0; c < 3; ++c) d2 += (a.best[c][i] - b.best[c][j]) * (a.best[c][i] - b.best[c][j]);
    return d2 < kSame * kSame;
  }

  KN_INLINE F draw(const Slots<W>& s, I event) const {
    return drawHashed(s.get(seed_), s.get(sample_), dimensionAt(depth_) + kDimUser + 3, event);
  }

  // Unit direction to the light from y.
  KN_INLINE V toTarget(const Slots<W>& s) const {
    const V to = V::get(to_.to, s);
    const M infinite = (s.get(to_.flags) & I(uint32_t(kLightIsInfinite))) != I(0);
    const V d = select(infinite, to, to - V::get(P_, s));
    return d * (F(1.f) / sqrt(max(dot(d, d), F(1e-30f))));
  }
  void towardsTarget(uint32_t n, const uint32_t* list, const Walks& w) const {
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const V d = toTarget(s);
      s.put(in, d.x, w.d[0]);
      s.put(in, d.y, w.d[1]);
      s.put(in, d.z, w.d[2]);
      s.put(in, I((1u << kPastTarget) - 1), w.through);
    }
  }
  // Random directions and boundaries' kinds, of trial t: towards what walks go through, and where that lies towards
  // the light half of them around the light.
  void aimAnywhere(uint32_t n, const uint32_t* list, const Walks& w, const uint32_t* trial) const {
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const I event = I(uint32_t(kEventSeed)) + s.get(trial) * I(uint32_t(kEventsOfTrial));
      const F u = draw(s, event), v = draw(s, event + I(1)), which = draw(s, event + I(2)),
              wide = draw(s, event + I(3));
      const V P = V::get(P_, s);
      // around the light, mostly near
      const V z = toTarget(s);
      const F angle = wide * wide;
      V d = Frame<W>(z).toWorld(uniformCone(u, v, F(0.5f) * angle * angle + F(1e-6f)));
      // towards objects, by how large they are seen
      F total(0.f);
      for (uint32_t b = 0; b < sv_->walkBoundCount; ++b) total += coneOf(P, b);
      const F some = select(isTowardsBounds(P, z), F(0.5f), F(0.f));
      F rest = max(which - some, F(0.f)) / (F(1.f) - some) * total;
      M open(true);
      V towards = z;
      for (uint32_t b = 0; b < sv_->walkBoundCount; ++b) {
        const F cone = coneOf(P, b);
        const M here = open & (rest <= cone);
        if (here.any()) {
          const WalkBound& x = sv_->walkBounds[b];
          const V axis = V(F(x.center[0]), F(x.center[1]), F(x.center[2])) - P;
          const F l2 = dot(axis, axis);
          const V unit =
              select(l2 > F(1e-20f), axis * (F(1.f) / sqrt(max(l2, F(1e-20f)))), V(F(0.f), F(0.f), F(1.f)));
          towards = select(here, Frame<W>(unit).toWorld(uniformCone(u, v, cone)), towards);
        }
        open = open & !here;
        rest -= cone;
      }
      d = normalize(select(which < some, d, towards));
      s.put(in, d.x, w.d[0]);
      s.put(in, d.y, w.d[1]);
      s.put(in, d.z, w.d[2]);
      // a quarter of the boundaries reflect, a quarter of the rays go on past the light
      const I bits = hashWords(hashWords(asInt(draw(s, event + I(4))), s.get(seed_)), event);
      const I more = hashWords(bits, event), low((1u << kPastTarget) - 1), high(~0u << kPastTarget);
      s.put(in, ((bits | bits.template shr<kPastTarget>()) & low) | (more & more.template shl<kPastTarget>() & high),
            w.through);
    }
  }
  KN_INLINE M isTowardsBounds(V P, V d) const {
    M any(false);
    for (uint32_t b = 0; b < sv_->walkBoundCount; ++b) {
      const WalkBound& x = sv_->walkBounds[b];
      const V to = V(F(x.center[0]), F(x.center[1]), F(x.center[2])) - P;
      const F along = max(dot(to, d), F(0.f)), far2 = dot(to, to) - along * along;
      any = any | (far2 < F(x.radius * x.radius));
    }
    return any;
  }
  // 1 - cosine of the cone that a sphere is seen in; 2 within it.
  KN_INLINE F coneOf(V P, uint32_t b) const {
    const WalkBound& x = sv_->walkBounds[b];
    const V to = V(F(x.center[0]), F(x.center[1]), F(x.center[2])) - P;
    const F l2 = dot(to, to), sine2 = F(x.radius * x.radius) / max(l2, F(1e-30f));
    const F c = safeSqrt(F(1.f) - sine2);
    // 1 - cosine without cancellation
    return select(sine2 < F(1.f), sine2 / (F(1.f) + c), F(2.f));
  }

  // ---- one ray through the boundaries ----

  // Sets the listed walks' rays off from y along w.d.
  void leaveStart(uint32_t n, const uint32_t* list, const Walks& w) {
    const Rays& r = rays_->rays;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const V d = V::get(w.d, s), o = leave(V::get(P_, s), V::get(Ng_, s), s.get(bias_), d);
      put(s, in, o, r.o);
      put(s, in, d, r.d);
      s.put(in, F(1e30f), r.tMax);
      s.put(in, s.get(time_), r.time);
      s.put(in, s.get(radius_), r.radius);
      s.put(in, s.get(spread_), r.spread);
      s.put(in, I(0), rays_->origin);
      const Frame<W> f(d);
      const V zero;
      put(s, in, zero, dP_[0]);
      put(s, in, zero, dP_[1]);
      put(s, in, f.x, dD_[0]);
      put(s, in, f.y, dD_[1]);
      s.put(in, F(INFINITY), miss_);
      s.put(in, I(0), passed_);
      s.put(in, I(0), kinds_);
    }
    uint32_t* points = words(n);
    for (uint32_t i = 0, r0 = 0; i < n;) {
      while (list[i] >= runs_[r0].end) ++r0;
      uint32_t m = 0;
      const uint32_t from = i;
      for (; i < n && list[i] < runs_[r0].end; ++i) points[m++] = point_[list[i]];
      sv_->leave(g_, rays_, runs_[r0].c, m, points, list + from, nullptr);
    }
  }
  static KN_INLINE void put(const Slots<W>& s, M m, V x, float* const to[3]) {
    s.put(m, x.x, to[0]);
    s.put(m, x.y, to[1]);
    s.put(m, x.z, to[2]);
  }

  // Of rays that were traced: those that pass their target before they meet anything have come as near as they will,
  // but for those that are to go on to boundary k; `isFound`: only those of the path that was found end, at
  // its last boundary. What they miss it by, and Newton's step. The others that met something stay in `open`; returns
  // their number.
  uint32_t endAtTargets(uint32_t n, uint32_t* open, uint32_t k, const Walks& w, bool isFound) {
    const bool isLast = k == most_;
    uint32_t m = 0;
    const Rays& r = rays_->rays;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(open + i);
      const F t = s.get(rays_->hits.t);
      const M met = in & (t < F(3e38f));
      M ends(false);
      if (const M through = in & (s.get(passed_) != I(0)); through.any()) {
        const M infinite = (s.get(to_.flags) & I(uint32_t(kLightIsInfinite))) != I(0);
        const V o = V::get(r.o, s), d = V::get(r.d, s), to = V::get(to_.to, s);
        const V away = to - o;
        const F along = select(infinite, dot(to, d), dot(away, d));
        ends = through & (along > F(0.f)) & ((infinite & !met) | ((!infinite) & (along < t * F(1.0001f))));
        if (isFound) {
          ends = ends & (s.get(w.found) == I(k));
        } else if (k && !isLast) {
          ends = ends & !(met & ((s.get(w.through) & I(1u << (kPastTarget + k - 1))) != I(0)));
        }
        // across the ray: what is missed, as an angle, and how that changes with w
        const F scale = F(1.f) / max(along, F(1e-30f));
        const V e = select(infinite, to - d * along, away - d * along) * scale;
        const Frame<W> f(d);
        const V da = V::get(dD_[0], s), db = V::get(dD_[1], s);
        const V ca = select(infinite, da, da + V::get(dP_[0], s) * scale),
                cb = select(infinite, db, db + V::get(dP_[1], s) * scale);
        const F a = dot(f.x, ca), b = dot(f.x, cb), c = dot(f.y, ca), g = dot(f.y, cb);
        const F det = a * g - b * c, ex = dot(f.x, e), ey = dot(f.y, e);
        const M good = abs(det) > F(1e-12f);
        const F inverse = F(1.f) / select(good, det, F(1.f));
        ends = ends & good;
        F sa = (g * ex - b * ey) * inverse, sb = (a * ey - c * ex) * inverse;
        // a step beyond half a radian means nothing
        const F size = sqrt(sa * sa + sb * sb), shorter = min(F(0.5f) / max(size, F(1e-30f)), F(1.f));
        sa = sa * shorter;
        sb = sb * shorter;
        const Frame<W> at(V::get(w.d, s));
        s.put(ends, sqrt(dot(e, e)), miss_);
        put(s, ends, at.x * sa + at.y * sb, next_);
        // solid angle at the last boundary, seen from y: how much wider the pencil has become
        s.put(ends, o_.withoutTerm ? F(1.f) : abs(det), spreadOfPath_);
      }
      const Packer<W> pack(isLast ? M(false) : met & !ends);
      pack.put(s.s, open + m);
      m += uint32_t(pack.count);
    }
    padList(m, open);
    return m;
  }

  // Facet of boundary k about the normal (0, 0, 1), and its density by solid angle: GGX facets, whatever the
  // material's are.
  KN_INLINE V facet(const Slots<W>& s, uint32_t k, F alpha, F& density) const {
    const F u = draw(s, I(kEventFacets + 2 * k)), v = draw(s, I(kEventFacets + 2 * k + 1));
    const F a2 = alpha * alpha, tan2 = a2 * u / max(F(1.f) - u, F(1e-7f));
    const F c2 = F(1.f) / (F(1.f) + tan2), c = sqrt(c2), sine = safeSqrt(F(1.f) - c2);
    F sn, cs;
    sincos(v * F(kTwoPi), sn, cs);
    const F q = a2 + tan2;
    density = a2 / max(F(kPi) * c2 * c * q * q, F(1e-30f));
    return {sine * cs, sine * sn, c};
  }
  // How the frame about n changes with it: d is the change of n. (Frame's own formula, differentiated.)
  static KN_INLINE V turnFrame(V n, V dn, V local) {
    const F sign = copySign(F(1.f), n.z), a = F(-1.f) / (sign + n.z), da = a * a * dn.z;
    const F db = fma(dn.x * n.y + n.x * dn.y, a, n.x * n.y * da);
    const V x(sign * (F(2.f) * n.x * dn.x * a + n.x * n.x * da), sign * db, -sign * dn.x);
    const V y(db, F(2.f) * n.y * dn.y * a + n.y * n.y * da, -dn.y);
    return x * local.x + y * local.y + dn * local.z;
  }

  // The listed rays' hits: turns them, with their derivatives, at boundary k. Those that go on stay in `open`.
  // `value` (null: not wanted) is multiplied by what the boundary passes on.
  uint32_t turn(uint32_t n, uint32_t* open, uint32_t k, const Walks& w, const Found* found) {
    Context* const* contexts;
    const uint32_t count = sv_->shade(g_, rays_, kTraitEyePath | kTraitWalk, depth_ + 1 + k, n, open, &contexts);
    uint32_t m = 0;
    for (uint32_t c = 0; c < count; ++c)
      if (contexts[c]->traits & kTraitWalkable) m = turnAt(*contexts[c], open, m, k, w, found);
    padList(m, open);
    return m;
  }
  uint32_t turnAt(const Context& c, uint32_t* open, uint32_t m, uint32_t k, const Walks& w, const Found* found) {
    uint32_t *through = words(c.padded), *lobe = words(c.padded);
    float *eta = floats(c.padded), *alpha = floats(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) through[i] = w.through[c.path[i]] >> k & 1;
    const InterfaceArgs args{through, eta, alpha, lobe};
    c.bxdf->interface(&c, c.closure, &args);
    // where there is no such lobe the other one is taken
    bool lacks = false;
    for (uint32_t i = 0; i < c.padded; ++i) {
      const bool is = i < c.count ? lobe[i] == kNoLobe : false;
      if (is) through[i] ^= 1u;
      lacks = lacks || is;
    }
    if (lacks) c.bxdf->interface(&c, c.closure, &args);
    const Value e1 = c.builtin(Builtin::FacetEdge1), e2 = c.builtin(Builtin::FacetEdge2),
                n1 = c.builtin(Builtin::DNEdge1), n2 = c.builtin(Builtin::DNEdge2);
    uint32_t *points = words(c.padded), *passes = words(c.padded), leaving = 0;
    float *wi[3], *jacobian = nullptr;
    if (found) {
      floats(c.padded, wi);
      jacobian = floats(c.padded);
    }
    const uint32_t first = m;
    const Rays& r = rays_->rays;
    for (uint32_t i = 0; i < c.count; i += W) {
      M on = firstOf(c.count, i);
      const Slots<W> s = Slots<W>::load(c.path + i);
      const V N = V::load(c.N, i), Ng = V::load(c.Ng, i), wo = V::load(c.wo, i), d = -wo;
      const M passing = I::load(through + i) != I(0);
      on = on & (I::load(lobe + i) != I(kNoLobe)) & !isSeenFlat(N, wo);
      // the point's derivatives on the facet, and with them those of N
      const V x1 = V::load(e1.data, i), x2 = V::load(e2.data, i), G = cross(x1, x2);
      const F size2 = dot(G, G), slant = dot(G, d), t = F::load(c.distance + i);
      on = on & (size2 > F(0.f)) & (slant * slant > F(1e-12f) * size2);
      const F perSlant = F(1.f) / select(on, slant, F(1.f)), perSize = F(1.f) / select(on, size2, F(1.f));
      const F rough = F::load(alpha + i);
      F density(1.f);
      V h = N;
      const M isRough = rough > F(0.f);
      V local(F(0.f), F(0.f), F(1.f));
      if ((on & isRough).any()) {
        local = facet(s, k, max(rough, F(1e-4f)), density);
        h = select(isRough, normalize(Frame<W>(N).toWorld(local)), N);
      }
      const F cosO = dot(wo, h), ratio = F::load(eta + i);
      on = on & (cosO > F(1e-6f));
      const F rest = fnma(ratio * ratio, fnma(cosO, cosO, F(1.f)), F(1.f)), cosT = sqrt(max(rest, F(1e-12f)));
      on = on & ((!passing) | (rest > F(1e-12f)));
      const F mu = fms(ratio, cosO, cosT);
      V to = select(passing, d * ratio + h * mu, fma(h, cosO + cosO, d));
      to = to * (F(1.f) / sqrt(max(dot(to, to), F(1e-20f))));
      const F side = dot(Ng, to);
      on = on & ((passing & (side < F(0.f))) | ((!passing) & (side > F(0.f))));
      if (on.none()) continue;
      for (int a = 0; a < 2; ++a) {
        const V dd = V::get(dD_[a], s), along = fma(dd, t, V::get(dP_[a], s));
        const V dx = fma(d, -dot(G, along) * perSlant, along);
        const V dN = V::load(n1.data, i) * (dot(G, cross(dx, x2)) * perSize) +
                     V::load(n2.data, i) * (dot(G, cross(x1, dx)) * perSize);
        V dh = dN;
        if (isRough.any()) dh = select(isRough, turnFrame(N, dN, local), dN);
        const F dc = -(dot(dd, h) + dot(d, dh));
        const V refracted = dd * ratio + h * ((ratio - ratio * ratio * cosO / cosT) * dc) + dh * mu;
        const V reflected = dd + (h * dc + dh * cosO) * F(2.f);
        put(s, on, dx, dP_[a]);
        put(s, on, select(passing, refracted, reflected), dD_[a]);
      }
      const V from = leave(V::load(c.P, i), Ng, F::load(c.bias + i), to);
      put(s, on, from, r.o);
      put(s, on, to, r.d);
      s.put(on, F(1e30f), r.tMax);
      s.put(on, F::load(c.radius + i), r.radius);
      s.put(on, F::load(c.spread + i), r.spread);
      s.put(on,
            select(isRough, I(0), I(uint32_t(kFromDiscrete))) | I(uint32_t(kFromSpecular)) |
                select(passing, I(uint32_t(kFromTransmission)), I(0)),
            rays_->origin);
      s.put(on, I(k + 1), passed_);
      const I bit = select(passing, I(1u << k), I(0));
      s.put(on, k == 0 ? bit : s.get(kinds_) | bit, kinds_);
      if (found) {
        to.store(wi, i);
        // solid angle of directions by that of facets (Walter et al. 2007, equations 14 and 17)
        const F m2 = F(1.f) / ratio, cosI = dot(to, h), sum = fma(m2, cosI, cosO);
        const F turns = select(passing, sum * sum / max(m2 * m2 * abs(cosI), F(1e-20f)), F(4.f) * cosO);
        select(isRough, turns / density, F(1.f)).store(jacobian + i);
      }
      const Packer<W> pack(on);
      pack.put(s.s, open + m);
      pack.put(I::lanes(int32_t(i)), points + leaving);
      pack.put(select(passing, I(1), I(0)), passes + leaving);
      m += uint32_t(pack.count);
      leaving += uint32_t(pack.count);
    }
    if (!leaving) return m;
    sv_->leave(g_, rays_, &c, leaving, points, open + first, passes);
    if (found) bring(c, leaving, points, through, lobe, wi, jacobian, k, *found);
    return m;
  }
  // What the boundary passes on, into the listed points' paths.
  void bring(const Context& c, uint32_t n, const uint32_t* points, const uint32_t* through, const uint32_t* lobe,
             float* const wi[3], const float* jacobian, uint32_t k, const Found& found) {
    float* value[3];
    floats(c.padded, value);
    uint32_t* isOn = words(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i) isOn[i] = 0;
    for (uint32_t i = 0; i < n; ++i) isOn[points[i]] = 1;
    for (uint32_t i = 0; i < c.padded; ++i)
      if (!isOn[i])
        for (int x = 0; x < 3; ++x) wi[x][i] = c.N[x][i];
    const InterfaceValueArgs args{through, {wi[0], wi[1], wi[2]}, {value[0], value[1], value[2]}};
    c.bxdf->interfaceValue(&c, c.closure, &args);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t p = points[i], s = c.path[p];
      for (int x = 0; x < 3; ++x) found.value[x][s] *= value[x][p] * jacobian[p];
      found.event[k][s] = c.eventOfSlot[c.slotOfLobe[lobe[p]]];
    }
  }

  // ---- Newton's method ----

  // From w.d on, the listed walks: w.found.
  void walk(uint32_t n, const uint32_t* list, const Walks& w) {
    if (!n) return;
    uint32_t *live = words(n), *open = words(n), m = n;
    for (uint32_t i = 0; i < n; ++i) {
      live[i] = list[i];
      w.found[list[i]] = 0;
      w.bestMiss[list[i]] = INFINITY;
      w.damp[list[i]] = 1;
    }
    padList(m, live);
    for (uint32_t iteration = 0; m && iteration < o_.iterations; ++iteration) {
      const MemoryMark mark = sv_->markMemory(g_);
      for (uint32_t i = 0; i < padded(m); ++i) open[i] = live[i];
      leaveStart(m, live, w);
      for (uint32_t k = 0, left = m; left; ++k) {
        sv_->traceWalks(g_, rays_, depth_ + 1 + k, left, open);
        left = endAtTargets(left, open, k, w, false);
        if (left) left = turn(left, open, k, w, nullptr);
      }
      m = improve(m, live, w, iteration + 1 == o_.iterations);
      sv_->releaseMemory(g_, mark);
    }
  }
  // Takes what came nearer, tries half the way where nothing did. Walks that are done leave the list.
  uint32_t improve(uint32_t n, uint32_t* live, const Walks& w, bool isLast) {
    uint32_t m = 0;
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(live + i);
      const F miss = s.get(miss_), before = s.get(w.bestMiss);
      const M better = in & (miss < before);
      s.put(better, miss, w.bestMiss);
      put(s, better, V::get(w.d, s), w.best);
      put(s, better, V::get(next_, s), w.step);
      s.put(better, s.get(passed_), w.found);
      s.put(better, s.get(kinds_), w.foundBits);
      F damp = s.get(w.damp);
      damp = select(better, min(damp + damp, F(1.f)), damp * F(0.5f));
      s.put(in, damp, w.damp);
      const F best = min(miss, before);
      // a walk that has not begun has nowhere to go back to; one whose steps help no more is as near as floats are
      const M goes = in & (best < F(3e38f)) & (best > F(kConverged)) & (damp > F(0.01f)) & M(!isLast);
      const M done = in & !goes;
      s.put(done & !(best < F(kFound)), I(0), w.found);
      const V from = V::get(w.best, s), d = normalize(from + V::get(w.step, s) * damp);
      put(s, goes, d, w.d);
      const Packer<W> pack(goes);
      pack.put(s.s, live + m);
      m += uint32_t(pack.count);
    }
    padList(m, live);
    return m;
  }

  // ---- what a path brings ----

  Found makeFound() const {
    Found f;
    floats(n_, f.value);
    for (uint32_t k = 0; k < o_.interfaces; ++k) f.event[k] = words(n_);
    for (float*& x : f.transmittance) x = floats(rays_->capacity);
    return f;
  }
  // The listed walks' paths once more, as paths of the world with all that is in it.
  void follow(uint32_t n, const uint32_t* list, const Walks& w, const Found& found) {
    if (!n) return;
    const MemoryMark mark = sv_->markMemory(g_);
    uint32_t *open = words(n), *ended = words(n);
    for (uint32_t i = 0; i < padded(n); ++i) open[i] = list[i];
    for (uint32_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) {
        w.d[c][list[i]] = w.best[c][list[i]];
        found.value[c][list[i]] = 1;
      }
    float* const* media = sv_->hasMedia ? found.transmittance : nullptr;
    leaveStart(n, list, w);
    uint32_t* lit = words(n);
    uint32_t done = 0;
    for (uint32_t k = 0, left = n; left; ++k) {
      sv_->trace(g_, rays_, RayKind::Indirect, depth_ + 1 + k, left, open, media);
      const uint32_t before = left;
      uint32_t* was = words(before);
      for (uint32_t i = 0; i < before; ++i) was[i] = open[i];
      left = endAtTargets(left, open, k, w, true);
      uint32_t m = 0;
      for (uint32_t i = 0; i < before; ++i)
        if (miss_[was[i]] < INFINITY) ended[m++] = was[i];
      padList(m, ended);
      for (uint32_t i = 0; media && i < left; ++i)
        for (int c = 0; c < 3; ++c) found.value[c][open[i]] *= media[c][open[i]];
      if (m) arrive(m, ended, media, found);
      for (uint32_t i = 0; i < m; ++i) lit[done++] = ended[i];
      if (left) left = turn(left, open, k, w, &found);
    }
    // what did not come to its light brings nothing
    for (uint32_t i = 0; i < n; ++i) passed_[list[i]] = 0;
    for (uint32_t i = 0; i < done; ++i) passed_[lit[i]] = 1;
    for (uint32_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c)
        if (!passed_[list[i]]) found.value[c][list[i]] = 0;
    sv_->releaseMemory(g_, mark);
  }
  // Light at the ends of the listed walks' paths.
  void arrive(uint32_t n, const uint32_t* list, float* const* media, const Found& found) {
    const Rays& r = rays_->rays;
    float *light[3], *along = floats(rays_->capacity), *factor = floats(rays_->capacity);
    floats(rays_->capacity, light);
    uint32_t *delta = words(n), *other = words(n), deltas = 0, others = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = list[i];
      for (float* x : light) x[s] = 0;
      factor[s] = 0;
      along[s] = 1;
      if (to_.flags[s] & kLightIsDelta)
        delta[deltas++] = s;
      else
        other[others++] = s;
      if (to_.flags[s] & kLightIsInfinite) continue;
      along[s] = 0;
      for (int c = 0; c < 3; ++c) along[s] += (to_.to[c][s] - r.o[c][s]) * r.d[c][s];
    }
    padList(deltas, delta);
    padList(others, other);
    if (deltas) {
      sv_->deltaLights(g_, rays_, deltas, delta, to_.light, light, factor);
      for (uint32_t i = 0; media && i < deltas; ++i) {
        // what the medium lets through on the whole way to the next surface, of which this is a part
        const uint32_t s = delta[i];
        const float t = rays_->hits.t[s], part = t < 3e38f ? along[s] / t : 1.f;
        for (int c = 0; c < 3; ++c)
          light[c][s] *= pow(F(media[c][s] > 1e-30f ? media[c][s] : 1e-30f), F(part)).lane0();
      }
    }
    if (others) {
      LightHits h;
      sv_->lightHits(g_, rays_, RayKind::Indirect, others, other, &h);
      for (uint32_t i = 0; i < h.count; ++i) {
        const uint32_t s = h.slot[i];
        if (h.light[i] != to_.light[s]) continue;
        // not another part of the same light
        if (!(to_.flags[s] & kLightIsInfinite) && !(std::abs(h.t[i] - along[s]) < 5e-3f * along[s])) continue;
        const float* const* radiance = h.specularRadiance[0] ? h.specularRadiance : h.radiance;
        for (int c = 0; c < 3; ++c) light[c][s] += radiance[c][i];
        factor[s] = h.specular[i];
      }
    }
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const I flags = s.get(to_.flags);
      const M isArea = (flags & I(uint32_t(kLightIsInfinite | kLightIsDelta))) == I(0);
      const F far = s.get(along), cosine = max(-dot(V::get(to_.N, s), V::get(r.d, s)), F(0.f));
      const F scale = s.get(factor) * select(isArea, cosine / max(far * far, F(1e-30f)), F(1.f)) /
                      max(s.get(spreadOfPath_) * s.get(to_.pdf), F(1e-30f));
      const V v = V::get(found.value, s) * V::get(light, s) * scale;
      put(s, in, v, found.value);
    }
  }

  // Paths that were found times `trials` (null: 1), by the slots of the points where walks begin.
  void contribute(uint32_t n, const uint32_t* list, const Walks& w, const Found& found, const uint32_t* trials) {
    if (!n) return;
    uint32_t mostSlots = 1;
    for (uint32_t r = 0; r < runCount_; ++r)
      mostSlots = runs_[r].c->slotCount > mostSlots ? runs_[r].c->slotCount : mostSlots;
    const uint32_t room = n * mostSlots;
    float* value[3];
    floats(room, value);
    uint32_t *slot = words(room), *light = words(room), *state = words(room), m = 0;
    for (uint32_t i = 0, r = 0; i < n;) {
      while (list[i] >= runs_[r].end) ++r;
      const uint32_t from = i;
      while (i < n && list[i] < runs_[r].end) ++i;
      const Context& c = *runs_[r].c;
      EvaluateArgs e{};
      float* wi[3];
      floats(c.padded, wi);
      for (int x = 0; x < 3; ++x) {
        for (uint32_t p = 0; p < c.padded; ++p) wi[x][p] = c.N[x][p];
        for (uint32_t j = from; j < i; ++j) wi[x][point_[list[j]]] = w.best[x][list[j]];
        e.wi[x] = wi[x];
        for (uint32_t l = 0; l < c.slotCount; ++l) e.weight[l][x] = floats(c.padded);
      }
      e.pdf = floats(c.padded);
      c.bxdf->evaluate(&c, c.closure, &e);
      for (uint32_t j = from; j < i; ++j) {
        const uint32_t s = list[j], p = point_[s], path = slot_[s];
        const float times = trials ? float(trials[s]) : 1.f;
        for (uint32_t l = 0; l < c.slotCount; ++l) {
          float v[3];
          for (int x = 0; x < 3; ++x)
            v[x] = paths_.throughput[x][path] * e.weight[l][x][p] * found.value[x][s] * times;
          if (!(v[0] != 0 || v[1] != 0 || v[2] != 0)) continue;
          float most = paths_.clampCaustic;
          if (depth_ + w.found[s] + 1 >= paths_.clampDepth)
            most = most < paths_.clampLuminance ? most : paths_.clampLuminance;
          if (most < 1e30f) {
            const float f = factorToLuminance(Vec3<1>(v[0], v[1], v[2]), Float<1>(most)).lane0();
            for (float& x : v) x *= f;
          }
          uint32_t at = sv_->paths.next[paths_.state[path] * sv_->paths.eventCount + c.eventOfSlot[l]];
          for (uint32_t k = 0; k < w.found[s]; ++k)
            at = sv_->paths.next[at * sv_->paths.eventCount + found.event[k][s]];
          for (int x = 0; x < 3; ++x) value[x][m] = v[x];
          slot[m] = path;
          light[m] = to_.light[s];
          state[m++] = at;
        }
      }
    }
    const Contributions out{m, slot, {value[0], value[1], value[2]}, state, light};
    if (m) sv_->contribute(g_, &out);
  }
  void note(uint32_t n, const uint32_t* list, const Walks& w, const Found& found, const uint32_t* trials) const {
    if (!n) return;
    float *d[3], *value[3];
    floats(n, d);
    floats(n, value);
    uint32_t *slot = words(n), *interfaces = words(n), *tried = words(n);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = list[i];
      slot[i] = slot_[s];
      interfaces[i] = w.found[s];
      tried[i] = trials ? trials[s] : 0;
      for (int c = 0; c < 3; ++c) {
        d[c][i] = w.best[c][s];
        value[c][i] = w.found[s] ? found.value[c][s] : 0.f;
      }
    }
    const WalkNote out{n, slot, interfaces, {d[0], d[1], d[2]}, tried, {value[0], value[1], value[2]}};
    sv_->noteWalks(g_, &out);
  }

  Group* g_;
  const Services* sv_;
  ManifoldOptions o_;
  uint32_t most_ = 0, depth_ = 0;
  Paths paths_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
