// Proves the noise of include/kinora/math/noise.h: range, mean, deviation and mean absolute value (which the header
// states), continuity, zeros at lattice points, no relation between slices, no favourite axis, and the same bits at
// all widths. It does not prove that it looks good.
#define KINORA_KERNEL_FILE "math/noise_test.cpp"
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/math/noise.h>

#ifndef KINORA_NOISE_TEST_ONCE
#define KINORA_NOISE_TEST_ONCE
namespace kinora::noiseTest {
using Fill = void (*)(uint32_t n, const float* const p[3], const float* radius, float* noise, float* fractal);
}
#endif

KINORA_KERNELS_BEGIN
template <int W>
void fill(uint32_t n, const float* const p[3], const float* radius, float* noise, float* fractal) {
  for (uint32_t i = 0; i < n; i += W) {
    const Vec3<W> q = Vec3<W>::load(p, i);
    gradientNoise(q, 99u).store(noise + i);
    FractalShape<W> shape;
    shape.erosion = Float<W>(0.3f);
    shape.variation = Float<W>(0.6f);
    fractalNoise(shape, q, Float<W>::load(radius + i), 7u).store(fractal + i);
  }
}
KN_POINTERS(kFill, fill)
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
struct Points {
  std::vector<float> x, y, z, radius, noise, fractal;
  explicit Points(uint32_t n) : x(n), y(n), z(n), radius(n), noise(n), fractal(n) {}
  void run(noiseTest::Fill f) {
    const float* const p[3] = {x.data(), y.data(), z.data()};
    f(uint32_t(x.size()), p, radius.data(), noise.data(), fractal.data());
  }
};
// A low-discrepancy walk through a cube of `size` (Roberts' R3 sequence).
Points walk(uint32_t n, double size) {
  Points p(n);
  for (uint32_t i = 0; i < n; ++i) {
    p.x[i] = float((std::fmod(i * 0.8191725133961645, 1.0) - 0.5) * size);
    p.y[i] = float((std::fmod(i * 0.6710436067037893, 1.0) - 0.5) * size);
    p.z[i] = float((std::fmod(i * 0.5497004779019703, 1.0) - 0.5) * size);
  }
  return p;
}
double correlation(const std::vector<float>& a, const std::vector<float>& b) {
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < a.size(); ++i)
    ab += double(a[i]) * b[i], aa += double(a[i]) * a[i], bb += double(b[i]) * b[i];
  return ab / std::sqrt(aa * bb);
}
}  // namespace

TEST(Noise, HasTheStatedStatistics) {
  Points p = walk(1u << 20, 1000);
  p.run(N_AVX2::kFill8);
  double sum = 0, squares = 0, absolute = 0;
  uint32_t clamped = 0;
  for (float v : p.noise) {
    ASSERT_LE(std::fabs(v), 1.f);
    sum += v, squares += double(v) * v, absolute += std::fabs(v), clamped += std::fabs(v) == 1.f;
  }
  const double n = double(p.noise.size());
  EXPECT_NEAR(sum / n, 0, 1e-3);
  EXPECT_NEAR(std::sqrt(squares / n), kNoiseDeviation, 1e-3);
  EXPECT_NEAR(absolute / n, kNoiseMeanAbs, 1e-3);
  EXPECT_LT(clamped / n, 2e-5);
  for (float v : p.fractal) ASSERT_LE(std::fabs(v), 1.f);
}

TEST(Noise, IsContinuousAndZeroOnTheLattice) {
  // across cell faces and inside, steps of 1e-3 change it by little more than the steepest gradient allows
  Points p(1u << 16);
  for (uint32_t i = 0; i < p.x.size(); ++i)
    p.x[i] = -20 + float(i) * 1e-3f, p.y[i] = 0.37f + float(i) * 5e-4f, p.z[i] = -7.77f;
  p.run(N_AVX2::kFill8);
  for (size_t i = 1; i < p.noise.size(); ++i) ASSERT_LT(std::fabs(p.noise[i] - p.noise[i - 1]), 8e-3f) << i;
  for (uint32_t i = 0; i < p.x.size(); ++i)
    p.x[i] = float(i % 512) - 256, p.y[i] = float(i / 512), p.z[i] = float(i % 7);
  p.run(N_AVX2::kFill8);
  for (float v : p.noise) ASSERT_EQ(v, 0.f);
}

TEST(Noise, SlicesAreUnrelatedAndAxesAlike) {
  double deviation[3];
  for (int spacing : {1, 64, 1024})
    for (int axis = 0; axis < 3; ++axis) {
      // squares of 64 x 64 cells at half-way positions, perpendicular to the axis
      std::vector<std::vector<float>> slices;
      double squares = 0;
      for (int k = 0; k < 40; ++k) {
        Points p(64 * 64);
        std::vector<float>* place[3] = {&p.x, &p.y, &p.z};
        for (uint32_t i = 0; i < p.x.size(); ++i) {
          (*place[axis])[i] = float(k * spacing) + 0.5f;
          (*place[(axis + 1) % 3])[i] = float(i % 64) + 0.5f;
          (*place[(axis + 2) % 3])[i] = float(i / 64) + 0.5f;
        }
        p.run(N_AVX2::kFill8);
        slices.push_back(p.noise);
        for (float v : p.noise) squares += double(v) * v;
      }
      deviation[axis] = std::sqrt(squares / (40 * 64 * 64));
      for (size_t a = 0; a < slices.size(); ++a)
        for (size_t b = a + 2; b < slices.size(); ++b)  // neighbours share a lattice plane; chance alone gives 0.1
          ASSERT_LT(std::fabs(correlation(slices[a], slices[b])), 0.13)
              << "axis " << axis << ", slices " << a << ", " << b;
    }
  EXPECT_NEAR(deviation[0] / deviation[1], 1, 0.03);
  EXPECT_NEAR(deviation[0] / deviation[2], 1, 0.03);
}

TEST(Noise, SameBitsAtAllWidths) {
  Points p = walk(1u << 12, 5000), q = p;
  for (uint32_t i = 0; i < p.x.size(); ++i) p.radius[i] = q.radius[i] = float(i % 100) * 0.01f;
  p.run(N_AVX2::kFill1);
  std::vector<noiseTest::Fill> others{N_AVX2::kFill4, N_AVX2::kFill8};
  if (cpuHasAvx512()) others.push_back(N_AVX3::kFill16);
  for (noiseTest::Fill f : others) {
    q.run(f);
    EXPECT_EQ(std::memcmp(p.noise.data(), q.noise.data(), p.noise.size() * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(p.fractal.data(), q.fractal.data(), p.noise.size() * sizeof(float)), 0);
  }
}

}  // namespace kinora
#endif
