// The walks of PathsBelow. Included by subsurface.h alone, per target.
//
// A walk: free flights by one channel at a time, chosen by the path's throughput and weighed over all (one-sample
// multiple importance sampling, Veach 1997 chapter 9; the sum of the channels never grows), Henyey-Greenstein
// scattering, Russian roulette. Chiang, Kutz and Burley, "Practical and controllable subsurface scattering for
// production path tracing" (SIGGRAPH talks 2016), is where diffuse entry and exit come from. With an index of the
// boundary (Subsurface::ior) light goes in by the cosine's law of the outside, refracted and weighed by what Fresnel's
// formulas let through, over the mean of that; what arrives from inside is mirrored by chance as they say, always beyond
// the critical angle, or comes out by a cosine's law. Up to a constant that is the transport of a matt surface on a
// dielectric, and so it is reciprocal: n^2 times the densities inside are the transmittances outside.
#if defined(KINORA_SUBSURFACE_WALKS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBSURFACE_WALKS_H_TARGET
#undef KINORA_SUBSURFACE_WALKS_H_TARGET
#else
#define KINORA_SUBSURFACE_WALKS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Walks are followed a flight at a time, all that are under way together. Where a region is known that the surface does
// not reach into, flights that end within it need no ray. The others wait until they are many: lanes stay filled.
template <int W>
void PathsBelow<W>::walk(uint32_t n, const uint32_t* points, const GenerateArgs& a) {
  const Context& c = *c_;
  Walkers running = makeWalkers(n), waiting = makeWalkers(n);
  hasTails_ = false;
  enters_ = nullptr;
  bool isBounded = false;
  isEven_ = n > 0;
  first_ = n ? points[0] : 0;
  for (uint32_t i = 0; i < n; ++i) {
    hasTails_ |= below_.tail[points[i]] > 0;
    isBounded |= below_.ior[points[i]] > 1;
    const auto isSame = [&](const float* x) { return x[points[i]] == x[first_]; };
    for (int k = 0; k < 3; ++k)
      isEven_ = isEven_ && isSame(below_.length[k]) && isSame(below_.albedo[k]) && isSame(below_.surface[k]);
    isEven_ = isEven_ && isSame(below_.anisotropy);
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
  const Rgb<W> b = x.beta, length = colorAt(below_.length, p);
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
  const Rgb<W> length = colorAt(below_.length, p), depth(t / length.x, t / length.y, t / length.z);
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
  x.beta = select(met, b, b * colorAt(below_.albedo, p));
}

// Those that go on where a flight ended: in another direction unless they met a part of the body, by Russian roulette.
template <int W>
KN_INLINE Mask<W> PathsBelow<W>::scatter(Walker& x, Mask<W> met, Mask<W> in) {
  const I p = x.point, event = x.step * I(8);
  const F mu = sampleHenyeyGreenstein(numberAt(below_.anisotropy, p), drawEvent(x.address, event + I(2)));
  const F r = safeSqrt(fnma(mu, mu, F(1.f)));
  F sinPhi, cosPhi;
  sincos(drawEvent(x.address, event + I(3)) * F(kTwoPi), sinPhi, cosPhi);
  x.d = select(met, x.d, normalize(Frame<W>(x.d).toWorld({r * cosPhi, r * sinPhi, mu})));
  const F most = maxComponent(x.beta);
  // Not below what the surface returns in the mean: dark ones are entered seldom, by paths that are worth much.
  const F mean = clamp(maxComponent(colorAt(below_.surface, p)), F(0.1f), F(1.f));
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
    const F g = max(numberAt(below_.anisotropy, x.point), F(0.f));
    const Rgb<W> length = colorAt(below_.length, x.point);
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

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
