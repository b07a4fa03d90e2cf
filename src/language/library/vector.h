// Geometry of the language on triples, plain (Vec3) and dual (Dual3) from one source: F is Float<W> or Dual<W>, V its
// triple. What is not defined (a zero length, total reflection) is zero with zero derivatives. Included per target.
#include "language/library/fast_math.h"
#include "language/library/round_math.h"

#if defined(KINORA_LANGUAGE_VECTOR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_VECTOR_H_TARGET
#undef KINORA_LANGUAGE_VECTOR_H_TARGET
#else
#define KINORA_LANGUAGE_VECTOR_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <int W>
KN_INLINE Float<W> dot(Vec3<W> a, Vec3<W> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <int W>
KN_INLINE Dual<W> dot(Dual3<W> a, Dual3<W> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
KN_INLINE V cross(V a, V b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V>
KN_INLINE auto length(V a) {
  return lang::sqrt(lang::dot(a, a));
}
template <class V>
KN_INLINE auto distance(V a, V b) {
  return lang::length(a - b);
}
template <int W>
KN_INLINE Float<W> inverseOrZero(Float<W> x) {
  return keep(x > Float<W>(0.f), Float<W>(1.f) / x);
}
template <int W>
KN_INLINE Dual<W> inverseOrZero(Dual<W> x) {
  const Float<W> r = inverseOrZero(x.v);
  return chain(r, -(r * r), x);
}
template <class V>
KN_INLINE V normalize(V a) {
  return a * inverseOrZero(lang::length(a));
}
// Of q to the segment from a to b.
template <class V>
KN_INLINE auto distance(V a, V b, V q) {
  const V d = b - a;
  const auto square = lang::dot(d, d);
  using F = decltype(lang::dot(d, d));
  const F t = clampTo(divide(lang::dot(q - a, d), square), F(0.f), F(1.f));
  const auto zero = decltype(valueOf(square))(0.f);
  return choose(valueOf(square) == zero, lang::distance(q, a), lang::distance(q, a + d * t));
}
template <class V>
KN_INLINE V faceforward(V n, V i, V reference) {
  const auto along = valueOf(lang::dot(i, reference));
  return choose(along > decltype(along)(0.f), -n, n);
}
template <class V>
KN_INLINE V reflect(V i, V n) {
  const auto along = lang::dot(n, i);
  return i - n * (along * decltype(valueOf(along))(2.f));
}
// eta is the index of the side that i comes from over that of the other.
template <class V, class F>
KN_INLINE V refract(V i, V n, F eta) {
  using Plain = decltype(valueOf(eta));
  const F along = lang::dot(i, n);
  const F k = Plain(1.f) - eta * eta * (Plain(1.f) - along * along);
  const V through = i * eta - n * (eta * along + lang::sqrt(k));
  return keep(!(valueOf(k) < Plain(0.f)), through);
}
template <class V, class F>
KN_INLINE void fresnel(V i, V n, F eta, F& kr, F& kt, V& r, V& t) {
  using Plain = decltype(valueOf(eta));
  const Plain one(1.f);
  const F c = lang::abs(lang::dot(i, n));
  const F square = divide(F(1.f), eta * eta) - one + c * c;
  const auto passes = valueOf(square) >= Plain(0.f);
  const F g = lang::sqrt(square), less = g - c, more = g + c;
  const F ratio = divide(c * more - one, c * less + one), beam = divide(less, more);
  const F reflected = Plain(0.5f) * (one + ratio * ratio) * (beam * beam);
  kr = choose(passes, reflected, F(1.f));
  kt = keep(passes, (one - reflected) * eta * eta);
  r = lang::reflect(i, n);
  t = keep(passes, lang::refract(i, n, eta));
}
// p turned by an angle around the line from a to b (right hand).
template <class V, class F>
KN_INLINE V rotate(V p, F angle, V a, V b) {
  using Plain = decltype(valueOf(angle));
  const Plain one(1.f);
  const V k = lang::normalize(b - a), d = p - a;
  F s, c;
  lang::sincos(angle, s, c);
  const F rest = one - c, x = k.x, y = k.y, z = k.z;
  const F xx = x * x, yy = y * y, zz = z * z, xy = x * y * rest, xz = x * z * rest, yz = y * z * rest;
  const V turned(d.x * (xx + (one - xx) * c) + d.y * (xy - z * s) + d.z * (xz + y * s),
                 d.x * (xy + z * s) + d.y * (yy + (one - yy) * c) + d.z * (yz - x * s),
                 d.x * (xz - y * s) + d.y * (yz + x * s) + d.z * (zz + (one - zz) * c));
  return turned + a;
}
// ---- of derivatives themselves ----
template <int W>
KN_INLINE Vec3<W> filterwidth(Dual3<W> p) {
  return {lang::filterwidth(p.x), lang::filterwidth(p.y), lang::filterwidth(p.z)};
}
template <int W>
KN_INLINE Float<W> area(Dual3<W> p) {
  return lang::length(lang::cross(p.alongX(), p.alongY()));
}
// Not of unit length; flipped where the renderer says that the surface is left-handed.
template <int W>
KN_INLINE Vec3<W> calculatenormal(Dual3<W> p, Mask<W> flipped) {
  const Vec3<W> n = lang::cross(p.alongX(), p.alongY());
  return choose(flipped, -n, n);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
