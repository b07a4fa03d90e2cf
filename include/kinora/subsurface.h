// Paths below surfaces, for integrators: what generate() flagged kSampleBelow goes in at points of a context and comes
// out elsewhere, by random walks or by the profiles of diffusion (subsurface_profiles.h), many paths at once. Where it
// comes out is a context with a diffuse bxdf of its own, on which light samples are taken and from which paths go on
// (PathLoop in path_loop.h shows it). Random numbers are addressed by path and event: nothing depends on which paths
// are together. Included per target.
//
// A walk: free flights by one channel at a time, chosen by the path's throughput and weighed over all (one-sample
// multiple importance sampling, Veach 1997 chapter 9; the sum of the channels never grows), Henyey-Greenstein
// scattering, Russian roulette. Chiang, Kutz and Burley, "Practical and controllable subsurface scattering for
// production path tracing" (SIGGRAPH talks 2016), is where diffuse entry and exit come from. With an index of the
// boundary (Subsurface::ior) light goes in by the cosine's law of the outside, refracted and weighed by what Fresnel's
// formulas let through, over the mean of that; what arrives from inside is mirrored by chance as they say, always beyond
// the critical angle, or comes out by a cosine's law. Up to a constant that is the transport of a matt surface on a
// dielectric, and so it is reciprocal: n^2 times the densities inside are the transmittances outside.
//
// A profile: a chord through the object beside the point, along the normal or one of two tangents, at a distance taken
// by one of the terms and channels; one of its hits on the object is where light comes out. The density is that of all
// axes, terms and channels together (King, Kulla, Conty and Fajardo, "BSSRDF importance sampling", SIGGRAPH talks 2013).
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
  static KN_INLINE void padPoints(uint32_t m, uint32_t* x) {
    for (uint32_t i = m; i < padded(m); ++i) x[i] = m ? x[m - 1] : 0;
  }

  Group* g_;
  const Services* sv_;
  const SubsurfaceOptions o_;
  const Context* c_ = nullptr;
  uint32_t part_ = 0, parts_ = 1;
  Subsurface below_;
  bool hasTails_ = false;             // some flights are no exponential ones
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
  uint32_t *x[5] = {words(n), words(n), words(n), words(n), words(n)}, *which = words(n);
  float *u = floats(n), *v = floats(n), *time = floats(n), *radius = floats(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i];
    x[0][i] = c.place.instance[p];
    x[1][i] = c.place.geometry[p];
    x[2][i] = c.place.primitive[p];
    x[3][i] = c.sampleSeed[p];
    x[4][i] = c.sampleIndex[p];
    u[i] = c.place.u[p];
    v[i] = c.place.v[p];
    time[i] = c.time[p];
    radius[i] = c.radius[p];
  }
  const SurfacePlaces places{x[0], x[1], x[2], u, v, time, radius, nullptr, x[3], x[4]};
  VertexRecord* records = static_cast<VertexRecord*>(sv_->alloc(g_, (n + kPad) * sizeof(VertexRecord)));
  const uint32_t made = sv_->makeVertices(g_, n, &places, records, which);
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

// Walks are followed a flight at a time, all that are under way together. Where a region is known that the surface does
// not reach into, flights that end within it need no ray. The others wait until they are many: lanes stay filled.
template <int W>
void PathsBelow<W>::walk(uint32_t n, const uint32_t* points, const GenerateArgs& a) {
  const Context& c = *c_;
  Walkers running = makeWalkers(n), waiting = makeWalkers(n);
  hasTails_ = false;
  enters_ = nullptr;
  bool isBounded = false;
  for (uint32_t i = 0; i < n; ++i) {
    hasTails_ |= below_.tail[points[i]] > 0;
    isBounded |= below_.ior[points[i]] > 1;
  }
  padPoints(n, entered_);
  if (isBounded) {
    enters_ = floats(c.padded);
    float ior = 0, lets = 1;
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t p = points[i];
      if (below_.ior[p] != ior) lets = float(diffuseTransmittance(double(ior = below_.ior[p])));
      enters_[p] = lets;
    }
  }
  for (uint32_t i = 0; i < n; i += W) {
    const I p = I::load(points + i);
    Vec3<W> d = Vec3<W>::gather(a.wi, p);
    const Vec3<W> Ng = Vec3<W>::gather(c.Ng, p);
    Rgb<W> beta(1.f);
    if (enters_) refractInto(Ng, p, d, beta);
    const Vec3<W> P = leave(Vec3<W>::gather(c.P, p), Ng, gather(c.bias, p), d);
    const Walker x{P, d, beta, gather(c.time, p), p, I(0), I(1), I(1), addressOf(p)};
    fly(x).store(waiting.flight + i);
    x.store(waiting, i);
  }
  waiting.count = n;
  while (waiting.count + running.count) {
    meetSurface(waiting, running);
    waiting.count = 0;
    while (running.count && running.count >= waiting.count) flyFreely(running, waiting);
  }
}

template <int W>
typename PathsBelow<W>::Walkers PathsBelow<W>::makeWalkers(uint32_t n) const {
  Walkers w;
  for (int k = 0; k < 3; ++k) {
    w.P[k] = floats(n);
    w.d[k] = floats(n);
    w.beta[k] = floats(n);
    w.center[k] = floats(n);
    w.normal[k] = floats(n);
  }
  for (float** x : {&w.time, &w.flight, &w.radius, &w.curvature, &w.offset}) *x = floats(n);
  for (uint32_t** x : {&w.point, &w.boundary, &w.within, &w.step, &w.address}) *x = words(n);
  return w;
}

// The length of the next free flight, by one channel.
template <int W>
KN_INLINE Float<W> PathsBelow<W>::fly(const Walker& x) const {
  const I p = x.point, event = x.step * I(8);
  const Rgb<W> b = x.beta, length = Rgb<W>::gather(below_.length, p);
  const F u = drawEvent(x.address, event) * (b.x + b.y + b.z);
  const Mask<W> first = u < b.x, second = (!first) & (u < b.x + b.y);
  const F own = select(first, length.x, select(second, length.y, length.z));
  const F depth = -log(F(1.f) - drawEvent(x.address, event + I(1)));
  F t = depth * own;
  if (hasTails_) {
    const F tail = gather(below_.tail, p);
    const F power = select(x.boundary != I(0), tail, tail / (F(1.f) + tail));
    t = select(tail > F(0.f), (exp(min(depth * power, F(60.f))) - F(1.f)) * own / tail, t);
  }
  return min(t, F(1e30f));
}

// Multiplies in what each channel made of a way of length t, over what all of them together did.
template <int W>
KN_INLINE void PathsBelow<W>::weigh(Walker& x, F t, Mask<W> met) const {
  const I p = x.point;
  const Rgb<W> length = Rgb<W>::gather(below_.length, p), depth(t / length.x, t / length.y, t / length.z);
  Rgb<W> kept(exp(-depth.x), exp(-depth.y), exp(-depth.z));
  Rgb<W> made(kept.x / length.x, kept.y / length.y, kept.z / length.z);
  if (hasTails_) {
    const F tail = gather(below_.tail, p);
    const Mask<W> heavy = tail > F(0.f), edge = x.boundary != I(0);
    const F slow = F(1.f) / max(tail, F(1e-6f)), power = select(edge, slow, slow + F(1.f));
    const F scale = select(edge, F(1.f), F(1.f) + tail);
    const auto law = [&](F y, F l, F& keeps, F& makes) {
      const F q = log(fma(tail, y, F(1.f)));
      keeps = select(heavy, exp(-(power * q)), keeps);
      makes = select(heavy, scale * exp(-((power + F(1.f)) * q)) / l, makes);
    };
    law(depth.x, length.x, kept.x, made.x);
    law(depth.y, length.y, kept.y, made.y);
    law(depth.z, length.z, kept.z, made.z);
  }
  const F before = x.beta.x + x.beta.y + x.beta.z;
  Rgb<W> b = x.beta * select(met, kept, made);
  const F after = b.x + b.y + b.z;
  b = b * zeroUnless(after > F(0.f), before / max(after, F(1e-37f)));
  x.beta = select(met, b, b * Rgb<W>::gather(below_.albedo, p));
}

// Those that go on where a flight ended: in another direction unless they met a part of the body, by Russian roulette.
template <int W>
KN_INLINE Mask<W> PathsBelow<W>::scatter(Walker& x, Mask<W> met, Mask<W> in) {
  const I p = x.point, event = x.step * I(8);
  const F mu = sampleHenyeyGreenstein(gather(below_.anisotropy, p), drawEvent(x.address, event + I(2)));
  const F r = safeSqrt(fnma(mu, mu, F(1.f)));
  F sinPhi, cosPhi;
  sincos(drawEvent(x.address, event + I(3)) * F(kTwoPi), sinPhi, cosPhi);
  x.d = select(met, x.d, normalize(Frame<W>(x.d).toWorld({r * cosPhi, r * sinPhi, mu})));
  const F most = maxComponent(x.beta);
  // Not below what the surface returns in the mean: dark ones are entered seldom, by paths that are worth much.
  const F mean = clamp(maxComponent(Rgb<W>::gather(below_.surface, p)), F(0.1f), F(1.f));
  const F goesOn = clamp(most / (mean * F(o_.rouletteBelow)), F(0.f), F(1.f));
  in = in & (drawEvent(x.address, event + I(4)) < goesOn);
  x.beta = x.beta * (F(1.f) / max(goesOn, F(1e-30f)));
  x.boundary = select(met, I(1), I(0));
  x.step = x.step + I(1);
  const Mask<W> endless = in & !(x.step < I(o_.mostSteps));
  if (endless.any()) {
    goBack(x, endless);
    in = in & !endless;
  }
  return in;
}

template <int W>
KN_INLINE void PathsBelow<W>::goBack(const Walker& x, Mask<W> lanes) {
  alignas(64) float beta[3][W];
  alignas(64) uint32_t point[W];
  x.beta.x.store(beta[0]);
  x.beta.y.store(beta[1]);
  x.beta.z.store(beta[2]);
  x.point.store(point);
  for (uint32_t bits = lanes.bits(); bits; bits &= bits - 1) {
    const auto k = uint32_t(__builtin_ctz(bits));
    const float own[3] = {beta[0][k], beta[1][k], beta[2][k]};
    goBack(point[k], own, BelowSurface::Endless);
  }
}

// Directions of a cosine's law outside become those inside. They are weighed by what is let through, over its mean.
template <int W>
KN_INLINE void PathsBelow<W>::refractInto(Vec3<W> Ng, I point, Vec3<W>& d, Rgb<W>& beta) const {
  const F ior = gather(below_.ior, point), eta = F(1.f) / ior, along = dot(d, Ng), mu = min(abs(along), F(1.f));
  const Mask<W> bends = ior > F(1.f);
  const F inside = safeSqrt(fnma(eta * eta, fnma(mu, mu, F(1.f)), F(1.f)));
  // the part in the surface shortens, the other is set
  const Vec3<W> bent = (d - Ng * along) * eta + Ng * copySign(inside, along);
  const F through = (F(1.f) - fresnelDielectric(mu, eta)) / gather(enters_, point);
  d = select(bends, normalize(bent), d);
  beta = select(bends, beta * through, beta);
}

// Of the lanes that would come out those that the boundary reflects go on inside.
template <int W>
KN_INLINE Mask<W> PathsBelow<W>::mirror(Walker& x, const ObjectHits& h, uint32_t i, Mask<W> ends) const {
  const F ior = gather(below_.ior, x.point);
  const Vec3<W> Ng = normalize(Vec3<W>::load(h.ng, i));
  const F along = dot(x.d, Ng), mu = min(abs(along), F(1.f));
  const Mask<W> mirrored =
      ends & (ior > F(1.f)) & (drawEvent(x.address, x.step * I(8) + I(5)) < fresnelDielectric(mu, ior));
  const Vec3<W> away = normalize(x.d - Ng * (along + along));
  x.d = select(mirrored, away, x.d);
  // off the surface that it came from within
  x.P = select(mirrored, leave(x.P, Ng, gather(c_->bias, x.point), away), x.P);
  return mirrored;
}

// One flight of all that run, as far as no surface can be in the way. The others, with their flights, wait.
template <int W>
void PathsBelow<W>::flyFreely(Walkers& running, Walkers& waiting) {
  const MemoryMark mark = sv_->markMemory(g_);
  const uint32_t n = running.count;
  // those that leave their region ask for another one, about where they are
  float *P[3] = {floats(n), floats(n), floats(n)}, *reach = floats(n);
  uint32_t *point = words(n), *entry = words(n), asking = 0;
  for (uint32_t i = 0; i < n; i += W) {
    const Walker x = Walker::load(running, i);
    const F t = fly(x);
    t.store(running.flight + i);
    const Region own = Region::load(running, i);
    const Mask<W> asks = Mask<W>::firstN(int(n - i < W ? n - i : W)) & !own.holds(fma(x.d, t, x.P));
    const Packer<W> pack(asks);
    x.P.pack(pack, P, asking);
    const F g = max(gather(below_.anisotropy, x.point), F(0.f));
    const Rgb<W> length = Rgb<W>::gather(below_.length, x.point);
    pack.put((length.x + length.y + length.z) * F(kReach / 3) / (F(1.f) - g), reach + asking);
    pack.put(x.point, point + asking);
    pack.put(I::lanes(i), entry + asking);
    asking += uint32_t(pack.count);
  }
  FreeRegions found{
      {floats(n), floats(n), floats(n)}, floats(n), {floats(n), floats(n), floats(n)}, floats(n), floats(n)};
  if (below_.traceSet && *below_.traceSet)
    for (uint32_t i = 0; i < asking; ++i) found.radius[i] = 0;
  else
    sv_->freeRegions(g_, c_, asking, point, P, reach, &found);
  for (uint32_t i = 0; i < asking; ++i) {
    const uint32_t e = entry[i];
    for (int k = 0; k < 3; ++k) {
      running.center[k][e] = found.center[k][i];
      running.normal[k][e] = found.normal[k][i];
    }
    running.radius[e] = found.radius[i];
    running.curvature[e] = found.curvature[i];
    running.offset[e] = found.offset[i];
  }
  uint32_t open = 0;
  for (uint32_t i = 0; i < n; i += W) {
    Walker x = Walker::load(running, i);
    const F t = F::load(running.flight + i);
    const Region own = Region::load(running, i);
    const Vec3<W> to = fma(x.d, t, x.P);
    const Mask<W> all = Mask<W>::firstN(int(n - i < W ? n - i : W));
    const Mask<W> free = all & own.holds(to);
    const Packer<W> packWaiting(all & !free);
    x.pack(packWaiting, waiting);
    packWaiting.put(t, waiting.flight + waiting.count);
    waiting.count += uint32_t(packWaiting.count);
    if (free.none()) continue;
    weigh(x, t, Mask<W>(false));
    x.P = to;
    const Packer<W> pack(scatter(x, Mask<W>(false), free));
    running.count = open;
    x.pack(pack, running);
    own.pack(pack, running);
    open += uint32_t(pack.count);
  }
  running.count = open;
  padPoints(open, running.point);
  padPoints(waiting.count, waiting.point);
  sv_->releaseMemory(g_, mark);
}

// Flights of those that wait, which may meet the surface: paths come out, or run on.
template <int W>
void PathsBelow<W>::meetSurface(Walkers& waiting, Walkers& running) {
  const Context& c = *c_;
  const MemoryMark mark = sv_->markMemory(g_);
  const uint32_t m = waiting.count;
  const float reach = 8 * sv_->worldRadius;
  float* tMax = floats(m);
  for (uint32_t i = 0; i < m; i += W)
    // the first ray asks whether there is an inside at all
    select(I::load(waiting.step + i) == I(0), F(1e30f), F::load(waiting.flight + i)).store(tMax + i);
  Rays rays{};
  for (int k = 0; k < 3; ++k) {
    rays.o[k] = waiting.P[k];
    rays.d[k] = waiting.d[k];
  }
  rays.tMax = tMax;
  rays.time = waiting.time;
  ObjectHits h{};
  h.most = 1;
  h.nearestOnly = 1;
  h.traceSet = below_.traceSet;
  sv_->hitsOnObject(g_, &c, m, waiting.point, &rays, &h);
  for (uint32_t i = 0; i < m; i += W) {
    Walker x = Walker::load(waiting, i);
    Mask<W> in = Mask<W>::firstN(int(m - i < W ? m - i : W));
    const I p = x.point;
    const F t = F::load(waiting.flight + i);
    const Mask<W> hit = in & (I::load(h.count + i) != I(0));
    const F s = select(hit, F::load(h.t + i), F(1e30f));
    const Mask<W> met = hit & (s <= t);
    const F way = select(met, s, t);
    weigh(x, way, met);
    x.P = fma(x.d, way, x.P);
    if (met.any()) {
      // out, or into another part and out of one, where parts join; from within, the surface is crossed the other way
      const Mask<W> outside = gather(c.entering, p) != I(0);
      const Mask<W> goesOut = (I::load(h.leaves + i) != I(0)) ^ (!outside);
      Mask<W> ends = met;
      if (below_.joins) {
        x.within = select(met, x.within + select(goesOut, I(-1), I(1)), x.within);
        ends = met & !(x.within > I(0));
      }
      Mask<W> mirrored(false);
      if (enters_) {
        mirrored = mirror(x, h, i, ends);
        ends = ends & !mirrored;
        if (below_.joins) x.within = select(mirrored, x.within + I(1), x.within);
      }
      alignas(64) float bs[3][W];
      x.beta.x.store(bs[0]);
      x.beta.y.store(bs[1]);
      x.beta.z.store(bs[2]);
      // flights are as many as scatterings and one, where parts neither join nor reflect
      const Mask<W> kept = below_.leavesOutSingle ? ends & !(x.step == I(1)) : ends;
      for (uint32_t bits = kept.bits(); bits; bits &= bits - 1) {
        const uint32_t k = uint32_t(__builtin_ctz(bits));
        const float own[3] = {bs[0][k], bs[1][k], bs[2][k]};
        comeOut(h, i + k, waiting.point[i + k], own);
      }
      in = in & !ends;
      x.P = select(met & !mirrored, fma(x.d, gather(c.bias, p), x.P), x.P);  // beyond the inner surface
    }
    const Mask<W> none = in & (!hit) & (x.step == I(0));
    for (uint32_t bits = none.bits(); bits; bits &= bits - 1) {
      const uint32_t at = waiting.point[i + uint32_t(__builtin_ctz(bits))];
      const float own[3] = {below_.surface[0][at], below_.surface[1][at], below_.surface[2][at]};
      goBack(at, own, BelowSurface::Open);
    }
    in = in & !none;
    const Vec3<W> from = x.P - Vec3<W>::gather(c.P, p);
    const Mask<W> far = in & !(dot(from, from) < F(reach * reach));
    if (far.any()) {
      goBack(x, far);
      in = in & !far;
    }
    if (in.none()) continue;
    const Packer<W> pack(scatter(x, met, in));
    x.pack(pack, running);
    pack.put(F(0.f), running.radius + running.count);
    running.count += uint32_t(pack.count);
  }
  padPoints(running.count, running.point);
  sv_->releaseMemory(g_, mark);
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
  Rays rays{};
  for (int k = 0; k < 3; ++k) {
    rays.o[k] = o[k];
    rays.d[k] = d[k];
  }
  rays.tMax = tMax;
  rays.time = time;
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

template <int W>
void PathsBelow<W>::probe(uint32_t n, const uint32_t* points) {
  if (!n) return;
  const Context& c = *c_;
  const bool dipoles = below_.model != SubsurfaceModel::Burley;
  for (uint32_t k = 0; k < 3; ++k) {
    for (uint32_t t = 0; t < below_.terms; ++t) spread_[t][k] = floats(c.padded);
    for (float*& x : dipole_[k]) x = dipoles ? floats(c.padded) : nullptr;
  }
  float ior = 0;
  BoundaryMoments moments(1);
  // most points have the albedo of the one before
  float known[3] = {-1, -1, -1};
  Dipole unit[3] = {};
  for (uint32_t j = 0; j < n; ++j) {
    const uint32_t p = points[j];
    if (dipoles && below_.ior[p] != ior) {
      moments = BoundaryMoments(double(ior = below_.ior[p]));
      for (float& a : known) a = -1;
    }
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t t = 0; t < below_.terms; ++t) {
        const float length = below_.term[t].length[k][p], albedo = below_.term[t].albedo[k][p];
        // of dipoles the tail's length is that of the profile's longer exponential
        spread_[t][k][p] = length / (dipoles ? 3.f : burleyScale(albedo));
        if (!dipoles) continue;
        if (albedo != known[k])
          unit[k] = makeDipole(below_.model == SubsurfaceModel::BetterDipole, known[k] = albedo, moments);
        const Dipole d = stretched(unit[k], length);
        const float x[5] = {d.decay, d.depth, d.mirrored, d.flux, d.fluence};
        for (int i = 0; i < 5; ++i) dipole_[k][i][p] = x[i];
      }
  }
  float *o[3], *d[3];
  for (int k = 0; k < 3; ++k) {
    o[k] = floats(n);
    d[k] = floats(n);
  }
  float *tMax = floats(n), *time = floats(n), *pick = floats(n);
  uint32_t* point = words(n);
  for (uint32_t i = 0; i < n; ++i) point[i] = points[i];
  padPoints(n, point);
  for (uint32_t i = 0; i < n; i += W) {
    const I p = I::load(point + i);
    // the term and channel, by what they return
    F sum(0.f);
    const auto part = [&](uint32_t t, uint32_t k) {
      return gather(below_.surface[k], p) * gather(below_.term[t].share[k], p);
    };
    for (uint32_t t = 0; t < below_.terms; ++t)
      for (uint32_t k = 0; k < 3; ++k) sum += part(t, k);
    F rest = draw(p, 0) * sum, spread(0.f);
    Mask<W> open(true);
    for (uint32_t t = 0; t < below_.terms; ++t)
      for (uint32_t k = 0; k < 3; ++k) {
        const F share = part(t, k);
        const Mask<W> here = open & (share > F(0.f));
        spread =
            select(here, gather(spread_[t][k], p), spread);  // of the last that has a share, should rounding say so
        open = open & !(here & (rest < share));
        rest -= share;
      }
    const F r = sampleBurleyProfile(spread, draw(p, 1), draw(p, 2)), farthest = spread * F(kFarthest);
    const F half = safeSqrt(farthest * farthest - r * r);
    F s, co;
    sincos(draw(p, 3) * F(kTwoPi), s, co);
    const Frame<W> f(Vec3<W>::gather(c.Ng, p));
    const F u = draw(p, 4);
    const Mask<W> alongX = u < F(kAxis[0]), alongY = (!alongX) & (u < F(kAxis[0] + kAxis[1]));
    const Vec3<W> axis = select(alongX, f.x, select(alongY, f.y, f.z));
    const Vec3<W> a = select(alongX, f.y, select(alongY, f.z, f.x)),
                  b = select(alongX, f.z, select(alongY, f.x, f.y));
    const Vec3<W> from = fma(axis, half, fma(a, r * co, fma(b, r * s, Vec3<W>::gather(c.P, p))));
    from.store(o, i);
    (-axis).store(d, i);
    select(r < farthest, half + half, F(-1.f)).store(tMax + i);
    gather(c.time, p).store(time + i);
    draw(p, 5).store(pick + i);
  }
  Rays rays{};
  for (int k = 0; k < 3; ++k) {
    rays.o[k] = o[k];
    rays.d[k] = d[k];
  }
  rays.tMax = tMax;
  rays.time = time;
  ObjectHits h{};
  h.most = kMostHits;
  h.traceSet = below_.traceSet;
  sv_->hitsOnObject(g_, &c, n, point, &rays, &h);
  for (uint32_t i = 0; i < n; ++i) {
    if (!h.count[i] || !(tMax[i] > 0)) continue;
    const uint32_t all = h.count[i] < kMostHits ? h.count[i] : kMostHits, chosen = uint32_t(pick[i] * float(all));
    const float beta[3] = {float(all), float(all), float(all)};
    comeOut(h, size_t(i) * kMostHits + (chosen < all ? chosen : all - 1), point[i], beta);
    out_.isInside[out_.count - 1] = c.entering[point[i]] ? 0 : 1;  // on the side where light went in
  }
}

// Multiplies the shares of points where light comes out, which are the numbers of hits on their chords, by the profile
// over the density of all ways to take a chord through the place. point: where it went in; ~0: not by a profile.
template <int W>
void PathsBelow<W>::weighProfiles(const Context& x, const uint32_t* point, float* const beta[3]) const {
  const Context& c = *c_;
  const bool dipoles = below_.model != SubsurfaceModel::Burley;
  for (uint32_t i = 0; i < x.count; i += W) {
    alignas(64) uint32_t at[W];
    uint32_t byProfile = 0;
    for (uint32_t k = 0; k < W; ++k) {
      const bool isOne = i + k < x.count && point[i + k] != ~0u;
      at[k] = isOne ? point[i + k] : 0;
      byProfile |= uint32_t(isOne) << k;
    }
    const I p = I::load(at);
    const Vec3<W> way = Vec3<W>::load(x.P, i) - Vec3<W>::gather(c.P, p), Ng = Vec3<W>::load(x.Ng, i);
    const Frame<W> f(Vec3<W>::gather(c.Ng, p));
    const F r2 = dot(way, way), r = sqrt(r2);
    const Vec3<W> local = f.toLocal(way), n = f.toLocal(Ng);
    const F beside[3] = {safeSqrt(r2 - local.x * local.x), safeSqrt(r2 - local.y * local.y),
                         safeSqrt(r2 - local.z * local.z)};
    const F along[3] = {abs(n.x), abs(n.y), abs(n.z)};
    F density(0.f), sum(0.f), value[3];
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t t = 0; t < below_.terms; ++t) {
        const F share = gather(below_.term[t].share[k], p), part = gather(below_.surface[k], p) * share;
        const F d = gather(spread_[t][k], p);
        sum += part;
        const Mask<W> within = r <= d * F(kFarthest);
        F made(0.f);
        for (int a = 0; a < 3; ++a) made = fma(burleyProfile(d, beside[a]), along[a] * F(kAxis[a]), made);
        density += zeroUnless(within, part * made);
        const auto of = [&](int j) { return gather(dipole_[k][j], p); };
        value[k] += part * (dipoles ? dipoleProfile(of(0), of(1), of(2), of(3), of(4), r) : burleyProfile(d, r));
      }
    const F scale = sum / max(density, F(1e-37f));
    for (uint32_t k = 0; k < 3; ++k) {
      alignas(64) float factor[W];
      (value[k] * zeroUnless(density > F(0.f), scale)).store(factor);
      for (uint32_t l = 0; l < W && i + l < x.count; ++l)
        if (byProfile >> l & 1) beta[k][i + l] *= factor[l];
    }
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

#include <kinora/simd/tables.h>
