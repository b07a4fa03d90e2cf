// Paths that an integrator follows vertex by vertex, from the camera or from lights: what bidirectional methods begin
// with. Subpaths traces them, makes contexts and takes new directions; Arrivals holds light back until its shadow
// rays have been traced. Whoever uses them keeps the books on densities. Included per target.
#include <kinora/clamp_luminance.h>
#include <kinora/cover_by_media.h>
#include <kinora/integrator.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>
#include <kinora/roulette.h>

#ifndef KINORA_SUBPATHS_ONCE
#define KINORA_SUBPATHS_ONCE
#include <algorithm>
#include <cmath>
namespace kinora {
// A vertex of a light path, put aside for others to connect to.
struct PathVertex {
  VertexRecord vertex;
  float throughput[3];
  uint32_t light;   // where the path began
  float factor[2];  // of the light on diffuse and on specular slots here: 1 after the first vertex
  uint32_t before;  // how many vertices of the path were before it
  uint32_t tail;    // of their events, see PathStates
  float factorOf(uint32_t event) const { return factor[event & 1]; }
};
}  // namespace kinora
#endif

#if defined(KINORA_SUBPATHS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBPATHS_H_TARGET
#undef KINORA_SUBPATHS_H_TARGET
#else
#define KINORA_SUBPATHS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// What a bxdf's weight, which holds the shading normal's cosine on wi's side, is multiplied by where importance
// travels: its own is that of wo's side, and the geometric normal's on the other (Veach 1997, section 5.3).
template <int W>
KN_INLINE Float<W> adjointFactor(const Context& c, uint32_t i, Vec3<W> wi) {
  if (c.traits & kTraitInSpace) return Float<W>(1.f);
  const Vec3<W> N = Vec3<W>::load(c.N, i), Ng = Vec3<W>::load(c.Ng, i), wo = Vec3<W>::load(c.wo, i);
  return abs(dot(N, wo) * dot(Ng, wi)) / max(abs(dot(Ng, wo) * dot(N, wi)), Float<W>(1e-12f));
}

// The bxdfs' answers for one direction a point (unit, arrays of the context's padded length): weights by slot and
// both densities, in memory of the group.
inline EvaluateArgs evaluateBxdf(const Context& c, const float* const wi[3]) {
  EvaluateArgs e{{wi[0], wi[1], wi[2]}, {}, c.alloc<float>(c.padded), c.alloc<float>(c.padded)};
  for (uint32_t l = 0; l < c.slotCount; ++l)
    for (float*& w : e.weight[l]) w = c.alloc<float>(c.padded);
  c.bxdf->evaluate(&c, c.closure, &e);
  return e;
}

// The state after an event at a vertex that is reached in another one.
inline uint32_t stepState(const PathStates& paths, uint32_t state, uint32_t event) {
  return paths.next[state * paths.eventCount + event];
}
// The state after a connection: an event, and those of a tail.
inline uint32_t stepState(const PathStates& paths, uint32_t state, uint32_t event, uint32_t tail) {
  return paths.end[tail * paths.stateCount + stepState(paths, state, event)];
}

// Points of a context whose paths go below the surface (kSampleBelow), as generate() made them: they have their
// throughputs, and live on once subpaths_below.h has brought them out again.
struct SunkPoints {
  const Context* context = nullptr;
  GenerateArgs made{};
  uint32_t count = 0, *points = nullptr;
};

// The paths of a group, by slot. Each step is trace(), shade(), and scatter() for each context.
template <int W>
class Subpaths {
 public:
  // traits: kTraitEyePath or kTraitLightPath, with kTraitSubsurface where materials are to offer ways below surfaces (and
  // kTraitBothEnds where both kinds of paths are followed). Light paths that take one end there.
  Subpaths(Group* group, const Services* services, uint32_t traits, Roulette roulette = {})
      : g_(group), sv_(services), traits_(traits), roulette_(roulette) {
    const uint32_t n = g_->padded + kPad;
    for (int c = 0; c < 3; ++c) {
      throughput[c] = floats(n);
      medium_[c] = floats(n);
    }
    state = words(n);
    live = words(n);
    if (!(traits_ & kTraitLightPath)) return;
    began_ = floats(n);
  }

  // Camera rays of all samples.
  void startAtCamera() {
    count = g_->count;
    for (int c = 0; c < 3; ++c) g_->paths.throughput[c] = throughput[c];
    for (uint32_t i = 0; i < g_->padded; ++i) {
      live[i] = std::min(i, count - 1);
      for (float* t : throughput) t[i] = g_->rayWeight[i];
      state[i] = sv_->paths.start;
      g_->paths.origin[i] = kFromDiscrete;
    }
    if (!sv_->mediaScatter || !g_->paths.glow[0]) return;
    float* share = floats(g_->padded);
    againstLights_ = floats(g_->padded);
    std::fill_n(share, g_->padded, 1.f);
    std::fill_n(againstLights_, g_->padded, HUGE_VALF);
    g_->paths.againstLights = againstLights_;
    g_->paths.share = share;
  }
  // Emitted rays: those that carry light live.
  EmittedLight startAtLights() {
    EmittedLight rays{};
    sv_->emitLight(g_, g_->count, &rays);
    light = rays.light;
    factor_[0] = rays.diffuse;
    factor_[1] = rays.specular;
    count = 0;
    for (int c = 0; c < 3; ++c) {
      g_->paths.throughput[c] = throughput[c];
      g_->paths.glow[c] = nullptr;  // light paths do not look for what media emit
    }
    for (uint32_t i = 0; i < g_->count; ++i) {
      for (int c = 0; c < 3; ++c) throughput[c][i] = rays.throughput[c][i];
      began_[i] = maxComponent(Vec3<1>::load(throughput, i)).lane0();
      state[i] = 0;
      g_->paths.origin[i] = 0;
      live[count] = i;
      count += throughput[0][i] + throughput[1][i] + throughput[2][i] > 0;
    }
    return rays;
  }

  // What the surfaces of a context give off on their own, times a factor, as far as no contribution has a luminance above
  // `most`.
  void contributeEmission(const Context& c, float most = 1e30f, float factor = 1) const {
    if (!c.bxdf->emission) return;
    float* rgb[3] = {c.alloc<float>(c.padded), c.alloc<float>(c.padded), c.alloc<float>(c.padded)};
    uint32_t *at = c.alloc<uint32_t>(c.padded), *light = c.alloc<uint32_t>(c.padded);
    c.bxdf->emission(&c, c.closure, rgb);
    for (uint32_t i = 0; i < c.count; ++i) {
      const Vec3<1> v = Vec3<1>::load(rgb, i) * Vec3<1>::load(throughput, c.path[i]) * Float<1>(factor);
      (v * factorToLuminance(v, Float<1>(most))).store(rgb, i);
      at[i] = state[c.path[i]];
      light[i] = kNoLight;
    }
    const Contributions out{c.count, c.path, {rgb[0], rgb[1], rgb[2]}, at, light, LightKind::Arrives};
    sv_->contribute(g_, &out);
  }

  // What media emitted along the rays of camera paths (after trace), beside light samples of it; as far as no
  // contribution has a luminance above `most`.
  void contributeGlow(float most = 1e30f) const {
    float* const* glow = g_->paths.glow;
    if (!glow[0]) return;
    float* value[3] = {floats(count), floats(count), floats(count)};
    uint32_t *slot = words(count), *at = words(count), *light = words(count), n = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t s = live[i];
      const Vec3<1> v(throughput[0][s] * glow[0][s], throughput[1][s] * glow[1][s], throughput[2][s] * glow[2][s]);
      if (!(v.x.lane0() != 0 || v.y.lane0() != 0 || v.z.lane0() != 0)) continue;
      (v * factorToLuminance(v, Float<1>(most))).store(value, n);
      slot[n] = s;
      at[n] = state[s];
      light[n++] = kNoLight;
    }
    const Contributions out{n, slot, {value[0], value[1], value[2]}, at, light, LightKind::Arrives};
    if (n) sv_->contribute(g_, &out);
  }

  // Lights that the paths have met (after trace), each with a weight.
  void contribute(const LightHits& h, uint32_t depth, const float* weight) const {
    // where unshadowed light is wanted, what light samples could have found too is told apart from the rest
    for (const LightKind kind : {LightKind::Arrives, LightKind::Shadowed}) {
      if (kind == LightKind::Shadowed && !sv_->wantsUnshadowed) break;
      contributeAs(kind, h, depth, weight, [&](uint32_t origin) {
        const bool isShadowed = sv_->wantsUnshadowed && !(origin & kFromDiscrete);
        return isShadowed == (kind == LightKind::Shadowed);
      });
    }
  }
  // The same of lights along the rays (Services::lightsAlong), as if nothing were in the way.
  void contributeUnshadowed(const LightHits& h, uint32_t depth, const float* weight) const {
    contributeAs(LightKind::Unshadowed, h, depth, weight, [](uint32_t) { return true; });
  }

  // Nearest hits of the paths that live, which all go on living. What media let through weighs on them from shade()
  // on: lights met by the rays know of it themselves.
  void trace(uint32_t depth) {
    const bool isCamera = depth == 0 && traits_ & kTraitEyePath;
    sv_->trace(g_, &g_->paths, isCamera ? RayKind::Camera : RayKind::Indirect, depth, count, live, medium_);
  }
  // After trace(0), see there.
  void coverByMedia() const {
    if (sv_->mediaScatter) kinora::coverByMedia(g_, sv_, count, live, medium_);
  }
  // Contexts of what they hit; those that escaped end.
  uint32_t shade(uint32_t depth, Context* const** contexts) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const uint32_t s = live[i];
      for (int c = 0; c < 3; ++c) throughput[c][s] *= medium_[c][s];
      live[n] = s;
      n += g_->paths.hits.t[s] < 3e38f;
    }
    const bool isCamera = depth == 0 && traits_ & kTraitEyePath;
    if (isCamera && n) {
      float* alpha = floats(n);
      std::fill_n(alpha, n, 1.f);
      sv_->cover(g_, n, live, alpha);
    }
    count = 0;  // from here on they are those that scatter() lets live
    return sv_->shade(g_, &g_->paths, isCamera ? traits_ | kTraitPrimaryHit : traits_, depth, n, live, contexts);
  }
  // The points of a context as vertices of their paths, before directions are taken from them.
  PathVertex* vertices(const Context& c, uint32_t depth) const {
    uint32_t* points = c.alloc<uint32_t>(c.count);
    VertexRecord* records = c.alloc<VertexRecord>(c.count);
    PathVertex* out = c.alloc<PathVertex>(c.count);
    for (uint32_t i = 0; i < c.count; ++i) points[i] = i;
    sv_->keepVertices(g_, &c, c.count, points, records);
    for (uint32_t i = 0; i < c.count; ++i) {
      const uint32_t s = c.path[i];
      out[i] = {records[i], {throughput[0][s], throughput[1][s], throughput[2][s]}, light[s], {1, 1}, depth,
                state[s]};
      if (!depth)
        for (int k = 0; k < 2; ++k) out[i].factor[k] = factor_[k][s];
    }
    return out;
  }
  // Of light paths, by slot: the light's factors on diffuse (0) and specular slots of the first vertex.
  float factorOf(uint32_t slot, int k) const { return factor_[k][slot]; }
  // Lanes of light paths that mirrors or lenses send on which do not show their light.
  Mask<W> unseen(const Slots<W>& s, Int<W> flags) const {
    alignas(64) uint32_t is[W], slot[W], flag[W];
    s.s.store(slot);
    flags.store(flag);
    for (int l = 0; l < W; ++l) {
      const uint32_t from = light[slot[l]];
      const uint32_t hides = flag[l] & kSampleTransmit ? kLightUnseenByLenses : kLightUnseenByMirrors;
      is[l] = flag[l] & kSampleDiscrete && from < sv_->lightCount && sv_->lightExceptions[from] & hides;
    }
    return Int<W>::load(is) != Int<W>(0);
  }
  // New directions from the points of a context, one each, in memory of the group; slot is kNoLobe where the path
  // ends. Rays, throughputs and states are those of the next step.
  // lightParts: light samples that were taken at the points, where media emit. sunk: gets the paths that go below the
  // surface; null: they end. Contexts where such paths came out (kTraitComesOut) have random numbers of their own.
  GenerateArgs scatter(const Context& c, uint32_t depth, uint32_t lightParts = 1, SunkPoints* sunk = nullptr) {
    using F = Float<W>;
    const bool comesOut = c.traits & kTraitComesOut;
    const auto f = [&] { return c.alloc<float>(c.padded + kPad); };
    const auto u = [&] { return c.alloc<uint32_t>(c.padded + kPad); };
    float* random[4] = {f(), f(), f(), f()};
    const GenerateArgs a{
        {random[0], random[1], random[2], random[3]}, {f(), f(), f()}, {f(), f(), f()}, f(), f(), u(), u()};
    for (uint32_t i = 0; i < c.padded; i += W)
      for (uint32_t k = 0; k < 4; k += 2) {
        F x, y;
        draw2(sv_->samples, Int<W>::load(c.sampleSeed + i), Int<W>::load(c.sampleIndex + i),
              dimension(depth) + (comesOut ? kDimBelow
                                  : k      ? kDimLobe
                                           : kDimBxdf),
              x, y);
        x.store(random[k] + i);
        y.store(random[k + 1] + i);
      }
    c.bxdf->generate(&c, c.closure, &a);
    uint32_t *points = u(), *through = u(), *slots = comesOut ? u() : nullptr, n = 0;
    if (sunk) *sunk = {&c, a, 0, c.bxdf->subsurface ? u() : nullptr};
    const Rays& r = g_->paths.rays;
    for (uint32_t i = 0; i < c.count; i += W) {
      const Mask<W> in = Mask<W>::firstN(int(std::min<uint32_t>(c.count - i, W)));
      const Slots<W> s = Slots<W>::load(c.path + i);
      const Int<W> slot = Int<W>::load(a.slot + i), flags = Int<W>::load(a.flags + i);
      const F pdf = F::load(a.pdf + i);
      const Vec3<W> w = Vec3<W>::load(a.wi, i);
      Vec3<W> t = Vec3<W>::get(throughput, s) * Vec3<W>::load(a.weight, i) * (F(1.f) / max(pdf, F(1e-38f)));
      Int<W> what(uint32_t(c.eventOfSlot[0]));
      for (uint32_t l = 1; l < c.slotCount; ++l)
        what = select(slot == Int<W>(l), Int<W>(uint32_t(c.eventOfSlot[l])), what);
      const Mask<W> isSpecular = (what & Int<W>(1)) != Int<W>(0);
      if (traits_ & kTraitLightPath) {
        t = t * adjointFactor(c, i, w);
        if (!depth) t = t * select(isSpecular, s.get(factor_[1]), s.get(factor_[0]));
      }
      Mask<W> on = in & (slot != Int<W>(kNoLobe)) & (pdf > F(0.f)) & (maxComponent(t) > F(0.f));
      if (traits_ & kTraitLightPath && !depth && sv_->lightExceptions) on = on & !unseen(s, flags);
      if (depth >= roulette_.depth && !comesOut) {
        F r, unused;
        draw2(sv_->samples, Int<W>::load(c.sampleSeed + i), Int<W>::load(c.sampleIndex + i),
              dimension(depth) + kDimRoulette, r, unused);
        const F left = began_ ? maxComponent(t) / max(s.get(began_), F(1e-38f)) : maxComponent(t);
        const F goesOn = clamp(left * F(1.f / roulette_.threshold), F(0.05f), F(1.f));
        on = on & (r < goesOn);
        t = t * (F(1.f) / goesOn);
      }
      const Mask<W> sinks = on & ((flags & Int<W>(uint32_t(kSampleBelow))) != Int<W>(0));
      on = on & !sinks;
      select(sunk ? on | sinks : on, slot, Int<W>(kNoLobe)).store(a.slot + i);
      if (sunk && sinks.any()) {
        for (int k = 0; k < 3; ++k) s.put(sinks, k == 0 ? t.x : k == 1 ? t.y : t.z, throughput[k]);
        const Packer<W> pack(sinks);
        pack.put(Int<W>::lanes(int32_t(i)), sunk->points + sunk->count);
        sunk->count += uint32_t(pack.count);
      }
      if (on.none()) continue;
      const Vec3<W> o = leave(Vec3<W>::load(c.P, i), Vec3<W>::load(c.Ng, i), F::load(c.bias + i), w);
      for (int k = 0; k < 3; ++k) {
        s.put(on, k == 0 ? o.x : k == 1 ? o.y : o.z, r.o[k]);
        s.put(on, k == 0 ? w.x : k == 1 ? w.y : w.z, r.d[k]);
        s.put(on, k == 0 ? t.x : k == 1 ? t.y : t.z, throughput[k]);
      }
      const Mask<W> discrete = (flags & Int<W>(uint32_t(kSampleDiscrete))) != Int<W>(0);
      if (againstLights_) {
        const F infinite(HUGE_VALF);
        s.put(on, lightParts ? select(discrete, infinite, pdf * F(1.f / float(lightParts))) : infinite,
              againstLights_);
      }
      s.put(on, F(1e30f), r.tMax);
      s.put(on, F::load(c.radius + i), r.radius);
      // Vertices of light paths are seen by the camera without anything in between: they stay sharp.
      const F spread = F::load(c.spread + i);
      const Mask<W> keeps = discrete | Mask<W>((traits_ & kTraitLightPath) != 0);
      s.put(on, select(keeps, spread, spreadAfter(spread, pdf)), r.spread);
      const uint32_t* next = traits_ & kTraitLightPath ? sv_->paths.nextTail : sv_->paths.next;
      s.put(on, gather(next, s.get(state) * Int<W>(sv_->paths.eventCount) + what), state);
      const auto bit = [&](Mask<W> m, uint32_t b) { return select(m, Int<W>(b), Int<W>(0)); };
      const Mask<W> transmits = (flags & Int<W>(uint32_t(kSampleTransmit))) != Int<W>(0);
      s.put(on, bit(discrete, kFromDiscrete) | bit(isSpecular, kFromSpecular) | bit(transmits, kFromTransmission),
            g_->paths.origin);
      const Packer<W> pack(on);
      pack.put(s.s, live + count);
      if (slots) pack.put(s.s, slots + n);
      pack.put(Int<W>::lanes(int32_t(i)), points + n);
      pack.put(bit(transmits, 1), through + n);
      n += uint32_t(pack.count);
      count += uint32_t(pack.count);
    }
    if (n) sv_->leave(g_, &g_->paths, &c, n, points, slots, through);
    return a;
  }
  // Of camera paths at `s`: the states after an event at their vertices.
  Int<W> stateAfter(const Slots<W>& s, uint32_t event) const {
    return gather(sv_->paths.next, s.get(state) * Int<W>(sv_->paths.eventCount) + Int<W>(event));
  }
  // A ray that goes on with a slot's path, in place of scatter(): the event by which it left the vertex before, and its
  // RayList::origin. pdf: of its direction, against light samples of media; 0: these have all, HUGE_VALF: it does.
  void goOn(uint32_t slot, const float o[3], const float d[3], float radius, float spread, uint32_t event,
            uint32_t origin, float pdf) {
    const Rays& r = g_->paths.rays;
    for (int k = 0; k < 3; ++k) {
      r.o[k][slot] = o[k];
      r.d[k][slot] = d[k];
    }
    r.tMax[slot] = 1e30f;
    r.radius[slot] = radius;
    r.spread[slot] = spread;
    state[slot] = stepState(sv_->paths, state[slot], event);
    g_->paths.origin[slot] = origin;
    if (againstLights_) againstLights_[slot] = pdf;
    live[count++] = slot;
  }

  float* throughput[3];
  uint32_t* state;            // PathStates: of camera paths the state, of light paths the tail
  uint32_t* light = nullptr;  // where light paths began, by slot
  uint32_t* live;             // slots of the paths that live
  uint32_t count = 0;

 private:
  float* floats(uint32_t n) const { return static_cast<float*>(sv_->alloc(g_, (n + kPad) * sizeof(float))); }
  uint32_t* words(uint32_t n) const { return static_cast<uint32_t*>(sv_->alloc(g_, (n + kPad) * sizeof(uint32_t))); }
  // Of lights met, those of rays with such origins.
  template <class IsWanted>
  void contributeAs(LightKind kind, const LightHits& h, uint32_t depth, const float* weight,
                    const IsWanted& isWanted) const {
    float* value[3] = {floats(h.count), floats(h.count), floats(h.count)};
    uint32_t* at = words(h.count);
    for (uint32_t i = 0; i < h.count; ++i) {
      const uint32_t s = h.slot[i], origin = g_->paths.origin[s];
      const float factor = depth == 0 ? 1.f : origin & kFromSpecular ? h.specular[i] : h.diffuse[i];
      const float w = isWanted(origin) ? weight[i] * factor : 0.f;
      const bool isSpecular = depth && origin & kFromSpecular && h.specularRadiance[0];
      const float* const* radiance = isSpecular ? h.specularRadiance : h.radiance;
      for (int k = 0; k < 3; ++k) value[k][i] = throughput[k][s] * radiance[k][i] * w;
      at[i] = state[s];
    }
    const Contributions out{h.count, h.slot, {value[0], value[1], value[2]}, at, h.light, kind};
    sv_->contribute(g_, &out);
  }
  // Light paths share sample indices and dimensions with the camera paths that they are connected to.
  uint32_t dimension(uint32_t depth) const {
    return dimensionAt(depth) | (traits_ & kTraitLightPath ? kOwnIndex : 0);
  }

  Group* g_;
  const Services* sv_;
  uint32_t traits_;
  Roulette roulette_;
  const float* factor_[2] = {};  // of the lights that paths began at, by slot
  float* medium_[3];
  float* againstLights_ = nullptr;  // RayList::againstLights; null where nothing in space emits
  float* began_ = nullptr;          // largest component of the throughput that light paths began with, by slot
};

// Light on its way to points of contexts of one depth: values, each behind one of the shadow rays. What does not fit
// sends the rest ahead. Made once a group: its arrays are half a megabyte.
template <int W>
class Arrivals {
 public:
  Arrivals(Group* group, const Services* services, uint32_t rays = 4096, uint32_t values = 16384)
      : g_(group), sv_(services), mostRays_(rays), mostValues_(values) {
    for (int k = 0; k < 3; ++k) {
      o_[k] = make<float>(rays);
      d_[k] = make<float>(rays);
      transmittance_[k] = make<float>(rays);
      value_[k] = make<float>(values);
    }
    tMax_ = make<float>(rays);
    spread_ = make<float>(rays);
    time_ = make<float>(rays);
    point_ = make<uint32_t>(rays);
    runs_ = make<ShadowRun>(rays);
    for (uint32_t** x : {&ray_, &slot_, &state_, &light_}) *x = make<uint32_t>(values);
    lightOfRay_ = make<uint32_t>(rays);
    if (group->teaches) broughtBy_ = make<float*>(rays);
  }
  // The points that follow are this context's. brought: by point, where what its rays bring is added up as the mean of
  // the channels, no later than by send(); null: nowhere. Only where paths teach (Group::teaches).
  void of(const Context& context, float* brought = nullptr) {
    c_ = &context;
    brought_ = brought;
  }
  // Begins a ray from a point, in direction d over a distance (0: nothing shadows what comes from there); at most so
  // many values follow that come along it.
  // spread: LightSamples::spread of a light sample; 0: the vertex's own. light: of a light sample, see
  // ShadowRays::light.
  void from(uint32_t point, Vec3<1> d, float distance, uint32_t values, float spread = 0, uint32_t light = kNoLight) {
    const Vec3<1> o = leave(Vec3<1>::load(c_->P, point), Vec3<1>::load(c_->Ng, point), Float<1>(c_->bias[point]), d);
    from(point, o, d, distance * 0.99999f - 2 * c_->bias[point], values, spread, light);
  }
  // The same of a ray that leaves from o, and is so long.
  void from(uint32_t point, Vec3<1> o, Vec3<1> d, float tMax, uint32_t values, float spread, uint32_t light) {
    if (rays_ == mostRays_ || values_ + values > mostValues_) send();
    o.store(o_, rays_);
    d.store(d_, rays_);
    tMax_[rays_] = tMax;
    time_[rays_] = c_->time[point];
    spread_[rays_] = spread;
    lightOfRay_[rays_] = light;
    if (broughtBy_) broughtBy_[rays_] = brought_ ? brought_ + point : nullptr;
    point_[rays_++] = point;
    if (!runCount_ || runs_[runCount_ - 1].context != c_) runs_[runCount_++] = {c_, nullptr, 0};
    runs_[runCount_ - 1].end = rays_;
  }
  void add(Vec3<1> value, uint32_t state, uint32_t light) {
    if (!(maxComponent(value).lane0() > 0)) return;
    value.store(value_, values_);
    ray_[values_] = rays_ - 1;
    slot_[values_] = c_->path[point_[rays_ - 1]];
    state_[values_] = state;
    light_[values_++] = light;
  }
  // The same for the points i, i + 1, ... of lanes `on`; each lane's ray.
  Int<W> from(Mask<W> on, uint32_t i, Vec3<W> d, Float<W> distance, uint32_t values, Float<W> spread = Float<W>(0.f),
              Int<W> light = Int<W>(kNoLight)) {
    if (rays_ + W > mostRays_ || values_ + values * W > mostValues_) send();
    const Float<W> bias = Float<W>::load(c_->bias + i);
    const Packer<W> pack(on);
    leave(Vec3<W>::load(c_->P, i), Vec3<W>::load(c_->Ng, i), bias, d).pack(pack, o_, rays_);
    d.pack(pack, d_, rays_);
    pack.put(distance * Float<W>(0.99999f) - (bias + bias), tMax_ + rays_);
    pack.put(Float<W>::load(c_->time + i), time_ + rays_);
    pack.put(spread, spread_ + rays_);
    pack.put(light, lightOfRay_ + rays_);
    pack.put(Int<W>::lanes(int32_t(i)), point_ + rays_);
    alignas(64) uint32_t ray[W] = {};
    for (uint32_t bits = on.bits(); bits; bits &= bits - 1) {
      const uint32_t lane = uint32_t(__builtin_ctz(bits));
      if (broughtBy_) broughtBy_[rays_] = brought_ ? brought_ + i + lane : nullptr;
      ray[lane] = rays_++;
    }
    if (!runCount_ || runs_[runCount_ - 1].context != c_) runs_[runCount_++] = {c_, nullptr, 0};
    runs_[runCount_ - 1].end = rays_;
    return Int<W>::load(ray);
  }
  void add(Mask<W> on, Vec3<W> value, Int<W> ray, Int<W> slot, Int<W> state, Int<W> light) {
    const Packer<W> pack(on & isThere(value));
    value.pack(pack, value_, values_);
    pack.put(ray, ray_ + values_);
    pack.put(slot, slot_ + values_);
    pack.put(state, state_ + values_);
    pack.put(light, light_ + values_);
    values_ += uint32_t(pack.count);
  }
  // Not black; what is not a number counts, so that the film can report it.
  static KN_INLINE Mask<W> isThere(Vec3<W> v) { return abs(v.x) + abs(v.y) + abs(v.z) != Float<W>(0.f); }
  // Traces the rays and contributes what is left.
  void send() {
    if (values_) {
      const ShadowRays rays{rays_,
                            {o_[0], o_[1], o_[2]},
                            {d_[0], d_[1], d_[2]},
                            tMax_,
                            time_,
                            point_,
                            runCount_,
                            runs_,
                            nullptr,
                            {transmittance_[0], transmittance_[1], transmittance_[2]},
                            spread_,
                            lightOfRay_};
      sv_->shadow(g_, runs_[0].context->depth, &rays);
      for (uint32_t i = 0; broughtBy_ && i < values_; ++i) {
        const uint32_t ray = ray_[i];
        float sum = 0;
        for (int k = 0; k < 3; ++k) sum += value_[k][i] * transmittance_[k][ray];
        if (broughtBy_[ray]) *broughtBy_[ray] += sum * (1.f / 3.f);
      }
      uint32_t n = 0;
      for (uint32_t i = 0; i < values_; i += W) {
        const Mask<W> in = Mask<W>::firstN(int(std::min<uint32_t>(values_ - i, W)));
        const Int<W> ray = select(in, Int<W>::load(ray_ + i), Int<W>(0));
        const Vec3<W> v = Vec3<W>::load(value_, i) * Vec3<W>::gather(transmittance_, ray);
        const Int<W> slot = Int<W>::load(slot_ + i), state = Int<W>::load(state_ + i),
                     light = Int<W>::load(light_ + i);
        const Packer<W> pack(in & isThere(v));
        v.pack(pack, value_, n);
        pack.put(slot, slot_ + n);
        pack.put(state, state_ + n);
        pack.put(light, light_ + n);
        n += uint32_t(pack.count);
      }
      const Contributions out{n, slot_, {value_[0], value_[1], value_[2]}, state_, light_, LightKind::Shadowed};
      sv_->contribute(g_, &out);
    }
    rays_ = values_ = runCount_ = 0;
  }

 private:
  template <class T>
  T* make(uint32_t n) const {
    return static_cast<T*>(sv_->alloc(g_, (n + kPad) * sizeof(T)));
  }
  Group* g_;
  const Services* sv_;
  const Context* c_ = nullptr;
  uint32_t mostRays_, mostValues_;
  float *o_[3], *d_[3], *transmittance_[3], *tMax_, *time_, *spread_, *value_[3];
  uint32_t *point_, *ray_, *slot_, *state_, *light_, *lightOfRay_;
  ShadowRun* runs_;
  float *brought_ = nullptr, **broughtBy_ = nullptr;  // of the context; by ray, null where no path teaches
  uint32_t rays_ = 0, values_ = 0, runCount_ = 0;
};

// Connections of points of a context with vertices of other paths, at most one a point, and what the bxdfs at both
// ends say of them. All in memory of the group.
struct Connections {
  struct End {
    const Context* context;
    uint32_t point;
    const EvaluateArgs* bxdf;  // for the direction back to the point
  };
  uint32_t count;
  const uint32_t* point;  // by connection
  const End* end;         // by connection
  EvaluateArgs bxdf;      // by point of the context, towards the end
  float* d[3];            // by point: unit, towards the end; N where there is no connection
  float* distance;        // by connection

  Connections(Group* g, const Services* services, const Context& c, uint32_t n, const uint32_t* points,
              const VertexRecord* vertices)
      : count(n), point(points) {
    End* ends = c.alloc<End>(n + 1);
    end = ends;
    distance = c.alloc<float>(n + 1);
    for (int k = 0; k < 3; ++k) {
      d[k] = c.alloc<float>(c.padded);
      std::copy_n(c.N[k], c.padded, d[k]);
    }
    Context* const* contexts;
    const uint32_t contextCount = services->shadeVertices(g, n, vertices, &contexts);
    EvaluateArgs* bxdfs = c.alloc<EvaluateArgs>(contextCount + 1);
    for (uint32_t k = 0; k < contextCount; ++k) {
      const Context& e = *contexts[k];
      float* back[3] = {e.alloc<float>(e.padded), e.alloc<float>(e.padded), e.alloc<float>(e.padded)};
      for (uint32_t j = 0; j < e.padded; ++j) {
        const uint32_t r = e.path[j], i = point[r];
        const Vec3<1> between = Vec3<1>::load(e.P, j) - Vec3<1>::load(c.P, i);
        const Float<1> far = max(length(between), Float<1>(1e-18f));
        ends[r] = {&e, std::min(j, e.count - 1), bxdfs + k};
        distance[r] = far.lane0();
        (between / far).store(d, i);
        (-between / far).store(back, j);
      }
      bxdfs[k] = evaluateBxdf(e, back);
    }
    bxdf = evaluateBxdf(c, d);
  }
  // From where a ray leaves a point of the context to where one leaves the other end: what a shadow ray of the connection
  // goes. From off the surface in the direction d it would meet one that it comes to at a low angle before the end.
  Vec3<1> between(const Context& c, uint32_t connection) const {
    const uint32_t i = point[connection], j = end[connection].point;
    const Context& e = *end[connection].context;
    const Vec3<1> w = Vec3<1>::load(d, i);
    return leave(Vec3<1>::load(e.P, j), Vec3<1>::load(e.Ng, j), Float<1>(e.bias[j]), -w) -
           leave(Vec3<1>::load(c.P, i), Vec3<1>::load(c.Ng, i), Float<1>(c.bias[i]), w);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
