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
#include <kinora/manifold_walk.h>

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

// Ratio: DensityRatio, or what a test puts in its place.
template <int W, class Ratio = DensityRatio>
class ManifoldWalks {
 public:
  using F = Float<W>;
  using I = Int<W>;
  using V = Vec3<W>;
  using M = Mask<W>;
  using Tracer = WalkTracer<W, Ratio>;
  ManifoldWalks(Group* group, const Services* services, const ManifoldOptions& options)
      : g_(group), sv_(services), memory_{group, services}, o_(options) {
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
    if (at_.n) connectAll();
    sv_->releaseMemory(g_, mark);
  }

 private:
  static constexpr float kSame = 1e-3f;  // distance of directions at y that are one path's

  static KN_INLINE M firstOf(uint32_t n, uint32_t i) {
    return M::firstN(int(n - i < uint32_t(W) ? n - i : uint32_t(W)));
  }

  void begin(uint32_t count, Context* const* contexts) {
    at_.runs = static_cast<WalkStarts::Run*>(sv_->alloc(g_, (count + 1) * sizeof(WalkStarts::Run)));
    at_.runCount = at_.n = 0;
    for (uint32_t k = 0; k < count; ++k) {
      const Context& c = *contexts[k];
      // kTraitScattersOnce: nothing is followed from there
      if ((c.traits & (kTraitWalkable | kTraitScattersOnce)) || !c.bxdf || !c.bxdf->evaluate) continue;
      at_.runs[at_.runCount++] = {&c, at_.n, at_.n + c.count};
      at_.n += c.count;
    }
    if (!at_.n) return;
    at_.makeStarts(memory_);
    for (uint32_t r = 0; r < at_.runCount; ++r) {
      const Context& c = *at_.runs[r].c;
      for (uint32_t p = 0; p < c.count; ++p) {
        const uint32_t i = at_.runs[r].first + p;
        at_.point[i] = p;
        at_.slot[i] = c.path[p];
        at_.seed[i] = c.sampleSeed[p];
        at_.sample[i] = c.sampleIndex[p];
        for (int x = 0; x < 3; ++x) {
          at_.P[x][i] = c.P[x][p];
          at_.Ng[x][i] = c.Ng[x][p];
        }
        at_.bias[i] = c.bias[p];
        at_.time[i] = c.time[p];
        at_.radius[i] = c.radius[p];
        at_.spread[i] = c.spread[p];
      }
    }
    at_.padArrays();
    // places on lights
    const uint32_t dim = dimensionAt(depth_) + kDimUser;
    float* u[6];
    for (float*& x : u) x = memory_.floats(at_.n);
    for (uint32_t i = 0; i < at_.n; i += W)
      for (uint32_t k = 0; k < 3; ++k) {
        F a, b;
        draw2(sv_->samples, I::load(at_.seed + i), I::load(at_.sample + i), dim + k, a, b);
        a.store(u[2 * k] + i);
        b.store(u[2 * k + 1] + i);
      }
    const float* five[5] = {u[0], u[2], u[3], u[4], u[5]};
    sv_->walkTargets(g_, at_.n, five, at_.time, &at_.to);
    at_.makeTracks(memory_);
  }
  // The listed walks, each `times` times, one behind the other.
  WalkStarts repeat(uint32_t n, const uint32_t* list, uint32_t times) const {
    WalkStarts more;
    more.n = n * times;
    more.runs = static_cast<WalkStarts::Run*>(sv_->alloc(g_, (at_.runCount + 1) * sizeof(WalkStarts::Run)));
    more.makeStarts(memory_);
    more.to.light = memory_.words(more.n);
    more.to.flags = memory_.words(more.n);
    memory_.floats(more.n, more.to.to);
    memory_.floats(more.n, more.to.N);
    more.to.pdf = memory_.floats(more.n);
    uint32_t run = 0, last = ~0u;
    for (uint32_t i = 0; i < more.n; ++i) {
      const uint32_t s = list[i / times];
      while (s >= at_.runs[run].end) ++run;
      if (run != last) {
        more.runs[more.runCount++] = {at_.runs[run].c, i, i};
        last = run;
      }
      more.runs[more.runCount - 1].end = i + 1;
      more.point[i] = at_.point[s];
      more.slot[i] = at_.slot[s];
      more.seed[i] = at_.seed[s];
      more.sample[i] = at_.sample[s];
      for (int c = 0; c < 3; ++c) {
        more.P[c][i] = at_.P[c][s];
        more.Ng[c][i] = at_.Ng[c][s];
        more.to.to[c][i] = at_.to.to[c][s];
        more.to.N[c][i] = at_.to.N[c][s];
      }
      more.bias[i] = at_.bias[s];
      more.time[i] = at_.time[s];
      more.radius[i] = at_.radius[s];
      more.spread[i] = at_.spread[s];
      more.to.light[i] = at_.to.light[s];
      more.to.flags[i] = at_.to.flags[s];
      more.to.pdf[i] = at_.to.pdf[s];
    }
    more.padArrays();
    more.makeTracks(memory_);
    return more;
  }
  WalkState makeState(uint32_t n) const {
    WalkState w;
    memory_.floats(n, w.d);
    memory_.floats(n, w.best);
    w.bestMiss = memory_.floats(n);
    memory_.floats(n, w.step);
    w.damp = memory_.floats(n);
    w.through = memory_.words(n);
    w.found = memory_.words(n);
    w.foundBits = memory_.words(n);
    return w;
  }

  void connectAll() {
    Tracer tracer(memory_, o_, at_, depth_, most_);
    uint32_t* list = memory_.words(at_.n);
    // straight towards the light, through all that is in the way
    WalkState straight = makeState(at_.n);
    uint32_t m = 0;
    for (uint32_t i = 0; i < at_.n; ++i) {
      straight.found[i] = 0;
      if (at_.to.pdf[i] > 0) list[m++] = i;
    }
    padWalks(m, list);
    towardsTarget(m, list, straight);
    tracer.walk(m, list, straight);
    WalkFound found = makeFound();
    uint32_t* some = memory_.words(at_.n);
    uint32_t k = 0;
    clear(m, list, found);
    for (uint32_t i = 0; i < m; ++i)
      if (straight.found[list[i]]) some[k++] = list[i];
    padWalks(k, some);
    follow(tracer, k, some, straight, found);
    contribute(k, some, straight, found, nullptr);
    note(m, list, straight, found, nullptr);
    if (!o_.findsAll) return;
    // from anywhere
    WalkState other = makeState(at_.n);
    uint32_t* first = memory_.words(at_.n);
    for (uint32_t i = 0; i < at_.n; ++i) first[i] = 0;
    aimAnywhere(at_, m, list, other, first);
    tracer.walk(m, list, other);
    k = 0;
    clear(m, list, found);
    for (uint32_t i = 0; i < m; ++i)
      if (other.found[list[i]] && !isSame(straight, list[i], other, list[i])) some[k++] = list[i];
    padWalks(k, some);
    follow(tracer, k, some, other, found);
    uint32_t open = 0;
    uint32_t* again = memory_.words(at_.n);
    uint32_t* trials = memory_.words(at_.n);
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
  void findAgain(uint32_t open, uint32_t* again, const WalkState& w, uint32_t* trials) {
    constexpr uint32_t kEnough = 64, kMostAtOnce = 8;
    for (uint32_t t = 1; open && t <= o_.mostTrials;) {
      const MemoryMark mark = sv_->markMemory(g_);
      uint32_t times = kEnough / open;
      times = times < 1 ? 1 : times > kMostAtOnce ? kMostAtOnce : times;
      if (times > o_.mostTrials + 1 - t) times = o_.mostTrials + 1 - t;
      const WalkStarts repeated = repeat(open, again, times);
      const uint32_t n = repeated.n;
      const WalkState trial = makeState(n);
      uint32_t *list = memory_.words(n), *number = memory_.words(n);
      for (uint32_t i = 0; i < n; ++i) {
        list[i] = i;
        number[i] = t + i % times;
      }
      padWalks(n, list);
      aimAnywhere(repeated, n, list, trial, number);
      Tracer(memory_, o_, repeated, depth_, most_).walk(n, list, trial);
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
      sv_->releaseMemory(g_, mark);
    }
  }
  static void clear(uint32_t n, const uint32_t* list, const WalkFound& found) {
    for (uint32_t i = 0; i < n; ++i)
      for (float* x : found.value) x[list[i]] = 0;
  }
  static bool isSame(const WalkState& a, uint32_t i, const WalkState& b, uint32_t j) {
    if (!a.found[i] || a.found[i] != b.found[j] || a.foundBits[i] != b.foundBits[j]) return false;
    float d2 = 0;
    for (int c = 0; c < 3; ++c) d2 += (a.best[c][i] - b.best[c][j]) * (a.best[c][i] - b.best[c][j]);
    return d2 < kSame * kSame;
  }

  KN_INLINE F draw(const WalkStarts& at, const Slots<W>& s, I event) const { return drawOf<W>(at, depth_, s, event); }

  // Unit direction to the light from y.
  KN_INLINE V toTarget(const WalkStarts& at, const Slots<W>& s) const {
    const V to = V::get(at.to.to, s);
    const M infinite = (s.get(at.to.flags) & I(uint32_t(kLightIsInfinite))) != I(0);
    const V d = select(infinite, to, to - V::get(at.P, s));
    return d * (F(1.f) / sqrt(max(dot(d, d), F(1e-30f))));
  }
  void towardsTarget(uint32_t n, const uint32_t* list, const WalkState& w) const {
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const V d = toTarget(at_, s);
      s.put(in, d.x, w.d[0]);
      s.put(in, d.y, w.d[1]);
      s.put(in, d.z, w.d[2]);
      s.put(in, I((1u << WalkState::kPastTarget) - 1), w.through);
    }
  }
  // Random directions and boundaries' kinds, of trial t: towards what walks go through, and where that lies towards
  // the light half of them around the light.
  void aimAnywhere(const WalkStarts& at, uint32_t n, const uint32_t* list, const WalkState& w,
                   const uint32_t* trial) const {
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const I event = I(uint32_t(kWalkEventSeed)) + s.get(trial) * I(uint32_t(kWalkEventsOfTrial));
      const F u = draw(at, s, event), v = draw(at, s, event + I(1)), which = draw(at, s, event + I(2)),
              wide = draw(at, s, event + I(3));
      const V P = V::get(at.P, s);
      // around the light, mostly near
      const V z = toTarget(at, s);
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
      const I bits = hashWords(hashWords(asInt(draw(at, s, event + I(4))), s.get(at.seed)), event);
      const I more = hashWords(bits, event), low((1u << WalkState::kPastTarget) - 1),
              high(~0u << WalkState::kPastTarget);
      s.put(in,
            ((bits | bits.template shr<WalkState::kPastTarget>()) & low) |
                (more & more.template shl<WalkState::kPastTarget>() & high),
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

  // ---- what a path brings ----

  WalkFound makeFound() const {
    WalkFound f;
    memory_.floats(at_.n, f.value);
    for (uint32_t k = 0; k < o_.interfaces; ++k) f.event[k] = memory_.words(at_.n);
    for (float*& x : f.transmittance) x = memory_.floats(at_.rays->capacity);
    return f;
  }
  // The listed walks' paths once more, as paths of the world with all that is in it.
  void follow(Tracer& tracer, uint32_t n, const uint32_t* list, const WalkState& w, const WalkFound& found) {
    if (!n) return;
    const MemoryMark mark = sv_->markMemory(g_);
    uint32_t *open = memory_.words(n), *ended = memory_.words(n);
    for (uint32_t i = 0; i < padded(n); ++i) open[i] = list[i];
    for (uint32_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c) {
        w.d[c][list[i]] = w.best[c][list[i]];
        found.value[c][list[i]] = 1;
      }
    float* const* media = sv_->hasMedia ? found.transmittance : nullptr;
    tracer.leaveStart(n, list, w);
    uint32_t* lit = memory_.words(n);
    uint32_t done = 0;
    for (uint32_t k = 0, left = n; left; ++k) {
      sv_->trace(g_, at_.rays, RayKind::Indirect, depth_ + 1 + k, left, open, media);
      const uint32_t before = left;
      uint32_t* was = memory_.words(before);
      for (uint32_t i = 0; i < before; ++i) was[i] = open[i];
      left = tracer.endAtTargets(left, open, k, w, true);
      uint32_t m = 0;
      for (uint32_t i = 0; i < before; ++i)
        if (at_.miss[was[i]] < INFINITY) ended[m++] = was[i];
      padWalks(m, ended);
      for (uint32_t i = 0; media && i < left; ++i)
        for (int c = 0; c < 3; ++c) found.value[c][open[i]] *= media[c][open[i]];
      if (m) arrive(m, ended, media, found);
      for (uint32_t i = 0; i < m; ++i) lit[done++] = ended[i];
      if (left) left = tracer.turn(left, open, k, w, &found);
    }
    // what did not come to its light brings nothing
    for (uint32_t i = 0; i < n; ++i) at_.passed[list[i]] = 0;
    for (uint32_t i = 0; i < done; ++i) at_.passed[lit[i]] = 1;
    for (uint32_t i = 0; i < n; ++i)
      for (int c = 0; c < 3; ++c)
        if (!at_.passed[list[i]]) found.value[c][list[i]] = 0;
    sv_->releaseMemory(g_, mark);
  }
  // Light at the ends of the listed walks' paths.
  void arrive(uint32_t n, const uint32_t* list, float* const* media, const WalkFound& found) {
    const Rays& r = at_.rays->rays;
    float *light[3], *along = memory_.floats(at_.rays->capacity), *factor = memory_.floats(at_.rays->capacity);
    memory_.floats(at_.rays->capacity, light);
    uint32_t *delta = memory_.words(n), *other = memory_.words(n), deltas = 0, others = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = list[i];
      for (float* x : light) x[s] = 0;
      factor[s] = 0;
      along[s] = 1;
      if (at_.to.flags[s] & kLightIsDelta)
        delta[deltas++] = s;
      else
        other[others++] = s;
      if (at_.to.flags[s] & kLightIsInfinite) continue;
      along[s] = 0;
      for (int c = 0; c < 3; ++c) along[s] += (at_.to.to[c][s] - r.o[c][s]) * r.d[c][s];
    }
    padWalks(deltas, delta);
    padWalks(others, other);
    if (deltas) {
      sv_->deltaLights(g_, at_.rays, deltas, delta, at_.to.light, light, factor);
      for (uint32_t i = 0; media && i < deltas; ++i) {
        // what the medium lets through on the whole way to the next surface, of which this is a part
        const uint32_t s = delta[i];
        const float t = at_.rays->hits.t[s], part = t < 3e38f ? along[s] / t : 1.f;
        for (int c = 0; c < 3; ++c)
          light[c][s] *= pow(F(media[c][s] > 1e-30f ? media[c][s] : 1e-30f), F(part)).lane0();
      }
    }
    if (others) {
      LightHits h;
      sv_->lightHits(g_, at_.rays, RayKind::Indirect, others, other, &h);
      for (uint32_t i = 0; i < h.count; ++i) {
        const uint32_t s = h.slot[i];
        if (h.light[i] != at_.to.light[s]) continue;
        // not another part of the same light
        if (!(at_.to.flags[s] & kLightIsInfinite) && !(std::abs(h.t[i] - along[s]) < 5e-3f * along[s])) continue;
        const float* const* radiance = h.specularRadiance[0] ? h.specularRadiance : h.radiance;
        for (int c = 0; c < 3; ++c) light[c][s] += radiance[c][i];
        factor[s] = h.specular[i];
      }
    }
    for (uint32_t i = 0; i < n; i += W) {
      const M in = firstOf(n, i);
      const Slots<W> s = Slots<W>::load(list + i);
      const I flags = s.get(at_.to.flags);
      const M isArea = (flags & I(uint32_t(kLightIsInfinite | kLightIsDelta))) == I(0);
      const F far = s.get(along), cosine = max(-dot(V::get(at_.to.N, s), V::get(r.d, s)), F(0.f));
      const F scale = s.get(factor) * select(isArea, cosine / max(far * far, F(1e-30f)), F(1.f)) /
                      max(s.get(at_.spreadOfPath) * s.get(at_.to.pdf), F(1e-30f));
      const V v = V::get(found.value, s) * V::get(light, s) * scale;
      s.put(in, v.x, found.value[0]);
      s.put(in, v.y, found.value[1]);
      s.put(in, v.z, found.value[2]);
    }
  }

  // Paths that were found times `trials` (null: 1), by the slots of the points where walks begin.
  void contribute(uint32_t n, const uint32_t* list, const WalkState& w, const WalkFound& found,
                  const uint32_t* trials) {
    if (!n) return;
    uint32_t mostSlots = 1;
    for (uint32_t r = 0; r < at_.runCount; ++r)
      mostSlots = at_.runs[r].c->slotCount > mostSlots ? at_.runs[r].c->slotCount : mostSlots;
    const uint32_t room = n * mostSlots;
    float* value[3];
    memory_.floats(room, value);
    uint32_t *slot = memory_.words(room), *light = memory_.words(room), *state = memory_.words(room), m = 0;
    for (uint32_t i = 0, r = 0; i < n;) {
      while (list[i] >= at_.runs[r].end) ++r;
      const uint32_t from = i;
      while (i < n && list[i] < at_.runs[r].end) ++i;
      const Context& c = *at_.runs[r].c;
      EvaluateArgs e{};
      float* wi[3];
      memory_.floats(c.padded, wi);
      for (int x = 0; x < 3; ++x) {
        for (uint32_t p = 0; p < c.padded; ++p) wi[x][p] = c.N[x][p];
        for (uint32_t j = from; j < i; ++j) wi[x][at_.point[list[j]]] = w.best[x][list[j]];
        e.wi[x] = wi[x];
        for (uint32_t l = 0; l < c.slotCount; ++l) e.weight[l][x] = memory_.floats(c.padded);
      }
      e.pdf = memory_.floats(c.padded);
      c.bxdf->evaluate(&c, c.closure, &e);
      for (uint32_t j = from; j < i; ++j) {
        const uint32_t s = list[j], p = at_.point[s], path = at_.slot[s];
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
          light[m] = at_.to.light[s];
          state[m++] = at;
        }
      }
    }
    const Contributions out{m, slot, {value[0], value[1], value[2]}, state, light};
    if (m) sv_->contribute(g_, &out);
  }
  void note(uint32_t n, const uint32_t* list, const WalkState& w, const WalkFound& found,
            const uint32_t* trials) const {
    if (!n) return;
    float *d[3], *value[3];
    memory_.floats(n, d);
    memory_.floats(n, value);
    uint32_t *slot = memory_.words(n), *interfaces = memory_.words(n), *tried = memory_.words(n);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t s = list[i];
      slot[i] = at_.slot[s];
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
  const WalkMemory memory_;
  ManifoldOptions o_;
  WalkStarts at_;
  uint32_t most_ = 0, depth_ = 0;
  Paths paths_{};
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
