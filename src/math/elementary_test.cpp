// Every function of math/elementary.h against long double libm over its range: the figures in that header's comments
// are what is asserted here, and all widths give the same bits. Misses arguments between the sampled ones: 200,000
// per range, random in the range or in its logarithm, besides special values.
#define KINORA_KERNEL_FILE "math/elementary_test.cpp"
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/math/elementary.h>

#ifndef ELEMENTARY_TEST_ONCE
#define ELEMENTARY_TEST_ONCE
namespace kinora::elementaryTest {
enum Function { kSin, kCos, kTan, kExp2, kExp, kLog, kLog2, kPow, kAtan, kAtan2, kAsin, kAcos, kFunctions };
// y = f(a, b) for n values, a multiple of 16.
using Run = void (*)(Function f, uint32_t n, const float* a, const float* b, float* y);
}  // namespace kinora::elementaryTest
#endif

KINORA_KERNELS_BEGIN
using namespace elementaryTest;

template <int W>
KN_INLINE Float<W> apply(Function f, Float<W> a, Float<W> b) {
  switch (f) {
    case kSin:
      return sin(a);
    case kCos:
      return cos(a);
    case kTan:
      return tan(a);
    case kExp2:
      return exp2(a);
    case kExp:
      return exp(a);
    case kLog:
      return log(a);
    case kLog2:
      return log2(a);
    case kPow:
      return pow(a, b);
    case kAtan:
      return atan(a);
    case kAtan2:
      return atan2(a, b);
    case kAsin:
      return asin(a);
    default:
      return acos(a);
  }
}
template <int W>
HWY_ATTR void run(Function f, uint32_t n, const float* a, const float* b, float* y) {
  for (uint32_t i = 0; i < n; i += W) apply(f, Float<W>::load(a + i), Float<W>::load(b + i)).store(y + i);
}
#define KN_X(W)                                                                                             \
  [[maybe_unused]] HWY_ATTR void run##W(Function f, uint32_t n, const float* a, const float* b, float* y) { \
    run<W>(f, n, a, b, y);                                                                                  \
  }
KN_EACH_WIDTH(KN_X)
#undef KN_X
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
using namespace elementaryTest;
constexpr uint32_t kCount = 200000;
constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();

uint64_t mix(uint64_t z) {
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}
double unit(uint64_t i) { return double(mix(i * 0x9E3779B97F4A7C15u + 7) >> 11) * 0x1p-53; }

std::vector<float> between(double lo, double hi, uint64_t seed = 1) {
  std::vector<float> v(kCount);
  for (uint32_t i = 0; i < kCount; ++i) v[i] = float(lo + (hi - lo) * unit(seed * 1000003 + i));
  v[0] = float(lo);
  v[1] = float(hi);
  return v;
}
std::vector<float> logBetween(double lo, double hi, uint64_t seed = 1) {
  std::vector<float> v(kCount);
  for (uint32_t i = 0; i < kCount; ++i) v[i] = float(lo * std::pow(hi / lo, unit(seed * 1000003 + i)));
  return v;
}
std::vector<float> call(Function f, const std::vector<float>& a, const std::vector<float>& b, Run r) {
  std::vector<float> y(a.size());
  r(f, uint32_t(a.size()), a.data(), b.data(), y.data());
  return y;
}

struct Errors {
  double absolute = 0, relative = 0;
  float absoluteAt = 0, relativeAt = 0;
};
// Worst errors at width 8; bits equal at the other widths.
template <class Reference>
Errors measure(const char* name, Function f, const std::vector<float>& a, const std::vector<float>& b,
               Reference reference) {
  setThreadFloatMode();
  const std::vector<float> y = call(f, a, b, &N_AVX2::run8);
  for (const Run r : {&N_AVX2::run1, &N_AVX2::run4, cpuHasAvx512() ? &N_AVX3::run16 : &N_AVX2::run8}) {
    const std::vector<float> z = call(f, a, b, r);
    EXPECT_EQ(0, std::memcmp(y.data(), z.data(), y.size() * sizeof(float))) << name << ": widths differ";
  }
  Errors e;
  for (size_t i = 0; i < a.size(); ++i) {
    const long double want = reference((long double)a[i], (long double)b[i]);
    const double error = std::isfinite(y[i]) ? double(std::fabs((long double)y[i] - want)) : HUGE_VAL;
    const double relative = double(error / std::max<long double>(std::fabs(want), 1.2e-38L));
    if (error > e.absolute) {
      e.absolute = error;
      e.absoluteAt = a[i];
    }
    if (relative > e.relative) {
      e.relative = relative;
      e.relativeAt = a[i];
    }
  }
  std::printf("%-28s absolute %.3g (at %.9g), relative %.3g (at %.9g)\n", name, e.absolute, double(e.absoluteAt),
              e.relative, double(e.relativeAt));
  return e;
}
template <class Reference>
Errors measure(const char* name, Function f, const std::vector<float>& a, Reference reference) {
  return measure(name, f, a, a, [&](long double x, long double) { return reference(x); });
}
float one(Function f, float a, float b = 0) {
  std::vector<float> x(16, a), y(16, b);
  return call(f, x, y, &N_AVX2::run8)[3];
}

TEST(Elementary, SineAndCosine) {
  const auto s = [](long double x) { return std::sin(x); };
  const auto c = [](long double x) { return std::cos(x); };
  for (const double range : {3.2, 100.0, 8192.0}) {
    EXPECT_LT(measure("sin", kSin, between(-range, range), s).absolute, 1.5e-7) << range;
    EXPECT_LT(measure("cos", kCos, between(-range, range, 2), c).absolute, 1.5e-7) << range;
  }
  // near multiples of pi the relative error stays small where it can: sin x = x
  EXPECT_LT(measure("sin, small", kSin, logBetween(1e-30, 0.7), s).relative, 2e-7);
  EXPECT_EQ(one(kSin, 0.f), 0.f);
  EXPECT_EQ(one(kCos, 0.f), 1.f);
  EXPECT_LT(measure("tan", kTan, between(-1.5, 1.5), [](long double x) { return std::tan(x); }).relative, 1e-6);
}

TEST(Elementary, Exponentials) {
  const auto e2 = [](long double x) { return std::exp2(x); };
  const auto e = [](long double x) { return std::exp(x); };
  EXPECT_LT(measure("exp2", kExp2, between(-125.9, 127.9), e2).relative, 2e-7);
  EXPECT_LT(measure("exp2, small", kExp2, logBetween(1e-12, 1), e2).relative, 2e-7);
  EXPECT_LT(measure("exp, |x| < 10", kExp, between(-10, 10), e).relative, 2e-7);
  EXPECT_LT(measure("exp", kExp, between(-87, 88.7), e).relative, 2e-7);
  EXPECT_EQ(one(kExp2, -127), 0.f);
  EXPECT_EQ(one(kExp2, 128), kInf);
  EXPECT_EQ(one(kExp2, 0), 1.f);
  EXPECT_EQ(one(kExp2, 5), 32.f);
  EXPECT_EQ(one(kExp, 0), 1.f);
  EXPECT_EQ(one(kExp, -100), 0.f);
  EXPECT_EQ(one(kExp, 89), kInf);
  EXPECT_EQ(one(kExp, -kInf), 0.f);
  EXPECT_EQ(one(kExp, kInf), kInf);
  EXPECT_TRUE(std::isnan(one(kExp, kNan)) && std::isnan(one(kExp2, kNan)));
}

TEST(Elementary, Logarithms) {
  const auto l = [](long double x) { return std::log(x); };
  EXPECT_LT(measure("log, below 1/2", kLog, logBetween(1.2e-38, 0.5), l).relative, 2e-7);
  EXPECT_LT(measure("log, above 2", kLog, logBetween(2, 3e38), l).relative, 2e-7);
  EXPECT_LT(measure("log, near 1", kLog, between(0.5, 2), l).absolute, 1e-7);
  EXPECT_LT(measure("log2, above 2", kLog2, logBetween(2, 3e38), [](long double x) { return std::log2(x); }).relative,
            4e-7);
  EXPECT_EQ(one(kLog, 1), 0.f);
  EXPECT_EQ(one(kLog, 0), -kInf);
  EXPECT_EQ(one(kLog, kInf), kInf);
  EXPECT_TRUE(std::isnan(one(kLog, -1)) && std::isnan(one(kLog, kNan)));
}

TEST(Elementary, Powers) {
  const std::vector<float> x = logBetween(1e-6, 1e6), y = between(-4, 4, 3);
  double worst = 0;
  const Errors e =
      measure("pow / (1 + |y ln x|)", kPow, x, y, [&](long double a, long double b) { return std::pow(a, b); });
  (void)e;
  const std::vector<float> got = call(kPow, x, y, &N_AVX2::run8);
  for (size_t i = 0; i < x.size(); ++i) {
    const double want = std::pow(double(x[i]), double(y[i])), scale = 1 + std::abs(y[i] * std::log(double(x[i])));
    worst = std::max(worst, std::abs(got[i] / want - 1) / scale);
  }
  std::printf("%-28s relative error / (1 + |y ln x|): %.3g\n", "pow", worst);
  EXPECT_LT(worst, 2e-7);
  EXPECT_EQ(one(kPow, 0, 2), 0.f);
  EXPECT_EQ(one(kPow, 0, 0), 1.f);
  EXPECT_EQ(one(kPow, 5, 0), 1.f);
  EXPECT_EQ(one(kPow, 1, 1e30f), 1.f);
  EXPECT_TRUE(std::isnan(one(kPow, -2, 2)));
}

TEST(Elementary, InverseFunctions) {
  const auto atanReference = [](long double x) { return std::atan(x); };
  EXPECT_LT(measure("atan, |x| < 4", kAtan, between(-4, 4), atanReference).absolute, 2e-7);
  EXPECT_LT(measure("atan, large", kAtan, logBetween(1, 1e30), atanReference).absolute, 2e-7);
  EXPECT_LT(measure("atan, small", kAtan, logBetween(1e-30, 0.4), atanReference).relative, 2e-7);
  EXPECT_LT(measure("atan2", kAtan2, between(-1, 1), between(-1, 1, 5),
                    [](long double y, long double x) { return std::atan2(y, x); })
                .absolute,
            4e-7);
  EXPECT_EQ(one(kAtan2, 0, 0), 0.f);
  EXPECT_NEAR(one(kAtan2, 0, -1), M_PI, 4e-7);
  EXPECT_NEAR(one(kAtan2, -1, 0), -M_PI / 2, 4e-7);
  EXPECT_LT(measure("asin", kAsin, between(-1, 1), [](long double x) { return std::asin(x); }).absolute, 2e-7);
  EXPECT_LT(measure("acos", kAcos, between(-1, 1), [](long double x) { return std::acos(x); }).absolute, 4e-7);
  EXPECT_LT(measure("acos, x > 0.5", kAcos, between(0.5, 1), [](long double x) { return std::acos(x); }).absolute,
            2e-7);
  // small angles keep relative accuracy
  std::vector<float> near = logBetween(1e-7, 0.5);
  for (float& x : near) x = 1 - x;
  EXPECT_LT(measure("acos, near 1", kAcos, near, [](long double x) { return std::acos(std::min(x, 1.0L)); }).relative,
            2e-7);
  EXPECT_EQ(one(kAcos, 2), 0.f);
  EXPECT_NEAR(one(kAcos, -2), M_PI, 3e-7);
  EXPECT_NEAR(one(kAsin, 2), M_PI / 2, 3e-7);
}

}  // namespace
}  // namespace kinora
#endif
