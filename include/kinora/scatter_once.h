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
#include <kinora/integrator.h>
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
  // `throughput`, by entry of c.path.
  bool scatter(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a, uint32_t part,
               uint32_t parts, float* const throughput[3]);
  // Where they are: in space, of one slot, for light samples alone.
  const Context& context() const { return at_; }
  // Rays from points of context(), in these directions: each is moved to where it leaves the body, and tMax (null: there
  // is none) is shortened by that. `factor` gets what is left of their light there, 0 where it does not leave.
  void leaveBody(uint32_t n, const uint32_t* points, float* const o[3], const float* const d[3], float* tMax,
                 float* const factor[3]);
  // Directions by the phase function, one for each point of context(): d and the points themselves, packed.
  uint32_t directions(uint32_t* points, float* const o[3], float* const d[3]) const;
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
    h.most = 1;
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
  uint32_t* entered_ = nullptr;  // by point of at_: the point where its path went in
  Phase phase_{};
  Context at_;
};

template <int W>
bool ScatterOnce<W>::scatter(const Context& c, uint32_t n, const uint32_t* points, const GenerateArgs& a,
                             uint32_t part, uint32_t parts, float* const throughput[3]) {
  in_ = &c;
  part_ = part;
  parts_ = parts;
  if (!n || !c.bxdf->subsurface) return false;
  Subsurface below{};
  for (float*& l : below.single.length) l = floats(c.padded);
  below.single.anisotropy = floats(c.padded);
  below.single.ior = floats(c.padded);
  c.bxdf->subsurface(&c, c.closure, &below);
  medium_ = below.single;
  RayList* list = sv_->makeRays(g_, n);
  float *o[3], *d[3], *t = floats(n);
  for (int k = 0; k < 3; ++k) {
    o[k] = floats(n);
    d[k] = floats(n);
  }
  uint32_t *from = words(n), *entry = words(n);
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
  const ObjectHits h = hits(n, points, o, d);
  // A flight within the body, by one channel at a time and weighed over all: together they are worth what scatters there.
  uint32_t m = 0, lost = 0, *open = words(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = points[i], s = c.path[p];
    if (!h.count[i]) {
      open[lost++] = p;
      for (int k = 0; k < 3; ++k) throughput[k][s] = 0;
      continue;
    }
    float ends[3], share[3], sum = 0;
    for (int k = 0; k < 3; ++k) {
      ends[k] = 1 - exp(Float<1>(-h.t[i] / medium_.length[k][p])).lane0();
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
    t[m] = far < h.t[i] ? far : h.t[i];
    float density = 0, kept[3];
    for (int k = 0; k < 3; ++k) {
      kept[k] = exp(Float<1>(-t[m] / medium_.length[k][p])).lane0() / medium_.length[k][p];
      density += throughput[k][s] * kept[k];
    }
    for (int k = 0; k < 3; ++k) throughput[k][s] *= kept[k] * sum / density;
    for (int k = 0; k < 3; ++k) {
      list->rays.o[k][m] = o[k][i];
      list->rays.d[k][m] = d[k][i];
    }
    list->rays.tMax[m] = h.t[i];
    list->rays.time[m] = c.time[p];
    list->rays.radius[m] = c.radius[p];
    list->rays.spread[m] = c.spread[p];
    from[m] = p;
    entry[m] = m;
    ++m;
  }
  if (lost) sv_->noteBelow(g_, &c, lost, open, BelowSurface::Open);
  if (!m) return false;
  for (uint32_t i = m; i < padded(m); ++i) entry[i] = entry[m - 1];
  sv_->leave(g_, list, &c, m, from, entry, nullptr);
  at_ = *sv_->pointsInSpace(g_, list, kTraitEyePath, c.depth, m, entry, t);
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
  at_.traits |= kTraitComesOut | kTraitScattersOnce;
  return true;
}

template <int W>
void ScatterOnce<W>::leaveBody(uint32_t n, const uint32_t* points, float* const o[3], const float* const d[3],
                               float* tMax, float* const factor[3]) {
  uint32_t* entered = words(n);
  for (uint32_t i = 0; i < padded(n); ++i) entered[i] = n ? entered_[points[i < n ? i : n - 1]] : 0;
  const ObjectHits h = hits(n, entered, o, d);
  for (uint32_t i = 0; i < n; i += W) {
    const Mask<W> hit = Mask<W>::firstN(int(n - i < W ? n - i : W)) & (I::load(h.count + i) != I(0));
    const F end = tMax ? F::load(tMax + i) : F(1e30f), found = select(hit, F::load(h.t + i), F(0.f));
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
    const F g = gather(medium_.anisotropy, p), length = select(stays, end, t * mu / max(inside, F(1e-6f)));
    const F turned = henyeyGreenstein<W>(g, dot(before, bent)) / henyeyGreenstein<W>(g, dot(before, w));
    const F lets = turned * (F(1.f) - fresnelDielectric(mu, eta)) * mu / max(inside, F(1e-6f));
    const Rgb<W> free = Rgb<W>::gather(medium_.length, p);
    const Rgb<W> kept(exp(-(length / free.x)), exp(-(length / free.y)), exp(-(length / free.z)));
    zeroUnless(hit, kept * select(stays, F(1.f), lets)).store(factor, i);
    const F bias = gather(in_->bias, p);
    const Vec3<W> from = Vec3<W>::load(o, i);
    select(leaves, leave(fma(w, t, from), Ng, bias, w), from).store(o, i);
    if (tMax) select(leaves, max(end - t - bias, F(0.f)), end).store(tMax + i);
  }
}

template <int W>
uint32_t ScatterOnce<W>::directions(uint32_t* points, float* const o[3], float* const d[3]) const {
  for (uint32_t i = 0; i < at_.count; ++i) {
    const uint32_t p = entered_[i];
    const Float<1> mu = sampleHenyeyGreenstein(Float<1>(medium_.anisotropy[p]), Float<1>(draw(p, 2)));
    const Float<1> r = safeSqrt(Float<1>(1.f) - mu * mu);
    Float<1> s, co;
    sincos(Float<1>(draw(p, 3) * kTwoPi), s, co);
    const Vec3<1> before(phase_.d[0][i], phase_.d[1][i], phase_.d[2][i]);
    const Vec3<1> w = normalize(Frame<1>(before).toWorld({r * co, r * s, mu}));
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
