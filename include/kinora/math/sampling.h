// Warps and frames for wide values: what bxdfs, lights and integrators share. Directions are unit vectors; pdfs are
// per solid angle unless the name says otherwise. Included per target, like wide.h.
#include <kinora/math/elementary.h>

#if defined(KINORA_SAMPLING_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SAMPLING_H_TARGET
#undef KINORA_SAMPLING_H_TARGET
#else
#define KINORA_SAMPLING_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

constexpr float kPi = 3.14159265358979324f;
constexpr float kInvPi = 0.318309886183790672f;
constexpr float kTwoPi = 6.28318530717958648f;
constexpr float kInvTwoPi = 0.159154943091895336f;
constexpr float kInvFourPi = 0.0795774715459476679f;

// Right-handed orthonormal frame about a unit z (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017).
template <int W>
struct Frame {
  Vec3<W> x, y, z;
  KN_INLINE Frame() {}
  KN_INLINE Frame(Vec3<W> a, Vec3<W> b, Vec3<W> c) : x(a), y(b), z(c) {}
  KN_INLINE explicit Frame(Vec3<W> n) : z(n) {
    using F = Float<W>;
    const F sign = copySign(F(1.f), n.z);
    const F a = F(-1.f) / (sign + n.z);
    const F b = n.x * n.y * a;
    x = Vec3<W>(fma(sign * n.x * n.x, a, F(1.f)), sign * b, -sign * n.x);
    y = Vec3<W>(b, fma(n.y * n.y, a, sign), -n.y);
  }
  // z = n, x as near to the given tangent as it can be; falls back where the tangent is (nearly) parallel or zero.
  static KN_INLINE Frame fromTangent(Vec3<W> n, Vec3<W> tangent) {
    using F = Float<W>;
    Vec3<W> t = tangent - n * dot(n, tangent);
    const F l2 = dot(t, t);
    const Mask<W> good = l2 > F(1e-10f) * max(dot(tangent, tangent), F(1e-20f));
    const Frame f(n);
    t = select(good, t * (F(1.f) / sqrt(max(l2, F(1e-30f)))), f.x);
    // once more: where the tangent was nearly parallel, the first difference kept few digits
    t = normalize(fma(n, -dot(n, t), t));
    return Frame(t, cross(n, t), n);
  }
  KN_INLINE Vec3<W> toLocal(Vec3<W> v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
  KN_INLINE Vec3<W> toWorld(Vec3<W> v) const { return fma(x, v.x, fma(y, v.y, z * v.z)); }
};

// Uniform on the unit disk by Shirley and Chiu's concentric map: keeps strata compact.
template <int W>
KN_INLINE void concentricDisk(Float<W> u, Float<W> v, Float<W>& x, Float<W>& y) {
  using F = Float<W>;
  const F a = fma(u, F(2.f), F(-1.f)), b = fma(v, F(2.f), F(-1.f));
  const Mask<W> first = a * a > b * b;
  const F r = select(first, a, b);
  const F q = select(first, b, a) / select(r == F(0.f), F(1.f), r);
  const F phi =
      select(first, q * F(0.785398163397448310f), fnma(q, F(0.785398163397448310f), F(1.57079632679489662f)));
  F s, c;
  sincos(phi, s, c);
  x = r * c;
  y = r * s;
}
// Cosine-weighted direction about +z; pdf = z / pi.
template <int W>
KN_INLINE Vec3<W> cosineHemisphere(Float<W> u, Float<W> v) {
  Float<W> x, y;
  concentricDisk(u, v, x, y);
  return {x, y, safeSqrt(fnma(x, x, fnma(y, y, Float<W>(1.f))))};
}
// Bends a direction of cosineHemisphere() so that its density goes with the cosine's power of `exponent`; pdf =
// (exponent + 1) / (2 pi) z^exponent. The square of z is even in [0, 1] for exponent 1; in general its power
// (exponent + 1) / 2 is.
template <int W>
KN_INLINE Vec3<W> bendToPower(Vec3<W> local, Float<W> exponent) {
  using F = Float<W>;
  const F c2 = pow(max(local.z * local.z, F(1e-30f)), F(2.f) / (exponent + F(1.f)));
  const F scale = safeSqrt(F(1.f) - c2) / max(safeSqrt(fnma(local.z, local.z, F(1.f))), F(1e-12f));
  return {local.x * scale, local.y * scale, sqrt(c2)};
}
// Uniform on the unit sphere; pdf = 1 / (4 pi).
template <int W>
KN_INLINE Vec3<W> uniformSphere(Float<W> u, Float<W> v) {
  using F = Float<W>;
  const F z = fnma(F(2.f), u, F(1.f)), r = safeSqrt(fnma(z, z, F(1.f)));
  F s, c;
  sincos(v * F(kTwoPi), s, c);
  return {r * c, r * s, z};
}
// Uniform in a cone about +z with the given cosine of its half angle; pdf = 1 / (2 pi (1 - cosMax)).
// oneMinusCosMax is passed instead of the cosine so that narrow cones keep accuracy.
template <int W>
KN_INLINE Vec3<W> uniformCone(Float<W> u, Float<W> v, Float<W> oneMinusCosMax) {
  using F = Float<W>;
  const F h = u * oneMinusCosMax;  // 1 - cos
  const F z = F(1.f) - h, r = safeSqrt(h * (F(2.f) - h));
  F s, c;
  sincos(v * F(kTwoPi), s, c);
  return {r * c, r * s, z};
}
// Balance heuristic for one sample of each of two techniques; both densities in the same measure (Veach 1995).
template <int W>
KN_INLINE Float<W> misBalance(Float<W> mine, Float<W> other) {
  return mine / max(mine + other, Float<W>(1e-38f));
}
// Power heuristic with exponent 2, written so that large densities do not overflow.
template <int W>
KN_INLINE Float<W> misPower(Float<W> mine, Float<W> other) {
  using F = Float<W>;
  const F r = other / max(mine, F(1e-38f));
  return F(1.f) / fma(r, r, F(1.f));
}
// Direction reflected about the unit normal n: both point away from the surface.
template <int W>
KN_INLINE Vec3<W> reflect(Vec3<W> wo, Vec3<W> n) {
  const Float<W> d = dot(wo, n);
  return fma(n, d + d, -wo);
}
// Refraction of wo (away from the surface) through n on wo's side; eta = ior(wo side) / ior(other side).
// Returns false lanes on total internal reflection.
template <int W>
KN_INLINE Mask<W> refract(Vec3<W> wo, Vec3<W> n, Float<W> eta, Vec3<W>& wt) {
  using F = Float<W>;
  const F c = dot(wo, n), s2 = eta * eta * max(fnma(c, c, F(1.f)), F(0.f));
  const F ct = safeSqrt(F(1.f) - s2);
  wt = fma(n, fms(eta, c, ct), -(wo * eta));
  return s2 < F(1.f);
}
// Unpolarised Fresnel reflectance of a dielectric; cosine on the incident side (>= 0), eta = ior(incident) /
// ior(other).
template <int W>
KN_INLINE Float<W> fresnelDielectric(Float<W> cosI, Float<W> eta) {
  using F = Float<W>;
  const F s2 = eta * eta * max(fnma(cosI, cosI, F(1.f)), F(0.f));
  const F cosT = safeSqrt(F(1.f) - s2);
  const F rs = (eta * cosI - cosT) / max(eta * cosI + cosT, F(1e-20f));
  const F rp = (cosI - eta * cosT) / max(cosI + eta * cosT, F(1e-20f));
  return select(s2 >= F(1.f), F(1.f), F(0.5f) * fma(rs, rs, rp * rp));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
