// Wide values: Float<W>, Int<W>, Mask<W> for W = 1, 4, 8 (AVX2) and 16 (AVX-512) over Highway. Kernel code is written
// once as templates over W; a one-lane type runs the same source. Every operation is IEEE-exact or explicitly fused,
// so that a lane's result never depends on W or on the instruction set. Included per target: no classic include
// guard.
#include <kinora/simd/targets.h>

#ifndef KINORA_WIDE_ONCE
#define KINORA_WIDE_ONCE
#include <array>
#include <cstdint>
#include <cstring>
namespace kinora {
// By the bits of a mask of 8 lanes: which of them are set, in order, and then the others. For Packer below.
inline constexpr std::array<uint8_t, 256 * 8> kPackedLanes = [] {
  std::array<uint8_t, 256 * 8> lanes{};
  for (uint32_t bits = 0; bits < 256; ++bits) {
    uint32_t k = 8 * bits;
    for (const bool isSet : {true, false})
      for (uint8_t lane = 0; lane < 8; ++lane)
        if ((bits >> lane & 1) == uint32_t(isSet)) lanes[k++] = lane;
  }
  return lanes;
}();
}  // namespace kinora
#endif

#if defined(KINORA_WIDE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_WIDE_H_TARGET
#undef KINORA_WIDE_H_TARGET
#else
#define KINORA_WIDE_H_TARGET
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

static_assert(HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3, "kernels are compiled for AVX2 and AVX-512 only");

#define KN_INLINE HWY_ATTR HWY_INLINE

template <int W>
struct Float;
template <int W>
struct Int;

// Lanes that take part. A mask only ever narrows.
template <int W>
struct Mask {
  using D = hn::FixedTag<float, W>;
  hn::Mask<D> m;
  KN_INLINE Mask() : m(hn::FirstN(D(), 0)) {}
  KN_INLINE Mask(hn::Mask<D> mm) : m(mm) {}
  KN_INLINE explicit Mask(bool b) : m(hn::FirstN(D(), b ? W : 0)) {}
  static KN_INLINE Mask firstN(int n) { return Mask(hn::FirstN(D(), size_t(n))); }
  friend KN_INLINE Mask operator&(Mask a, Mask b) { return Mask(hn::And(a.m, b.m)); }
  friend KN_INLINE Mask operator|(Mask a, Mask b) { return Mask(hn::Or(a.m, b.m)); }
  friend KN_INLINE Mask operator^(Mask a, Mask b) { return Mask(hn::Xor(a.m, b.m)); }
  friend KN_INLINE Mask operator!(Mask a) { return Mask(hn::Not(a.m)); }
  KN_INLINE Mask& operator&=(Mask b) { return *this = *this & b; }
  KN_INLINE Mask& operator|=(Mask b) { return *this = *this | b; }
  KN_INLINE bool any() const { return !hn::AllFalse(D(), m); }
  KN_INLINE bool all() const { return hn::AllTrue(D(), m); }
  KN_INLINE bool none() const { return hn::AllFalse(D(), m); }
  KN_INLINE int count() const { return int(hn::CountTrue(D(), m)); }
  // bit i is lane i
  KN_INLINE uint32_t bits() const {
    uint8_t b[8] = {0};
    hn::StoreMaskBits(D(), m, b);
    return (uint32_t(b[0]) | uint32_t(b[1]) << 8) & (W == 32 ? ~0u : ((1u << W) - 1u));
  }
};

template <int W>
struct Float {
  using D = hn::FixedTag<float, W>;
  using V = hn::Vec<D>;
  V v;
  KN_INLINE Float() : v(hn::Zero(D())) {}
  KN_INLINE Float(V x) : v(x) {}
  KN_INLINE Float(float x) : v(hn::Set(D(), x)) {}
  static KN_INLINE Float load(const float* p) { return Float(hn::LoadU(D(), p)); }
  static KN_INLINE Float lanes(float first, float step = 1) {  // first, first + step, ...
    return Float(hn::MulAdd(hn::Iota(D(), 0.f), hn::Set(D(), step), hn::Set(D(), first)));
  }
  KN_INLINE void store(float* p) const { hn::StoreU(v, D(), p); }
  KN_INLINE float lane0() const { return hn::GetLane(v); }
  friend KN_INLINE Float operator+(Float a, Float b) { return Float(hn::Add(a.v, b.v)); }
  friend KN_INLINE Float operator-(Float a, Float b) { return Float(hn::Sub(a.v, b.v)); }
  friend KN_INLINE Float operator*(Float a, Float b) { return Float(hn::Mul(a.v, b.v)); }
  friend KN_INLINE Float operator/(Float a, Float b) { return Float(hn::Div(a.v, b.v)); }
  friend KN_INLINE Float operator-(Float a) { return Float(hn::Neg(a.v)); }
  KN_INLINE Float& operator+=(Float b) { return *this = *this + b; }
  KN_INLINE Float& operator-=(Float b) { return *this = *this - b; }
  KN_INLINE Float& operator*=(Float b) { return *this = *this * b; }
  KN_INLINE Float& operator/=(Float b) { return *this = *this / b; }
  friend KN_INLINE Mask<W> operator<(Float a, Float b) { return Mask<W>(hn::Lt(a.v, b.v)); }
  friend KN_INLINE Mask<W> operator<=(Float a, Float b) { return Mask<W>(hn::Le(a.v, b.v)); }
  friend KN_INLINE Mask<W> operator>(Float a, Float b) { return Mask<W>(hn::Gt(a.v, b.v)); }
  friend KN_INLINE Mask<W> operator>=(Float a, Float b) { return Mask<W>(hn::Ge(a.v, b.v)); }
  friend KN_INLINE Mask<W> operator==(Float a, Float b) { return Mask<W>(hn::Eq(a.v, b.v)); }
  // not hn::Ne, which is false for NaN on x86 (an ordered comparison): x != x must find NaN
  friend KN_INLINE Mask<W> operator!=(Float a, Float b) { return !(a == b); }
};

// 32-bit integers; arithmetic wraps. Unsigned operations are named.
template <int W>
struct Int {
  using D = hn::FixedTag<int32_t, W>;
  using DU = hn::FixedTag<uint32_t, W>;
  using V = hn::Vec<D>;
  V v;
  KN_INLINE Int() : v(hn::Zero(D())) {}
  KN_INLINE Int(V x) : v(x) {}
  KN_INLINE Int(int32_t x) : v(hn::Set(D(), x)) {}
  KN_INLINE Int(uint32_t x) : v(hn::Set(D(), int32_t(x))) {}
  static KN_INLINE Int load(const int32_t* p) { return Int(hn::LoadU(D(), p)); }
  static KN_INLINE Int load(const uint32_t* p) { return Int(hn::LoadU(D(), reinterpret_cast<const int32_t*>(p))); }
  static KN_INLINE Int lanes(int32_t first) { return Int(hn::Iota(D(), first)); }
  KN_INLINE void store(int32_t* p) const { hn::StoreU(v, D(), p); }
  KN_INLINE void store(uint32_t* p) const { hn::StoreU(v, D(), reinterpret_cast<int32_t*>(p)); }
  KN_INLINE int32_t lane0() const { return hn::GetLane(v); }
  friend KN_INLINE Int operator+(Int a, Int b) { return Int(hn::Add(a.v, b.v)); }
  friend KN_INLINE Int operator-(Int a, Int b) { return Int(hn::Sub(a.v, b.v)); }
  friend KN_INLINE Int operator*(Int a, Int b) { return Int(hn::Mul(a.v, b.v)); }
  friend KN_INLINE Int operator&(Int a, Int b) { return Int(hn::And(a.v, b.v)); }
  friend KN_INLINE Int operator|(Int a, Int b) { return Int(hn::Or(a.v, b.v)); }
  friend KN_INLINE Int operator^(Int a, Int b) { return Int(hn::Xor(a.v, b.v)); }
  template <int K>
  KN_INLINE Int shl() const {
    return Int(hn::ShiftLeft<K>(v));
  }
  template <int K>
  KN_INLINE Int sar() const {
    return Int(hn::ShiftRight<K>(v));
  }  // arithmetic
  template <int K>
  KN_INLINE Int shr() const {  // logical
    return Int(hn::BitCast(D(), hn::ShiftRight<K>(hn::BitCast(DU(), v))));
  }
  friend KN_INLINE Mask<W> operator==(Int a, Int b) {
    return Mask<W>(hn::RebindMask(typename Mask<W>::D(), hn::Eq(a.v, b.v)));
  }
  friend KN_INLINE Mask<W> operator!=(Int a, Int b) { return !(a == b); }
  friend KN_INLINE Mask<W> operator<(Int a, Int b) {
    return Mask<W>(hn::RebindMask(typename Mask<W>::D(), hn::Lt(a.v, b.v)));
  }
  friend KN_INLINE Mask<W> operator>(Int a, Int b) { return b < a; }
  friend KN_INLINE Mask<W> operator>=(Int a, Int b) { return !(a < b); }
};

// ---- selection, comparison ----
template <int W>
KN_INLINE Float<W> select(Mask<W> m, Float<W> yes, Float<W> no) {
  return Float<W>(hn::IfThenElse(m.m, yes.v, no.v));
}
template <int W>
KN_INLINE Int<W> select(Mask<W> m, Int<W> yes, Int<W> no) {
  return Int<W>(hn::IfThenElse(hn::RebindMask(typename Int<W>::D(), m.m), yes.v, no.v));
}
template <int W>
KN_INLINE Float<W> zeroUnless(Mask<W> m, Float<W> x) {
  return Float<W>(hn::IfThenElseZero(m.m, x.v));
}
// IEEE minNum-free: min(a, b) = a < b ? a : b on every target, so that NaN behaves alike everywhere. That is what the
// instructions of x86 do: the second operand where either is NaN or both are zeros.
template <int W>
KN_INLINE Float<W> min(Float<W> a, Float<W> b) {
  return Float<W>(hn::Min(a.v, b.v));
}
template <int W>
KN_INLINE Float<W> max(Float<W> a, Float<W> b) {
  return Float<W>(hn::Max(a.v, b.v));
}
template <int W>
KN_INLINE Float<W> clamp(Float<W> x, Float<W> lo, Float<W> hi) {
  return min(max(x, lo), hi);
}
template <int W>
KN_INLINE Float<W> abs(Float<W> x) {
  return Float<W>(hn::Abs(x.v));
}
template <int W>
KN_INLINE Float<W> sqrt(Float<W> x) {
  return Float<W>(hn::Sqrt(x.v));
}
template <int W>
KN_INLINE Float<W> floor(Float<W> x) {
  return Float<W>(hn::Floor(x.v));
}
template <int W>
KN_INLINE Float<W> fma(Float<W> a, Float<W> b, Float<W> c) {
  return Float<W>(hn::MulAdd(a.v, b.v, c.v));
}  // a*b + c, one rounding
template <int W>
KN_INLINE Float<W> fnma(Float<W> a, Float<W> b, Float<W> c) {
  return Float<W>(hn::NegMulAdd(a.v, b.v, c.v));
}  // c - a*b, one rounding
template <int W>
KN_INLINE Float<W> fms(Float<W> a, Float<W> b, Float<W> c) {
  return Float<W>(hn::MulSub(a.v, b.v, c.v));
}  // a*b - c, one rounding
template <int W>
KN_INLINE Float<W> copySign(Float<W> magnitude, Float<W> sign) {
  return Float<W>(hn::CopySign(magnitude.v, sign.v));
}
template <int W>
KN_INLINE Float<W> lerp(Float<W> a, Float<W> b, Float<W> t) {
  return fma(t, b - a, a);
}
template <int W>
KN_INLINE Float<W> safeSqrt(Float<W> x) {
  return sqrt(max(x, Float<W>(0.f)));
}
// False for NaN and infinities.
template <int W>
KN_INLINE Mask<W> isFinite(Float<W> x) {
  return (x - x) == Float<W>(0.f);
}

// ---- conversions ----
template <int W>
KN_INLINE Int<W> toInt(Float<W> x) {
  return Int<W>(hn::ConvertTo(typename Int<W>::D(), x.v));
}  // towards zero
template <int W>
KN_INLINE Int<W> toNearestInt(Float<W> x) {
  return Int<W>(hn::NearestInt(x.v));
}  // half to even
template <int W>
KN_INLINE Float<W> toFloat(Int<W> x) {
  return Float<W>(hn::ConvertTo(typename Float<W>::D(), x.v));
}
template <int W>
KN_INLINE Float<W> asFloat(Int<W> x) {
  return Float<W>(hn::BitCast(typename Float<W>::D(), x.v));
}
template <int W>
KN_INLINE Int<W> asInt(Float<W> x) {
  return Int<W>(hn::BitCast(typename Int<W>::D(), x.v));
}
// Uniform in [0, 1) from the top 24 bits of an unsigned word; exact.
template <int W>
KN_INLINE Float<W> toUnitFloat(Int<W> bits) {
  return toFloat(bits.template shr<8>()) * Float<W>(1.f / 16777216.f);
}

// ---- memory ----
template <int W>
KN_INLINE Float<W> gather(const float* base, Int<W> index) {
  if constexpr (W == 1)
    return Float<W>(base[index.lane0()]);  // the gather instruction costs as much for one lane as for four
  return Float<W>(hn::GatherIndex(typename Float<W>::D(), base, index.v));
}
template <int W>
KN_INLINE Int<W> gather(const int32_t* base, Int<W> index) {
  if constexpr (W == 1) return Int<W>(base[index.lane0()]);
  return Int<W>(hn::GatherIndex(typename Int<W>::D(), base, index.v));
}
template <int W>
KN_INLINE Int<W> gather(const uint32_t* base, Int<W> index) {
  return gather(reinterpret_cast<const int32_t*>(base), index);
}
// base[index[lane]] = x[lane] where m; lanes must name distinct places (or order does not matter).
template <int W>
KN_INLINE void scatter(Mask<W> m, Float<W> x, float* base, Int<W> index) {
  alignas(64) float xs[W];
  alignas(64) int32_t is[W];
  x.store(xs);
  index.store(is);
  for (uint32_t b = m.bits(); b; b &= b - 1) {
    const int i = __builtin_ctz(b);
    base[is[i]] = xs[i];
  }
}
template <int W>
KN_INLINE void storeWhere(Mask<W> m, Float<W> x, float* p) {
  select(m, x, Float<W>::load(p)).store(p);
}
// Writes the lanes of a mask packed, for any number of arrays: the order is found once. Whole vectors are stored:
// keep W of slack behind what is written (stores under a mask are slow on some CPUs).
template <int W>
struct Packer {
  using DI = typename Int<W>::D;
  const int count;
  const decltype(hn::IndicesFromVec(DI(), hn::Zero(DI()))) order;
  KN_INLINE explicit Packer(Mask<W> m) : count(m.count()), order(hn::IndicesFromVec(DI(), inOrder(m))) {}
  KN_INLINE void put(Float<W> x, float* p) const { put(asInt(x), reinterpret_cast<int32_t*>(p)); }
  KN_INLINE void put(Int<W> x, int32_t* p) const { hn::StoreU(hn::TableLookupLanes(x.v, order), DI(), p); }
  KN_INLINE void put(Int<W> x, uint32_t* p) const { put(x, reinterpret_cast<int32_t*>(p)); }

 private:
  // Without the instruction for it, Highway's Compress() has a table that g++ 12 copies to the stack at each use.
  static KN_INLINE hn::Vec<DI> inOrder(Mask<W> m) {
    if constexpr (W == 8 && HWY_TARGET == HWY_AVX2)
      return hn::PromoteTo(DI(), hn::LoadU(hn::Rebind<uint8_t, DI>(), &kPackedLanes[8 * size_t(m.bits())]));
    else
      return hn::Compress(hn::Iota(DI(), 0), hn::RebindMask(DI(), m.m));
  }
};

// W indices into arrays by path slot. Groups whose paths all live list their slots in order: then arrays are loaded
// and stored as vectors, else gathered and scattered.
template <int W>
struct Slots {
  Int<W> s;
  const uint32_t first;
  const bool run;
  KN_INLINE explicit Slots(Int<W> slots)
      : s(slots), first(uint32_t(slots.lane0())), run((slots == Int<W>::lanes(slots.lane0())).all()) {}
  static KN_INLINE Slots load(const uint32_t* p) { return Slots(Int<W>::load(p)); }
  // Of a list that ends after n slots, and of which nothing beyond may be read: the first of them fills the lanes
  // left.
  static KN_INLINE Slots loadUpTo(const uint32_t* p, uint32_t n) {
    if (n >= uint32_t(W)) return load(p);
    alignas(64) uint32_t last[W];
    for (uint32_t k = 0; k < uint32_t(W); ++k) last[k] = p[k < n ? k : 0];
    return load(last);
  }
  KN_INLINE Float<W> get(const float* p) const { return run ? Float<W>::load(p + first) : gather(p, s); }
  KN_INLINE Int<W> get(const uint32_t* p) const { return run ? Int<W>::load(p + first) : gather(p, s); }
  KN_INLINE void put(Mask<W> m, Float<W> x, float* p) const {
    if (run)
      storeWhere(m, x, p + first);
    else
      scatter(m, x, p, s);
  }
  KN_INLINE void put(Mask<W> m, Int<W> x, uint32_t* p) const { put(m, asFloat(x), reinterpret_cast<float*>(p)); }
};

// Sum of the lanes in lane order (the same for every W only if the caller adds lane by lane; use for statistics).
template <int W>
KN_INLINE float sumLanes(Float<W> x) {
  alignas(64) float xs[W];
  x.store(xs);
  float s = 0;
  for (int i = 0; i < W; ++i) s += xs[i];
  return s;
}

// ---- three floats ----
template <int W>
struct Vec3 {
  Float<W> x, y, z;
  KN_INLINE Vec3() {}
  KN_INLINE Vec3(Float<W> a, Float<W> b, Float<W> c) : x(a), y(b), z(c) {}
  KN_INLINE explicit Vec3(float a) : x(a), y(a), z(a) {}
  static KN_INLINE Vec3 load(const float* const p[3], size_t i) {
    return {Float<W>::load(p[0] + i), Float<W>::load(p[1] + i), Float<W>::load(p[2] + i)};
  }
  static KN_INLINE Vec3 load(float* const p[3], size_t i) {
    return {Float<W>::load(p[0] + i), Float<W>::load(p[1] + i), Float<W>::load(p[2] + i)};
  }
  static KN_INLINE Vec3 gather(const float* const p[3], Int<W> i) {
    return {HWY_NAMESPACE::gather(p[0], i), HWY_NAMESPACE::gather(p[1], i), HWY_NAMESPACE::gather(p[2], i)};
  }
  static KN_INLINE Vec3 get(const float* const p[3], const Slots<W>& s) {
    return {s.get(p[0]), s.get(p[1]), s.get(p[2])};
  }
  static KN_INLINE Vec3 get(float* const p[3], const Slots<W>& s) { return {s.get(p[0]), s.get(p[1]), s.get(p[2])}; }
  static KN_INLINE Vec3 gather(float* const p[3], Int<W> i) {
    return {HWY_NAMESPACE::gather(p[0], i), HWY_NAMESPACE::gather(p[1], i), HWY_NAMESPACE::gather(p[2], i)};
  }
  KN_INLINE void store(float* const p[3], size_t i) const {
    x.store(p[0] + i);
    y.store(p[1] + i);
    z.store(p[2] + i);
  }
  friend KN_INLINE Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend KN_INLINE Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend KN_INLINE Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
  friend KN_INLINE Vec3 operator*(Vec3 a, Float<W> s) { return {a.x * s, a.y * s, a.z * s}; }
  friend KN_INLINE Vec3 operator*(Float<W> s, Vec3 a) { return a * s; }
  friend KN_INLINE Vec3 operator/(Vec3 a, Float<W> s) { return {a.x / s, a.y / s, a.z / s}; }
  friend KN_INLINE Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  KN_INLINE Vec3& operator+=(Vec3 b) { return *this = *this + b; }
  KN_INLINE Vec3& operator-=(Vec3 b) { return *this = *this - b; }
  KN_INLINE Vec3& operator*=(Float<W> s) { return *this = *this * s; }
  KN_INLINE Vec3& operator*=(Vec3 b) { return *this = *this * b; }
  KN_INLINE void pack(const Packer<W>& k, float* const p[3], size_t at) const {
    k.put(x, p[0] + at);
    k.put(y, p[1] + at);
    k.put(z, p[2] + at);
  }
};
template <int W>
using Rgb = Vec3<W>;  // colour: x, y, z are r, g, b

template <int W>
KN_INLINE Vec3<W> select(Mask<W> m, Vec3<W> a, Vec3<W> b) {
  return {select(m, a.x, b.x), select(m, a.y, b.y), select(m, a.z, b.z)};
}
template <int W>
KN_INLINE Vec3<W> zeroUnless(Mask<W> m, Vec3<W> a) {
  return {zeroUnless(m, a.x), zeroUnless(m, a.y), zeroUnless(m, a.z)};
}
template <int W>
KN_INLINE Float<W> dot(Vec3<W> a, Vec3<W> b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <int W>
KN_INLINE Vec3<W> cross(Vec3<W> a, Vec3<W> b) {
  return {fms(a.y, b.z, a.z * b.y), fms(a.z, b.x, a.x * b.z), fms(a.x, b.y, a.y * b.x)};
}
template <int W>
KN_INLINE Vec3<W> fma(Vec3<W> a, Float<W> s, Vec3<W> b) {
  return {fma(a.x, s, b.x), fma(a.y, s, b.y), fma(a.z, s, b.z)};
}
template <int W>
KN_INLINE Float<W> length(Vec3<W> a) {
  return sqrt(dot(a, a));
}
template <int W>
KN_INLINE Vec3<W> normalize(Vec3<W> a) {
  return a * (Float<W>(1.f) / sqrt(dot(a, a)));
}
template <int W>
KN_INLINE Vec3<W> lerp(Vec3<W> a, Vec3<W> b, Float<W> t) {
  return {lerp(a.x, b.x, t), lerp(a.y, b.y, t), lerp(a.z, b.z, t)};
}
template <int W>
KN_INLINE Float<W> maxComponent(Vec3<W> a) {
  return max(a.x, max(a.y, a.z));
}
template <int W>
KN_INLINE Float<W> average(Vec3<W> a) {
  return (a.x + a.y + a.z) * Float<W>(1.f / 3.f);
}
// Rec. 709 luminance.
template <int W>
KN_INLINE Float<W> luminance(Vec3<W> c) {
  return fma(c.x, Float<W>(0.2126f), fma(c.y, Float<W>(0.7152f), c.z * Float<W>(0.0722f)));
}
template <int W>
KN_INLINE Mask<W> isFinite(Vec3<W> a) {
  return isFinite(a.x + a.y + a.z);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
