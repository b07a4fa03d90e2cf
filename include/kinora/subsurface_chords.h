// Ways out of PathsBelow by profiles (subsurface_profiles.h). Included by subsurface.h alone, per target.
//
// A profile: a chord through the object beside the point, along the normal or one of two tangents, at a distance taken
// by one of the terms and channels; one of its hits on the object is where light comes out. The density is that of all
// axes, terms and channels together (King, Kulla, Conty and Fajardo, "BSSRDF importance sampling", SIGGRAPH talks 2013).
#if defined(KINORA_SUBSURFACE_CHORDS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SUBSURFACE_CHORDS_H_TARGET
#undef KINORA_SUBSURFACE_CHORDS_H_TARGET
#else
#define KINORA_SUBSURFACE_CHORDS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

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
  const Rays rays = raysAlong(o, d, tMax, time);
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

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
