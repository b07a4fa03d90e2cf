// The sample tables: strata of every prefix, what draw2() makes of them, independence of dimensions, and what they
// are for: errors of integrals, of one dimension and of several together.
#include "sampling/sample_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

#include "sampling/draw.h"
#include "sampling/matched_orders.h"
#include "simd/dispatch.h"

namespace kinora {
namespace {

struct Sample {
  uint32_t x, y;
};
Sample at(const SampleTable& t, uint32_t set, uint32_t i) {
  uint32_t r = 0;
  for (uint32_t b = 0; b < t.logSamples; ++b) r |= (i >> b & 1) << (t.logSamples - 1 - b);
  const uint32_t place = (set << t.logSamples) + r;
  return {t.xs[place], t.ys[place]};
}

// One sample in each of the 2^k boxes, for every shape of box.
bool stratified(const std::vector<Sample>& s) {
  uint32_t k = 0;
  while ((1u << k) < s.size()) ++k;
  for (uint32_t a = 0; a <= k; ++a) {
    std::vector<bool> taken(s.size(), false);
    for (const Sample& p : s) {
      const uint32_t cx = a ? p.x >> (32 - a) : 0, cy = k - a ? p.y >> (32 - (k - a)) : 0;
      const uint32_t cell = cx << (k - a) | cy;
      if (taken[cell]) return false;
      taken[cell] = true;
    }
  }
  return true;
}

struct Named {
  const char* name;
  const SampleTable& (*table)();
};
class Table : public ::testing::TestWithParam<Named> {};

TEST_P(Table, PrefixesAreStratified) {
  const SampleTable& t = GetParam().table();
  ASSERT_EQ(t.logSets, 4u);
  ASSERT_EQ(t.logSamples, 10u);
  for (uint32_t set = 0; set < 16; ++set)
    for (uint32_t k = 0; k <= t.logSamples; ++k)
      for (uint32_t block = 0; block < (1024u >> k); ++block) {
        std::vector<Sample> s;
        for (uint32_t i = 0; i < (1u << k); ++i) s.push_back(at(t, set, (block << k) + i));
        ASSERT_TRUE(stratified(s)) << "set " << set << ", block " << block << " of " << (1u << k);
      }
}

TEST_P(Table, SetsDiffer) {
  const SampleTable& t = GetParam().table();
  for (uint32_t a = 0; a < 16; ++a)
    for (uint32_t b = 0; b < a; ++b) {
      uint32_t same = 0;
      for (uint32_t i = 0; i < 1024; ++i) same += (at(t, a, i).x ^ at(t, b, i).x) < 1u << 16;
      EXPECT_LT(same, 8u) << a << " " << b;
    }
}

struct Drawn {
  std::vector<float> u, v;
};
Drawn draw(const SampleTable& t, uint32_t seed, uint32_t first, uint32_t n, uint32_t dimension, uint32_t width) {
  const uint32_t m = (n + 15) & ~15u;
  std::vector<uint32_t> seeds(m, seed), samples(m);
  for (uint32_t i = 0; i < m; ++i) samples[i] = first + i;
  Drawn d{std::vector<float>(m), std::vector<float>(m)};
  drawSpan(width)(t, m, seeds.data(), samples.data(), dimension, d.u.data(), d.v.data());
  d.u.resize(n);
  d.v.resize(n);
  return d;
}

// Aligned blocks of what draw2() gives, hashes applied.
TEST_P(Table, DrawnBlocksAreStratified) {
  const SampleTable& t = GetParam().table();
  for (uint32_t seed = 1; seed < 20; ++seed)
    for (const uint32_t dimension : {0u, 1u, 9u, 40u})
      for (uint32_t k = 0; k <= 10; ++k) {
        const uint32_t first = (seed * 7 % 5) << k;  // some of them beyond the table's length
        const Drawn d = draw(t, seed * 0x9E3779B9u, first, 1u << k, dimension, 8);
        std::vector<Sample> s;
        for (size_t i = 0; i < d.u.size(); ++i) {
          ASSERT_TRUE(d.u[i] >= 0 && d.u[i] < 1 && d.v[i] >= 0 && d.v[i] < 1);
          s.push_back({uint32_t(d.u[i] * 4294967296.0), uint32_t(d.v[i] * 4294967296.0)});
        }
        ASSERT_TRUE(stratified(s)) << "seed " << seed << ", dimension " << dimension << ", " << (1u << k) << " from "
                                   << first;
      }
}

TEST_P(Table, WidthsGiveTheSameBits) {
  const SampleTable& t = GetParam().table();
  for (const uint32_t first : {0u, 5u, 1020u, 4000000000u}) {
    const Drawn a = draw(t, 77, first, 64, 3, 1);
    for (const uint32_t w : {4u, 8u, 16u}) {
      if (w == 16 && !cpuHasAvx512()) continue;
      const Drawn b = draw(t, 77, first, 64, 3, w);
      EXPECT_EQ(a.u, b.u) << w;
      EXPECT_EQ(a.v, b.v) << w;
    }
  }
}

// Chi-square of pairs (u of one dimension, u or v of another) over 8x8 boxes. Samples within a pixel are dependent on
// purpose, so counts of one pixel are no multinomial; over many pixels each box's mean count must still be even, and
// the spread of the counts must not exceed that of independent numbers by much (correlated dimensions fill few
// boxes).
TEST_P(Table, DimensionsAreIndependent) {
  const SampleTable& t = GetParam().table();
  constexpr uint32_t kPixels = 600;
  for (const uint32_t n : {16u, 64u, 256u}) {
    double worst = 0;
    for (const auto& [a, b] : {std::pair{0u, 1u}, {1u, 8u}, {8u, 12u}, {9u, 24u}, {8u, 24u}}) {
      double statistic = 0, total[64] = {};
      for (uint32_t pixel = 0; pixel < kPixels; ++pixel) {
        const uint32_t seed = pixelSeed(int(pixel % 30), int(pixel / 30), 1);
        const Drawn p = draw(t, seed, 0, n, a | kOwnIndex, 8), q = draw(t, seed, 0, n, b | kOwnIndex, 8);
        double box[64] = {};
        for (uint32_t i = 0; i < n; ++i)
          ++box[uint32_t(p.u[i] * 8) * 8 + uint32_t((pixel & 1 ? q.u[i] : q.v[i]) * 8)];
        for (int k = 0; k < 64; ++k) {
          const double e = n / 64.0;
          statistic += (box[k] - e) * (box[k] - e) / e;
          total[k] += box[k];
        }
      }
      // mean 63 for independent numbers; rows and columns are stratified, which leaves 49
      const double mean = statistic / kPixels;
      worst = std::max(worst, mean);
      EXPECT_LT(mean, 75) << n << " samples, dimensions " << a << " and " << b;
      double even = 0;
      for (const double c : total) even += std::pow(c - n * kPixels / 64.0, 2) / (n * kPixels / 64.0);
      EXPECT_LT(even, 130) << n << " samples, dimensions " << a << " and " << b;
    }
    std::printf("%s, %u samples: statistic of dimension pairs at most %.1f (independent numbers: 63)\n",
                GetParam().name, n, worst);
  }
}

TEST_P(Table, IntegrationErrorFallsFast) {
  const SampleTable& t = GetParam().table();
  const std::function<double(double, double)> functions[] = {
      [](double x, double y) { return x * x + y * y < 2 / M_PI ? 1.0 : 0.0; },  // quarter disk of area 1/2
      [](double x, double y) { return std::exp(-x * x - y * y); }};
  const double gauss = 0.5 * std::sqrt(M_PI) * std::erf(1), exact[] = {0.5, gauss * gauss};
  const char* const names[] = {"disk", "Gaussian"};
  for (int f = 0; f < 2; ++f) {
    double error[2] = {};
    const uint32_t counts[2] = {16, 1024};
    double hashed = 0;
    for (int c = 0; c < 2; ++c) {
      for (uint32_t pixel = 0; pixel < 300; ++pixel) {
        const Drawn d = draw(t, hashWords(pixel, 99), 0, counts[c], 5, 8);
        double sum = 0, independent = 0;
        for (uint32_t i = 0; i < counts[c]; ++i) {
          sum += functions[f](d.u[i], d.v[i]);
          if (c == 1)
            independent += functions[f](double(drawEvent(pixel, i, 1, 0)), double(drawEvent(pixel, i, 2, 0)));
        }
        error[c] += std::pow(sum / counts[c] - exact[f], 2) / 300;
        hashed += c == 1 ? std::pow(independent / counts[c] - exact[f], 2) / 300 : 0;
      }
      error[c] = std::sqrt(error[c]);
    }
    hashed = std::sqrt(hashed);
    const double slope = std::log(error[1] / error[0]) / std::log(double(counts[1]) / counts[0]);
    std::printf("%s, %s: error %.3g at 16, %.3g at 1024 samples (N^%.2f); independent numbers %.3g at 1024\n",
                GetParam().name, names[f], error[0], error[1], slope, hashed);
    // an edge costs: N^-0.75 for the disk, N^-1.5 for the smooth function (Owen 1997)
    EXPECT_LT(slope, f ? -1.3 : -0.65);
    EXPECT_LT(error[1], hashed * (f ? 0.05 : 0.3));
  }
}

INSTANTIATE_TEST_SUITE_P(Tables, Table, ::testing::Values(Named{"pmj02", &pmj02Table}, Named{"sobol", &sobolTable}),
                         [](const auto& info) { return info.param.name; });

TEST(SampleTables, BuildQuicklyAndAlike) {
  const auto start = std::chrono::steady_clock::now();
  const SampleTable& t = pmj02Table();
  const SampleTable& s = sobolTable();
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  std::printf("both tables: %.2f ms (0 when another test has made them)\n", ms);
  EXPECT_LT(ms, 100);
  EXPECT_EQ(&t, &pmj02Table());
  EXPECT_NE(t.xs, s.xs);
  // the bits are part of every picture: kept hash of both tables
  uint32_t h = 1;
  for (uint32_t i = 0; i < 16 * 1024; ++i) h = hashWords(hashWords(h, t.xs[i] ^ s.xs[i]), t.ys[i] + s.ys[i]);
  EXPECT_EQ(h, 3524195028u);
}

// Aligned blocks of samples stay blocks, and no two dimensions have one order.
TEST(MatchedOrders, AreNestedAndDiffer) {
  const auto orders = matchedOrders();
  ASSERT_FALSE(orders.empty());
  for (const MatchedOrder& o : orders) {
    EXPECT_LT(o.dimension, kMatchedDimensions);
    for (uint32_t k = 0; k < MatchedOrder::kDigits; ++k) EXPECT_EQ(o.columns[k] >> k, 1u) << o.dimension;
    for (const MatchedOrder& other : orders) {
      if (&o == &other) continue;
      EXPECT_NE(o.dimension, other.dimension);
      EXPECT_FALSE(std::equal(o.columns, o.columns + MatchedOrder::kDigits, other.columns)) << o.dimension;
    }
  }
  const SampleTable& t = sobolTable();
  for (size_t row = 0; row < orders.size(); ++row) EXPECT_EQ(t.rowOf[orders[row].dimension], row);
}

// Variance over pixels of the mean of n values of two pairs of numbers, matched or (kOwnIndex) not.
double varianceOfProduct(uint32_t a, uint32_t b, uint32_t n, uint32_t flag) {
  double sum = 0, squares = 0;
  constexpr int kPixels = 400;
  for (int pixel = 0; pixel < kPixels; ++pixel) {
    const uint32_t seed = pixelSeed(pixel % 20, pixel / 20, 3);
    const Drawn p = draw(sobolTable(), seed, 0, n, a | flag, 8), q = draw(sobolTable(), seed, 0, n, b | flag, 8);
    double mean = 0;
    for (uint32_t i = 0; i < n; ++i)
      mean += (p.v[i] < 0.3f + 0.37f * p.u[i] && q.u[i] < 0.2f + 0.5f * q.v[i] ? 1. : 0.) / n;
    sum += mean;
    squares += mean * mean;
  }
  return squares / kPixels - sum / kPixels * sum / kPixels;
}

// What light transport multiplies: the place in the pixel, a light seen there, a direction, a light of what it meets.
TEST(MatchedOrders, PairsAreStratifiedWithEachOther) {
  const uint32_t light0 = dimensionAt(0) + kDimLight, bxdf0 = dimensionAt(0) + kDimBxdf,
                 light1 = dimensionAt(1) + kDimLight, bxdf1 = dimensionAt(1) + kDimBxdf;
  for (const uint32_t n : {64u, 256u}) {
    double matched = 0, shuffled = 0;
    for (const auto& [a, b] : {std::pair<uint32_t, uint32_t>{kDimFilter, light0},
                               {kDimFilter, bxdf0},
                               {bxdf0, light1},
                               {bxdf0, bxdf1},
                               {kDimLens, light0}}) {
      const double m = varianceOfProduct(a, b, n, 0), s = varianceOfProduct(a, b, n, kOwnIndex);
      EXPECT_LT(m, s) << a << " and " << b << ", " << n;
      matched += m;
      shuffled += s;
    }
    std::printf("edges over two pairs, %u samples: variance %.3g of that of pairs shuffled by chance\n", n,
                matched / shuffled);
    EXPECT_LT(matched, 0.5 * shuffled) << n;
  }
}

// Sub-samples have indices of their own, which nothing else is matched with.
TEST(MatchedOrders, SubSamplesAreShuffledByChance) {
  constexpr uint32_t kDimension = dimensionAt(0) + kDimLight;
  EXPECT_EQ(subSampled(kDimension, 0, 1), kDimension);
  EXPECT_EQ(subSampled(kDimension, 0, 2), kDimension | kOwnIndex);
  EXPECT_EQ(subSampled(kDimension, 1u << 24, 1), kDimension | kOwnIndex);
  const std::vector<uint32_t> seeds(16, 5), samples = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  std::vector<float> u(16), v(16);
  drawSplit(8)(sobolTable(), 16, seeds.data(), samples.data(), kDimension, 0, 1, u.data(), v.data());
  EXPECT_EQ(u, draw(sobolTable(), 5, 0, 16, kDimension, 8).u);
  drawSplit(8)(sobolTable(), 16, seeds.data(), samples.data(), kDimension, 1, 2, u.data(), v.data());
  const Drawn own = draw(sobolTable(), 5, 0, 33, kDimension | kOwnIndex, 8);
  for (uint32_t i = 0; i < 16; ++i) EXPECT_EQ(u[i], own.u[2 * i + 1]);
}

}  // namespace
}  // namespace kinora
