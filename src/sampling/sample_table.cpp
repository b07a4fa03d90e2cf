#include "sampling/sample_table.h"

#include <memory>
#include <vector>

#include "sampling/matched_orders.h"

namespace kinora {

namespace {

constexpr uint32_t kLogSets = 4, kLogSamples = 10, kSets = 1u << kLogSets, kSamples = 1u << kLogSamples;

struct Storage {
  std::vector<uint32_t> xs = std::vector<uint32_t>(kSets * kSamples), ys = std::vector<uint32_t>(kSets * kSamples);
  std::vector<uint32_t> orders;
  std::vector<uint8_t> rowOf = std::vector<uint8_t>(kMatchedDimensions, kHashedOrder);
  SampleTable table{xs.data(), ys.data(), kLogSets, kLogSamples, nullptr, rowOf.data()};
  // draw2() scrambles indices from their low end, so they are stored with their bits reversed
  static uint32_t place(uint32_t set, uint32_t sample) {
    uint32_t r = 0;
    for (uint32_t b = 0; b < kLogSamples; ++b) r |= (sample >> b & 1) << (kLogSamples - 1 - b);
    return set * kSamples + r;
  }
  void put(uint32_t set, uint32_t sample, uint32_t x, uint32_t y) {
    xs[place(set, sample)] = x;
    ys[place(set, sample)] = y;
  }
  void matchDimensions() {
    static_assert(1u << MatchedOrder::kDigits == kSamples);
    const auto all = matchedOrders();
    orders.resize(all.size() * kSamples);
    for (size_t row = 0; row < all.size(); ++row) {
      rowOf[all[row].dimension] = uint8_t(row);
      for (uint32_t i = 0; i < kSamples; ++i) orders[row * kSamples + i] = place(0, all[row].of(i));
    }
    table.orders = orders.data();
  }
};

// Columns of Sobol's generator matrices, most significant digit in bit 31. Dimension 0 is van der Corput's identity,
// dimension 1 has the primitive polynomial x + 1: Pascal's triangle modulo 2.
struct Sobol {
  uint32_t column[2][32];
  Sobol() {
    uint32_t v = 0x80000000u;
    for (uint32_t k = 0; k < 32; ++k) {
      column[0][k] = 0x80000000u >> k;
      column[1][k] = v;
      v ^= v >> 1;
    }
  }
  uint32_t at(uint32_t dimension, uint32_t index) const {
    uint32_t x = 0;
    for (uint32_t k = 0; index >> k; ++k)
      if (index >> k & 1) x ^= column[dimension][k];
    return x;
  }
};

// The earlier sample in whose stratum a new one is placed, on the other half: sample N + i of a doubling from N =
// 2^level to 2N shares its first `level` digits with sample i ^ partner, and differs in the next. In a digital
// sequence that partner is the same for all i: the combination of the first columns that gives the first digits of
// column `level` (the "xor-values" of Helmer, Christensen and Kensler, "Stochastic Generation of (t,s) Sample
// Sequences", EGSR 2021; here they are solved for instead of listed).
uint32_t partner(const Sobol& sobol, uint32_t dimension, uint32_t level) {
  const uint32_t digits = level ? ~0u << (32 - level) : 0;
  for (uint32_t j = 0; j < (1u << level); ++j)
    if (((sobol.at(dimension, j) ^ sobol.column[dimension][level]) & digits) == 0) return j;
  return 0;  // not reached: the leading square blocks of both matrices are invertible
}

std::unique_ptr<Storage> makePmj02() {
  auto s = std::make_unique<Storage>();
  const Sobol sobol;
  uint32_t xorValue[2][kLogSamples];
  for (uint32_t d = 0; d < 2; ++d)
    for (uint32_t level = 0; level < kLogSamples; ++level) xorValue[d][level] = partner(sobol, d, level);
  std::vector<uint32_t> value[2] = {std::vector<uint32_t>(kSamples), std::vector<uint32_t>(kSamples)};
  for (uint32_t set = 0; set < kSets; ++set) {
    for (uint32_t d = 0; d < 2; ++d) {
      value[d][0] = hashWords(hashWords(0x4b696e6fu, set), d);
      for (uint32_t level = 0; level < kLogSamples; ++level)
        for (uint32_t i = 0; i < (1u << level); ++i) {
          const uint32_t n = (1u << level) + i, half = 0x80000000u >> level;
          const uint32_t random = hashWords(hashWords(set * 2 + d + 1, 0x504d4a32u), n);
          const uint32_t stratum = (value[d][i ^ xorValue[d][level]] ^ half) & ~(half - 1);
          value[d][n] = stratum | (random & (half - 1));
        }
    }
    for (uint32_t i = 0; i < kSamples; ++i) s->put(set, i, value[0][i], value[1][i]);
  }
  return s;
}

// Each digit is flipped by a random bit that depends on all digits above it (Owen 1995).
uint32_t owenScramble(uint32_t x, uint32_t seed) {
  uint32_t flips = hashWords(seed, 0) & 0x80000000u;
  for (uint32_t b = 1; b < 32; ++b) {
    const uint32_t above = x >> (32 - b);
    flips |= hashWords(seed ^ (b * 0x9E3779B9u), above) >> 31 << (31 - b);
  }
  return x ^ flips;
}

std::unique_ptr<Storage> makeSobol() {
  auto s = std::make_unique<Storage>();
  const Sobol sobol;
  for (uint32_t set = 0; set < kSets; ++set)
    for (uint32_t i = 0; i < kSamples; ++i)
      s->put(set, i, owenScramble(sobol.at(0, i), hashWords(0x536f626fu, 2 * set)),
             owenScramble(sobol.at(1, i), hashWords(0x536f626fu, 2 * set + 1)));
  s->matchDimensions();
  return s;
}

}  // namespace

const SampleTable& pmj02Table() {
  static const std::unique_ptr<Storage> storage = makePmj02();
  return storage->table;
}

const SampleTable& sobolTable() {
  static const std::unique_ptr<Storage> storage = makeSobol();
  return storage->table;
}

}  // namespace kinora
