// The scattering of light by one fibre: how light that comes from one direction leaves, for a given offset across the width.
// Directions are inclinations theta to the plane normal to the fibre (positive towards the tip) and azimuths phi about it.
// Marschner et al., "Light Scattering from Human Hair Fibers" (SIGGRAPH 2003): paths R, TT, TRT, caustics, elliptic sections;
// d'Eon et al., "An Energy-Conserving Hair Reflectance Model" (EGSR 2011): the lobe along the fibre;
// Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing" (EGSR 2016): the offset of
// the hit instead of an average over it, logistic lobes about the fibre, what is left for longer paths.
// It knows no colours and no frames. Included per target.
#include <kinora/bxdf_author.h>
#include <type_traits>

#ifndef KINORA_HAIR_FIBER_ONCE
#define KINORA_HAIR_FIBER_ONCE
namespace kinora::hair {
// What a material binds to know how fibres lie.
struct FiberPlace {
  Value along, aroundU, across;  // dPdv, dPdu; where a ribbon was met
  void bind(const Context& c) {
    along = c.builtin(Builtin::DPdv);
    across = c.fn->primvar(&c, "__ribbon", nullptr);
    if (across.components) aroundU = c.builtin(Builtin::DPdu);
  }
};
}  // namespace kinora::hair
#endif

#if defined(KINORA_HAIR_FIBER_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_HAIR_FIBER_H_TARGET
#undef KINORA_HAIR_FIBER_H_TARGET
#else
#define KINORA_HAIR_FIBER_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// I0(x) exp(-x) for x >= 0; relative error below 4e-7 (Abramowitz and Stegun 9.8.1, 9.8.2).
template <int W>
KN_INLINE Float<W> scaledBesselI0(Float<W> x) {
  using F = Float<W>;
  const F small = min(x, F(3.75f)) * F(1.f / 3.75f), t = small * small;
  F p = fma(t, F(0.0045813f), F(0.0360768f));
  p = fma(p, t, F(0.2659732f));
  p = fma(p, t, F(1.2067492f));
  p = fma(p, t, F(3.0899424f));
  p = fma(p, t, F(3.5156229f));
  p = fma(p, t, F(1.f));
  const F large = max(x, F(3.75f)), s = F(3.75f) / large;
  F q = fma(s, F(0.00392377f), F(-0.01647633f));
  q = fma(q, s, F(0.02635537f));
  q = fma(q, s, F(-0.02057706f));
  q = fma(q, s, F(0.00916281f));
  q = fma(q, s, F(-0.00157565f));
  q = fma(q, s, F(0.00225319f));
  q = fma(q, s, F(0.01328592f));
  q = fma(q, s, F(0.39894228f));
  return select(x < F(3.75f), p * exp(-x), q / sqrt(large));
}

template <int W>
KN_INLINE Rgb<W> positive(Rgb<W> c) {
  const Float<W> none(0.f);
  return {max(c.x, none), max(c.y, none), max(c.z, none)};
}

// An inclination by its sine and cosine.
template <int W>
struct Inclination {
  Float<W> s, c;
  KN_INLINE Inclination() {}
  KN_INLINE Inclination(Float<W> sine, Float<W> cosine) : s(sine), c(cosine) {}
  // That of a smaller angle by the one given.
  KN_INLINE Inclination lessened(Float<W> angleSine, Float<W> angleCosine) const {
    return {fms(s, angleCosine, c * angleSine), abs(fma(c, angleCosine, s * angleSine))};
  }
};

// The frame of a fibre where it is seen along wo: T along it, X towards wo in the plane normal to it, Y = T x X.
template <int W>
struct FiberFrame {
  using F = Float<W>;
  Vec3<W> T, X, Y;
  Inclination<W> outgoing;
  F gamma;  // azimuth of the normal, from X: the offset of the hit across the width
  KN_INLINE FiberFrame() {}
  KN_INLINE FiberFrame(const hair::FiberPlace& place, const Surface<W>& s) {
    const F none(0.f), one(1.f);
    Vec3<W> t = place.along.components ? loadVec<W>(place.along, s.at) : Vec3<W>(none, none, none);
    const F t2 = dot(t, t);
    const Mask<W> hasAlong = (t2 > F(1e-30f)) & isFinite(t2);
    T = select(hasAlong, t * (one / sqrt(select(hasAlong, t2, one))), Frame<W>(s.N).y);
    const F sine = clamp(dot(s.wo, T), F(-1.f), one);
    const Vec3<W> flat = fma(T, -sine, s.wo);
    const F flat2 = dot(flat, flat);
    const Mask<W> slanted = flat2 > F(1e-10f);
    X = select(slanted, normalize(select(slanted, flat, s.N)), Frame<W>(T).x);
    X = normalize(fma(T, -dot(T, X), X));
    Y = cross(T, X);
    outgoing = Inclination<W>(sine, sqrt(flat2));
    gamma = atan2(dot(s.N, Y), max(dot(s.N, X), none));
    if (place.across.components) {
      // a ribbon stands for a tube: where it was met says where the tube would have been
      const F u = loadFloat<W>(place.across, s.at);
      const F side = dot(loadVec<W>(place.aroundU, s.at), Y);
      gamma = select(abs(u) <= one, asin(select(side < none, -u, u)), gamma);
    }
  }
  // Inclination and azimuth of a direction, and back.
  KN_INLINE Inclination<W> inclinationOf(Vec3<W> w, F& phi) const {
    const F x = dot(w, X), y = dot(w, Y);
    phi = atan2(y, x);
    return {clamp(dot(w, T), F(-1.f), F(1.f)), sqrt(fma(x, x, y * y))};
  }
  KN_INLINE Vec3<W> direction(F sine, F phi) const {
    F phiSine, phiCosine;
    sincos(phi, phiSine, phiCosine);
    const F cosine = safeSqrt(fnma(sine, sine, F(1.f)));
    return fma(T, sine, fma(X, cosine * phiCosine, Y * (cosine * phiSine)));
  }
};

// Along the fibre, about the inclination -o: the spherical Gaussian of variance v, as a function of the inclination alone
// (d'Eon et al. 2011, equation 7). Density in which cos(i) di is the measure.
template <int W>
struct AlongLobe {
  using F = Float<W>;
  F v, perV, scale, tail;  // tail: exp(-2 / v)
  KN_INLINE AlongLobe() {}
  // Standard deviation in radians.
  KN_INLINE explicit AlongLobe(F deviation) {
    const F d = max(deviation, F(0.005f));
    v = d * d;
    perV = F(1.f) / v;
    tail = exp(F(-2.f) * perV);
    scale = perV / (F(1.f) - tail);
  }
  KN_INLINE F density(const Inclination<W>& o, const Inclination<W>& i) const {
    // 1 - cos(o + i) without cancellation, for narrow lobes
    const F a = i.s + o.s, b = i.c - o.c, off = fma(a, a, b * b) * F(0.5f);
    return scale * scaledBesselI0(o.c * i.c * perV) * exp(-off * perV);
  }
  // Sine of the inclination.
  KN_INLINE F sample(const Inclination<W>& o, F u, F cosineOfTurn) const {
    const F w = max(u, F(1e-7f));
    const F off = clamp(-v * log(fma(F(1.f) - w, tail, w)), F(0.f), F(2.f));  // 1 - cos of the angle to -o
    const F sine = safeSqrt(off * (F(2.f) - off));
    return clamp(fma(F(1.f) - off, -o.s, sine * cosineOfTurn * o.c), F(-1.f), F(1.f));
  }
};

// About the fibre: a logistic distribution cut off at half a turn to each side, then normalised (Chiang et al. 2016).
template <int W>
struct AboutLobe {
  using F = Float<W>;
  F s, perS, least, span;  // least: the part beyond half a turn on one side
  KN_INLINE AboutLobe() {}
  // Standard deviation in radians, of the distribution that is not cut off.
  KN_INLINE explicit AboutLobe(F deviation) {
    s = max(deviation * F(0.551328895f), F(0.002f));  // sqrt(3) / pi
    perS = F(1.f) / s;
    const F e = exp(F(-kPi) * perS);
    least = e / (F(1.f) + e);
    span = (F(1.f) - e) / (F(1.f) + e);
  }
  KN_INLINE F density(F angle) const {
    const F e = exp(-abs(wrapped(angle)) * perS), d = F(1.f) + e;
    return e * perS / (d * d * span);
  }
  KN_INLINE F sample(F u) const {
    const F y = max(fma(u, span, least), F(1e-30f));
    return clamp(s * log(y / max(F(1.f) - y, F(1e-7f))), F(-kPi), F(kPi));
  }
  static KN_INLINE F wrapped(F angle) { return fnma(toFloat(toNearestInt(angle * F(kInvTwoPi))), F(kTwoPi), angle); }
};

// What becomes of light that meets the fibre with an inclination, at an offset across the width: `gamma` is the azimuth of the
// outward normal there, from the direction the light comes from, within a quarter turn.
enum HairPath : uint32_t { kPathR, kPathTT, kPathTRT, kPathGlint, kHairPaths };
template <int W>
struct FiberHit {
  using F = Float<W>;
  F reflectance;         // of the surface at the offset
  F centre[kHairPaths];  // azimuths to which light leaves, from the direction it comes from

  KN_INLINE FiberHit() {}
  // ior: of the fibre; innerIor: that which TRT sees in an elliptic section. mix: 1 Fresnel's reflectance, 0 its mean over
  // the width (`mean`).
  KN_INLINE FiberHit(const Inclination<W>& o, F gamma, F ior, F innerIor, F mix, F mean) {
    F h, cosGamma;
    sincos(gamma, h, cosGamma);
    cosGamma = max(cosGamma, F(0.f));
    reflectance = lerp(mean, fresnelDielectric(o.c * cosGamma, F(1.f) / ior), mix);
    const F c = max(o.c, F(1e-3f)), s2 = o.s * o.s;
    // indices that light sees in projection to the normal plane (Bravais)
    const F eta = safeSqrt(fms(ior, ior, s2)) / c, inner = safeSqrt(fms(innerIor, innerIor, s2)) / c;
    const F twice = gamma + gamma;
    centre[kPathR] = twice;
    centre[kPathTT] = fnma(F(2.f), asin(h / max(eta, F(1.f))), twice) + F(kPi);
    centre[kPathTRT] = fnma(F(4.f), asin(h / max(inner, F(1.f))), twice);
    // where TRT turns back, so that light gathers; none beyond an index of 2
    const F edge = safeSqrt((F(4.f) - inner * inner) * F(1.f / 3)), e = min(edge, F(1.f));
    const F caustic = fnma(F(4.f), asin(e / max(inner, F(1.f))), F(2.f) * asin(e));
    centre[kPathGlint] = copySign(abs(caustic), -gamma);
  }
};

// The density of a direction, summed over techniques by their energies, and the sum of these.
template <int W>
struct FiberDensity {
  Float<W> sum = Float<W>(0.f), total = Float<W>(0.f);
  KN_INLINE FiberDensity() {}
  template <uint32_t N>
  KN_INLINE void set(const Float<W> (&energy)[N], Float<W> all, const Float<W> (&density)[N]) {
    total = all;
    for (uint32_t k = 0; k < N; ++k) sum = fma(energy[k], density[k], sum);
  }
  KN_INLINE Float<W> mean() const { return sum / max(total, Float<W>(1e-30f)); }
};
// Which of the techniques, by energy; what is left of w is uniform again.
template <int W>
struct ChosenTechnique {
  Int<W> which;
  Float<W> rest;
  Mask<W> found;  // rounding may walk past the last one that is on
  template <uint32_t N>
  KN_INLINE ChosenTechnique(const Float<W> (&energy)[N], Float<W> total, Float<W> w) : which(0u) {
    using F = Float<W>;
    F left = w * total, share(0.f);
    Mask<W> open(true);
    for (uint32_t k = 0; k < N; ++k) {
      const F e = energy[k];
      const Mask<W> here = open & (e > F(0.f)) & ((left < e) | Mask<W>(k + 1 == N));
      which = select(here, Int<W>(k), which);
      share = select(here, e, share);
      open = open & !here;
      left = select(open, left - e, left);
    }
    found = (!open) & (total > F(0.f));
    rest = clamp(left / max(share, F(1e-30f)), F(0.f), F(0x1.fffffep-1f));
  }
};

// Mean of the reflectance over the width, at inclination 0: Gauss and Legendre's points for the offset.
template <int W>
KN_INLINE Float<W> meanFiberReflectance(Float<W> ior) {
  using F = Float<W>;
  constexpr float kCosine[4] = {0.997587f, 0.943978f, 0.742370f, 0.366119f};  // sqrt(1 - h^2)
  constexpr float kShare[4] = {0.173927f, 0.326073f, 0.326073f, 0.173927f};
  F sum(0.f);
  for (int k = 0; k < 4; ++k) sum = fma(F(kShare[k]), fresnelDielectric(F(kCosine[k]), F(1.f) / ior), sum);
  return sum;
}

// A direction by the path of each lane, of `count`: those behind TRT have its lobe along the fibre. azimuth(path): one by
// the path's lobe about it.
template <int W, class Azimuth>
KN_INLINE Vec3<W> sampleFiber(const FiberFrame<W>& frame, const AlongLobe<W> (&along)[3],
                              const Inclination<W> (&seen)[3], Int<W> which, uint32_t count, Float<W> u, Float<W> v,
                              Azimuth azimuth) {
  using F = Float<W>;
  F turnSine, turnCosine;
  sincos(v * F(kTwoPi), turnSine, turnCosine);
  F sine(0.f), phi(0.f);
  for (uint32_t p = 0; p < count; ++p) {
    const Mask<W> here = which == Int<W>(p);
    if (!here.any()) continue;
    const uint32_t a = p < 3 ? p : kPathTRT;
    sine = select(here, along[a].sample(seen[a], u, turnCosine), sine);
    phi = select(here, azimuth(p), phi);
  }
  return frame.direction(sine, phi);
}

// A fibre's lobes towards wi, by the lanes of a material: its frame, what it knows of the side that is seen (own) with
// the techniques' energies, their densities(), and add() of what one side sends to the other.
// Values are times `gain` (a number, or one by channel) and go to the lobes from `lobe` on. back only where it is wanted.
// otherSide(inclination, phi): what would be known of a side that is seen from there.
template <int W, class Lanes, class Gain, class OtherSide>
KN_INLINE void evaluateFiber(const Lanes& k, Vec3<W> wi, Gain gain, uint32_t lobe, LobeSum<W>& out,
                             FiberDensity<W>& forward, FiberDensity<W>& back, OtherSide otherSide) {
  using F = Float<W>;
  constexpr uint32_t kTechniques = std::extent_v<decltype(Lanes::Side::energy)>;
  F phi;
  const Inclination<W> i = k.frame.inclinationOf(wi, phi);
  F density[kTechniques];
  k.densities(k.own, i, phi, density);
  forward.set(k.own.energy, k.own.total, density);
  // The way back through the fibre comes in at the mirrored offset: with another one, the density would go with other
  // values than with those that it is of, and weights of light transport by them would not sum to 1 over the width.
  if (out.wantsReverse || k.adjoint) {
    const typename Lanes::Side other = otherSide(i, phi);
    F lit[kTechniques];
    k.densities(other, k.frame.outgoing, -phi, lit);
    back.set(other.energy, other.total, lit);
    // light leaves towards wi: what an eye there would see of the fibre's whole width
    if (k.adjoint) k.add(other, lit, gain * (i.c / max(k.frame.outgoing.c, F(1e-3f))), wi, lobe, out);
  }
  if (!k.adjoint) k.add(k.own, density, gain, wi, lobe, out);
}
// Of round fibres: all that is known of a side follows from the inclination and the offset.
template <int W, class Lanes, class Gain>
KN_INLINE void evaluateFiber(const Lanes& k, Vec3<W> wi, Gain gain, uint32_t lobe, LobeSum<W>& out,
                             FiberDensity<W>& forward, FiberDensity<W>& back) {
  evaluateFiber(k, wi, gain, lobe, out, forward, back,
                [&](const Inclination<W>& i, Float<W>) HWY_ATTR { return k.sideOf(i, -k.frame.gamma); });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
