// Sixteen lanes on a CPU that has eight: a pair of vectors that answers to the names of Highway which
// kinora/simd/wide.h and src/language/library use. With it the machine's kernels of width 16 are compiled for AVX2,
// from the same source, for tests on CPUs without AVX-512. Included before any header of ours that uses Highway; one
// target only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <kinora/simd/targets.h>
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_AVX3 | HWY_AVX3_DL | HWY_SSE4 | HWY_SSSE3)
// the kernel file is compiled once, as it stands
#define HIGHWAY_HWY_FOREACH_TARGET_H_
#include <hwy/highway.h>
#undef HWY_ONCE
#define HWY_ONCE 1

HWY_BEFORE_NAMESPACE();
namespace hwy {
namespace HWY_NAMESPACE {

#define KN_P HWY_ATTR HWY_INLINE

template <class Type>
struct PairTag {
  using T = Type;
  using Half = Simd<Type, 32 / sizeof(Type), 0>;
};
namespace detail {
template <>
struct FixedTagChecker<float, 16> {
  using type = PairTag<float>;
};
template <>
struct FixedTagChecker<int32_t, 16> {
  using type = PairTag<int32_t>;
};
template <>
struct FixedTagChecker<uint32_t, 16> {
  using type = PairTag<uint32_t>;
};
template <>
struct FixedTagChecker<uint8_t, 64> {
  using type = PairTag<uint8_t>;
};
}  // namespace detail

template <class V>
struct PairVec {
  V a, b;
  KN_P PairVec(V x, V y) : a(x), b(y) {}
};
template <class V>
KN_P PairVec<V> pairOf(V x, V y) {
  return PairVec<V>(x, y);
}
template <class M>
struct PairMask {
  M a, b;
  KN_P PairMask(M x, M y) : a(x), b(y) {}
};
template <class M>
KN_P PairMask<M> maskPairOf(M x, M y) {
  return PairMask<M>(x, y);
}

#define KN_UNARY(Name)                   \
  template <class V>                     \
  KN_P PairVec<V> Name(PairVec<V> x) {   \
    return pairOf(Name(x.a), Name(x.b)); \
  }
#define KN_BINARY(Name)                              \
  template <class V>                                 \
  KN_P PairVec<V> Name(PairVec<V> x, PairVec<V> y) { \
    return pairOf(Name(x.a, y.a), Name(x.b, y.b));   \
  }
#define KN_TERNARY(Name)                                           \
  template <class V>                                               \
  KN_P PairVec<V> Name(PairVec<V> x, PairVec<V> y, PairVec<V> z) { \
    return pairOf(Name(x.a, y.a, z.a), Name(x.b, y.b, z.b));       \
  }
#define KN_COMPARE(Name)                               \
  template <class V>                                   \
  KN_P auto Name(PairVec<V> x, PairVec<V> y) {         \
    return maskPairOf(Name(x.a, y.a), Name(x.b, y.b)); \
  }
KN_UNARY(Neg)
KN_UNARY(Abs)
KN_UNARY(Sqrt)
KN_UNARY(Floor)
KN_UNARY(Ceil)
KN_UNARY(Trunc)
KN_BINARY(Add)
KN_BINARY(Sub)
KN_BINARY(Mul)
KN_BINARY(Div)
KN_BINARY(Min)
KN_BINARY(Max)
KN_BINARY(And)
KN_BINARY(Or)
KN_BINARY(Xor)
KN_BINARY(CopySign)
KN_BINARY(Shl)
KN_BINARY(Shr)
KN_BINARY(TableLookupBytes)
KN_TERNARY(MulAdd)
KN_TERNARY(NegMulAdd)
KN_TERNARY(MulSub)
KN_COMPARE(Lt)
KN_COMPARE(Le)
KN_COMPARE(Gt)
KN_COMPARE(Ge)
KN_COMPARE(Eq)
#undef KN_UNARY
#undef KN_BINARY
#undef KN_TERNARY
#undef KN_COMPARE
template <class V>
KN_P auto NearestInt(PairVec<V> x) {
  return pairOf(NearestInt(x.a), NearestInt(x.b));
}
template <int K, class V>
KN_P PairVec<V> ShiftLeft(PairVec<V> x) {
  return pairOf(ShiftLeft<K>(x.a), ShiftLeft<K>(x.b));
}
template <int K, class V>
KN_P PairVec<V> ShiftRight(PairVec<V> x) {
  return pairOf(ShiftRight<K>(x.a), ShiftRight<K>(x.b));
}
template <int K, class V>
KN_P PairVec<V> RotateRight(PairVec<V> x) {
  return pairOf(RotateRight<K>(x.a), RotateRight<K>(x.b));
}
template <class V>
KN_P auto GetLane(PairVec<V> x) {
  return GetLane(x.a);
}

// ---- with a tag ----
template <class T>
KN_P auto Zero(PairTag<T>) {
  const typename PairTag<T>::Half h;
  return pairOf(Zero(h), Zero(h));
}
template <class T>
KN_P auto Set(PairTag<T>, T x) {
  const typename PairTag<T>::Half h;
  return pairOf(Set(h, x), Set(h, x));
}
template <class T, class T2>
KN_P auto Iota(PairTag<T>, T2 first) {
  const typename PairTag<T>::Half h;
  return pairOf(Iota(h, T(first)), Iota(h, T(T(first) + T(Lanes(h)))));
}
template <class T>
KN_P auto LoadU(PairTag<T>, const T* p) {
  const typename PairTag<T>::Half h;
  return pairOf(LoadU(h, p), LoadU(h, p + Lanes(h)));
}
template <class T>
KN_P auto LoadDup128(PairTag<T>, const T* p) {
  const typename PairTag<T>::Half h;
  return pairOf(LoadDup128(h, p), LoadDup128(h, p));
}
template <class V, class T>
KN_P void StoreU(PairVec<V> x, PairTag<T>, T* p) {
  const typename PairTag<T>::Half h;
  StoreU(x.a, h, p);
  StoreU(x.b, h, p + Lanes(h));
}
template <class T, class V>
KN_P auto BitCast(PairTag<T>, PairVec<V> x) {
  const typename PairTag<T>::Half h;
  return pairOf(BitCast(h, x.a), BitCast(h, x.b));
}
template <class T, class V>
KN_P auto ConvertTo(PairTag<T>, PairVec<V> x) {
  const typename PairTag<T>::Half h;
  return pairOf(ConvertTo(h, x.a), ConvertTo(h, x.b));
}
template <class T, class V>
KN_P auto GatherIndex(PairTag<T>, const T* base, PairVec<V> i) {
  const typename PairTag<T>::Half h;
  return pairOf(GatherIndex(h, base, i.a), GatherIndex(h, base, i.b));
}

// ---- masks ----
template <class V>
KN_P auto MaskFromVec(PairVec<V> x) {
  return maskPairOf(MaskFromVec(x.a), MaskFromVec(x.b));
}
template <class T>
KN_P auto FirstN(PairTag<T>, size_t n) {
  const typename PairTag<T>::Half h;
  const size_t half = Lanes(h);
  return maskPairOf(FirstN(h, n < half ? n : half), FirstN(h, n < half ? 0 : n - half));
}
template <class T, class M>
KN_P auto RebindMask(PairTag<T>, PairMask<M> m) {
  const typename PairTag<T>::Half h;
  return maskPairOf(RebindMask(h, m.a), RebindMask(h, m.b));
}
template <class M>
KN_P PairMask<M> And(PairMask<M> x, PairMask<M> y) {
  return maskPairOf(And(x.a, y.a), And(x.b, y.b));
}
template <class M>
KN_P PairMask<M> Or(PairMask<M> x, PairMask<M> y) {
  return maskPairOf(Or(x.a, y.a), Or(x.b, y.b));
}
template <class M>
KN_P PairMask<M> Xor(PairMask<M> x, PairMask<M> y) {
  return maskPairOf(Xor(x.a, y.a), Xor(x.b, y.b));
}
template <class M>
KN_P PairMask<M> Not(PairMask<M> x) {
  return maskPairOf(Not(x.a), Not(x.b));
}
template <class T, class M>
KN_P bool AllFalse(PairTag<T>, PairMask<M> m) {
  const typename PairTag<T>::Half h;
  return AllFalse(h, m.a) && AllFalse(h, m.b);
}
template <class T, class M>
KN_P bool AllTrue(PairTag<T>, PairMask<M> m) {
  const typename PairTag<T>::Half h;
  return AllTrue(h, m.a) && AllTrue(h, m.b);
}
template <class T, class M>
KN_P size_t CountTrue(PairTag<T>, PairMask<M> m) {
  const typename PairTag<T>::Half h;
  return CountTrue(h, m.a) + CountTrue(h, m.b);
}
template <class T, class M>
KN_P size_t StoreMaskBits(PairTag<T>, PairMask<M> m, uint8_t* bits) {
  const typename PairTag<T>::Half h;
  StoreMaskBits(h, m.a, bits);
  StoreMaskBits(h, m.b, bits + 1);
  return 2;
}
template <class M, class V>
KN_P PairVec<V> IfThenElse(PairMask<M> m, PairVec<V> yes, PairVec<V> no) {
  return pairOf(IfThenElse(m.a, yes.a, no.a), IfThenElse(m.b, yes.b, no.b));
}
template <class M, class V>
KN_P PairVec<V> IfThenElseZero(PairMask<M> m, PairVec<V> yes) {
  return pairOf(IfThenElseZero(m.a, yes.a), IfThenElseZero(m.b, yes.b));
}
#undef KN_P

}  // namespace HWY_NAMESPACE
}  // namespace hwy
HWY_AFTER_NAMESPACE();

// what src/language/vm calls its functions must not meet the library's own
#define KINORA_ONLY_WIDTH_16
#define arithmeticKernels pairedArithmeticKernels
#define mathKernels pairedMathKernels
#define mixedKernels pairedMixedKernels
#define integerKernels pairedIntegerKernels
#define memoryKernels pairedMemoryKernels
#define vectorKernels pairedVectorKernels
#define noiseKernels pairedNoiseKernels
#define colorKernels pairedColorKernels
#define splineKernels pairedSplineKernels
#define fusedKernels pairedFusedKernels
