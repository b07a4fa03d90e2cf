// simd/wide.h: packing and access by slot do what a loop over lanes does, at every width and for every mask; minima
// and maxima treat NaN and signed zero alike at every width, which "the same bits at all widths" stands on.
#define KINORA_KERNEL_FILE "math/wide_test.cpp"
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/simd/wide.h>

#ifndef WIDE_TEST_ONCE
#define WIDE_TEST_ONCE
namespace kinora::wideTest {
struct Data {
  uint32_t mask = 0;
  float in[16], packed[32];
  uint32_t slots[16], ids[32];
  float table[64], got[16];
  float pairs[2][64], least[64], most[64];
  int count = 0;
  uint32_t listed = 1, tail[16];
};
}  // namespace kinora::wideTest
#endif

KINORA_KERNELS_BEGIN
using wideTest::Data;

template <int W>
HWY_ATTR void run(Data& d) {
  alignas(64) float bits[W];
  for (int i = 0; i < W; ++i) bits[i] = float(d.mask >> i & 1);
  const Mask<W> m = Float<W>::load(bits) > Float<W>(0.5f);
  const Packer<W> pack(m);
  pack.put(Float<W>::load(d.in), d.packed);
  pack.put(Int<W>::load(d.slots), d.ids);
  d.count = pack.count;
  const Slots<W> s = Slots<W>::load(d.slots);
  s.get(d.table).store(d.got);
  Slots<W>::loadUpTo(d.slots, d.listed).s.store(d.tail);
  s.put(m, Float<W>::load(d.in), d.table);
  for (int i = 0; i < 64; i += W) {
    const Float<W> a = Float<W>::load(d.pairs[0] + i), b = Float<W>::load(d.pairs[1] + i);
    min(a, b).store(d.least + i);
    max(a, b).store(d.most + i);
  }
}
#define KN_X(W) \
  [[maybe_unused]] HWY_ATTR void run##W(Data& d) { run<W>(d); }
KN_EACH_WIDTH(KN_X)
#undef KN_X
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora {
namespace {

using wideTest::Data;
struct Width {
  int lanes;
  void (*run)(Data&);
};
std::vector<Width> widths() {
  std::vector<Width> w{{1, &N_AVX2::run1}, {4, &N_AVX2::run4}, {8, &N_AVX2::run8}};
  if (hwy::SupportedTargets() & HWY_AVX3) w.push_back({16, &N_AVX3::run16});
  return w;
}

Data filled(uint32_t mask, uint32_t firstSlot, uint32_t step) {
  Data d;
  d.mask = mask;
  for (uint32_t i = 0; i < 16; ++i) {
    d.in[i] = float(i) + 0.5f;
    d.slots[i] = firstSlot + i * step;
  }
  for (uint32_t i = 0; i < 64; ++i) d.table[i] = -float(i);
  std::memset(d.pairs, 0, sizeof d.pairs);
  return d;
}

TEST(Wide, PacksTheLanesOfAnyMaskInOrder) {
  for (const Width& w : widths())
    for (uint32_t mask = 0; mask < 1u << w.lanes; mask += w.lanes == 16 ? 37 : 1) {
      Data d = filled(mask, 5, 2);
      w.run(d);
      int n = 0;
      for (int i = 0; i < w.lanes; ++i) {
        if (!(mask >> i & 1)) continue;
        ASSERT_EQ(d.packed[n], d.in[i]) << "width " << w.lanes << " mask " << mask;
        ASSERT_EQ(d.ids[n], d.slots[i]);
        ++n;
      }
      ASSERT_EQ(d.count, n);
    }
}

TEST(Wide, SlotsReadAndWriteLikeALoop) {
  for (const Width& w : widths())
    for (const uint32_t step : {1u, 3u})  // a run, and not
      for (const uint32_t mask : {0u, 0xffffu, 0x5a5au, 1u}) {
        Data d = filled(mask, 7, step);
        w.run(d);
        for (int i = 0; i < w.lanes; ++i) EXPECT_EQ(d.got[i], -float(7 + uint32_t(i) * step)) << w.lanes;
        for (uint32_t k = 0; k < 64; ++k) {
          float want = -float(k);
          for (int i = 0; i < w.lanes; ++i)
            if (d.slots[i] == k && (mask >> i & 1)) want = d.in[i];
          EXPECT_EQ(d.table[k], want) << "width " << w.lanes << " step " << step << " mask " << mask << " slot " << k;
        }
      }
}

TEST(Wide, ListsMayEndWithinAVector) {
  for (const Width& w : widths())
    for (uint32_t listed = 1; listed <= 16; ++listed) {
      Data d = filled(0, 3, 2);
      d.listed = listed;
      for (uint32_t i = listed; i < 16; ++i) d.slots[i] = 63;  // not to be taken
      w.run(d);
      for (uint32_t i = 0; i < uint32_t(w.lanes); ++i)
        EXPECT_EQ(d.tail[i], d.slots[i < listed ? i : 0]) << w.lanes << ' ' << listed;
    }
}

TEST(Wide, MinimaAndMaximaOfOddNumbersAreTheSameAtAllWidths) {
  const float odd[8] = {0.f, -0.f, 1.f, -1.f, INFINITY, -INFINITY, NAN, -NAN};
  Data base = filled(0, 0, 1);
  for (int i = 0; i < 64; ++i) {
    base.pairs[0][i] = odd[i / 8];
    base.pairs[1][i] = odd[i % 8];
  }
  Data one = base;
  widths()[0].run(one);
  for (const Width& w : widths()) {
    Data d = base;
    w.run(d);
    EXPECT_EQ(std::memcmp(d.least, one.least, sizeof d.least), 0) << w.lanes;
    EXPECT_EQ(std::memcmp(d.most, one.most, sizeof d.most), 0) << w.lanes;
  }
}

}  // namespace
}  // namespace kinora
#endif
