#include "sampling/sample_table.h"

#include <vector>

namespace kinora {

// Temporary table until the kit lands.
const SampleTable& pmj02Table() {
  static const SampleTable t = [] {
    constexpr uint32_t kLogSets = 4, kLog = 10;
    static std::vector<uint32_t> xs(1u << (kLogSets + kLog)), ys(xs.size());
    const auto owen = [](uint32_t x, uint32_t seed) {
      uint32_t r = 0;
      for (int b = 31; b >= 0; --b) {
        const uint32_t above = b == 31 ? 0 : x >> (b + 1);
        r |= (((x >> b) & 1) ^ (hashWords(above + uint32_t(b) * 0x1234567u, seed) & 1)) << b;
      }
      return r;
    };
    for (uint32_t s = 0; s < (1u << kLogSets); ++s)
      for (uint32_t i = 0; i < (1u << kLog); ++i) {
        uint32_t x = 0, y = 0, v = 1u << 31;
        for (int b = 0; b < 32; ++b) x |= (i >> b & 1) << (31 - b);
        for (uint32_t k = i; k; k >>= 1, v ^= v >> 1)
          if (k & 1) y ^= v;
        xs[(s << kLog) + i] = owen(x, s * 2 + 1);
        ys[(s << kLog) + i] = owen(y, s * 2 + 2);
      }
    return SampleTable{xs.data(), ys.data(), kLogSets, kLog};
  }();
  return t;
}

}  // namespace kinora
