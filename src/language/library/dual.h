// Values that carry derivatives along the two directions of the shading grid: Dual (a float) and Dual3 (a triple),
// and the arithmetic of the language on plain and dual values alike, so that a function of this library is written
// once as a template over Float<W> or Dual<W>. Called by the library's other headers and by the machine's kernels.
// Everything stands in namespace lang, because the language's numbers differ from the renderer's own (simd/wide.h,
// math/elementary.h): call it qualified (lang::sin), or the argument's namespace makes the call ambiguous.
// No fused operation anywhere: the reference's arithmetic is one rounding an operation. Included per target.
#include <kinora/simd/wide.h>

#if defined(KINORA_LANGUAGE_DUAL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_DUAL_H_TARGET
#undef KINORA_LANGUAGE_DUAL_H_TARGET
#else
#define KINORA_LANGUAGE_DUAL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <int W>
struct Dual {
  Float<W> v, dx, dy;
  KN_INLINE Dual() {}
  KN_INLINE explicit Dual(Float<W> value) : v(value) {}
  KN_INLINE explicit Dual(float value) : v(value) {}
  KN_INLINE Dual(Float<W> value, Float<W> x, Float<W> y) : v(value), dx(x), dy(y) {}
  friend KN_INLINE Dual operator+(Dual a, Dual b) { return {a.v + b.v, a.dx + b.dx, a.dy + b.dy}; }
  friend KN_INLINE Dual operator-(Dual a, Dual b) { return {a.v - b.v, a.dx - b.dx, a.dy - b.dy}; }
  friend KN_INLINE Dual operator*(Dual a, Dual b) {
    return {a.v * b.v, a.v * b.dx + a.dx * b.v, a.v * b.dy + a.dy * b.v};
  }
  friend KN_INLINE Dual operator+(Dual a, Float<W> b) { return {a.v + b, a.dx, a.dy}; }
  friend KN_INLINE Dual operator+(Float<W> a, Dual b) { return {a + b.v, b.dx, b.dy}; }
  friend KN_INLINE Dual operator-(Dual a, Float<W> b) { return {a.v - b, a.dx, a.dy}; }
  friend KN_INLINE Dual operator-(Float<W> a, Dual b) { return {a - b.v, -b.dx, -b.dy}; }
  friend KN_INLINE Dual operator*(Dual a, Float<W> b) { return {a.v * b, a.dx * b, a.dy * b}; }
  friend KN_INLINE Dual operator*(Float<W> a, Dual b) { return {a * b.v, a * b.dx, a * b.dy}; }
  friend KN_INLINE Dual operator-(Dual a) { return {-a.v, -a.dx, -a.dy}; }
};

// A triple of duals, so that formulas on Vec3 serve it unchanged.
template <int W>
struct Dual3 {
  Dual<W> x, y, z;
  KN_INLINE Dual3() {}
  KN_INLINE explicit Dual3(Vec3<W> v) : x(v.x), y(v.y), z(v.z) {}
  KN_INLINE Dual3(Dual<W> a, Dual<W> b, Dual<W> c) : x(a), y(b), z(c) {}
  KN_INLINE Dual3(Vec3<W> v, Vec3<W> dx, Vec3<W> dy) : x(v.x, dx.x, dy.x), y(v.y, dx.y, dy.y), z(v.z, dx.z, dy.z) {}
  KN_INLINE Vec3<W> value() const { return {x.v, y.v, z.v}; }
  KN_INLINE Vec3<W> alongX() const { return {x.dx, y.dx, z.dx}; }
  KN_INLINE Vec3<W> alongY() const { return {x.dy, y.dy, z.dy}; }
  friend KN_INLINE Dual3 operator+(Dual3 a, Dual3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend KN_INLINE Dual3 operator-(Dual3 a, Dual3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend KN_INLINE Dual3 operator*(Dual3 a, Dual3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend KN_INLINE Dual3 operator*(Dual3 a, Dual<W> s) { return {a.x * s, a.y * s, a.z * s}; }
  friend KN_INLINE Dual3 operator*(Dual3 a, Float<W> s) { return {a.x * s, a.y * s, a.z * s}; }
  friend KN_INLINE Dual3 operator-(Dual3 a) { return {-a.x, -a.y, -a.z}; }
};

// The triple that belongs to a scalar type: Triple<Float<W>> is Vec3<W>, Triple<Dual<W>> is Dual3<W>.
template <class F>
struct TripleOf;
template <int W>
struct TripleOf<Float<W>> {
  static constexpr int width = W;
  using Type = Vec3<W>;
};
template <int W>
struct TripleOf<Dual<W>> {
  static constexpr int width = W;
  using Type = Dual3<W>;
};
template <class F>
using Triple = typename TripleOf<F>::Type;
template <class F>
inline constexpr int kWidthOf = TripleOf<F>::width;

template <int W>
KN_INLINE Float<W> valueOf(Float<W> a) {
  return a;
}
template <int W>
KN_INLINE Float<W> valueOf(Dual<W> a) {
  return a.v;
}
template <int W>
KN_INLINE Vec3<W> valueOf(Vec3<W> a) {
  return a;
}
template <int W>
KN_INLINE Vec3<W> valueOf(Dual3<W> a) {
  return a.value();
}

// f(a) from its value and its slope at a.
template <int W>
KN_INLINE Dual<W> chain(Float<W> value, Float<W> slope, Dual<W> a) {
  return {value, slope * a.dx, slope * a.dy};
}

// choose(m, yes, no): select under a name that the argument's namespace does not know.
template <int W>
KN_INLINE Float<W> choose(Mask<W> m, Float<W> yes, Float<W> no) {
  return HWY_NAMESPACE::select(m, yes, no);
}
template <int W>
KN_INLINE Int<W> choose(Mask<W> m, Int<W> yes, Int<W> no) {
  return HWY_NAMESPACE::select(m, yes, no);
}
template <int W>
KN_INLINE Dual<W> choose(Mask<W> m, Dual<W> yes, Dual<W> no) {
  return {choose(m, yes.v, no.v), choose(m, yes.dx, no.dx), choose(m, yes.dy, no.dy)};
}
template <int W>
KN_INLINE Vec3<W> choose(Mask<W> m, Vec3<W> yes, Vec3<W> no) {
  return HWY_NAMESPACE::select(m, yes, no);
}
template <int W>
KN_INLINE Dual3<W> choose(Mask<W> m, Dual3<W> yes, Dual3<W> no) {
  return {choose(m, yes.x, no.x), choose(m, yes.y, no.y), choose(m, yes.z, no.z)};
}
// x where m, else zero with zero derivatives
template <int W>
KN_INLINE Float<W> keep(Mask<W> m, Float<W> x) {
  return HWY_NAMESPACE::zeroUnless(m, x);
}
template <int W>
KN_INLINE Dual<W> keep(Mask<W> m, Dual<W> x) {
  return {keep(m, x.v), keep(m, x.dx), keep(m, x.dy)};
}
template <int W>
KN_INLINE Vec3<W> keep(Mask<W> m, Vec3<W> x) {
  return HWY_NAMESPACE::zeroUnless(m, x);
}
template <int W>
KN_INLINE Dual3<W> keep(Mask<W> m, Dual3<W> x) {
  return {keep(m, x.x), keep(m, x.y), keep(m, x.z)};
}

// Division as the language's `/`: a quotient that is not finite is 0.
template <int W>
KN_INLINE Float<W> divide(Float<W> a, Float<W> b) {
  const Float<W> q = a / b;
  return keep(HWY_NAMESPACE::isFinite(q), q);
}
template <int W>
KN_INLINE Dual<W> divide(Dual<W> a, Dual<W> b) {
  const Float<W> q = divide(a.v, b.v), inverse = divide(Float<W>(1.f), b.v);
  return {q, inverse * (a.dx - q * b.dx), inverse * (a.dy - q * b.dy)};
}
template <int W>
KN_INLINE Dual<W> divide(Dual<W> a, Float<W> b) {
  const Float<W> inverse = divide(Float<W>(1.f), b);
  return {divide(a.v, b), inverse * a.dx, inverse * a.dy};
}
// sqrt(x < 0) = 0; no slope at 0.
template <int W>
KN_INLINE Float<W> sqrt(Float<W> x) {
  return HWY_NAMESPACE::sqrt(HWY_NAMESPACE::max(x, Float<W>(0.f)));
}
template <int W>
KN_INLINE Dual<W> sqrt(Dual<W> x) {
  const Float<W> r = lang::sqrt(x.v);
  return chain(r, keep(x.v > Float<W>(0.f), Float<W>(0.5f) / r), x);
}
// min(x, y) = x <= y ? x : y and max = x > y ? x : y; the derivative is that of the operand taken.
template <class F>
KN_INLINE F least(F x, F y) {
  return choose(valueOf(x) <= valueOf(y), x, y);
}
template <class F>
KN_INLINE F greatest(F x, F y) {
  return choose(valueOf(x) > valueOf(y), x, y);
}
template <class F>
KN_INLINE F clampTo(F x, F lo, F hi) {
  return greatest(least(x, hi), lo);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
