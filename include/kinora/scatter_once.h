// Paths that scatter exactly once below a surface (kSampleOnce), for integrators: what generate() flagged goes in
// refracted, a place where it scatters is taken along that ray, and from there straight lines lead through the surface
// to lights, or on into the scene. Used as PathLoop (path_loop.h) shows: light samples are taken at a context in space,
// whose bxdf is the phase function; their shadow rays are then moved to where they leave the body. Included per target.
//
// The way out is the first order of refraction (Jensen, Marschner, Levoy and Hanrahan, "A practical model for subsurface
// light transport", SIGGRAPH 2001): the surface is looked for straight ahead, and there the light is bent:
// from the cosine m outside and the cosine m' that Snell's law makes of it inside follow the length inside, s m / m', the
// scattering angle, what Fresnel lets in, and the solid angle, which m / (n^2 m') makes of that outside. Under a plane
// and a light far away that is exact. What the surface reflects inside is not followed.
//
// Paths that pass unscattered (kSampleStraight) go on where that ray leaves the body: bent by Snell's law at the surface
// there, or at a facet of it, weighed by Beer and Lambert's law for the way, by Fresnel's transmittance and by n^2, which
// undoes the 1 / n^2 of radiance that went in. What is totally reflected there is lost.
#include <kinora/integrator.h>
#include <kinora/math/microfacet.h>
#include <kinora/math/sampling.h>
#include <kinora/random.h>
#include <kinora/ray_start.h>
#include <kinora/subsurface.h>

#if defined(KINORA_SCATTER_ONCE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SCATTER_ONCE_H_TARGET
#undef KINORA_SCATTER_ONCE_H_TARGET
#else
#define KINORA_SCATTER_ONCE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Henyey and Greenstein's phase function, per solid angle; g in (-1, 1).
template <int W>
KN_INLINE Float<W> henyeyGreenstein(Float<W> g, Float<W> cosine) {
  using F = Float<W>;
  const F q = fma(g, g, F(1.f)) - F(2.f) * g * cosine;
  return fnma(g, g, F(1.f)) * F(kInvTwoPi * 0.5f) / (q * sqrt(max(q, F(1e-9f))));
}

template <int W>
class ScatterOnce {
 public:
  using F = Float<W>;
  using I = Int<W>;
  ScatterOnce(Group* group, const Services* services) : g_(group), sv_(services) {}

  // Takes the places of n points of a context; false where there is none. What the flights are worth is multiplied into
  // `throughput`, by entry of c.path. Points whose samples are kSampleStraight are left to pass().
  bool scatter(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a, uint32_t part,
               uint32_t parts, float* const throughput[3]);
  // Paths that go on behind the body: where they leave it in space, by context; their number, and by path the entry of
  // c.path, the origin and the direction.
  struct Passed {
    uint32_t count = 0;
    Context at;
    uint32_t *point, *path;
    float *o[3], *d[3];
  };
  // Of n points of a context whose samples are kSampleStraight, as scatter().
  Passed pass(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a, uint32_t part,
              uint32_t parts, float* const throughput[3]);
  // Where they are: in space, of one slot, for light samples alone.
  const Context& context() const { return at_; }
  // Rays from points of context(), in these directions: each is moved to where it leaves the body, and tMax (null: there
  // is none) is shortened by that. `factor` gets what is left of their light there, 0 where it does not leave. share: of
  // a light sample where directions() find lights too, which they do not within the body; null: 1.
  void leaveBody(uint32_t n, const uint32_t* points, float* const o[3], const float* const d[3], float* tMax,
                 const float* share, float* const factor[3]) const;
  // Directions by the phase function, one for each point of context(): d, the points themselves, packed, and densities.
  uint32_t directions(uint32_t* points, float* const o[3], float* const d[3], float* pdf) const;
  float bias(uint32_t point) const { return in_->bias[entered_[point]]; }

 private:
  struct Phase {
    const float *anisotropy, *d[3];  // by point: the mean cosine, and where light scattered there is seen along
  };
  static void evaluate(const Context* c, const void* closure, const EvaluateArgs* a) {
    const Phase& p = *static_cast<const Phase*>(closure);
    for (uint32_t i = 0; i < c->count; i += W)
      store(F::load(p.anisotropy + i), Vec3<W>::load(p.d, i), Vec3<W>::load(a->wi, i), i, a);
  }
  static void evaluateAt(const Context*, const void* closure, uint32_t point, uint32_t n, const EvaluateArgs* a) {
    const Phase& p = *static_cast<const Phase*>(closure);
    const Vec3<W> d(F(p.d[0][point]), F(p.d[1][point]), F(p.d[2][point]));
    for (uint32_t i = 0; i < n; i += W) store(F(p.anisotropy[point]), d, Vec3<W>::load(a->wi, i), i, a);
  }
  // light comes from wi and goes on to the camera, against d: its direction turns by the angle between d and wi
  static KN_INLINE void store(F g, Vec3<W> d, Vec3<W> wi, uint32_t i, const EvaluateArgs* a) {
    const F f = henyeyGreenstein<W>(g, dot(d, wi));
    Rgb<W>(f, f, f).store(a->weight[0], i);
    f.store(a->pdf + i);
    if (a->pdfReverse) f.store(a->pdfReverse + i);
  }
  static const BxdfFunctions* functions() {
    static constexpr BxdfFunctions kFunctions = [] {
      BxdfFunctions f{};
      f.evaluate = &evaluate;
      f.evaluateAt = &evaluateAt;
      return f;
    }();
    return &kFunctions;
  }
  float* floats(uint32_t n) const { return static_cast<float*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(float))); }
  uint32_t* words(uint32_t n) const {
    return static_cast<uint32_t*>(sv_->alloc(g_, (padded(n) + kPad) * sizeof(uint32_t)));
  }
  float draw(uint32_t point, uint32_t event) const {
    const Context& c = *in_;
    const uint32_t sample = c.sampleIndex[point] * parts_ + part_;
    const Int<1> address = hashWords(hashWords(Int<1>(c.sampleSeed[point]), Int<1>(sample)),
                                     Int<1>((dimensionAt(c.depth) + kDimBelow) ^ 0x3C6EF372u));
    return toUnitFloat(hashWords(address, Int<1>(event))).lane0();
  }
  void begin(const Context& c, uint32_t part, uint32_t parts) {
    in_ = &c;
    part_ = part;
    parts_ = parts;
    Subsurface below{};
    for (float*& l : below.single.length) l = floats(c.padded);
    below.single.anisotropy = floats(c.padded);
    below.single.ior = floats(c.padded);
    below.single.alpha = floats(c.padded);
    c.bxdf->subsurface(&c, c.closure, &below);
    medium_ = below.single;
    comesOutBehind_ = below.comesOutBehind;
  }
  // Rays from n points of a context, that go in.
  void rays(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a, float* const o[3],
            float* const d[3]) const {
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t p = points[i];
      const Vec3<1> way(a.wi[0][p], a.wi[1][p], a.wi[2][p]), Ng(c.Ng[0][p], c.Ng[1][p], c.Ng[2][p]);
      const Vec3<1> start = leave(Vec3<1>(c.P[0][p], c.P[1][p], c.P[2][p]), Ng, Float<1>(c.bias[p]), way);
      const float x[3] = {start.x.lane0(), start.y.lane0(), start.z.lane0()};
      for (int k = 0; k < 3; ++k) {
        o[k][i] = x[k];
        d[k][i] = a.wi[k][p];
      }
    }
  }
  // Ray i of rays(), of point p, as entry m of a list.
  void addRay(RayList& list, uint32_t m, uint32_t p, uint32_t i, float* const o[3], float* const d[3],
              float tMax) const {
    for (int k = 0; k < 3; ++k) {
      list.rays.o[k][m] = o[k][i];
      list.rays.d[k][m] = d[k][i];
    }
    list.rays.tMax[m] = tMax;
    list.rays.time[m] = in_->time[p];
    list.rays.radius[m] = in_->radius[p];
    list.rays.spread[m] = in_->spread[p];
  }
  // Of m rays that left the points `from`, places at the distances t.
  Context placesOn(RayList& list, uint32_t m, const uint32_t* from, const float* t) const {
    uint32_t* entry = words(m);
    for (uint32_t i = 0; i < padded(m); ++i) entry[i] = i < m ? i : m - 1;
    sv_->leave(g_, &list, in_, m, from, entry, nullptr);
    return *sv_->pointsInSpace(g_, &list, kTraitEyePath | kTraitComesOut, in_->depth, m, entry, t);
  }
  // Straight ways out of the bodies of the points where paths went in: whether there is one, where it ends, the length
  // of it that is within, and the normal there.
  struct Ways {
    const uint32_t* found;
    const float *t, *within, *ng[3];
    ObjectHits all;
  };
  Ways ways(uint32_t n, const uint32_t* entered, const float* const o[3], const float* const d[3]) const {
    const ObjectHits h = hits(n, entered, o, d);
    if (h.most == 1) return {h.count, h.t, h.t, {h.ng[0], h.ng[1], h.ng[2]}, h};
    uint32_t* found = words(n);
    float *t = floats(n), *within = floats(n), *ng[3] = {floats(n), floats(n), floats(n)};
    for (uint32_t i = 0; i < n; ++i) {
      found[i] = 0;
      float inside = 0;
      int depth = 1;
      for (uint32_t k = 0; k < h.count[i]; ++k) {
        const size_t at = size_t(i) * h.most + k;
        const float from = k ? h.t[at - 1] : 0.f;
        if (depth > 0) inside += h.t[at] - from;
        depth += isExit(h, at, entered[i]) ? -1 : 1;
        // the last exit, or the nearest surface where there is none
        if (found[i] && !(isExit(h, at, entered[i]) && depth <= 0)) continue;
        found[i] = 1;
        t[i] = h.t[at];
        within[i] = medium_.skipsGaps ? inside : t[i];
        for (int c = 0; c < 3; ++c) ng[c][i] = h.ng[c][at];
      }
    }
    return {found, t, within, {ng[0], ng[1], ng[2]}, h};
  }
  bool isExit(const ObjectHits& h, size_t at, uint32_t entered) const {
    return (h.leaves[at] != 0) == (in_->entering[entered] != 0);
  }
  // Where on the way of a ray so much of it lies within the body.
  float placeOn(const Ways& w, uint32_t i, uint32_t entered, float within) const {
    if (w.all.most == 1 || !medium_.skipsGaps) return within;
    int depth = 1;
    for (uint32_t k = 0; k < w.all.count[i]; ++k) {
      const size_t at = size_t(i) * w.all.most + k;
      const float from = k ? w.all.t[at - 1] : 0.f, length = w.all.t[at] - from;
      if (depth > 0) {
        if (within <= length) return from + within;
        within -= length;
      }
      depth += isExit(w.all, at, entered) ? -1 : 1;
    }
    return w.t[i];
  }
  // The nearest hits of rays on the bodies of the points where paths went in.
  ObjectHits hits(uint32_t n, const uint32_t* entered, const float* const o[3], const float* const d[3]) const {
    float *tMax = floats(n), *time = floats(n);
    for (uint32_t i = 0; i < n; ++i) {
      tMax[i] = 1e30f;
      time[i] = in_->time[entered[i]];
    }
    Rays rays{};
    for (int k = 0; k < 3; ++k) {
      rays.o[k] = const_cast<float*>(o[k]);
      rays.d[k] = const_cast<float*>(d[k]);
    }
    rays.tMax = tMax;
    rays.time = time;
    ObjectHits h{};
    h.most = 1 + medium_.mostPassed;
    h.nearestOnly = 1;
    h.traceSet = medium_.traceSet;
    sv_->hitsOnObject(g_, in_, n, entered, &rays, &h);
    return h;
  }

  Group* g_;
  const Services* sv_;
  const Context* in_ = nullptr;
  uint32_t part_ = 0, parts_ = 1;
  SingleScatter medium_;
  bool comesOutBehind_ = true;
  uint32_t* entered_ = nullptr;  // by point of at_: the point where its path went in
  Phase phase_{};
  Context at_;
};

template <int W>
bool ScatterOnce<W>::scatter(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a,
                             uint32_t part, uint32_t parts, float* const throughput[3]) {
  if (!n || !c.bxdf->subsurface) return false;
  begin(c, part, parts);
  RayList* list = sv_->makeRays(g_, n);
  float *o[3], *d[3], *t = floats(n);
  for (int k = 0; k < 3; ++k) {
    o[k] = floats(n);
    d[k] = floats(n);
  }
  uint32_t* from = words(n);
  rays(c, n, points, a, o, d);
  const Ways h = ways(n, points, o, d);
  // A flight within the body, by one channel at a time and weighed over all: together they are worth what scatters there.
  uint32_t m = 0, lost = 0, *open = words(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i], s = c.path[p];
    if (!h.found[i]) {
      open[lost++] = p;
      for (int k = 0; k < 3; ++k) throughput[k][s] = 0;
      continue;
    }
    float ends[3], share[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
      ends[k] = 1 - exp(Float<1>(-h.within[i] / medium_.length[k][p])).lane0();
      sum += share[k] = throughput[k][s] * ends[k];
    }
    if (!(sum > 0)) {
      for (int k = 0; k < 3; ++k) throughput[k][s] = 0;
      continue;
    }
    const float u = draw(p, 0) * sum;
    const int own = u < share[0] ? 0 : u < share[0] + share[1] || !(share[2] > 0) ? 1 : 2;
    const float depth = -log(Float<1>(1 - draw(p, 1) * ends[own])).lane0();
    const float far = depth * medium_.length[own][p];
    const float within = far < h.within[i] ? far : h.within[i];
    t[m] = placeOn(h, i, p, within);
    float density = 0, kept[3];
    for (int k = 0; k < 3; ++k) {
      kept[k] = exp(Float<1>(-within / medium_.length[k][p])).lane0() / medium_.length[k][p];
      density += throughput[k][s] * kept[k];
    }
    for (int k = 0; k < 3; ++k) throughput[k][s] *= kept[k] * sum / density;
    addRay(*list, m, p, i, o, d, h.t[i]);
    from[m++] = p;
  }
  if (lost) sv_->noteBelow(g_, &c, lost, open, BelowSurface::Open);
  if (!m) return false;
  at_ = placesOn(*list, m, from, t);
  const uint32_t room = at_.padded;
  float* anisotropy = floats(room);
  float* along[3] = {floats(room), floats(room), floats(room)};
  uint32_t* path = words(room);
  entered_ = words(room);
  for (uint32_t i = 0; i < room; ++i) {
    const uint32_t e = at_.path[i];
    entered_[i] = from[e];
    path[i] = c.path[from[e]];
    anisotropy[i] = medium_.anisotropy[from[e]];
    for (int k = 0; k < 3; ++k) along[k][i] = list->rays.d[k][e];
  }
  phase_ = {anisotropy, {along[0], along[1], along[2]}};
  uint16_t* event = static_cast<uint16_t*>(sv_->alloc(g_, sizeof(uint16_t)));
  *event = c.eventOfSlot[a.slot[points[0]]];
  static constexpr uint8_t kSlot[kMaxLobes] = {};
  at_.path = path;
  at_.bxdf = functions();
  at_.closure = &phase_;
  at_.lobeCount = at_.slotCount = 1;
  at_.slotOfLobe = kSlot;
  at_.eventOfSlot = event;
  at_.tintedSlots = at_.walkableSlots = 0;
  at_.traits |= kTraitScattersOnce;
  return true;
}

template <int W>
typename ScatterOnce<W>::Passed ScatterOnce<W>::pass(const Context& c, uint32_t n, const uint32_t* points,
                                                     const GenerateArgs& a, uint32_t part, uint32_t parts,
                                                     float* const throughput[3]) {
  using F1 = Float<1>;
  Passed out;
  if (!n || !c.bxdf->subsurface) return out;
  begin(c, part, parts);
  RayList* list = sv_->makeRays(g_, n);
  float *o[3], *d[3], *t = floats(n);
  for (int k = 0; k < 3; ++k) {
    o[k] = floats(n);
    d[k] = floats(n);
    out.o[k] = floats(n);
    out.d[k] = floats(n);
  }
  uint32_t *from = words(n), *open = words(n), lost = 0, m = 0;
  rays(c, n, points, a, o, d);
  const Ways h = ways(n, points, o, d);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i], s = c.path[p];
    const auto drop = [&] {
      for (int k = 0; k < 3; ++k) throughput[k][s] = 0;
    };
    if (!h.found[i]) {
      open[lost++] = p;
      drop();
      continue;
    }
    const Vec3<1> w(d[0][i], d[1][i], d[2][i]);
    Vec3<1> Ng = normalize(Vec3<1>(h.ng[0][i], h.ng[1][i], h.ng[2][i]));
    if ((dot(w, Ng) < F1(0.f)).any()) Ng = -Ng;
    // seen from inside: the surface's normal points back
    const F1 ior(medium_.ior[p]), alpha(medium_.alpha[p]);
    const Frame<1> plane(-Ng);
    const Vec3<1> local = plane.toLocal(-w);
    Vec3<1> facet(F1(0.f), F1(0.f), F1(1.f)), bent;
    const bool isRough = medium_.alpha[p] > 0 && medium_.ior[p] > 1;
    if (isRough) facet = sampleVisibleNormal(local, alpha, alpha, F1(draw(p, 4)), F1(draw(p, 5)));
    const bool leaves = refract(local, facet, ior, bent).any() && (bent.z < F1(0.f)).any();
    if (!leaves) {
      drop();
      continue;
    }
    F1 lets = (F1(1.f) - fresnelDielectric(clamp(dot(local, facet), F1(0.f), F1(1.f)), ior)) * ior * ior;
    bent = normalize(bent);
    if (isRough) {
      const F1 own = F1(1.f) + smithLambda(true, local, alpha, alpha);
      lets = lets * own / (own + smithLambda(true, bent, alpha, alpha));
    }
    bool brings = false;
    for (int k = 0; k < 3; ++k) {
      const float kept = exp(F1(-h.within[i] / medium_.length[k][p])).lane0();
      brings |= (throughput[k][s] *= kept * lets.lane0()) > 0;
    }
    if (!brings) continue;
    const Vec3<1> goesOn = normalize(plane.toWorld(bent)), start(o[0][i], o[1][i], o[2][i]);
    const Vec3<1> x = leave(fma(w, F1(h.t[i]), start), Ng, F1(c.bias[p]), goesOn);
    const float ox[3] = {x.x.lane0(), x.y.lane0(), x.z.lane0()},
                dx[3] = {goesOn.x.lane0(), goesOn.y.lane0(), goesOn.z.lane0()};
    for (int k = 0; k < 3; ++k) {
      out.o[k][m] = ox[k];
      out.d[k][m] = dx[k];
    }
    addRay(*list, m, p, i, o, d, t[m] = h.t[i]);
    from[m++] = p;
  }
  if (lost) sv_->noteBelow(g_, &c, lost, open, BelowSurface::Open);
  if (!m) return out;
  out.at = placesOn(*list, m, from, t);
  out.count = m;
  out.point = words(m);
  out.path = words(m);
  // the context's points are those of the list, in its own order
  float *ox[3] = {floats(m), floats(m), floats(m)}, *dx[3] = {floats(m), floats(m), floats(m)};
  for (uint32_t i = 0; i < m; ++i) {
    const uint32_t e = out.at.path[i];
    out.point[i] = i;
    out.path[i] = c.path[from[e]];
    for (int k = 0; k < 3; ++k) {
      ox[k][i] = out.o[k][e];
      dx[k][i] = out.d[k][e];
    }
  }
  for (int k = 0; k < 3; ++k) {
    out.o[k] = ox[k];
    out.d[k] = dx[k];
  }
  return out;
}

template <int W>
void ScatterOnce<W>::leaveBody(uint32_t n, const uint32_t* points, float* const o[3], const float* const d[3],
                               float* tMax, const float* share, float* const factor[3]) const {
  uint32_t* entered = words(n);
  for (uint32_t i = 0; i < padded(n); ++i) entered[i] = n ? entered_[points[i < n ? i : n - 1]] : 0;
  const Ways h = ways(n, entered, o, d);
  for (uint32_t i = 0; i < n; i += W) {
    const Mask<W> hit = Mask<W>::firstN(int(n - i < W ? n - i : W)) & (I::load(h.found + i) != I(0));
    const F end = tMax ? F::load(tMax + i) : F(1e30f), found = select(hit, F::load(h.t + i), F(0.f));
    const F within = select(hit, F::load(h.within + i), F(0.f));
    // lights within the body are nearer than its surface
    const Mask<W> leaves = hit & (found < end), stays = hit & !leaves;
    const I p = I::load(entered + i);
    const F t = select(leaves, found, F(0.f));
    const Vec3<W> w = Vec3<W>::load(d, i), Ng = select(leaves, normalize(Vec3<W>::load(h.ng, i)), w);
    const F ior = gather(medium_.ior, p), eta = F(1.f) / ior, side = dot(w, Ng), mu = min(abs(side), F(1.f));
    const F inside = safeSqrt(fnma(eta * eta, fnma(mu, mu, F(1.f)), F(1.f)));
    const Vec3<W> bent = (w - Ng * side) * eta + Ng * copySign(inside, side);
    alignas(64) float ray[3][W];
    alignas(64) uint32_t at[W];
    for (uint32_t l = 0; l < W; ++l) {
      at[l] = points[i + l < n ? i + l : n - 1];
      for (int k = 0; k < 3; ++k) ray[k][l] = phase_.d[k][at[l]];
    }
    const Vec3<W> before(F::load(ray[0]), F::load(ray[1]), F::load(ray[2]));
    const F g = gather(medium_.anisotropy, p), length = select(stays, end, within * mu / max(inside, F(1e-6f)));
    Mask<W> faces(true);
    if (!comesOutBehind_) {
      const Vec3<W> in = Vec3<W>::gather(in_->Ng, p);
      faces = stays | (dot(Ng, in) * side > F(0.f));
    }
    const F turned = henyeyGreenstein<W>(g, dot(before, bent)) / henyeyGreenstein<W>(g, dot(before, w));
    const F lets = turned * (F(1.f) - fresnelDielectric(mu, eta)) * mu / max(inside, F(1e-6f));
    const Rgb<W> free = Rgb<W>::gather(medium_.length, p);
    const Rgb<W> kept(exp(-(length / free.x)), exp(-(length / free.y)), exp(-(length / free.z)));
    const F whole = share ? F(1.f) / max(F::load(share + i), F(1e-30f)) : F(1.f);
    zeroUnless(hit & faces, kept * select(stays, whole, lets)).store(factor, i);
    const F bias = gather(in_->bias, p);
    const Vec3<W> from = Vec3<W>::load(o, i);
    select(leaves, leave(fma(w, t, from), Ng, bias, w), from).store(o, i);
    if (tMax) select(leaves, max(end - t - bias, F(0.f)), end).store(tMax + i);
  }
}

template <int W>
uint32_t ScatterOnce<W>::directions(uint32_t* points, float* const o[3], float* const d[3], float* pdf) const {
  for (uint32_t i = 0; i < at_.count; ++i) {
    const uint32_t p = entered_[i];
    const Float<1> mu = sampleHenyeyGreenstein(Float<1>(medium_.anisotropy[p]), Float<1>(draw(p, 2)));
    const Float<1> r = safeSqrt(Float<1>(1.f) - mu * mu);
    Float<1> s, co;
    sincos(Float<1>(draw(p, 3) * kTwoPi), s, co);
    const Vec3<1> before(phase_.d[0][i], phase_.d[1][i], phase_.d[2][i]);
    const Vec3<1> w = normalize(Frame<1>(before).toWorld({r * co, r * s, mu}));
    pdf[i] = henyeyGreenstein<1>(Float<1>(medium_.anisotropy[p]), dot(before, w)).lane0();
    const float x[3] = {w.x.lane0(), w.y.lane0(), w.z.lane0()};
    for (int k = 0; k < 3; ++k) {
      d[k][i] = x[k];
      o[k][i] = at_.P[k][i];
    }
    points[i] = i;
  }
  return at_.count;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif

#include <kinora/simd/tables.h>
