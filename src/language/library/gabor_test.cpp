// Proves gabor.h against a scalar reading of the same specification in doubles (the generator's draws in floats):
// every option, filtered and not, periodic; derivatives against differences; the period; less contrast under wider
// filters; the same bits at all widths. Misses what the specification itself would have wrong.
#define KINORA_KERNEL_FILE "language/library/gabor_test.cpp"
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include "language/library/gabor.h"

#ifndef LANGUAGE_GABOR_TEST_ONCE
#define LANGUAGE_GABOR_TEST_ONCE
namespace kinora::languageGaborTest {
constexpr int kPoints = 32;
struct Job {
  int dimensions = 3, anisotropic = 0;
  bool filter = false, periodic = false;
  float direction[3] = {1, 0, 0}, bandwidth = 1, impulses = 16, period[3] = {3, 4, 5};
  float x[3][3][kPoints] = {};    // coordinate, {value, dx, dy}
  float out[3][3][kPoints] = {};  // component, {value, dx, dy}
};
using Kernel = void (*)(Job&);
}  // namespace kinora::languageGaborTest
#endif

KINORA_KERNELS_BEGIN
using namespace languageGaborTest;
template <int W>
void run(Job& j) {
  for (int at = 0; at < kPoints; at += W) {
    using F = Float<W>;
    lang::Dual<W> x[3], r[3];
    const F period[3] = {F(j.period[0]), F(j.period[1]), F(j.period[2])};
    for (int i = 0; i < 3; ++i)
      x[i] = lang::Dual<W>(F::load(j.x[i][0] + at), F::load(j.x[i][1] + at), F::load(j.x[i][2] + at));
    lang::GaborOptions<W> o;
    o.anisotropic = j.anisotropic;
    o.filter = j.filter;
    o.direction = Vec3<W>(F(j.direction[0]), F(j.direction[1]), F(j.direction[2]));
    o.bandwidth = F(j.bandwidth);
    o.impulses = F(j.impulses);
    const F* p = j.periodic ? period : nullptr;
    if (j.dimensions == 1)
      lang::GaborNoise::dual<1, 3, W>(x, p, o, r);
    else if (j.dimensions == 2)
      lang::GaborNoise::dual<2, 3, W>(x, p, o, r);
    else
      lang::GaborNoise::dual<3, 3, W>(x, p, o, r);
    for (int c = 0; c < 3; ++c)
      r[c].v.store(j.out[c][0] + at), r[c].dx.store(j.out[c][1] + at), r[c].dy.store(j.out[c][2] + at);
  }
}
KN_POINTERS(kRun, run)
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
using namespace languageGaborTest;
constexpr double kTau = 6.283185307179586;

uint32_t rotated(uint32_t x, int k) { return x << k | x >> (32 - k); }
// lookup3 of four words
uint32_t hash(uint32_t x, uint32_t y, uint32_t z, uint32_t w) {
  uint32_t v[3];
  for (int i = 0; i < 3; ++i) v[i] = 0xdeadbeefu + 16 + 13 + (i == 0 ? x : i == 1 ? y : z);
  const int turns[6] = {4, 6, 8, 16, 19, 4};
  for (int i = 0; i < 6; ++i) {
    uint32_t &a = v[i % 3], &b = v[(i + 1) % 3], &c = v[(i + 2) % 3];
    a -= c, a ^= rotated(c, turns[i]), c += b;
  }
  v[0] += w;
  const int ends[7][3] = {{2, 1, 14}, {0, 2, 11}, {1, 0, 25}, {2, 1, 16}, {0, 2, 4}, {1, 0, 14}, {2, 1, 24}};
  for (const auto& e : ends) v[e[0]] ^= v[e[1]], v[e[0]] -= rotated(v[e[1]], e[2]);
  return v[2];
}
struct V3 {
  double x, y, z;
};
double dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
V3 cross(V3 a, V3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
V3 unit(V3 a) {
  const double s = 1 / std::sqrt(dot(a, a));
  return {a.x * s, a.y * s, a.z * s};
}
// General 2x2 matrices, so that not even the symmetric shortcuts are shared.
struct M2 {
  double m[2][2];
  double det() const { return m[0][0] * m[1][1] - m[0][1] * m[1][0]; }
  M2 inverse() const {
    const double d = det();
    return {{{m[1][1] / d, -m[0][1] / d}, {-m[1][0] / d, m[0][0] / d}}};
  }
};
M2 operator+(M2 a, M2 b) {
  for (int i = 0; i < 4; ++i) a.m[i / 2][i % 2] += b.m[i / 2][i % 2];
  return a;
}
M2 operator*(M2 a, M2 b) {
  M2 r{};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 2; ++k) r.m[i][j] += a.m[i][k] * b.m[k][j];
  return r;
}
M2 scaled(double s, M2 a) { return a * M2{{{s, 0}, {0, s}}}; }

// At point k, moved by `step` along one of its derivatives.
double gabor(const Job& j, int k, uint32_t seed, int direction = 1, double step = 0) {
  const float bandwidth = std::min(100.f, std::max(0.01f, j.bandwidth)),
              impulses = std::min(32.f, std::max(1.f, j.impulses));
  const double two = std::exp2(double(bandwidth)), a = 2 * ((two - 1) / (two + 1)) * 2.128934;
  const double R = std::sqrt(-std::log(0.02) / M_PI) / a, lambda = double(impulses) / (1.33333 * M_PI * R * R * R);
  double P[3] = {}, dx[3] = {}, dy[3] = {};
  for (int i = 0; i < j.dimensions; ++i)
    P[i] = double(j.x[i][0][k]) + step * double(j.x[i][direction][k]), dx[i] = double(j.x[i][1][k]),
    dy[i] = double(j.x[i][2][k]);
  const V3 px{dx[0], dx[1], dx[2]}, py{dy[0], dy[1], dy[2]};
  V3 n = cross(px, py), t{}, b{};
  bool filter = j.filter && dot(n, n) >= 1e-6;
  M2 spatial{};
  if (filter) {
    n = unit(n);
    t = unit(std::fabs(n.x) < 0.9 ? V3{0, n.z, -n.y} : V3{-n.z, 0, n.x});
    b = cross(n, t);
    const M2 M{
        {{px.x * t.x + py.x * t.y, px.x * b.x + py.x * b.y}, {px.y * t.x + py.y * t.y, px.y * b.x + py.y * b.y}}};
    const M2 Mt{{{M.m[0][0], M.m[1][0]}, {M.m[0][1], M.m[1][1]}}};
    spatial = scaled(0.25, Mt * M);
    filter = spatial.det() >= 1e-18;
  }
  double sum = 0;
  for (int cell = 0; cell < 27; ++cell) {
    double q[3], e[3];
    uint32_t word[3];
    for (int i = 0; i < 3; ++i) {
      const int offset = (i == 0 ? cell : i == 1 ? cell / 3 : cell / 9) % 3 - 1;
      q[i] = std::floor(P[i] / R) + offset;
      e[i] = P[i] / R - q[i];
      if (j.periodic) {
        const double p = i < j.dimensions ? std::max(1.0, std::floor(double(j.period[i]))) : 1;
        q[i] -= p * std::floor(q[i] / p);
      }
      word[i] = uint32_t(int64_t(q[i]));
    }
    uint32_t s = hash(word[0], word[1], word[2], seed);
    if (s == 0) s = 1;
    const auto draw = [&] {
      s *= 3039177861u;
      return float(s) * 0x1p-32f;
    };
    const float limit = float(std::exp(-lambda * R * R * R));
    int count = 0;
    for (float product = draw(); product > limit; product *= draw()) ++count;
    for (int i = 0; i < count; ++i) {
      V3 d;
      d.z = R * (e[2] - double(draw()));
      d.y = R * (e[1] - double(draw()));
      d.x = R * (e[0] - double(draw()));
      V3 omega{double(j.direction[0]), double(j.direction[1]), double(j.direction[2])};
      if (j.anisotropic != 1) {
        const double angle = kTau * double(draw());
        if (j.anisotropic == 0) {
          const double c = 2 * double(draw()) - 1, f = std::sqrt(1 - c * c);
          omega = {std::cos(angle) * f, std::sin(angle) * f, c};
        } else {
          const double size = std::sqrt(dot(omega, omega));
          omega = {size * std::cos(angle), size * std::sin(angle), 0};
        }
      }
      const double phase = kTau * double(draw());
      if (dot(d, d) >= R * R) continue;
      if (!filter) {
        sum += std::exp(-M_PI * a * a * dot(d, d)) * std::cos(kTau * dot(omega, d) + phase);
        continue;
      }
      const double w3[3] = {dot(omega, t), dot(omega, b), dot(omega, n)}, dl = -dot(n, d);
      const M2 SG = scaled(a * a / kTau, M2{{{1, 0}, {0, 1}}}), SF = scaled(1 / (kTau * kTau), spatial.inverse());
      const M2 inv = (SG + SF).inverse(), T = (SF.inverse() + SG.inverse()).inverse(), to = T * SG.inverse();
      double form = 0, wf[2] = {};
      for (int p = 0; p < 2; ++p)
        for (int r = 0; r < 2; ++r) form += w3[p] * inv.m[p][r] * w3[r], wf[r] += w3[p] * to.m[p][r];
      const double c = std::exp(-M_PI * a * a * dl * dl) / (kTau * std::sqrt(spatial.det())) /
                       (kTau * std::sqrt((SG + SF).det())) * std::exp(-0.5 * form);
      const double af2 = kTau * std::sqrt(T.det()), X[2] = {dot(d, t), dot(d, b)};
      sum += c * std::exp(-M_PI * af2 * (X[0] * X[0] + X[1] * X[1])) *
             std::cos(kTau * (wf[0] * X[0] + wf[1] * X[1]) + phase - kTau * dl * w3[2]);
    }
  }
  const double V = 1 / (4 * std::sqrt(2.0) * a * a * a);
  return sum / std::sqrt(lambda) * 0.5 / (3 * std::sqrt(V));
}

Job makeJob(int variant, float size) {
  Job j;
  j.dimensions = 1 + (variant + 2) % 3;
  j.anisotropic = variant % 3;
  j.filter = variant & 1;
  j.periodic = variant & 2;
  if (variant > 3) j.bandwidth = 0.8f + 0.2f * float(variant), j.impulses = float(3 * variant);
  if (variant > 5) j.direction[0] = 1.5f, j.direction[1] = -0.5f, j.direction[2] = 0.7f;
  for (int k = 0; k < kPoints; ++k)
    for (int i = 0; i < 3; ++i) {
      j.x[i][0][k] = float((std::fmod((k + 1) * (0.8191725 - 0.137 * i), 1.0) - 0.5) * double(size));
      j.x[i][1][k] = 0.3f * std::sin(float(5 * k + 2 * i));
      j.x[i][2][k] = 0.3f * std::cos(float(3 * k + 7 * i));
    }
  return j;
}
}  // namespace

TEST(LanguageGabor, ValuesAreThoseOfTheScalarReading) {
  int atTheRim = 0;  // impulses whose distance is the radius to all but the last digits: a hundredth more or less
  for (int variant = 0; variant < 12; ++variant) {
    Job j = makeJob(variant, 8);
    N_AVX2::kRun8(j);
    double most = 0;
    for (int k = 0; k < kPoints; ++k)
      for (int c = 0; c < 3; ++c) {
        const double e = gabor(j, k, uint32_t(c));
        const double off = std::fabs(double(j.out[c][0][k]) - e);
        ASSERT_LT(off, 0.01) << "variant " << variant << ", point " << k << ", component " << c;
        atTheRim += off > 3e-4;
        most = std::max(most, std::fabs(e));
      }
    EXPECT_GT(most, 0.2) << variant;
    EXPECT_LT(most, 1.5) << variant;
  }
  EXPECT_LE(atTheRim, 2);
}

TEST(LanguageGabor, DerivativesAgreeWithDifferences) {
  for (int variant = 0; variant < 12; ++variant) {
    Job j = makeJob(variant, 6);
    N_AVX2::kRun8(j);
    for (int d = 1; d < 3; ++d)
      for (int k = 0; k < kPoints; ++k) {
        const double h = 1e-6, slope = (gabor(j, k, 1, d, h) - gabor(j, k, 1, d, -h)) / (2 * h);
        ASSERT_NEAR(j.out[1][d][k], slope, 2e-3 * (1 + std::fabs(slope))) << "variant " << variant << ", point " << k;
      }
  }
}

TEST(LanguageGabor, PeriodCountsCells) {
  Job j = makeJob(2, 4), moved;
  j.dimensions = 3;
  moved = j;
  const double a = 2 * (1 / 3.0) * 2.128934, R = std::sqrt(-std::log(0.02) / M_PI) / a;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < kPoints; ++k) moved.x[i][0][k] += float(double(j.period[i]) * R);
  N_AVX2::kRun8(j);
  N_AVX2::kRun8(moved);
  for (int k = 0; k < kPoints; ++k) EXPECT_NEAR(j.out[0][0][k], moved.out[0][0][k], 1e-3);
}

TEST(LanguageGabor, WiderFiltersLeaveLess) {
  double before = 1e9;
  for (float width : {0.1f, 0.6f, 1.5f}) {
    Job j = makeJob(0, 50);
    j.filter = true;
    for (int k = 0; k < kPoints; ++k)
      for (int i = 0; i < 3; ++i) j.x[i][1][k] = i == 0 ? width : 0, j.x[i][2][k] = i == 1 ? width : 0;
    N_AVX2::kRun8(j);
    double squares = 0;
    for (int c = 0; c < 3; ++c)
      for (float v : j.out[c][0]) squares += double(v) * double(v);
    EXPECT_LT(squares, 0.8 * before) << width;
    before = squares;
  }
}

TEST(LanguageGabor, SameBitsAtAllWidths) {
  std::vector<Kernel> others{N_AVX2::kRun1, N_AVX2::kRun4};
  if (cpuHasAvx512()) others.push_back(N_AVX3::kRun16);
  for (int variant = 0; variant < 12; ++variant) {
    Job j = makeJob(variant, 100), other = j;
    N_AVX2::kRun8(j);
    for (Kernel k : others) {
      k(other);
      ASSERT_EQ(std::memcmp(j.out, other.out, sizeof j.out), 0) << variant;
    }
  }
}
}  // namespace kinora
#endif
