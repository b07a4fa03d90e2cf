#include "match_orders.h"

#include <kinora/sample_table.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "sampling/matched_orders.h"

namespace kinora::bench {

namespace {

constexpr uint32_t kDigits = MatchedOrder::kDigits, kSamples = 1u << kDigits;

enum Name {
  kFilter,
  kLight0,
  kBxdf0,
  kChoice0,
  kLobe0,
  kLens,
  kTime,
  kBxdf1,
  kLight1,
  kChoice1,
  kLobe1,
  kBxdf2,
  kLight2,
  kChoice2,
  kLobe2,
  kBxdf3,
  kLight3,
  kChoice3,
  kNames
};
const char* const kTexts[kNames] = {"filter",  "light 0",  "bxdf 0",  "choice 0", "lobe 0",  "lens",
                                    "time",    "bxdf 1",   "light 1", "choice 1", "lobe 1",  "bxdf 2",
                                    "light 2", "choice 2", "lobe 2",  "bxdf 3",   "light 3", "choice 3"};

// Dimensions that a factor of the integrand depends on together: a light on what the pixel sees, a light on what a
// direction meets, and so on.
struct Together {
  double weight;
  std::vector<Name> names;
};
const std::vector<Together>& together() {
  static const std::vector<Together> all = {{2, {kFilter, kLight0, kChoice0}},
                                            {1, {kFilter, kBxdf0, kLobe0}},
                                            {1, {kFilter, kLens, kLight0}},
                                            {1, {kFilter, kLens, kBxdf0}},
                                            {.5, {kFilter, kTime, kLight0}},
                                            {.5, {kTime, kLens, kBxdf0}},
                                            {1, {kTime, kChoice0}},
                                            {2, {kBxdf0, kLight1, kChoice1}},
                                            {1, {kBxdf0, kBxdf1, kLobe1}},
                                            {.5, {kFilter, kLight1}},
                                            {.5, {kFilter, kBxdf1}},
                                            {1, {kLobe0, kLight1}},
                                            {.5, {kLobe0, kBxdf1}},
                                            {1, {kBxdf1, kLight2, kChoice2}},
                                            {1, {kBxdf0, kLight2}},
                                            {1, {kBxdf0, kBxdf2}},
                                            {1, {kBxdf1, kBxdf2, kLobe2}},
                                            {.5, {kLobe1, kBxdf2}},
                                            {.5, {kLight0, kLight1}},
                                            {.5, {kLight0, kBxdf0}},
                                            {1, {kBxdf2, kLight3, kChoice3}},
                                            {1, {kBxdf2, kBxdf3}},
                                            {.5, {kBxdf1, kLight3}},
                                            {.5, {kBxdf0, kLight3}},
                                            {.5, {kBxdf1, kBxdf3}},
                                            {.3, {kFilter, kLight2}},
                                            {.3, {kFilter, kBxdf2}}};
  return all;
}

// The kernel of the L2 discrepancy under random digital shifts (Dick and Pillichshammer, "Digital Nets and Sequences",
// 2010, section 16.5), scaled so that its mean is 0. Its mean over the samples, of products over numbers, is what these
// integrate wrongly. The value at 0 is what each further number of a product weighs: half, since integrands depend on
// few of them at a time.
float kernel(uint32_t x) {
  constexpr float kWeight = 0.5f;
  return kWeight * (x ? 1 - 3 * std::ldexp(1.f, -(__builtin_clz(x) + 1)) : 1.f);
}

class Search {
 public:
  Search() {
    for (uint32_t i = 0; i < kSamples; ++i) {
      uint32_t x = 0, y = 0;
      for (uint32_t b = 0, column = 0x80000000u; b < kDigits; ++b, column ^= column >> 1)
        if (i >> b & 1) {
          x |= 0x80000000u >> b;
          y ^= column;
        }
      one_[i] = kernel(x);
      both_[i] = (1 + kernel(x)) * (1 + kernel(y)) - 1;
    }
    for (auto& row : orders_) row.resize(kSamples);
  }
  // Column by column, each the best of all that leave what stands; which of equals is left to chance, and the best of
  // many trials is kept.
  void run(Name p, int trials) {
    std::vector<uint32_t> best(kDigits);
    if (p == kFilter)
      for (uint32_t k = 0; k < kDigits; ++k) best[k] = 1u << k;
    else
      find(p, trials, best);
    fill(p, best, kDigits);
    columns_[p] = best;
  }
  // What is even about the index must not be the first digit of any number: films keep the even samples apart, and what
  // these differ by from all is taken for their error. One matrix before all others changes nothing but which samples of
  // a block are the even ones; of those that add digits of the index to its lowest the best is taken.
  void spreadHalves() {
    double least = 1e30;
    uint32_t best = 0;
    for (uint32_t mask = 0; mask < kSamples; mask += 2) {
      double cost = 0;
      for (uint32_t digits = 2; digits <= kDigits; ++digits) {
        const uint32_t all = 1u << digits;
        for (int p = 0; p < kNames; ++p) {
          double sum = 0, withFilter = 0;
          for (uint32_t i = 0; i < all; i += 2) {
            const uint32_t from = i ^ uint32_t(__builtin_parity(i & mask));
            sum += double(at(p, from));
            withFilter += double(at(p, from)) * double(at(kFilter, from));
          }
          cost += sum + (p == kFilter ? 0 : withFilter);
        }
      }
      if (!(cost < least)) continue;
      least = cost;
      best = mask;
    }
    for (auto& columns : columns_)
      for (uint32_t k = 1; k < kDigits; ++k)
        if (best >> k & 1) columns[k] ^= columns[0];
  }
  bool areTheSource() const {
    for (int p = 0; p < kNames; ++p)
      if (!std::equal(columns_[p].begin(), columns_[p].end(), matchedOrders()[size_t(p)].columns)) return false;
    return true;
  }
  void print() const {
    for (int p = 0; p < kNames; ++p) {
      std::printf("  {");
      for (uint32_t k = 0; k < kDigits; ++k) std::printf("%s0x%03x", k ? ", " : "", columns_[p][k]);
      std::printf("}  %s\n", kTexts[p]);
    }
  }

 private:
  static bool usesBoth(int p) { return matchedOrders()[size_t(p)].usesBoth; }
  float at(int p, uint32_t i) const {
    const uint32_t x = orders_[size_t(p)][i];
    return usesBoth(p) ? both_[x] : one_[x];
  }
  void fill(int p, const std::vector<uint32_t>& columns, uint32_t digits) {
    for (uint32_t i = 0; i < 1u << digits; ++i) {
      uint32_t to = 0;
      for (uint32_t k = 0; k < digits; ++k)
        if (i >> k & 1) to ^= columns[k];
      orders_[size_t(p)][i] = to;
    }
  }
  // By sample: products of the kernels of what stands with p, over all pairs and triples of which p is the last.
  std::vector<float> others(Name p) const {
    std::vector<float> sum(kSamples);
    const auto add = [&](double w, int a, int b) {
      for (uint32_t i = 0; i < kSamples; ++i) sum[i] += float(w) * at(a, i) * (b < 0 ? 1.f : at(b, i));
    };
    for (const Together& t : together()) {
      if (std::find(t.names.begin(), t.names.end(), p) == t.names.end()) continue;
      for (size_t a = 0; a < t.names.size(); ++a) {
        if (t.names[a] >= p) continue;
        add(t.weight, t.names[a], -1);
        for (size_t b = a + 1; b < t.names.size(); ++b)
          if (t.names[b] < p) add(t.weight / 2, t.names[a], t.names[b]);
      }
    }
    for (int a = 0; a < p; ++a) add(0.1, a, -1);
    return sum;
  }
  void find(Name p, int trials, std::vector<uint32_t>& best) {
    const std::vector<float> rest = others(p);
    double least = 1e30;
    for (int trial = 0; trial < trials; ++trial) {
      std::vector<uint32_t> columns(kDigits), equal;
      columns[0] = 1;
      double total = 0;
      for (uint32_t digit = 1; digit < kDigits; ++digit) {
        fill(p, columns, digit);
        const uint32_t half = 1u << digit;
        double lowest = 1e30;
        for (uint32_t below = 0; below < half; ++below) {
          double cost = 0;
          for (uint32_t i = 0; i < half; ++i) {
            const uint32_t x = orders_[size_t(p)][i] ^ (half | below);
            cost += double(at(p, i)) * double(rest[i]) +
                    double(usesBoth(p) ? both_[x] : one_[x]) * double(rest[i + half]);
          }
          if (cost < lowest - 1e-6) {
            lowest = cost;
            equal.clear();
          }
          if (cost < lowest + 1e-6) equal.push_back(half | below);
        }
        columns[digit] = equal[random_() % equal.size()];
        total += lowest;
      }
      if (total < least) {
        least = total;
        best = columns;
      }
    }
  }
  float one_[kSamples], both_[kSamples];
  std::vector<uint32_t> orders_[kNames], columns_[kNames];
  std::mt19937 random_{7};
};

}  // namespace

int printMatchedOrders(bool isQuick) {
  Search search;
  for (int p = 0; p < kNames; ++p) search.run(Name(p), isQuick ? 1 : 400);
  search.spreadHalves();
  search.print();
  if (isQuick || search.areTheSource()) return 0;
  std::fputs("kinora-bench: error BENCH-ORDERS: src/sampling/matched_orders.cpp has others\n", stderr);
  return 1;
}

}  // namespace kinora::bench
