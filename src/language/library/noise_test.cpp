// Proves hash.h, perlin.h, cell_noise.h and simplex.h against a plain scalar reading of the same specification,
// written here with loops and tables over any number type: values to the bit in floats, derivatives against central
// differences in doubles; lattice zeros, ranges, periods, the relation of components to the float noise, and the same
// bits at all widths. Misses what the specification itself would have wrong.
#define KINORA_KERNEL_FILE "language/library/noise_test.cpp"
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include "language/library/cell_noise.h"
#include "language/library/simplex.h"

#ifndef LANGUAGE_NOISE_TEST_ONCE
#define LANGUAGE_NOISE_TEST_ONCE
namespace kinora::languageNoiseTest {
enum Kind { kPerlin, kUnsignedPerlin, kCell, kHash, kSimplex, kHashInt };
// x[4][n], period[4][n] or null; the derivatives of coordinate i are dx = 1 + i, dy = i == along. r[9][n]: values,
// dx, dy.
struct Job {
  int kind, dimensions, components;
  bool derivatives, periodic;
  int along;
  uint32_t n;
  const float* x[4];
  const float* period[4];
  float* r[9];
};
using Kernel = void (*)(const Job&);
}  // namespace kinora::languageNoiseTest
#endif

KINORA_KERNELS_BEGIN
using namespace languageNoiseTest;

template <class Noise, int N, int C, bool kDerivatives, int W>
void runNoise(const Job& j) {
  for (uint32_t at = 0; at < j.n; at += W) {
    Float<W> x[N], p[N];
    for (int i = 0; i < N; ++i) x[i] = Float<W>::load(j.x[i] + at), p[i] = Float<W>::load(j.period[i] + at);
    if constexpr (kDerivatives) {
      lang::Dual<W> d[N], r[C];
      for (int i = 0; i < N; ++i)
        d[i] = lang::Dual<W>(x[i], Float<W>(1.f + float(i)), Float<W>(i == j.along ? 1.f : 0.f));
      Noise::template dual<N, C, W>(d, j.periodic ? p : nullptr, r);
      for (int c = 0; c < C; ++c)
        r[c].v.store(j.r[c] + at), r[c].dx.store(j.r[3 + c] + at), r[c].dy.store(j.r[6 + c] + at);
    } else {
      Float<W> r[C];
      Noise::template value<N, C, W>(x, j.periodic ? p : nullptr, r);
      for (int c = 0; c < C; ++c) r[c].store(j.r[c] + at);
    }
  }
}
// All forms in space at width 8; elsewhere those whose code holds the rest: this file is slow to compile.
template <class Noise, int N, int W>
void runComponents(const Job& j) {
  if (j.components == 3 && j.derivatives) return runNoise<Noise, N, 3, true, W>(j);
  if constexpr (W == 1 || W == 8)
    if (j.components == 1 && !j.derivatives) return runNoise<Noise, N, 1, false, W>(j);
  if constexpr (W == 8 && N == 3)
    return j.components == 1 ? runNoise<Noise, N, 1, true, W>(j) : runNoise<Noise, N, 3, false, W>(j);
}
template <class Noise, int W>
void runDimensions(const Job& j) {
  switch (j.dimensions) {
    case 1:
      return runComponents<Noise, 1, W>(j);
    case 2:
      return runComponents<Noise, 2, W>(j);
    case 3:
      return runComponents<Noise, 3, W>(j);
    default:
      return runComponents<Noise, 4, W>(j);
  }
}
template <int N, int W>
void runHash(const Job& j) {
  for (uint32_t at = 0; at < j.n; at += W) {
    Float<W> x[N];
    for (int i = 0; i < N; ++i) x[i] = Float<W>::load(j.x[i] + at);
    asFloat(lang::hashFloats<N>(x)).store(j.r[0] + at);
  }
}
template <int W>
void run(const Job& j) {
  switch (j.kind) {
    case kPerlin:
      return runDimensions<lang::PerlinNoise, W>(j);
    case kUnsignedPerlin:
      return runComponents<lang::UnsignedNoise<lang::PerlinNoise>, 3, W>(j);
    case kCell:
      return runDimensions<lang::CellNoise, W>(j);
    case kHash:
      return runDimensions<lang::HashNoise, W>(j);
    case kSimplex:
      return runDimensions<lang::SimplexNoise, W>(j);
    default:
      return runHash<2, W>(j);
  }
}
KN_POINTERS(kRun, run)
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
using namespace languageNoiseTest;
using Words = std::vector<uint32_t>;

// ---- the specification, read once more in scalars ----
uint32_t rot(uint32_t x, int k) { return x << k | x >> (32 - k); }
uint32_t finish(uint32_t a, uint32_t b, uint32_t c) {
  uint32_t* v[3] = {&a, &b, &c};
  const int steps[7][3] = {{2, 1, 14}, {0, 2, 11}, {1, 0, 25}, {2, 1, 16}, {0, 2, 4}, {1, 0, 14}, {2, 1, 24}};
  for (const auto& s : steps) *v[s[0]] ^= *v[s[1]], *v[s[0]] -= rot(*v[s[1]], s[2]);
  return c;
}
uint32_t hashWords(const Words& k) {
  uint32_t v[3];
  for (uint32_t& s : v) s = 0xdeadbeefu + 4 * uint32_t(k.size()) + 13;
  size_t at = 0;
  while (k.size() - at > 3) {
    for (int i = 0; i < 3; ++i) v[i] += k[at++];
    const int turns[6] = {4, 6, 8, 16, 19, 4};
    for (int i = 0; i < 6; ++i) {
      uint32_t &x = v[i % 3], &y = v[(i + 1) % 3], &z = v[(i + 2) % 3];
      x -= z, x ^= rot(z, turns[i]), z += y;
    }
  }
  for (int i = 0; at < k.size(); ++i) v[i] += k[at++];
  return finish(v[0], v[1], v[2]);
}
template <class T>
T fade(T t) {
  return t * t * t * (t * (T(6) * t - T(15)) + T(10));
}
template <class T>
T lerp(T a, T b, T t) {
  return a * (T(1) - t) + b * t;
}

template <class T>
T perlinCorner(int n, uint32_t h, const T* d) {
  const auto flip = [&](T x, int bit) { return h >> bit & 1 ? -x : x; };
  const T x = d[0], y = d[1], z = d[2], w = d[3];
  if (n == 1) return (h & 8 ? -T(1 + (h & 7)) : T(1 + (h & 7))) * x;
  if (n == 2) return h & 4 ? flip(y, 0) + flip(2 * x, 1) : flip(x, 0) + flip(2 * y, 1);
  if (n == 3) {
    const uint32_t k = h & 15;
    return flip(k < 8 ? x : y, 0) + flip(k < 4 ? y : k == 12 || k == 14 ? x : z, 1);
  }
  const uint32_t k = h & 31;
  return flip(k < 24 ? x : y, 0) + flip(k < 16 ? y : z, 1) + flip(k < 8 ? z : w, 2);
}
// Corner values laid out by bits (x lowest), then folded along z, x, y, w.
template <class T>
T perlin(int n, const T* x, const float* period, int component) {
  int64_t cell[4] = {};
  T f[4] = {};
  for (int i = 0; i < n; ++i) cell[i] = int64_t(std::floor(x[i])), f[i] = x[i] - std::floor(x[i]);
  T v[16] = {};
  for (int corner = 0; corner < 1 << n; ++corner) {
    Words k;
    T d[4] = {};
    for (int i = 0; i < n; ++i) {
      const int bit = corner >> i & 1;
      int64_t at = cell[i] + bit;
      if (period) {
        const int64_t p = std::max<int64_t>(1, int64_t(std::floor(period[i])));
        at = ((at % p) + p) % p;
      }
      k.push_back(uint32_t(at));
      d[i] = f[i] - T(bit);
    }
    v[corner] = perlinCorner(n, (hashWords(k) >> 8 * component) & 255, d);
  }
  for (int axis : n < 3 ? std::vector<int>{0, 1} : std::vector<int>{2, 0, 1, 3})
    if (axis < n)
      for (int corner = 0; corner < 1 << n; ++corner)
        if (!(corner >> axis & 1)) v[corner] = lerp(v[corner], v[corner | 1 << axis], fade(f[axis]));
  const T scale[5] = {0, T(0.2500f), T(0.6616f), T(0.9820f), T(0.8344f)};
  return scale[n] * v[0];
}
float toZeroOne(uint32_t h) { return float(h) * 0x1p-32f; }
uint32_t bitsOf(float x) {
  uint32_t b;
  std::memcpy(&b, &x, 4);
  return b;
}
float cellOrHash(bool cell, int n, const float* x, const float* period, int component, int components) {
  Words k;
  for (int i = 0; i < n; ++i) {
    float a = x[i];
    if (period) {
      const float p = std::max(1.f, std::floor(period[i]));
      a = a - p * std::floor(a / p);
    }
    k.push_back(cell ? uint32_t(int32_t(std::floor(a))) : bitsOf(a));
  }
  if (components == 3) k.push_back(uint32_t(component));
  return toZeroOne(hashWords(k));
}
template <class T>
T simplex(int n, const T* x, uint32_t seed) {
  const auto S = [](uint32_t a, uint32_t b, uint32_t c) { return finish(a, b, c ^ 0xdeadbeefu); };
  const auto direction1 = [](uint32_t h) { return (h & 8 ? -1 : 1) * T(1 + (h & 7)); };
  if (n == 1) {
    const int32_t i = int32_t(std::floor(x[0]));
    T sum = 0;
    for (int m = 0; m < 2; ++m) {
      const T d = x[0] - T(i) - T(m);
      T t = T(1) - d * d;
      t *= t, t *= t;
      sum += t * (direction1(S(uint32_t(i + m), seed, 0)) * d);
    }
    return T(0.36f) * sum;
  }
  const T F[5] = {0, 0, T(0.366025403f), T(1.f / 3.f), T(0.309016994f)};
  const T G[5] = {0, 0, T(0.211324865f), T(1.f / 6.f), T(0.138196601f)};
  static const int g2[8][2] = {{-1, -1}, {1, 0}, {-1, 0}, {1, 1}, {-1, 1}, {0, -1}, {0, 1}, {1, -1}};
  static const int g3[16][3] = {{1, 0, 1},   {0, 1, 1},   {-1, 0, 1}, {0, -1, 1}, {1, 0, -1}, {0, 1, -1},
                                {-1, 0, -1}, {0, -1, -1}, {1, -1, 0}, {1, 1, 0},  {-1, 1, 0}, {-1, -1, 0},
                                {1, 0, 1},   {-1, 0, 1},  {0, 1, -1}, {0, -1, -1}};
  T q = 0;
  for (int i = 0; i < n; ++i) q += x[i];
  q *= F[n];
  int32_t cell[4] = {}, total = 0;
  for (int i = 0; i < n; ++i) total += cell[i] = int32_t(std::floor(x[i] + q));
  T d[4];
  for (int i = 0; i < n; ++i) d[i] = x[i] - (T(cell[i]) - T(total) * G[n]);
  // axes from the longest to the shortest
  std::vector<int> order;
  for (int i = 0; i < n; ++i) {
    size_t at = 0;
    while (at < order.size() && (n == 3 ? d[order[at]] >= d[i] : d[order[at]] > d[i])) ++at;
    order.insert(order.begin() + long(at), i);
  }
  T sum = 0;
  int o[4] = {};
  for (int m = 0; m <= n; ++m) {
    if (m > 0) o[order[size_t(m - 1)]] = 1;
    T e[4], t = T(0.5), dot = 0;
    uint32_t k[4] = {};
    for (int i = 0; i < n; ++i) e[i] = d[i] - T(o[i]) + T(float(m) * float(G[n])), k[i] = uint32_t(cell[i] + o[i]);
    for (int i = 0; i < n; ++i) t -= e[i] * e[i];
    if (t < 0) continue;
    const uint32_t h = n == 2   ? S(k[0], k[1], seed)
                       : n == 3 ? S(k[0], k[1], S(k[2], seed, 0))
                                : S(k[0], k[1], S(k[2], k[3], seed));
    int bit = 4;
    for (int i = 0; i < n; ++i) {
      int g;
      if (n == 2)
        g = g2[h & 7][i];
      else if (n == 3)
        g = g3[h & 15][i];
      else if (i == int(h >> 3 & 3))
        g = 0;
      else
        g = h & uint32_t(bit) ? -1 : 1, bit >>= 1;
      dot = i == 0 ? T(g) * e[0] : dot + T(g) * e[i];
    }
    t *= t, t *= t;
    sum += t * dot;
  }
  const T scale[5] = {0, 0, 64, 68, 54};
  return scale[n] * sum;
}

// ---- batches ----
struct Batch {
  std::vector<float> x[4], period[4], r[9];
  explicit Batch(uint32_t n, float size) {
    for (auto& a : r) a.resize(n);
    for (int i = 0; i < 4; ++i) {
      const double steps[4] = {0.8566748838545029, 0.7338918566271260, 0.6287067210378087, 0.5385972572236101};
      for (uint32_t k = 0; k < n; ++k) {
        x[i].push_back(float((std::fmod((k + 1) * steps[i], 1.0) - 0.5) * size));
        period[i].push_back(float(1 + (k * 7 + uint32_t(i) * 3) % 11) + 0.5f);
      }
    }
  }
  void run(Kernel kernel, int kind, int n, int components, bool derivatives, bool periodic = false, int along = 0) {
    Job j{kind, n, components, derivatives, periodic, along, uint32_t(x[0].size()), {}, {}, {}};
    for (int i = 0; i < 4; ++i) j.x[i] = x[i].data(), j.period[i] = period[i].data();
    for (int i = 0; i < 9; ++i) j.r[i] = r[i].data();
    kernel(j);
  }
};
}  // namespace

TEST(LanguageNoise, HashIsTheSpecifiedOne) {
  Batch b(256, 1e6f);
  b.run(N_AVX2::kRun8, kHashInt, 2, 1, false);
  for (size_t k = 0; k < 256; ++k) ASSERT_EQ(bitsOf(b.r[0][k]), hashWords({bitsOf(b.x[0][k]), bitsOf(b.x[1][k])}));
}

TEST(LanguageNoise, ValuesAreThoseOfTheScalarReading) {
  for (float size : {4.f, 1e3f, 3e6f})
    for (int kind : {kPerlin, kCell, kHash, kSimplex})
      for (int n = 1; n <= 4; ++n)
        for (int components : {1, 3})
          for (bool periodic : {false, true}) {
            if (periodic && kind == kSimplex) continue;
            Batch b(512, size);
            b.run(N_AVX2::kRun8, kind, n, components, components == 3 && n != 3, periodic);
            for (uint32_t k = 0; k < 512; ++k)
              for (int c = 0; c < components; ++c) {
                float x[4], p[4];
                for (int i = 0; i < 4; ++i) x[i] = b.x[i][k], p[i] = b.period[i][k];
                const float* period = periodic ? p : nullptr;
                const float expected = kind == kPerlin    ? perlin<float>(n, x, period, c)
                                       : kind == kSimplex ? simplex<float>(n, x, uint32_t(c))
                                                          : cellOrHash(kind == kCell, n, x, period, c, components);
                ASSERT_EQ(b.r[c][k], expected)
                    << "kind " << kind << ", " << n << "D, component " << c << ", periodic " << periodic << " at "
                    << x[0] << " " << x[1] << " " << x[2];
              }
          }
}

TEST(LanguageNoise, DerivativesAgreeWithDifferences) {
  for (int kind : {kPerlin, kSimplex})
    for (int n = 1; n <= 4; ++n)
      for (int components : {1, 3})
        for (int along = 0; along < n; ++along) {
          if (components == 1 && n != 3) continue;
          Batch b(256, 20), plain(256, 20);
          b.run(N_AVX2::kRun8, kind, n, components, true, false, along);
          plain.run(N_AVX2::kRun8, kind, n, n == 3 ? components : 1, false);
          for (uint32_t k = 0; k < 256; ++k)
            for (int c = 0; c < components; ++c) {
              if (c == 0 || n == 3) {
                ASSERT_EQ(b.r[c][k], plain.r[c][k]);
              }
              double x[4], g[4] = {}, dx = 0;
              for (int i = 0; i < 4; ++i) x[i] = double(b.x[i][k]);
              const auto at = [&] {
                return kind == kPerlin ? perlin<double>(n, x, nullptr, c) : simplex<double>(n, x, uint32_t(c));
              };
              for (int i = 0; i < n; ++i) {
                const double centre = x[i], h = 1e-5;
                x[i] = centre + h;
                const double up = at();
                x[i] = centre - h;
                g[i] = (up - at()) / (2 * h);
                x[i] = centre;
                dx += g[i] * (1 + i);
              }
              // simplex noise jumps in its second derivative, and floats near 10 carry six digits
              ASSERT_NEAR(b.r[6 + c][k], g[along], 3e-4) << kind << " " << n << "D component " << c;
              ASSERT_NEAR(b.r[3 + c][k], dx, 2e-3) << kind << " " << n << "D component " << c;
            }
        }
  for (int kind : {kCell, kHash}) {
    Batch b(16, 20);
    b.r[3][5] = 9;
    b.run(N_AVX2::kRun8, kind, 3, 1, true);
    EXPECT_EQ(b.r[3][5], 0.f);
  }
}

TEST(LanguageNoise, GradientNoiseVanishesOnTheLatticeAndRepeats) {
  for (int n = 1; n <= 4; ++n) {
    Batch b(1024, 64);
    for (auto& a : b.x)
      for (float& v : a) v = std::floor(v);
    b.run(N_AVX2::kRun8, kPerlin, n, 3, true);
    for (int c = 0; c < 3; ++c)
      for (float v : b.r[c]) ASSERT_EQ(v, 0.f);
    // beyond 2^23 every float is a lattice point
    for (float& v : b.x[0]) v = v * 1e6f + 8388608.f;
    b.run(N_AVX2::kRun8, kPerlin, 1, 1, false);
    for (float v : b.r[0]) ASSERT_EQ(v, 0.f);
    // a whole number of periods away, at multiples of 1/64, which stay exact
    Batch p(1024, 16), q(1024, 16);
    float most = 0;
    for (int i = 0; i < 4; ++i)
      for (size_t k = 0; k < 1024; ++k) {
        p.x[i][k] = std::floor(p.x[i][k] * 64) / 64;
        q.x[i][k] = p.x[i][k] + 3 * std::floor(p.period[i][k]);
      }
    for (int kind : {kPerlin, kCell}) {
      p.run(N_AVX2::kRun8, kind, n, 1, false, true);
      q.run(N_AVX2::kRun8, kind, n, 1, false, true);
      for (size_t k = 0; k < 1024; ++k) {
        ASSERT_EQ(p.r[0][k], q.r[0][k]) << kind << " " << n << "D";
        most = std::max(most, std::fabs(p.r[0][k]));
      }
    }
    EXPECT_GT(most, 0.5f);
  }
}

TEST(LanguageNoise, RangesAndMeans) {
  for (int kind : {kPerlin, kSimplex, kCell, kHash})
    for (int n = 1; n <= 4; ++n) {
      Batch b(1 << 14, 500);
      b.run(N_AVX2::kRun8, kind, n, 3, true);
      const bool isSigned = kind == kPerlin || kind == kSimplex;
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        float least = 1, most = -1;
        for (float v : b.r[c]) sum += double(v), least = std::min(least, v), most = std::max(most, v);
        EXPECT_GE(least, isSigned ? -1.f : 0.f);
        EXPECT_LE(most, 1.f);
        EXPECT_GT(most - least, isSigned ? 1.2f : 0.98f) << kind << " " << n;
        EXPECT_NEAR(sum / (1 << 14), isSigned ? 0 : 0.5, 0.04) << kind << " " << n;
      }
    }
  Batch s(256, 30), u(256, 30);
  s.run(N_AVX2::kRun8, kPerlin, 3, 3, true);
  u.run(N_AVX2::kRun8, kUnsignedPerlin, 3, 3, true);
  for (size_t k = 0; k < 256; ++k)
    for (int c = 0; c < 9; ++c) ASSERT_EQ(u.r[c][k], 0.5f * (s.r[c][k] + (c < 3 ? 1.f : 0.f)));
}

TEST(LanguageNoise, SameBitsAtAllWidths) {
  std::vector<Kernel> others{N_AVX2::kRun1, N_AVX2::kRun4};
  if (cpuHasAvx512()) others.push_back(N_AVX3::kRun16);
  for (int kind : {kPerlin, kCell, kHash, kSimplex})
    for (int n = 1; n <= 4; ++n)
      for (bool triple : {false, true})
        for (bool periodic : {false, true}) {
          Batch a(256, 1000), b(256, 1000);
          a.run(N_AVX2::kRun8, kind, n, triple ? 3 : 1, triple, periodic, n - 1);
          for (Kernel k : others) {
            if (!triple && k != N_AVX2::kRun1) continue;
            b.run(k, kind, n, triple ? 3 : 1, triple, periodic, n - 1);
            for (int i = 0; i < (triple ? 9 : 1); ++i)
              for (size_t at = 0; at < 256; ++at)
                ASSERT_EQ(bitsOf(a.r[i][at]), bitsOf(b.r[i][at]))
                    << "kind " << kind << ", " << n << "D, result " << i << " of point " << at;
          }
        }
}
}  // namespace kinora
#endif
