#include "sequences.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "sampling/draw.h"
#include "sampling/sample_table.h"

namespace kinora::bench {

namespace {

constexpr uint32_t kMostPairs = 4;
// Those of a light seen in a pixel, then what is met by a direction.
constexpr uint32_t kDimensions[kMostPairs] = {kDimFilter, dimensionAt(0) + kDimLight, dimensionAt(0) + kDimBxdf,
                                              dimensionAt(1) + kDimLight};

struct Integrand {
  const char* name;
  uint32_t pairs;
  double (*value)(const float* x);
};
// Edges are shadows and silhouettes, slopes are soft light and textures. "_across": the value depends on pairs together.
constexpr Integrand kIntegrands[] = {
    {"edge_2d", 1, [](const float* x) { return x[1] < 0.3f + 0.37f * x[0] ? 1. : 0.; }},
    {"slope_2d", 1, [](const float* x) { return std::exp(-double(x[0] * x[0] + x[1] * x[1])); }},
    {"edges_product_4d", 2,
     [](const float* x) { return x[1] < 0.3f + 0.37f * x[0] && x[3] < 0.2f + 0.5f * x[2] ? 1. : 0.; }},
    {"penumbra_across_4d", 2,
     [](const float* x) {
       const float a = x[2] + 0.5f * (x[0] - 0.5f), b = x[3] + 0.5f * (x[1] - 0.5f);
       return a * a + b * b < 0.5f ? 1. : 0.;
     }},
    {"slopes_product_4d", 2, [](const float* x) { return double(x[0] * x[1] * x[2] * x[3]); }},
    {"edge_across_6d", 3,
     [](const float* x) {
       return 0.3f * x[0] + 0.2f * x[1] - 0.5f * x[2] + 0.4f * x[3] + 0.6f * x[4] - 0.2f * x[5] < 0.37f ? 1. : 0.;
     }},
    {"peak_8d", 4,
     [](const float* x) {
       double sum = 0;
       for (int k = 0; k < 8; ++k) sum += double((x[k] - 0.4f) * (x[k] - 0.4f));
       return std::exp(-3 * sum);
     }},
};

enum Sequence { kIndependent, kPmj02, kSobol, kMatched, kSequences };
const char* const kSequenceNames[kSequences] = {"independent", "pmj02", "sobol", "matched"};

// n samples of a pixel: by dimension of the integrand n numbers.
void draw(Sequence kind, uint32_t seed, uint32_t n, uint32_t pairs, std::vector<float>* x) {
  static const DrawSpan span = drawSpan(8);
  const uint32_t padded = (n + 15) & ~15u;
  std::vector<uint32_t> seeds(padded, seed), indices(padded);
  for (uint32_t i = 0; i < padded; ++i) indices[i] = i;
  for (uint32_t p = 0; p < pairs; ++p) {
    std::vector<float>&u = x[2 * p], &v = x[2 * p + 1];
    u.resize(padded);
    v.resize(padded);
    if (kind == kIndependent) {
      for (uint32_t i = 0; i < n; ++i) {
        u[i] = drawEvent(seed, i, 2 * p, 0);
        v[i] = drawEvent(seed, i, 2 * p + 1, 0);
      }
      continue;
    }
    const uint32_t dimension = kDimensions[p] | (kind == kMatched ? 0 : kOwnIndex);
    span(kind == kPmj02 ? pmj02Table() : sobolTable(), padded, seeds.data(), indices.data(), dimension, u.data(),
         v.data());
  }
}

double mean(const Integrand& f, const std::vector<float>* x, uint32_t n) {
  double sum = 0;
  for (uint32_t i = 0; i < n; ++i) {
    float at[2 * kMostPairs];
    for (uint32_t k = 0; k < 2 * f.pairs; ++k) at[k] = x[k][i];
    sum += f.value(at);
  }
  return sum / n;
}

// By many samples of an additive recurrence, whose steps are powers of the root of r^(d + 1) = r + 1.
double integral(const Integrand& f, bool isQuick) {
  const uint32_t dimensions = 2 * f.pairs;
  double root = 2;
  for (int i = 0; i < 64; ++i) root = std::pow(1 + root, 1. / (dimensions + 1));
  double step[2 * kMostPairs], sum = 0;
  for (uint32_t k = 0; k < dimensions; ++k) step[k] = std::pow(1 / root, double(k + 1));
  const uint32_t n = isQuick ? 1u << 14 : 1u << 23;
  for (uint32_t i = 0; i < n; ++i) {
    float at[2 * kMostPairs];
    for (uint32_t k = 0; k < dimensions; ++k) {
      const double x = 0.5 + step[k] * double(i + 1);
      at[k] = float(x - std::floor(x));
    }
    sum += f.value(at);
  }
  return sum / n;
}

// Owen-scrambled Sobol pairs that go through all pixels along Morton's curve, `n` of them each (a power of two), shuffled
// with pixels and blocks of four of them kept together: errors of neighbours compensate each other (Ahmed and Wonka,
// "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020).
class AlongTheScreen {
 public:
  AlongTheScreen(uint32_t seed, uint32_t logSamples) : seed_(seed), logSamples_(logSamples) {}
  void draw(uint32_t px, uint32_t py, uint32_t pairs, std::vector<float>* x) const {
    uint32_t pixel = 0;
    for (uint32_t b = 0; b < 10; ++b) pixel |= (px >> b & 1) << 2 * b | (py >> b & 1) << (2 * b + 1);
    const uint32_t n = 1u << logSamples_;
    for (uint32_t p = 0; p < pairs; ++p) {
      x[2 * p].resize(n);
      x[2 * p + 1].resize(n);
      const uint32_t h = hashWords(seed_, p);
      for (uint32_t i = 0; i < n; ++i) {
        const uint32_t index = scrambled(pixel << logSamples_ | i, h);
        uint32_t y = 0;
        for (uint32_t b = 0, column = 0x80000000u; b < 32; ++b, column ^= column >> 1)
          if (index >> b & 1) y ^= column;
        x[2 * p][i] = unit(scrambled(reversed(index), hashWords(h, 1)));
        x[2 * p + 1][i] = unit(scrambled(y, hashWords(h, 2)));
      }
    }
  }

 private:
  static uint32_t reversed(uint32_t x) {
    uint32_t r = 0;
    for (uint32_t b = 0; b < 32; ++b) r |= (x >> b & 1) << (31 - b);
    return r;
  }
  // Owen's scrambling: a digit is flipped by a hash of those above it.
  static uint32_t scrambled(uint32_t x, uint32_t seed) {
    uint32_t flips = hashWords(seed, 0) & 0x80000000u;
    for (uint32_t b = 1; b < 32; ++b) flips |= hashWords(hashWords(seed, b), x >> (32 - b)) >> 31 << (31 - b);
    return x ^ flips;
  }
  static float unit(uint32_t x) { return float(x >> 8) * 0x1p-24f; }
  uint32_t seed_, logSamples_;
};

}  // namespace

void measureIntegrals(const Options& options, Figures& figures) {
  const uint32_t pixels = options.quick ? 16 : 2048;
  const std::vector<uint32_t> counts =
      options.quick ? std::vector<uint32_t>{4, 16} : std::vector<uint32_t>{1, 4, 16, 32, 64, 128, 256, 1024};
  for (const Integrand& f : kIntegrands) {
    const double exact = integral(f, options.quick);
    for (const uint32_t n : counts) {
      double variance[kSequences];
      for (int s = 0; s < kSequences; ++s) {
        double sum = 0;
        std::vector<float> x[2 * kMostPairs];
        for (uint32_t pixel = 0; pixel < pixels; ++pixel) {
          draw(Sequence(s), pixelSeed(int(pixel % 64), int(pixel / 64), 1), n, f.pairs, x);
          const double e = mean(f, x, n) / exact - 1;
          sum += e * e;
        }
        variance[s] = sum / pixels;
        figures.add(std::string("error_") + kSequenceNames[s] + "_" + f.name + "_" + std::to_string(n),
                    {std::sqrt(variance[s])}, "relative, root mean square over pixels");
      }
      figures.add(std::string("gain_matched_") + f.name + "_" + std::to_string(n),
                  {variance[kPmj02] / std::max(variance[kMatched], 1e-30)},
                  "variance with pmj02, shuffled by chance, over that with matched orders");
    }
  }
}

void measureScreen(const Options& options, Figures& figures) {
  constexpr int kSide = 64;
  const Integrand& f = kIntegrands[3];
  const double exact = integral(f, options.quick);
  for (const uint32_t logSamples : {0u, 2u, 4u, 6u}) {
    if (options.quick && logSamples > 2) continue;
    const uint32_t n = 1u << logSamples;
    for (const bool isMorton : {false, true}) {
      const AlongTheScreen along(7, logSamples);
      std::vector<double> error(kSide * kSide);
      std::vector<float> x[2 * kMostPairs];
      double sum = 0;
      for (int py = 0; py < kSide; ++py)
        for (int px = 0; px < kSide; ++px) {
          if (isMorton)
            along.draw(uint32_t(px), uint32_t(py), f.pairs, x);
          else
            draw(kMatched, pixelSeed(px, py, 1), n, f.pairs, x);
          const double e = error[size_t(py * kSide + px)] = mean(f, x, n) / exact - 1;
          sum += e * e;
        }
      const std::string name = std::string(isMorton ? "screen_morton_" : "screen_matched_") + std::to_string(n);
      figures.add(name + "_pixel", {std::sqrt(sum / (kSide * kSide))}, "error of pixels");
      // binomial of 5 x 5 pixels, whose squares sum to (70 / 256)^2
      constexpr double kTap[5] = {1 / 16., 4 / 16., 6 / 16., 4 / 16., 1 / 16.};
      double left = 0;
      for (int py = 2; py < kSide - 2; ++py)
        for (int px = 2; px < kSide - 2; ++px) {
          double v = 0;
          for (int b = 0; b < 5; ++b)
            for (int a = 0; a < 5; ++a) v += kTap[a] * kTap[b] * error[size_t((py + b - 2) * kSide + px + a - 2)];
          left += v * v;
        }
      left /= (kSide - 4) * (kSide - 4);
      figures.add(name + "_averaged", {std::sqrt(left / (sum / (kSide * kSide))) / (70 / 256.)},
                  "of it when neighbours are averaged, over what is left of independent errors");
    }
  }
}

}  // namespace kinora::bench
