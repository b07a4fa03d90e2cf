// The integer hash under every noise of the language: Bob Jenkins' published lookup3
// (burtleburtle.net/bob/c/lookup3.c, public domain description), of one to five words. Called by the noises, and by
// the machine for hash(). Strings hash in string_hash.h. Included per target.
#include "language/library/round_math.h"

#if defined(KINORA_LANGUAGE_HASH_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_HASH_H_TARGET
#undef KINORA_LANGUAGE_HASH_H_TARGET
#else
#define KINORA_LANGUAGE_HASH_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

template <int K, int W>
KN_INLINE Int<W> rotate(Int<W> x) {
  const typename Int<W>::DU u;
#if HWY_TARGET == HWY_AVX2
  if constexpr (K % 8 == 0 && W > 1) {  // one shuffle of bytes for two shifts and an or; AVX-512 rotates
    constexpr int b = 4 - K / 8;
    const hn::FixedTag<uint8_t, 4 * W> bytes;
    alignas(16) static constexpr uint8_t kFrom[16] = {
        (0 + b) % 4,      (1 + b) % 4,      (2 + b) % 4,      (3 + b) % 4,     (0 + b) % 4 + 4, (1 + b) % 4 + 4,
        (2 + b) % 4 + 4,  (3 + b) % 4 + 4,  (0 + b) % 4 + 8,  (1 + b) % 4 + 8, (2 + b) % 4 + 8, (3 + b) % 4 + 8,
        (0 + b) % 4 + 12, (1 + b) % 4 + 12, (2 + b) % 4 + 12, (3 + b) % 4 + 12};
    const auto r = hn::TableLookupBytes(hn::BitCast(bytes, x.v), hn::LoadDup128(bytes, kFrom));
    return Int<W>(hn::BitCast(typename Int<W>::D(), r));
  }
#endif
  return Int<W>(hn::BitCast(typename Int<W>::D(), hn::RotateRight<32 - K>(hn::BitCast(u, x.v))));
}
// What n words start from.
KN_INLINE constexpr uint32_t hashStart(int words) { return 0xdeadbeefu + (uint32_t(words) << 2) + 13u; }

template <int W>
KN_INLINE void hashMix(Int<W>& a, Int<W>& b, Int<W>& c) {
  a = (a - c) ^ rotate<4>(c), c = c + b;
  b = (b - a) ^ rotate<6>(a), a = a + c;
  c = (c - b) ^ rotate<8>(b), b = b + a;
  a = (a - c) ^ rotate<16>(c), c = c + b;
  b = (b - a) ^ rotate<19>(a), a = a + c;
  c = (c - b) ^ rotate<4>(b), b = b + a;
}
// The end of a hash in two parts: the first does not touch a, so that lattice corners that differ in a alone share
// it.
template <int W>
KN_INLINE Int<W> hashFinishBC(Int<W> b, Int<W> c) {
  return (c ^ b) - rotate<14>(b);
}
template <int W>
KN_INLINE Int<W> hashFinishA(Int<W> a, Int<W> b, Int<W> c) {
  a = (a ^ c) - rotate<11>(c);
  b = (b ^ a) - rotate<25>(a);
  c = (c ^ b) - rotate<16>(b);
  a = (a ^ c) - rotate<4>(c);
  b = (b ^ a) - rotate<14>(a);
  return (c ^ b) - rotate<24>(b);
}
template <int W>
KN_INLINE Int<W> hashFinish(Int<W> a, Int<W> b, Int<W> c) {
  return hashFinishA(a, b, hashFinishBC(b, c));
}

template <int W>
KN_INLINE Int<W> hashWords(Int<W> x) {
  const Int<W> s(hashStart(1));
  return hashFinish(s + x, s, s);
}
template <int W>
KN_INLINE Int<W> hashWords(Int<W> x, Int<W> y) {
  const Int<W> s(hashStart(2));
  return hashFinish(s + x, s + y, s);
}
template <int W>
KN_INLINE Int<W> hashWords(Int<W> x, Int<W> y, Int<W> z) {
  const Int<W> s(hashStart(3));
  return hashFinish(s + x, s + y, s + z);
}
template <int W>
KN_INLINE Int<W> hashWords(Int<W> x, Int<W> y, Int<W> z, Int<W> w) {
  const Int<W> s(hashStart(4));
  Int<W> a = s + x, b = s + y, c = s + z;
  hashMix(a, b, c);
  return hashFinish(a + w, b, c);
}
template <int W>
KN_INLINE Int<W> hashWords(Int<W> x, Int<W> y, Int<W> z, Int<W> w, Int<W> v) {
  const Int<W> s(hashStart(5));
  Int<W> a = s + x, b = s + y, c = s + z;
  hashMix(a, b, c);
  return hashFinish(a + w, b + v, c);
}
// Of the first N words.
template <int N, int W>
KN_INLINE Int<W> hashOf(const Int<W>* k) {
  if constexpr (N == 1)
    return hashWords(k[0]);
  else if constexpr (N == 2)
    return hashWords(k[0], k[1]);
  else if constexpr (N == 3)
    return hashWords(k[0], k[1], k[2]);
  else if constexpr (N == 4)
    return hashWords(k[0], k[1], k[2], k[3]);
  else
    return hashWords(k[0], k[1], k[2], k[3], k[4]);
}
// The language's hash() of N floats: of their bits, so -0 and +0 differ.
template <int N, int W>
KN_INLINE Int<W> hashFloats(const Float<W>* x) {
  Int<W> k[N];
  for (int i = 0; i < N; ++i) k[i] = asInt(x[i]);
  return hashOf<N>(k);
}

// An unsigned word over 2^32, rounded to nearest: the largest 128 words give 1. Halves convert exactly; their sum is
// rounded once.
template <int W>
KN_INLINE Float<W> toZeroOne(Int<W> h) {
  using F = Float<W>;
  const F u = toFloat(h.template shr<16>()) * F(65536.f) + toFloat(h & Int<W>(0xffff));
  return u * F(1.f / 4294967296.f);
}

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
