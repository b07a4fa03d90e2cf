// Random numbers by address: (seed of the pixel, sample index, dimension) -> two numbers in [0, 1). Nothing is drawn
// from a stream, so a sample's numbers do not depend on what else was rendered. The table holds (0,2)
// sequences (Owen-scrambled Sobol pairs, src/sampling). A hash picks the sequence, shuffles the index so that every aligned
// block of 2^k samples stays one (a bit may change with those above it only), and exclusive-ors the digits, which
// keeps all base-2 strata. The shuffle must not be a mere exclusive or: sample 2k + 1 of all these sequences lies in
// the other half than sample 2k, so that the leading digits of any two dimensions would agree. The first dimensions of
// a camera path have fixed orders in place of hashed shuffles, so that they are stratified with each other as well
// (sampling/matched_orders.h). Included per target.
#include <kinora/sample_table.h>
#include <kinora/simd/wide.h>

#if defined(KINORA_RANDOM_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_RANDOM_H_TARGET
#undef KINORA_RANDOM_H_TARGET
#else
#define KINORA_RANDOM_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Int<W> hashWords(Int<W> a, Int<W> b) {
  Int<W> x = a ^ (b * Int<W>(0x9E3779B9u) + Int<W>(0x85EBCA6Bu));
  x = x ^ x.template shr<16>();
  x = x * Int<W>(0x7feb352du);
  x = x ^ x.template shr<15>();
  x = x * Int<W>(0x846ca68bu);
  return x ^ x.template shr<16>();
}

// The low 16 bits in reverse.
template <int W>
KN_INLINE Int<W> reverse16(Int<W> x) {
  using I = Int<W>;
  x = ((x & I(0x5555)).template shl<1>()) | (x.template shr<1>() & I(0x5555));
  x = ((x & I(0x3333)).template shl<2>()) | (x.template shr<2>() & I(0x3333));
  x = ((x & I(0x0f0f)).template shl<4>()) | (x.template shr<4>() & I(0x0f0f));
  return ((x & I(0x00ff)).template shl<8>()) | (x.template shr<8>() & I(0x00ff));
}

// The place of a sample within a set, shuffled by hashes: nested, in reversed bit order, where products and sums carry
// the right way (Laine and Karras' hash, EGSR 2011, with N. Vegdahl's constants, 2021). Bits above logSamples are waste.
template <int W>
KN_INLINE Int<W> shuffled(const SampleTable& t, Int<W> sample, Int<W> h, Int<W> h2) {
  const Int<W> h4 = h ^ h.template shr<15>();
  Int<W> x = Int<W>(hn::BitCast(
      typename Int<W>::D(),
      hn::ShiftRightSame(hn::BitCast(typename Int<W>::DU(), reverse16(sample).v), int(16 - t.logSamples))));
  x = x ^ (x * Int<W>(0x3d20adeau));
  x = x + h4.template shr<4>();
  x = x * (h2.template shr<16>() | Int<W>(1));
  x = x ^ (x * Int<W>(0x05526c56u));
  return x ^ (x * Int<W>(0x53a22864u));
}

// Two numbers in [0, 1) for each lane.
template <int W>
KN_INLINE void draw2(const SampleTable& t, Int<W> seed, Int<W> sample, uint32_t dimension, Float<W>& u, Float<W>& v) {
  const Int<W> mask(uint32_t((1u << t.logSamples) - 1));
  // samples beyond the table's length go on with other sequences
  Int<W> h = hashWords(seed, Int<W>(dimension));
  Int<W> high = Int<W>(hn::BitCast(
      typename Int<W>::D(), hn::ShiftRightSame(hn::BitCast(typename Int<W>::DU(), sample.v), int(t.logSamples))));
  h = h ^ (high * Int<W>(0xC2B2AE35u));
  const Int<W> set = h & Int<W>(uint32_t((1u << t.logSets) - 1));
  const Int<W> h2 = h * Int<W>(0x2C1B3C6Du);
  const Int<W> h3 = (h ^ h.template shr<13>()) * Int<W>(0x297A2D39u);
  const uint32_t row = dimension < kMatchedDimensions ? t.rowOf[dimension] : kHashedOrder;
  const Int<W> place = row == kHashedOrder ? shuffled(t, sample, h, h2) & mask
                                           : gather(t.orders, (sample & mask) + Int<W>(row << t.logSamples));
  const Int<W> index = place + set * Int<W>(uint32_t(1u << t.logSamples));
  u = toUnitFloat(gather(t.xs, index) ^ h3);
  v = toUnitFloat(gather(t.ys, index) ^ (h3 * Int<W>(0x165667B1u) + h2));
}
// For unbounded loops (tracking, rejection): plain hashes of an event counter.
template <int W>
KN_INLINE Float<W> drawHashed(Int<W> seed, Int<W> sample, uint32_t dimension, Int<W> event) {
  return toUnitFloat(hashWords(hashWords(hashWords(seed, sample), Int<W>(dimension ^ 0xA511E9B3u)), event));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
