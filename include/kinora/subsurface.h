// Paths below surfaces, for integrators: what generate() flagged kSampleBelow goes in at points of a context and comes
// out elsewhere, by random walks (subsurface_walks.h) or by the profiles of diffusion (subsurface_chords.h), many paths at
// once. Where it comes out is a context with a diffuse bxdf of its own, on which light samples are taken and from which
// paths go on (PathLoop in path_loop.h shows it). Random numbers are addressed by path and event: nothing depends on
// which paths are together. Included per target.
#include <kinora/integrator.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>
#include <kinora/subsurface_albedo.h>
#include <kinora/subsurface_profiles.h>

#ifndef KINORA_SUBSURFACE_ONCE
#define KINORA_SUBSURFACE_ONCE
namespace kinora {
struct SubsurfaceOptions {
  uint32_t mostSteps = 8192;  // flights of a walk; what is under way then comes out where it went in, and is counted
  float rouletteBelow = 1;    // throughput, in albedos of the surface, from which Russian roulette is played
};
// Paths that have come out: contexts whose bxdf is diffuse with an albedo of 1, whose events (one slot) are those of
// the lobe that they went in by, and whose Context::path are the entries of the context where they went in.
struct Emerged {
  uint32_t count = 0;
  Context* const* contexts = nullptr;
};
}  // namespace kinora
#endif

#if defined(KINORA_SUBSURFACE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBSURFACE_H_TARGET
#undef KINORA_SUBSURFACE_H_TARGET
#else
#define KINORA_SUBSURFACE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// The n points of a context whose samples go below the surface, medium by medium of the material (Subsurface::which):
// each(which, count, points). They are put in another order; rest: room for n more.
template <class Each>
inline void eachMediumBelow(const GenerateArgs& made, uint32_t n, uint32_t* points, uint32_t* rest,
                            const Each& each) {
  while (n) {
    const uint32_t which = made.flags[points[0]] >> kSampleMediumShift;
    uint32_t taken = 0, left = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (made.flags[points[i]] >> kSampleMediumShift == which)
        points[taken++] = points[i];
      else
        rest[left++] = points[i];
    each(which, taken, points);
    n = left;
    for (uint32_t i = 0; i < n; ++i) points[i] = rest[i];
  }
}

// Light that has come out leaves by a cosine's law.
template <int W>
struct DiffuseExit {
  static void evaluate(const Context* c, const void*, const EvaluateArgs* a) {
    for (uint32_t i = 0; i < c->count; i += W)
      chunk(Vec3<W>::load(c->N, i), Vec3<W>::load(c->Ng, i), Vec3<W>::load(c->wo, i), Vec3<W>::load(a->wi, i), i, a);
  }
  static void evaluateAt(const Context* c, const void*, uint32_t point, uint32_t n, const EvaluateArgs* a) {
    const auto at = [&](const float* const x[3]) {
      return Vec3<W>(Float<W>(x[0][point]), Float<W>(x[1][point]), Float<W>(x[2][point]));
    };
    for (uint32_t i = 0; i < n; i += W) chunk(at(c->N), at(c->Ng), at(c->wo), Vec3<W>::load(a->wi, i), i, a);
  }
  static void generate(const Context* c, const void*, const GenerateArgs* a) {
    using F = Float<W>;
    for (uint32_t i = 0; i < c->count; i += W) {
      const Vec3<W> local = cosineHemisphere(F::load(a->u[0] + i), F::load(a->u[1] + i));
      const Vec3<W> wi = Frame<W>(Vec3<W>::load(c->N, i)).toWorld(local);
      const F f = zeroUnless(dot(Vec3<W>::load(c->Ng, i), wi) > F(0.f), local.z * F(kInvPi));
      wi.store(a->wi, i);
      Rgb<W>(f, f, f).store(a->weight, i);
      f.store(a->pdf + i);
      if (a->pdfReverse) f.store(a->pdfReverse + i);
      select(f > F(0.f), Int<W>(0), Int<W>(kNoLobe)).store(a->slot + i);
      Int<W>(0).store(a->flags + i);
    }
  }
  static const BxdfFunctions* functions() {
    static constexpr BxdfFunctions kFunctions = [] {
      BxdfFunctions f{};
      f.generate = &generate;
      f.evaluate = &evaluate;
      f.evaluateAt = &evaluateAt;
      return f;
    }();
    return &kFunctions;
  }

 private:
  static KN_INLINE void chunk(Vec3<W> N, Vec3<W> Ng, Vec3<W> wo, Vec3<W> wi, uint32_t out, const EvaluateArgs* a) {
    using F = Float<W>;
    const F mu = dot(N, wi);
    const Mask<W> up = (mu > F(0.f)) & (dot(Ng, wi) > F(0.f));
    const F f = zeroUnless(up, mu * F(kInvPi));
    Rgb<W>(f, f, f).store(a->weight[0], out);
    f.store(a->pdf + out);
    if (a->pdfReverse) zeroUnless(up, max(dot(N, wo), F(0.f)) * F(kInvPi)).store(a->pdfReverse + out);
  }
};

// Scattering angle's cosine by Henyey and Greenstein; g 0: even.
template <int W>
KN_INLINE Float<W> sampleHenyeyGreenstein(Float<W> g, Float<W> u) {
  using F = Float<W>;
  const F even = fnma(F(2.f), u, F(1.f));
  const F s = fnma(g, g, F(1.f)) / fma(F(2.f) * g, u, F(1.f) - g);
  const F c = (fma(g, g, F(1.f)) - s * s) / (g + g);
  return select(abs(g) < F(1e-3f), even, clamp(c, F(-1.f), F(1.f)));
}

template <int W>
class PathsBelow {
 public:
  using F = Float<W>;
  using I = Int<W>;
  PathsBelow(Group* group, const Services* services, const SubsurfaceOptions& options = {})
      : g_(group), sv_(services), o_(options) {}

  // n points of a context, whose samples `a` of generate() go below, in the same of its media. `part` of `parts`
  // directions that are followed from each. What became of the paths is multiplied into `throughput`, by entry of
  // c.path.
  Emerged follow(const Context& c, uint32_t which, uint32_t n, const uint32_t* points, const GenerateArgs& a,
                 uint32_t part, uint32_t parts, float* const throughput[3]);

 private:
  // Places where paths come out, in their order of coming: by place, unless they go back to where they went in.
  struct Places {
    uint32_t count = 0;
    uint32_t *instance, *geometry, *primitive, *isInside, *point;
    uint32_t* isStraight;  // 1: it crossed the body
    float *u, *v, *beta[3];
  };
  float* floats(uint32_t n) const { return static_cast<float*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(float))); }
  uint32_t* words(uint32_t n) const {
    return static_cast<uint32_t*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(uint32_t)));
  }
  void begin(const Context& c, uint32_t which, uint32_t n, uint32_t part, uint32_t parts);
  uint32_t enter(uint32_t n, const uint32_t* points);
  // Walks under way, packed.
  struct Walkers {
    uint32_t count = 0;
    float *P[3], *d[3], *beta[3], *time, *flight;
    // a region that the surface does not reach into, as in FreeRegions; radius 0: none that they are in
    float *center[3], *radius, *normal[3], *curvature, *offset;
    uint32_t *point, *step;       // flights so far
    uint32_t* address;            // of random numbers, but for the event
    uint32_t *boundary, *within;  // whether the last event was the boundary; in how many of the joined parts it is
  };
  struct Walker {
    Vec3<W> P, d;
    Rgb<W> beta;
    F time;
    I point, step, boundary, within, address;
    static KN_INLINE Walker load(const Walkers& w, uint32_t i) {
      return {Vec3<W>::load(w.P, i),   Vec3<W>::load(w.d, i), Rgb<W>::load(w.beta, i),
              F::load(w.time + i),     I::load(w.point + i),  I::load(w.step + i),
              I::load(w.boundary + i), I::load(w.within + i), I::load(w.address + i)};
    }
    KN_INLINE void store(Walkers& w, uint32_t i) const {
      P.store(w.P, i);
      d.store(w.d, i);
      beta.store(w.beta, i);
      time.store(w.time + i);
      point.store(w.point + i);
      step.store(w.step + i);
      boundary.store(w.boundary + i);
      within.store(w.within + i);
      address.store(w.address + i);
    }
    // behind those that are there
    KN_INLINE void pack(const Packer<W>& k, Walkers& w) const {
      P.pack(k, w.P, w.count);
      d.pack(k, w.d, w.count);
      beta.pack(k, w.beta, w.count);
      k.put(time, w.time + w.count);
      k.put(point, w.point + w.count);
      k.put(step, w.step + w.count);
      k.put(boundary, w.boundary + w.count);
      k.put(within, w.within + w.count);
      k.put(address, w.address + w.count);
    }
  };
  // Of one walker: where it may fly without a ray.
  struct Region {
    Vec3<W> center, normal;
    F radius, curvature, offset;
    static KN_INLINE Region load(const Walkers& w, uint32_t i) {
      return {Vec3<W>::load(w.center, i), Vec3<W>::load(w.normal, i), F::load(w.radius + i), F::load(w.curvature + i),
              F::load(w.offset + i)};
    }
    KN_INLINE void pack(const Packer<W>& k, Walkers& w) const {
      center.pack(k, w.center, w.count);
      normal.pack(k, w.normal, w.count);
      k.put(radius, w.radius + w.count);
      k.put(curvature, w.curvature + w.count);
      k.put(offset, w.offset + w.count);
    }
    KN_INLINE Mask<W> holds(Vec3<W> x) const {
      const Vec3<W> from = x - center;
      const F square = dot(from, from);
      return (square < radius * radius) & (fma(curvature, square, dot(from, normal)) < offset);
    }
  };
  Walkers makeWalkers(uint32_t n) const;
  KN_INLINE F fly(const Walker& x) const;
  KN_INLINE void weigh(Walker& x, F t, Mask<W> met) const;
  KN_INLINE Mask<W> scatter(Walker& x, Mask<W> met, Mask<W> in);
  KN_INLINE void goBack(const Walker& x, Mask<W> lanes);
  KN_INLINE void refractInto(Vec3<W> Ng, I point, Vec3<W>& d, Rgb<W>& beta) const;
  KN_INLINE Mask<W> mirror(Walker& x, const ObjectHits& h, uint32_t i, Mask<W> ends) const;
  void flyFreely(Walkers& running, Walkers& waiting);
  void meetSurface(Walkers& waiting, Walkers& running);
  void walk(uint32_t n, const uint32_t* points, const GenerateArgs& a);
  void probe(uint32_t n, const uint32_t* points);
  void cross(uint32_t n, const uint32_t* points, const GenerateArgs& a);
  void weighProfiles(const Context& x, const uint32_t* point, float* const beta[3]) const;
  void followTopology(const Context& x, const uint32_t* from, float* const beta[3]) const;
  void comeOut(const ObjectHits& h, size_t hit, uint32_t point, const float beta[3]);
  void goBack(uint32_t point, const float beta[3], BelowSurface why);
  Emerged finish(uint32_t slot, float* const throughput[3]);
  // drawHashed(), of which what is the same for all events is hashed once
  KN_INLINE I addressOf(I point) const {
    const Context& c = *c_;
    const I sample = gather(c.sampleIndex, point) * I(parts_) + I(part_);
    return hashWords(hashWords(gather(c.sampleSeed, point), sample),
                     I((dimensionAt(c.depth) + kDimBelow) ^ 0xA511E9B3u));
  }
  static KN_INLINE F drawEvent(I address, I event) { return toUnitFloat(hashWords(address, event)); }
  KN_INLINE F draw(I point, uint32_t event) const { return drawEvent(addressOf(point), I(event)); }
  // Of the medium at a walk's point of entry. Most bodies have the same everywhere, which takes no gathers.
  KN_INLINE F numberAt(const float* x, I point) const { return isEven_ ? F(x[first_]) : gather(x, point); }
  KN_INLINE Rgb<W> colorAt(float* const x[3], I point) const {
    return {numberAt(x[0], point), numberAt(x[1], point), numberAt(x[2], point)};
  }
  static KN_INLINE void padPoints(uint32_t m, uint32_t* x) {
    for (uint32_t i = m; i < padded(m); ++i) x[i] = m ? x[m - 1] : 0;
  }

  Group* g_;
  const Services* sv_;
  const SubsurfaceOptions o_;
  const Context* c_ = nullptr;
  uint32_t part_ = 0, parts_ = 1;
  Subsurface below_;
  bool hasTails_ = false;  // some flights are no exponential ones
  bool isEven_ = false;    // lengths, albedos and mean cosines are the same at all points, as at first_
  uint32_t first_ = 0;
  bool hasProfiles_ = false;          // some paths come out by a profile
  float* enters_ = nullptr;           // by point: what the boundary lets in of diffuse light; null: there is none
  uint32_t* entered_;                 // points on what can have an inside
  Places out_;                        // found places
  uint32_t back_ = 0, *backPoint_;    // paths that come out where they went in
  uint32_t *lost_[2], lostCount_[2];  // their points, by BelowSurface
  float* backBeta_[3];
  // of profiles, by term, channel and point: the length of the density, and dipoles
  float *spread_[kMaxSubsurfaceTerms][3], *dipole_[3][5];
  static constexpr float kReach = 8;                       // mean free paths that regions are asked for with
  static constexpr uint32_t kMostHits = 16;                // of a chord; of more the farthest are not seen
  static constexpr float kFarthest = 30;                   // of a profile, in lengths: 3e-5 of it are beyond
  static constexpr float kAxis[3] = {0.25f, 0.25f, 0.5f};  // shares of the two tangents and of the normal
};

template <int W>
void PathsBelow<W>::begin(const Context& c, uint32_t which, uint32_t n, uint32_t part, uint32_t parts) {
  c_ = &c;
  below_.which = which;
  part_ = part;
  parts_ = parts;
  const auto f = [&] { return floats(c.padded); };
  for (int k = 0; k < 3; ++k) {
    below_.surface[k] = f();
    below_.albedo[k] = f();
    below_.length[k] = f();
    for (SubsurfaceTerm& t : below_.term) {
      t.share[k] = f();
      t.albedo[k] = f();
      t.length[k] = f();
    }
    out_.beta[k] = floats(n);
    backBeta_[k] = floats(n);
  }
  below_.anisotropy = f();
  below_.tail = f();
  below_.ior = f();
  below_.topology = f();
  c.bxdf->subsurface(&c, c.closure, &below_);
  for (uint32_t** x : {&out_.instance, &out_.geometry, &out_.primitive, &out_.isInside, &out_.point, &out_.isStraight,
                       &backPoint_, &lost_[0], &lost_[1]})
    *x = words(n);
  out_.u = floats(n);
  out_.v = floats(n);
  out_.count = back_ = lostCount_[0] = lostCount_[1] = 0;
}

// Curves, points and user geometry have no inside: no vertex can be made on them.
template <int W>
uint32_t PathsBelow<W>::enter(uint32_t n, const uint32_t* points) {
  const Context& c = *c_;
  entered_ = words(n);
  const MemoryMark mark = sv_->markMemory(g_);
  uint32_t *x[3] = {words(n), words(n), words(n)}, *which = words(n);
  float *u = floats(n), *v = floats(n), *time = floats(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i];
    x[0][i] = c.place.instance[p];
    x[1][i] = c.place.geometry[p];
    x[2][i] = c.place.primitive[p];
    u[i] = c.place.u[p];
    v[i] = c.place.v[p];
    time[i] = c.time[p];
  }
  SurfacePlaces places{};
  places.instance = x[0];
  places.geometry = x[1];
  places.primitive = x[2];
  places.u = u;
  places.v = v;
  places.time = time;
  const uint32_t made = sv_->makeVertices(g_, n, &places, nullptr, which);
  uint32_t next = 0;
  for (uint32_t i = 0; i < n; ++i) {
    if (next < made && which[next] == i) {
      entered_[next++] = points[i];
      continue;
    }
    const uint32_t p = points[i];
    const float own[3] = {below_.surface[0][p], below_.surface[1][p], below_.surface[2][p]};
    goBack(p, own, BelowSurface::Open);
  }
  sv_->releaseMemory(g_, mark);
  return made;
}

template <int W>
void PathsBelow<W>::comeOut(const ObjectHits& h, size_t hit, uint32_t point, const float beta[3]) {
  const uint32_t k = out_.count++;
  out_.instance[k] = h.instance[hit];
  out_.geometry[k] = h.geometry[hit];
  out_.primitive[k] = h.primitive[hit];
  out_.isInside[k] = h.leaves[hit] ? 0 : 1;
  out_.u[k] = h.u[hit];
  out_.v[k] = h.v[hit];
  out_.point[k] = point;
  out_.isStraight[k] = 0;
  for (int c = 0; c < 3; ++c) out_.beta[c][k] = beta[c];
}

template <int W>
void PathsBelow<W>::goBack(uint32_t point, const float beta[3], BelowSurface why) {
  backPoint_[back_] = point;
  for (int c = 0; c < 3; ++c) backBeta_[c][back_] = beta[c];
  ++back_;
  lost_[uint32_t(why)][lostCount_[uint32_t(why)]++] = point;
}

// Straight ways through the body: what is left of light over their length. Where parts are joined, to the last of the
// surfaces on the way; where there is none, nothing passes.
template <int W>
void PathsBelow<W>::cross(uint32_t n, const uint32_t* points, const GenerateArgs& a) {
  if (!n) return;
  const Context& c = *c_;
  float *o[3] = {floats(n), floats(n), floats(n)}, *d[3] = {floats(n), floats(n), floats(n)}, *tMax = floats(n),
        *time = floats(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i];
    const Vec3<1> way(a.wi[0][p], a.wi[1][p], a.wi[2][p]);
    const Vec3<1> start = leave(Vec3<1>(c.P[0][p], c.P[1][p], c.P[2][p]), Vec3<1>(c.Ng[0][p], c.Ng[1][p], c.Ng[2][p]),
                                Float<1>(c.bias[p]), way);
    const float x[3] = {start.x.lane0(), start.y.lane0(), start.z.lane0()};
    for (int k = 0; k < 3; ++k) {
      o[k][i] = x[k];
      d[k][i] = a.wi[k][p];
    }
    tMax[i] = 1e30f;
    time[i] = c.time[p];
  }
  const Rays rays = raysAlong(o, d, tMax, time);
  ObjectHits h{};
  h.most = below_.joins ? kMostHits : 1;
  h.nearestOnly = 1;
  h.traceSet = below_.traceSet;
  sv_->hitsOnObject(g_, &c, n, points, &rays, &h);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i];
    uint32_t last = h.count[i];
    while (last && below_.joins && (h.leaves[size_t(i) * h.most + last - 1] != 0) != (c.entering[p] != 0)) --last;
    if (!last) {
      const float none[3] = {0, 0, 0};
      goBack(p, none, BelowSurface::Open);
      continue;
    }
    const size_t at = size_t(i) * h.most + last - 1;
    float kept[3];
    for (int k = 0; k < 3; ++k) kept[k] = exp(Float<1>(-h.t[at] / below_.term[0].length[k][p])).lane0();
    comeOut(h, at, p, kept);
    out_.isStraight[out_.count - 1] = 1;
  }
}

// Takes off what is lost where the surface turns away from where paths went in (Subsurface::topology, comesOutBehind).
template <int W>
void PathsBelow<W>::followTopology(const Context& x, const uint32_t* from, float* const beta[3]) const {
  const Context& c = *c_;
  for (uint32_t i = 0; i < x.count; ++i) {
    const uint32_t p = from[i];
    if (p == ~0u || !(below_.topology[p] > 0 || !below_.comesOutBehind)) continue;
    float cosine = 0;
    for (int k = 0; k < 3; ++k) cosine += x.Ng[k][i] * c.Ng[k][p];
    const bool isLost = !below_.comesOutBehind && !(cosine > 0);
    const float kept = isLost ? 0.f : 1 - below_.topology[p] * (1 - (cosine > 0 ? cosine : 0));
    for (int k = 0; k < 3; ++k) beta[k][i] *= kept;
  }
}

// Vertices where paths come out, in one list with those where they went in.
template <int W>
Emerged PathsBelow<W>::finish(uint32_t slot, float* const throughput[3]) {
  const Context& c = *c_;
  const uint32_t n = out_.count, most = n + back_;
  VertexRecord* records = static_cast<VertexRecord*>(sv_->alloc(g_, (most + n + kPad) * sizeof(VertexRecord)));
  uint32_t *which = words(n), *point = words(most + n), *isStraight = words(n), made = 0;
  float* beta[3] = {floats(most + n), floats(most + n), floats(most + n)};
  if (n) {
    float *time = floats(n), *radius = floats(n);
    uint32_t *seed = words(n), *index = words(n);
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t p = out_.point[i];
      time[i] = c.time[p];
      radius[i] = c.radius[p];
      seed[i] = c.sampleSeed[p];
      index[i] = c.sampleIndex[p];
    }
    const SurfacePlaces places{out_.instance, out_.geometry, out_.primitive, out_.u, out_.v, time,
                               radius,        out_.isInside, seed,           index,  &c,     out_.point};
    made = sv_->makeVertices(g_, n, &places, records, which);
    uint32_t next = 0;
    for (uint32_t i = 0; i < made; ++i) {
      const uint32_t from = which[i];
      point[i] = out_.point[from];
      isStraight[i] = out_.isStraight[from];
      for (int k = 0; k < 3; ++k) beta[k][i] = out_.beta[k][from];
    }
    // on curves there are no places
    for (uint32_t i = 0; i < n; ++i) {
      if (next < made && which[next] == i) {
        ++next;
        continue;
      }
      const uint32_t p = out_.point[i];
      const float own[3] = {below_.surface[0][p], below_.surface[1][p], below_.surface[2][p]};
      goBack(p, own, BelowSurface::Open);
    }
  }
  if (back_) {
    sv_->keepVertices(g_, &c, back_, backPoint_, records + made);
    for (uint32_t i = 0; i < back_; ++i) {
      point[made + i] = backPoint_[i];
      for (int k = 0; k < 3; ++k) beta[k][made + i] = backBeta_[k][i];
    }
  }
  for (uint32_t why = 0; why < 2; ++why)
    if (lostCount_[why]) sv_->noteBelow(g_, &c, lostCount_[why], lost_[why], BelowSurface(why));
  Emerged out;
  const uint32_t total = made + back_;
  if (!total) return out;
  Context* const* contexts;
  out.count = sv_->shadeVertices(g_, total, records, &contexts);
  Context** own = static_cast<Context**>(sv_->alloc(g_, out.count * sizeof(Context*)));
  static constexpr uint8_t kSlot[kMaxLobes] = {};
  for (uint32_t k = 0; k < out.count; ++k) {
    const Context& x = *contexts[k];
    Context& y = *static_cast<Context*>(sv_->alloc(g_, sizeof(Context)));
    y = x;
    uint32_t* path = words(x.padded);
    uint16_t* event = static_cast<uint16_t*>(sv_->alloc(g_, sizeof(uint16_t)));
    *event = c.eventOfSlot[slot];
    float* share[3] = {floats(x.padded), floats(x.padded), floats(x.padded)};
    uint32_t* from = words(x.padded);
    for (uint32_t i = 0; i < x.padded; ++i) {
      const uint32_t r = x.path[i];
      path[i] = c.path[point[r]];
      if (i >= x.count) continue;
      for (int j = 0; j < 3; ++j) share[j][i] = beta[j][r];
      from[i] = r < made && !isStraight[r] ? point[r] : ~0u;
    }
    if (hasProfiles_) weighProfiles(x, from, share);
    followTopology(x, from, share);
    for (uint32_t i = 0; i < x.count; ++i)
      for (int j = 0; j < 3; ++j) throughput[j][path[i]] *= share[j][i];
    y.path = path;
    y.bxdf = DiffuseExit<W>::functions();
    y.closure = nullptr;
    y.lobeCount = y.slotCount = 1;
    y.slotOfLobe = kSlot;
    y.eventOfSlot = event;
    y.tintedSlots = 0;
    y.traits = (y.traits & ~(kTraitEncloses | kTraitTinted)) | kTraitComesOut;
    own[k] = &y;
  }
  out.contexts = own;
  return out;
}

template <int W>
Emerged PathsBelow<W>::follow(const Context& c, uint32_t which, uint32_t n, const uint32_t* points,
                              const GenerateArgs& a, uint32_t part, uint32_t parts, float* const throughput[3]) {
  if (!n || !c.bxdf->subsurface) return {};
  const uint32_t slot = a.slot[points[0]];
  begin(c, which, n, part, parts);
  n = enter(n, points);
  points = entered_;
  uint32_t *straight = words(n), crossing = 0, turning = 0;
  for (uint32_t i = 0; i < n; ++i) {
    if (a.flags[points[i]] & kSampleStraight)
      straight[crossing++] = points[i];
    else
      entered_[turning++] = points[i];
  }
  n = turning;
  padPoints(crossing, straight);
  cross(crossing, straight, a);
  hasProfiles_ = below_.model != SubsurfaceModel::Walk && n;
  if (below_.model == SubsurfaceModel::Walk)
    walk(n, points, a);
  else
    probe(n, points);
  return finish(slot, throughput);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/subsurface_chords.h>
#include <kinora/subsurface_walks.h>
#include <kinora/simd/tables.h>
