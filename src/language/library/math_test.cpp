// Proves fast_math.h and round_math.h: each approximation against long double mathematics with the error that the
// published polynomial is known for (bounded from both sides where the error shows in print: a better function would
// be the wrong one), the domain rules value by value, every derivative against central differences of the exact
// function, integer division against C's, and the same bits at all widths. Misses arguments between the sampled ones.
#define KINORA_KERNEL_FILE "language/library/math_test.cpp"
#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include "language/library/fast_math.h"
#include "language/library/round_math.h"

#ifndef LANGUAGE_MATH_TEST_ONCE
#define LANGUAGE_MATH_TEST_ONCE
// one, two and three arguments, each in a plain and a dual form
// clang-format off
#define UNARY(X) X(sin) X(cos) X(tan) X(asin) X(acos) X(atan) X(sinh) X(cosh) X(tanh) X(exp) X(exp2) X(expm1) X(log) \
  X(log2) X(log10) X(sqrt) X(inversesqrt) X(cbrt) X(erf) X(erfc) X(radians) X(degrees) X(abs)
// clang-format on
#define PLAIN_UNARY(X) X(logb) X(round) X(trunc) X(ceil) X(sign)
#define BINARY(X) X(pow) X(atan2) X(fmod) X(mod) X(divide) X(least) X(greatest) X(hypot)
#define TERNARY(X) X(clampTo) X(mix) X(smoothstep) X(linearstep)
#define QUATERNARY(X) X(smoothLinearstep) X(aastep)
namespace kinora::languageMathTest {
#define NAME(f) k_##f,
enum Function { UNARY(NAME) PLAIN_UNARY(NAME) BINARY(NAME) TERNARY(NAME) QUATERNARY(NAME) kFunctions };
#undef NAME
// Four arguments of three floats each (value, dx, dy), one result; n a multiple of 16.
using Kernel = void (*)(int f, bool dual, uint32_t n, const float* const* in, float* const* out);
enum Whole { kDivide, kRemainder, kMod, kWrap, kShl, kShr };
using KernelInt = void (*)(int f, uint32_t n, const int32_t* a, const int32_t* b, int32_t* r);
}  // namespace kinora::languageMathTest
#endif

KINORA_KERNELS_BEGIN
using namespace languageMathTest;

template <class F>
KN_INLINE F apply(int f, F a, F b, F c, F d) {
  switch (f) {
#define CASE1(name) \
  case k_##name:    \
    return lang::name(a);
#define CASE2(name) \
  case k_##name:    \
    return lang::name(a, b);
#define CASE3(name) \
  case k_##name:    \
    return lang::name(a, b, c);
#define CASE4(name) \
  case k_##name:    \
    return lang::name(a, b, c, d);
    UNARY(CASE1) BINARY(CASE2) TERNARY(CASE3) QUATERNARY(CASE4)
  }
  return a;
}
template <int W>
KN_INLINE Float<W> applyPlain(int f, Float<W> a) {
  switch (f) { PLAIN_UNARY(CASE1) }
  return a;
}
template <int W>
void run(int f, bool dual, uint32_t n, const float* const* in, float* const* out) {
  for (uint32_t i = 0; i < n; i += W) {
    lang::Dual<W> x[4];
    for (int k = 0; k < 4; ++k)
      x[k] = lang::Dual<W>(Float<W>::load(in[3 * k] + i), Float<W>::load(in[3 * k + 1] + i),
                           Float<W>::load(in[3 * k + 2] + i));
    // plain forms are compiled for two widths only: it is the same source, and this file is slow to compile
    const bool plain = f >= k_logb && f <= k_sign;
    if (plain) {
      applyPlain(f, x[0].v).store(out[0] + i);
    } else if (W == 4 || W == 16 || dual) {
      const lang::Dual<W> r = apply(f, x[0], x[1], x[2], x[3]);
      r.v.store(out[0] + i), r.dx.store(out[1] + i), r.dy.store(out[2] + i);
    } else if constexpr (W == 1 || W == 8) {
      apply(f, x[0].v, x[1].v, x[2].v, x[3].v).store(out[0] + i);
    }
  }
}
template <int W>
void runInt(int f, uint32_t n, const int32_t* a, const int32_t* b, int32_t* r) {
  for (uint32_t i = 0; i < n; i += W) {
    const Int<W> x = Int<W>::load(a + i), y = Int<W>::load(b + i);
    Int<W> z;
    switch (f) {
      case kDivide:
        z = lang::divide(x, y);
        break;
      case kRemainder:
        z = lang::remainder(x, y);
        break;
      case kMod:
        z = lang::mod(x, y);
        break;
      case kWrap:
        z = lang::wrap(x, y);
        break;
      case kShl:
        z = lang::shiftLeft(x, y);
        break;
      case kShr:
        z = lang::shiftRight(x, y);
        break;
    }
    z.store(r + i);
  }
}
KN_POINTERS(kRun, run)
#if HWY_TARGET == HWY_AVX2
constexpr KernelInt kRunInt1 = &runInt<1>, kRunInt8 = &runInt<8>;
#else
constexpr KernelInt kRunInt16 = &runInt<16>;
#endif
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
using namespace languageMathTest;
using D = long double;
constexpr float kInf = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();

struct Table {
  std::vector<float> in[12], out[3];
  explicit Table(size_t n) {
    n = (n + 15) / 16 * 16;
    for (auto& a : in) a.assign(n, 0.f);
    for (auto& a : out) a.assign(n, 0.f);
  }
  void run(Kernel how, int f, bool dual) {
    const float* i[12];
    float* o[3];
    for (int k = 0; k < 12; ++k) i[k] = in[k].data();
    for (int k = 0; k < 3; ++k) o[k] = out[k].data();
    how(f, dual, uint32_t(in[0].size()), i, o);
  }
};
float one(int f, float a, float b = 0, float c = 0, float d = 0) {
  Table t(1);
  t.in[0][0] = a, t.in[3][0] = b, t.in[6][0] = c, t.in[9][0] = d;
  t.run(N_AVX2::kRun8, f, false);
  return t.out[0][0];
}
struct Three {
  float v, dx, dy;
};
Three dual(int f, Three a, Three b = {}, Three c = {}, Three d = {}) {
  Table t(1);
  const Three x[4] = {a, b, c, d};
  for (int k = 0; k < 4; ++k) t.in[3 * k][0] = x[k].v, t.in[3 * k + 1][0] = x[k].dx, t.in[3 * k + 2][0] = x[k].dy;
  t.run(N_AVX2::kRun8, f, true);
  return {t.out[0][0], t.out[1][0], t.out[2][0]};
}
uint32_t scramble(uint32_t i) {
  i = (i ^ (i >> 16)) * 0x7feb352du;
  i = (i ^ (i >> 15)) * 0x846ca68bu;
  return i ^ (i >> 16);
}
float uniform(uint32_t i, float lo, float hi) { return lo + (hi - lo) * float(scramble(i) >> 8) * 0x1p-24f; }

D exactOf(int f, D x) {
  switch (f) {
    case k_sin:
      return sinl(x);
    case k_cos:
      return cosl(x);
    case k_tan:
      return tanl(x);
    case k_asin:
      return asinl(x);
    case k_acos:
      return acosl(x);
    case k_atan:
      return atanl(x);
    case k_sinh:
      return sinhl(x);
    case k_cosh:
      return coshl(x);
    case k_tanh:
      return tanhl(x);
    case k_exp:
      return expl(x);
    case k_exp2:
      return exp2l(x);
    case k_expm1:
      return expm1l(x);
    case k_log:
      return logl(x);
    case k_log2:
      return log2l(x);
    case k_log10:
      return log10l(x);
    case k_sqrt:
      return sqrtl(x);
    case k_inversesqrt:
      return 1 / sqrtl(x);
    case k_cbrt:
      return cbrtl(x);
    case k_erf:
      return erfl(x);
    case k_erfc:
      return erfcl(x);
    case k_radians:
      return x * 0.01745329251994329577L;
    case k_degrees:
      return x * 57.2957795130823208768L;
    default:
      return fabsl(x);
  }
}
// The largest error over a range, relative to max(1, |exact|) or plainly relative.
double worst(int f, float lo, float hi, bool relative) {
  Table t(200000);
  for (size_t i = 0; i < t.in[0].size(); ++i) t.in[0][i] = uniform(uint32_t(i), lo, hi);
  t.run(N_AVX2::kRun8, f, false);
  D most = 0;
  for (size_t i = 0; i < t.in[0].size(); ++i) {
    const D exact = exactOf(f, t.in[0][i]);
    most = std::max(most, fabsl(t.out[0][i] - exact) / (relative ? fabsl(exact) : std::max(D(1), fabsl(exact))));
  }
  return double(most);
}
}  // namespace

TEST(LanguageMath, ApproximationsHaveTheErrorOfTheReference) {
  struct Row {
    int f;
    float lo, hi;
    bool relative;
    double least, most;
  };
  // upper bounds near those published with the polynomials (sin 1.2e-7, cos 4.17e-7, acos 4.52e-5, atan 9.18e-6)
  for (const Row& r :
       {Row{k_sin, -6.3f, 6.3f, false, 3e-8, 1.4e-7}, Row{k_cos, -6.3f, 6.3f, false, 3e-7, 4.2e-7},
        Row{k_sin, 1e-12f, 1e-3f, true, 0, 2e-7},     Row{k_tan, 1e-12f, 1e-3f, true, 0, 2e-7},
        Row{k_sin, -5000, 5000, false, 3e-8, 2e-7},   Row{k_tan, -1.5f, 1.5f, true, 0, 1e-6},
        Row{k_tan, 0.1f, 1.5f, true, 0, 1e-6},        Row{k_acos, -1, 1, false, 4.3e-5, 4.6e-5},
        Row{k_asin, -1, 1, false, 4.3e-5, 4.6e-5},    Row{k_atan, -20, 20, false, 8e-6, 9.3e-6},
        Row{k_exp, -80, 80, true, 1e-6, 3e-5},        Row{k_exp2, -100, 100, true, 1e-7, 3e-5},
        Row{k_log2, 1e-3f, 1e3f, false, 1e-7, 1e-6},  Row{k_log, 1e-3f, 1e3f, false, 1e-7, 1e-6},
        Row{k_log10, 1e-3f, 1e3f, false, 1e-8, 1e-6}, Row{k_erf, -4, 4, false, 2e-7, 2e-6},
        Row{k_erfc, -4, 4, false, 2e-7, 2e-6},        Row{k_cosh, -20, 20, true, 1e-7, 1e-5},
        Row{k_sinh, 0.01f, 20, true, 1e-7, 1e-5},     Row{k_tanh, -8, 8, false, 1e-7, 4e-6},
        Row{k_cbrt, 1e-3f, 1e5f, true, 1e-6, 2e-5},   Row{k_expm1, -2, 4, false, 1e-8, 2e-5},
        Row{k_sqrt, 0, 1e6f, true, 1e-9, 6e-8},       Row{k_inversesqrt, 1e-3f, 1e6f, true, 1e-9, 1.2e-7}}) {
    const double e = worst(r.f, r.lo, r.hi, r.relative);
    EXPECT_LE(e, r.most) << "function " << r.f;
    EXPECT_GE(e, r.least) << "function " << r.f;
  }
}

TEST(LanguageMath, DomainRules) {
  EXPECT_EQ(one(k_log2, 0), -126.f);
  EXPECT_EQ(one(k_log2, -5), -126.f);
  EXPECT_NEAR(one(k_log, 0), -87.3365f, 1e-4f);
  EXPECT_EQ(one(k_logb, 0), -126.f);
  EXPECT_EQ(one(k_logb, -10), 3.f);
  EXPECT_EQ(one(k_sqrt, -1), 0.f);
  EXPECT_EQ(one(k_inversesqrt, 0), 0.f);
  EXPECT_EQ(one(k_inversesqrt, -4), 0.f);
  EXPECT_EQ(one(k_inversesqrt, 4), 0.5f);
  EXPECT_FLOAT_EQ(one(k_acos, 2), 0.f);
  EXPECT_FLOAT_EQ(one(k_acos, -2), 3.14159265f);
  EXPECT_FLOAT_EQ(one(k_asin, 7), 1.57079633f);
  EXPECT_EQ(one(k_cbrt, 0), 0.f);
  EXPECT_NEAR(one(k_cbrt, -27), -3.f, 1e-4f);
  EXPECT_EQ(one(k_exp, 1e9f), one(k_exp2, 126));  // clamped, not infinite
  EXPECT_EQ(one(k_pow, 0, 0), 1.f);
  EXPECT_EQ(one(k_pow, 0, -2), 0.f);
  EXPECT_EQ(one(k_pow, -2, 1), -2.f);
  EXPECT_NEAR(one(k_pow, -2, 3), -8.f, 2e-5f);
  EXPECT_NEAR(one(k_pow, -2, -4), 1 / 16.f, 1e-6f);
  EXPECT_EQ(one(k_pow, -2, 0.5f), 0.f);
  EXPECT_EQ(one(k_pow, 1e30f, 2), std::numeric_limits<float>::max());
  EXPECT_GT(one(k_pow, -1.0000001f, 16777218.f), 0.f);
  EXPECT_LT(one(k_pow, -1.f, 16777215.f), 0.f);
  EXPECT_EQ(one(k_atan2, 0, 0), 0.f);
  EXPECT_FLOAT_EQ(one(k_atan2, 0.f, -0.f), 3.14159265f);
  EXPECT_FLOAT_EQ(one(k_atan2, -1, 0), -1.57079633f);
  EXPECT_NEAR(one(k_atan2, kInf, -kInf), 2.35619449f, 1e-5f);
  EXPECT_EQ(one(k_divide, 1, 0), 0.f);
  EXPECT_EQ(one(k_divide, 0, 0), 0.f);
  EXPECT_EQ(one(k_divide, 1e30f, 1e-30f), 0.f);
  EXPECT_EQ(one(k_divide, 1, 4), 0.25f);
  EXPECT_EQ(one(k_fmod, 5, 0), 0.f);
  EXPECT_EQ(one(k_fmod, -5.5f, 2), -1.5f);
  EXPECT_EQ(one(k_mod, 5, 0), 5.f);
  EXPECT_EQ(one(k_mod, -16, 7), 5.f);
  EXPECT_EQ(one(k_round, 0.5f), 1.f);
  EXPECT_EQ(one(k_round, -2.5f), -3.f);
  EXPECT_EQ(one(k_round, 0.49999997f), 0.f);
  EXPECT_TRUE(std::signbit(one(k_round, -0.25f)));
  EXPECT_EQ(one(k_round, 8388609.f), 8388609.f);
  EXPECT_EQ(one(k_trunc, -1.75f), -1.f);
  EXPECT_EQ(one(k_ceil, -1.75f), -1.f);
  EXPECT_EQ(one(k_sign, -0.f), 0.f);
  EXPECT_EQ(one(k_sign, -3.f), -1.f);
  EXPECT_EQ(one(k_sign, 1e-30f), 1.f);
  EXPECT_EQ(one(k_clampTo, 5, 3, 1), 3.f);         // hi < lo gives lo
  EXPECT_TRUE(std::isnan(one(k_least, 1, kNan)));  // 1 <= NaN is false: the second
  EXPECT_EQ(one(k_least, kNan, 1), 1.f);
}

TEST(LanguageMath, ThresholdsAndBlends) {
  EXPECT_EQ(one(k_mix, 2, 4, 0.25f), 2.5f);
  EXPECT_EQ(one(k_smoothstep, 0, 2, 0.5f), 0.15625f);  // (3 - 2t) t^2 at 1/4
  EXPECT_EQ(one(k_smoothstep, 0, 2, -1), 0.f);
  EXPECT_EQ(one(k_smoothstep, 0, 2, 2), 1.f);
  EXPECT_EQ(one(k_smoothstep, 1, 1, 1), 1.f);
  EXPECT_EQ(one(k_smoothstep, 1, 1, 0.99f), 0.f);
  EXPECT_EQ(one(k_linearstep, 1, 3, 1.5f), 0.25f);
  EXPECT_EQ(one(k_linearstep, 1, 3, 9), 1.f);
  EXPECT_EQ(one(k_linearstep, 1, 1, 1), 1.f);
  EXPECT_EQ(one(k_linearstep, 1, 1, 0.5f), 0.f);
  // corners of half width 0.25 on [0, 1]: q^2 / (4 eps) with q = x + eps
  EXPECT_FLOAT_EQ(one(k_smoothLinearstep, 0, 1, 0, 0.25f), 0.0625f);
  EXPECT_FLOAT_EQ(one(k_smoothLinearstep, 0, 1, 1, 0.25f), 0.9375f);
  EXPECT_FLOAT_EQ(one(k_smoothLinearstep, 0, 1, 0.5f, 0.25f), 0.5f);
  EXPECT_EQ(one(k_smoothLinearstep, 0, 1, -0.25f, 0.25f), 0.f);
  EXPECT_EQ(one(k_smoothLinearstep, 0, 1, 1.25f, 0.25f), 1.f);
  EXPECT_EQ(one(k_smoothLinearstep, 2, 2, 3, 0.25f), 1.f);
  EXPECT_EQ(one(k_aastep, 1, 0.75f, 0.1f, -0.9f), 0.25f);  // width 1: from 0.5 to 1.5
  EXPECT_EQ(one(k_aastep, 1, 0.5f, 0, 1), 0.f);
  EXPECT_EQ(one(k_aastep, 1, 1.5f, 0, 1), 1.f);
  EXPECT_EQ(one(k_aastep, 1, 1, 0, 0), 0.f);
}

TEST(LanguageMath, DerivativesAgreeWithDifferences) {
  const int unary[] = {
#define NAME(f) k_##f,
      UNARY(NAME)};
  for (int f : unary)
    for (uint32_t i = 0; i < 200; ++i) {
      const bool positive = f == k_log || f == k_log2 || f == k_log10 || f == k_sqrt || f == k_inversesqrt;
      const float x = uniform(i, positive ? 0.05f : -0.95f, 0.95f), dx = uniform(i + 7777, -2, 2), dy = 0.5f;
      const D h = 1e-7L, slope = (exactOf(f, x + h) - exactOf(f, x - h)) / (2 * h);
      const Three r = dual(f, {x, dx, dy});
      const double tolerance = 1e-4 * (1 + fabs(double(slope)));
      ASSERT_NEAR(r.dx, double(slope * dx), 2 * tolerance) << "function " << f << " at " << x;
      ASSERT_NEAR(r.dy, double(slope * dy), tolerance) << "function " << f << " at " << x;
      ASSERT_EQ(r.v, one(f, x)) << f;
    }
  // Several arguments: along each one by one. atan2 has the reference's sign, opposite to calculus.
  struct Row {
    int f;
    std::function<D(D, D, D, D)> exact;
    float arguments[4];
    int sign = 1;
  };
  const Row rows[] = {
      {k_pow, [](D a, D b, D, D) { return powl(a, b); }, {1.7f, 2.3f}},
      {k_atan2, [](D a, D b, D, D) { return atan2l(a, b); }, {0.7f, -1.3f}, -1},
      {k_mod, [](D a, D b, D, D) { return a - b * floorl(a / b); }, {-7.3f, 2.2f}},
      {k_divide, [](D a, D b, D, D) { return a / b; }, {3.1f, -0.7f}},
      {k_least, [](D a, D b, D, D) { return std::min(a, b); }, {1, 2}},
      {k_greatest, [](D a, D b, D, D) { return std::max(a, b); }, {1, 2}},
      {k_hypot, [](D a, D b, D, D) { return hypotl(a, b); }, {1.5f, 2}},
      {k_clampTo, [](D a, D b, D c, D) { return std::max(std::min(a, c), b); }, {5, 1, 3}},
      {k_mix, [](D a, D b, D x, D) { return a * (1 - x) + b * x; }, {5, 1, 0.3f}},
      {k_smoothstep,
       [](D a, D b, D x, D) {
         const D t = (x - a) / (b - a);
         return (3 - 2 * t) * t * t;
       },
       {0.5f, 2, 1.1f}},
      {k_linearstep, [](D a, D b, D x, D) { return (x - a) / (b - a); }, {0.5f, 2, 1.1f}},
      {k_smoothLinearstep,
       [](D a, D b, D x, D e) {
         const D q = x - a + e;
         return q * q / (4 * e * (b - a));
       },
       {0.5f, 2, 0.55f, 0.125f}},
      {k_smoothLinearstep,
       [](D a, D b, D x, D e) {
         const D q = b - x + e;
         return 1 - q * q / (4 * e * (b - a));
       },
       {0.5f, 2, 1.95f, 0.125f}},
      {k_aastep, [](D e, D s, D a, D b) { return (s - e) / (fabsl(a) + fabsl(b)) + 0.5L; }, {1, 1.1f, -0.3f, 0.6f}},
  };
  for (const Row& r : rows) {
    Three x[4];
    for (int k = 0; k < 4; ++k) x[k] = {r.arguments[k], 0, 0};
    const D at[4] = {r.arguments[0], r.arguments[1], r.arguments[2], r.arguments[3]};
    for (int k = 0; k < 4; ++k) {
      const D h = 1e-6L;
      D up[4], down[4];
      for (int j = 0; j < 4; ++j) up[j] = at[j] + (j == k ? h : 0), down[j] = at[j] - (j == k ? h : 0);
      const D slope = (r.exact(up[0], up[1], up[2], up[3]) - r.exact(down[0], down[1], down[2], down[3])) / (2 * h);
      x[k].dx = 1, x[k].dy = -2;
      const Three y = dual(r.f, x[0], x[1], x[2], x[3]);
      EXPECT_NEAR(y.dx, r.sign * double(slope), 2e-4 * (1 + fabs(double(slope)))) << r.f << " argument " << k;
      EXPECT_NEAR(y.dy, -2 * r.sign * double(slope), 4e-4 * (1 + fabs(double(slope)))) << r.f << " argument " << k;
      x[k].dx = x[k].dy = 0;
    }
    EXPECT_NEAR(dual(r.f, x[0], x[1], x[2], x[3]).v, double(r.exact(at[0], at[1], at[2], at[3])), 1e-4) << r.f;
  }
  const Three f = dual(k_fmod, {7.3f, 1, 2}, {2, 5, 5});  // the second operand's derivative is dropped
  EXPECT_EQ(f.dx, 1.f);
  EXPECT_EQ(f.dy, 2.f);
}

TEST(LanguageMath, DerivativesWhereTheFunctionHasNone) {
  for (int f : {k_sqrt, k_inversesqrt, k_log, k_log2, k_log10, k_cbrt}) EXPECT_EQ(dual(f, {0, 1, 1}).dx, 0.f) << f;
  for (int f : {k_asin, k_acos}) EXPECT_EQ(dual(f, {1, 1, 1}).dx, 0.f) << f;
  EXPECT_EQ(dual(k_abs, {0, 3, 1}).dx, 3.f);
  EXPECT_EQ(dual(k_atan2, {0, 1, 1}, {0, 1, 1}).dx, 0.f);
  EXPECT_EQ(dual(k_least, {1, 3, 0}, {1, 5, 0}).dx, 3.f);     // a tie picks the first
  EXPECT_EQ(dual(k_greatest, {1, 3, 0}, {1, 5, 0}).dx, 5.f);  // and here the second
  const Three p = dual(k_pow, {0, 1, 1}, {0, 1, 1});
  EXPECT_EQ(p.v, 0.f);  // the reference's dual form
  EXPECT_EQ(p.dx, 0.f);
  EXPECT_EQ(dual(k_divide, {1, 2, 3}, {0, 1, 1}).dx, 0.f);
}

TEST(LanguageMath, IntegersAsInC) {
  std::vector<int32_t> a(1 << 16), b(a.size()), r(a.size());
  const int32_t lowest = std::numeric_limits<int32_t>::min(), highest = std::numeric_limits<int32_t>::max();
  const int32_t special[] = {0, 1, -1, 2, -2, 7, -7, lowest, highest, lowest + 1, highest - 1, 65536, -65536, 3};
  const size_t count = std::size(special);
  for (uint32_t i = 0; i < a.size(); ++i) {
    const bool edge = i < count * count;
    a[i] = edge ? special[i / count] : int32_t(scramble(i)) >> (scramble(i + 5) & 31);
    b[i] = edge ? special[i % count] : int32_t(scramble(~i)) >> (scramble(i + 9) & 31);
  }
  using Exact = std::function<int32_t(int64_t, int64_t)>;
  const Exact exact[] = {[](int64_t x, int64_t y) { return y ? int32_t(x / y) : 0; },
                         [](int64_t x, int64_t y) { return y ? int32_t(x % y) : 0; },
                         [](int64_t x, int64_t y) { return y ? int32_t(x % y) : int32_t(x); },
                         [](int64_t x, int64_t y) { return int32_t((x % y + y) % y); },
                         [](int64_t x, int64_t y) { return y >= 0 && y < 32 ? int32_t(uint32_t(x) << y) : 0; },
                         [](int64_t x, int64_t y) { return int32_t(x >> (y >= 0 && y < 32 ? y : 31)); }};
  for (int f = kDivide; f <= kShr; ++f)
    for (bool narrow : {false, true}) {
      (narrow ? N_AVX2::kRunInt1 : N_AVX2::kRunInt8)(f, uint32_t(a.size()), a.data(), b.data(), r.data());
      for (size_t i = 0; i < a.size(); ++i)
        if (f != kWrap || b[i] > 0) {
          ASSERT_EQ(r[i], exact[f](a[i], b[i])) << f << ": " << a[i] << ", " << b[i];
        }
    }
}

TEST(LanguageMath, SameBitsAtAllWidths) {
  std::vector<Kernel> others{N_AVX2::kRun1, N_AVX2::kRun4};
  if (cpuHasAvx512()) others.push_back(N_AVX3::kRun16);
  Table t(2048);
  for (int k = 0; k < 12; ++k)
    for (uint32_t i = 0; i < t.in[k].size(); ++i) t.in[k][i] = uniform(i * 12 + uint32_t(k), -4, 4);
  for (int i = 0; i < 8; ++i)
    t.in[0][size_t(i)] = float(i & 1 ? -1 : 1) * (i < 2 ? 0.f : i < 4 ? kInf : i < 6 ? 1e30f : kNan);
  for (int f = 0; f < kFunctions; ++f)
    for (bool derivatives : {false, true})
      for (Kernel how : others) {
        const bool plain = f >= k_logb && f <= k_sign;
        if (plain ? derivatives : !derivatives && how != N_AVX2::kRun1) continue;
        t.run(N_AVX2::kRun8, f, derivatives);
        const std::vector<float> first[3] = {t.out[0], t.out[1], t.out[2]};
        t.run(how, f, derivatives);
        for (int k = 0; k < (derivatives ? 3 : 1); ++k)
          ASSERT_EQ(std::memcmp(first[k].data(), t.out[k].data(), first[k].size() * sizeof(float)), 0) << f;
      }
}
}  // namespace kinora
#endif
