// Words of records that lie in memory each at a place of its own, one record a lane. Included per target, after
// wide.h: no classic include guard.
#include <kinora/simd/wide.h>

#if defined(KINORA_RECORDS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_RECORDS_H_TARGET
#undef KINORA_RECORDS_H_TARGET
#else
#define KINORA_RECORDS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// out[k], lane l: word k of the four that begin at from[l]. Loads of four and a transposition: gathers ask for each
// word by itself, and what is put together lane by lane waits for its stores.
template <int W>
KN_INLINE void loadFours(const float* const from[W], Float<W> out[4]) {
  if constexpr (W == 1) {
    for (size_t k = 0; k < 4; ++k) out[k] = Float<W>(from[0][k]);
  } else {
    const hn::FixedTag<float, 4> d4;
    const typename Float<W>::D d;
    const hn::FixedTag<double, W / 2> pairs;
    const auto four = [&](int lane) HWY_ATTR { return hn::LoadU(d4, from[lane]); };
    // Lanes j, j + 4, ...: one in each block of 128 bits.
    const auto row = [&](int j) HWY_ATTR {
      if constexpr (W == 4) {
        return four(j);
      } else {
        const hn::FixedTag<float, 8> d8;
        const auto two = [&](int lane) HWY_ATTR { return hn::Combine(d8, four(lane + 4), four(lane)); };
        if constexpr (W == 8)
          return two(j);
        else
          return hn::Combine(d, two(j + 8), two(j));
      }
    };
    const auto r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
    const auto low = [&](auto x, auto y) HWY_ATTR { return hn::BitCast(pairs, hn::InterleaveLower(d, x, y)); };
    const auto high = [&](auto x, auto y) HWY_ATTR { return hn::BitCast(pairs, hn::InterleaveUpper(d, x, y)); };
    const auto l01 = low(r0, r1), l23 = low(r2, r3), h01 = high(r0, r1), h23 = high(r2, r3);
    out[0] = Float<W>(hn::BitCast(d, hn::InterleaveLower(pairs, l01, l23)));
    out[1] = Float<W>(hn::BitCast(d, hn::InterleaveUpper(pairs, l01, l23)));
    out[2] = Float<W>(hn::BitCast(d, hn::InterleaveLower(pairs, h01, h23)));
    out[3] = Float<W>(hn::BitCast(d, hn::InterleaveUpper(pairs, h01, h23)));
  }
}

// The same of two words.
template <int W>
KN_INLINE void loadPairs(const float* const from[W], Float<W> out[2]) {
  if constexpr (W == 1) {
    for (size_t k = 0; k < 2; ++k) out[k] = Float<W>(from[0][k]);
  } else {
    const hn::FixedTag<float, 4> d4;
    const typename Float<W>::D d;
    const auto pair = [&](int lane) HWY_ATTR { return hn::LoadU(hn::FixedTag<float, 2>(), from[lane]); };
    // In each block of 128 bits lanes j and j + 1 of its four.
    const auto row = [&](int j) HWY_ATTR {
      const auto block = [&](int lane) HWY_ATTR { return hn::Combine(d4, pair(lane + 1), pair(lane)); };
      if constexpr (W == 4) {
        return block(j);
      } else {
        const hn::FixedTag<float, 8> d8;
        const auto two = [&](int lane) HWY_ATTR { return hn::Combine(d8, block(lane + 4), block(lane)); };
        if constexpr (W == 8)
          return two(j);
        else
          return hn::Combine(d, two(j + 8), two(j));
      }
    };
    const auto r0 = row(0), r1 = row(2);
    const auto even = hn::InterleaveLower(d, r0, r1), odd = hn::InterleaveUpper(d, r0, r1);
    out[0] = Float<W>(hn::InterleaveLower(d, even, odd));
    out[1] = Float<W>(hn::InterleaveUpper(d, even, odd));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
