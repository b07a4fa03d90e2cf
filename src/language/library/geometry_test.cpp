// Proves vector.h, matrix.h, spline.h and color.h: values against closed forms and against plain scalar readings in
// doubles, every derivative against central differences of the plain form, singular and undefined cases, published
// colour figures, and the same bits at all widths. Misses what both readings would have wrong.
#define KINORA_KERNEL_FILE "language/library/geometry_test.cpp"
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <vector>
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include "language/library/color.h"
#include "language/library/matrix.h"
#include "language/library/spline.h"

#ifndef LANGUAGE_GEOMETRY_TEST_ONCE
#define LANGUAGE_GEOMETRY_TEST_ONCE
namespace kinora::languageGeometryTest {
enum Op {
  kNormalize,
  kLength,
  kSegment,
  kFaceforward,
  kReflect,
  kRefract,
  kFresnel,
  kRotate,
  kCross,
  kPoint,
  kVector,
  kNormal,
  kColor,
  kSpline,
  kSplineTriple,
  kSplineInverse,
  kOps
};
constexpr int kIn = 20, kOut = 8, kPoints = 32;
// kIn inputs and kOut results, each value, dx and dy, of kPoints points.
struct Table {
  int op = 0, mode = 0, count = 0;
  float in[kIn][3][kPoints] = {};
  float out[kOut][3][kPoints] = {};
};
using Kernel = void (*)(Table&, bool derivatives);
// Results without derivatives: matrices (inverse in out..., determinant), colours of wavelengths and temperatures.
struct Plain {
  float m[16][kPoints], inverse[16][kPoints], determinant[kPoints], x[kPoints], wave[3][kPoints], body[3][kPoints];
};
using PlainKernel = void (*)(Plain&);
}  // namespace kinora::languageGeometryTest
#endif

KINORA_KERNELS_BEGIN
using namespace languageGeometryTest;

template <class V, class F>
KN_INLINE void put(V v, F* r) {
  r[0] = v.x, r[1] = v.y, r[2] = v.z;
}
template <class F>
KN_INLINE void apply(const Table& t, int at, const F* a, F* r) {
  constexpr int W = lang::kWidthOf<F>;
  using V = lang::Triple<F>;
  constexpr bool kDual = sizeof(F) != sizeof(Float<W>);
  const V p(a[0], a[1], a[2]), q(a[3], a[4], a[5]), s(a[6], a[7], a[8]);
  lang::Matrix<W> m;
  for (int i = 0; i < 16; ++i) m.m[i] = lang::valueOf(a[3 + i]);
  // knots from input 1 on: varying ones in the table's own layout
  const int element = 3 * kPoints;
  const auto knots = [&](int d) HWY_ATTR { return lang::VaryingKnots{t.in[1][d] + at, element, element}; };
  const auto triples = [&](int d) HWY_ATTR { return lang::VaryingKnots{t.in[1][d] + at, 3 * element, element}; };
  const auto basis = language::SplineBasis(t.mode & 7);
  switch (t.op) {
    case kNormalize:
      return put(lang::normalize(p), r);
    case kLength:
      r[0] = lang::length(p), r[1] = lang::distance(p, q);
      return;
    case kSegment:
      r[0] = lang::distance(p, q, s);
      return;
    case kFaceforward:
      return put(lang::faceforward(p, q, s), r);
    case kReflect:
      return put(lang::reflect(p, q), r);
    case kRefract:
      return put(lang::refract(p, q, a[6]), r);
    case kFresnel: {
      V reflected, through;
      lang::fresnel(p, q, a[6], r[0], r[1], reflected, through);
      put(reflected, r + 2);
      put(through, r + 5);
      return;
    }
    case kRotate:
      return put(lang::rotate(p, a[9], q, s), r);
    case kCross:
      r[3] = lang::dot(p, q);
      return put(lang::cross(p, q), r);
    case kPoint:
      return put(lang::transformPoint(m, p), r);
    case kVector:
      return put(lang::transformVector(m, p), r);
    case kNormal:
      return put(lang::transformNormal(m, p), r);
    case kColor:
      r[3] = lang::luminance(language::defaultColorSystem(), p);
      return put(lang::transformc(language::defaultColorSystem(), language::ColorSpace(t.mode / 8),
                                  language::ColorSpace(t.mode % 8), p),
                 r);
    case kSpline:
      if constexpr (kDual) {
        const lang::DualKnots<lang::VaryingKnots> dual{knots(0), knots(1), knots(2)};
        lang::spline<1>(basis, a[0], t.count, dual, r);
        lang::spline<1>(basis, a[0], t.count, knots(0), r + 1);  // plain knots
        lang::spline<1>(basis, a[0].v, t.count, dual, r + 2);    // plain x
      } else {
        lang::spline<1>(basis, a[0], t.count, knots(0), r);
        r[1] = r[2] = r[0];
      }
      return;
    case kSplineTriple:
      if constexpr (kDual) {
        const lang::DualKnots<lang::VaryingKnots> dual{triples(0), triples(1), triples(2)};
        lang::spline<3>(basis, a[0], t.count, dual, r);
      } else {
        lang::spline<3>(basis, a[0], t.count, triples(0), r);
        // the same from a uniform array: that of point 0
        float uniform[kIn];
        for (int i = 0; i + 1 < kIn; ++i) uniform[i] = t.in[1 + i][0][0];
        lang::spline<3>(basis, a[0], t.count, lang::UniformKnots{uniform, 3}, r + 3);
      }
      return;
    default:
      r[0] = lang::splineinverse(basis, a[0], t.count, knots(0));
      return;
  }
}
template <int W>
void run(Table& t, bool derivatives) {
  for (int at = 0; at < kPoints; at += W) {
    using D = lang::Dual<W>;
    D a[kIn], r[kOut];
    for (int i = 0; i < kIn; ++i)
      a[i] = D(Float<W>::load(t.in[i][0] + at), Float<W>::load(t.in[i][1] + at), Float<W>::load(t.in[i][2] + at));
    if (derivatives) {
      apply(t, at, a, r);
    } else if constexpr (W == 8) {  // the plain forms of the same source: one width saves compile time
      Float<W> v[kIn], o[kOut];
      for (int i = 0; i < kIn; ++i) v[i] = a[i].v;
      apply(t, at, v, o);
      for (int i = 0; i < kOut; ++i) r[i] = D(o[i]);
    }
    for (int i = 0; i < kOut; ++i)
      r[i].v.store(t.out[i][0] + at), r[i].dx.store(t.out[i][1] + at), r[i].dy.store(t.out[i][2] + at);
  }
}
template <int W>
void runPlain(Plain& p) {
  for (int at = 0; at < kPoints; at += W) {
    const auto m = lang::Matrix<W>::load(p.m[0] + at, kPoints);
    lang::inverse(m).store(p.inverse[0] + at, kPoints);
    lang::determinant(m).store(p.determinant + at);
    const Float<W> x = Float<W>::load(p.x + at);
    const Vec3<W> w = lang::wavelengthColor(language::defaultColorSystem(), x);
    const Vec3<W> b = lang::blackbody(language::defaultColorSystem(), x);
    w.x.store(p.wave[0] + at), w.y.store(p.wave[1] + at), w.z.store(p.wave[2] + at);
    b.x.store(p.body[0] + at), b.y.store(p.body[1] + at), b.z.store(p.body[2] + at);
  }
}
KN_POINTERS(kRun, run)
#if HWY_TARGET == HWY_AVX2
constexpr PlainKernel kPlain1 = &runPlain<1>, kPlain8 = &runPlain<8>;
#endif
KINORA_KERNELS_END

#if HWY_ONCE
#include "simd/dispatch.h"

namespace kinora {
namespace {
using namespace languageGeometryTest;
using language::ColorSpace;
using language::SplineBasis;
using Numbers = std::vector<double>;

float random(uint32_t i) {
  i = (i ^ (i >> 16)) * 0x7feb352du;
  i = (i ^ (i >> 15)) * 0x846ca68bu;
  return float((i ^ (i >> 16)) >> 8) * 0x1p-24f;
}
// Inputs in [lo, hi], derivatives in [-1, 1].
Table fill(int op, int mode, int count, float lo, float hi, uint32_t seed = 1) {
  Table t;
  t.op = op, t.mode = mode, t.count = count;
  for (int i = 0; i < kIn; ++i)
    for (int k = 0; k < kPoints; ++k) {
      const uint32_t n = seed * 7919u + uint32_t(i * kPoints + k) * 3;
      t.in[i][0][k] = lo + (hi - lo) * random(n);
      for (int d = 1; d < 3; ++d) t.in[i][d][k] = 2 * random(n + uint32_t(d)) - 1;
    }
  return t;
}
// Derivatives of `results` outputs against differences of the plain form along the inputs' own derivatives, of the
// first `moving` inputs; the others' derivatives are cleared.
void expectDerivatives(Table t, int moving, int results, double tolerance, const char* what, int from = 0) {
  for (int i = 0; i < kIn; ++i)
    for (int k = 0; k < kPoints; ++k)
      for (int d = 1; d < 3; ++d)
        if (i < from || i >= moving) t.in[i][d][k] = 0;
  Table dual = t;
  N_AVX2::kRun8(dual, true);
  Table plain = t;
  N_AVX2::kRun8(plain, false);
  for (int d = 1; d < 3; ++d) {
    const float h = 1.f / 256;
    Table up = t, down = t;
    for (int i = 0; i < kIn; ++i)
      for (int k = 0; k < kPoints; ++k) {
        up.in[i][0][k] += h * t.in[i][d][k];
        down.in[i][0][k] -= h * t.in[i][d][k];
      }
    N_AVX2::kRun8(up, false);
    N_AVX2::kRun8(down, false);
    for (int r = 0; r < results; ++r)
      for (int k = 0; k < kPoints; ++k) {
        const double slope = (double(up.out[r][0][k]) - double(down.out[r][0][k])) / (2 * double(h));
        ASSERT_NEAR(dual.out[r][d][k], slope, tolerance * (1 + std::fabs(slope)))
            << what << ", result " << r << ", point " << k << ", direction " << d;
        ASSERT_EQ(dual.out[r][0][k], plain.out[r][0][k]) << what;
      }
  }
}
Numbers at(const Table& t, int k) {
  Numbers a;
  for (int i = 0; i < kIn; ++i) a.push_back(double(t.in[i][0][k]));
  return a;
}
using Formula = std::function<Numbers(const Numbers&)>;
void expectValues(Table t, const Formula& exact, double tolerance, const char* what) {
  N_AVX2::kRun8(t, false);
  for (int k = 0; k < kPoints; ++k) {
    const Numbers e = exact(at(t, k));
    for (size_t r = 0; r < e.size(); ++r)
      ASSERT_NEAR(t.out[r][0][k], e[r], tolerance * (1 + std::fabs(e[r])))
          << what << ", result " << r << ", point " << k;
  }
}
double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
}  // namespace

TEST(LanguageGeometry, ValuesOfVectorFunctions) {
  const auto sized = [](Numbers v, double s) { return Numbers{v[0] * s, v[1] * s, v[2] * s}; };
  expectValues(
      fill(kNormalize, 0, 0, -2, 2), [&](const Numbers& a) { return sized(a, 1 / std::sqrt(dot(&a[0], &a[0]))); },
      1e-6, "normalize");
  expectValues(
      fill(kLength, 0, 0, -2, 2),
      [&](const Numbers& a) {
        return Numbers{std::hypot(a[0], a[1], a[2]), std::hypot(a[0] - a[3], a[1] - a[4], a[2] - a[5])};
      },
      1e-6, "length");
  // the distance to a segment as the least one to ten thousand of its points
  expectValues(
      fill(kSegment, 0, 0, -2, 2),
      [&](const Numbers& a) {
        double least = 1e9;
        for (int i = 0; i <= 10000; ++i) {
          const double t = i * 1e-4;
          least = std::min(least, std::hypot(a[0] + t * (a[3] - a[0]) - a[6], a[1] + t * (a[4] - a[1]) - a[7],
                                             a[2] + t * (a[5] - a[2]) - a[8]));
        }
        return Numbers{least};
      },
      1e-5, "segment");
  expectValues(
      fill(kFaceforward, 0, 0, -2, 2), [&](const Numbers& a) { return sized(a, dot(&a[3], &a[6]) > 0 ? -1 : 1); }, 0,
      "faceforward");
  expectValues(
      fill(kCross, 0, 0, -2, 2),
      [&](const Numbers& a) {
        return Numbers{a[1] * a[5] - a[2] * a[4], a[2] * a[3] - a[0] * a[5], a[0] * a[4] - a[1] * a[3],
                       dot(&a[0], &a[3])};
      },
      1e-6, "cross");
  // Snell's and Fresnel's laws: rays at an angle x to the normal (0, 0, 1), eta from 0.4 to 2.2
  Table t = fill(kFresnel, 0, 0, 0, 1);
  for (int k = 0; k < kPoints; ++k) {
    const float angle = 0.05f + 1.4f * float(k) / kPoints;
    const float v[7] = {std::sin(angle), 0, -std::cos(angle), 0, 0, 1, 0.4f + 1.8f * random(uint32_t(k))};
    for (int i = 0; i < 7; ++i) t.in[i][0][k] = v[i];
  }
  expectValues(
      t,
      [&](const Numbers& a) {
        const double sine = a[0] * a[6], c = -a[2];
        if (sine > 1) return Numbers{1, 0, a[0], 0, c, 0, 0, 0};
        const double ct = std::sqrt(1 - sine * sine), eta = a[6];
        const double rs = (eta * c - ct) / (eta * c + ct), rp = (c - eta * ct) / (c + eta * ct);
        const double kr = 0.5 * (rs * rs + rp * rp);
        return Numbers{kr, (1 - kr) * eta * eta, a[0], 0, c, sine, 0, -ct};
      },
      3e-5, "fresnel");
  Table refraction = t;
  refraction.op = kRefract;
  expectValues(
      refraction,
      [&](const Numbers& a) {
        const double sine = a[0] * a[6];
        return sine > 1 ? Numbers{0, 0, 0} : Numbers{sine, 0, -std::sqrt(1 - sine * sine)};
      },
      1e-5, "refract");
  // a turn about an axis through a by Rodrigues' formula
  expectValues(
      fill(kRotate, 0, 0, -2, 2),
      [&](const Numbers& a) {
        double k[3], d[3], x[3];
        for (int i = 0; i < 3; ++i)
          k[i] = a[6 + size_t(i)] - a[3 + size_t(i)], d[i] = a[size_t(i)] - a[3 + size_t(i)];
        const double size = std::sqrt(dot(k, k));
        for (double& v : k) v /= size;
        for (int i = 0; i < 3; ++i) x[i] = k[(i + 1) % 3] * d[(i + 2) % 3] - k[(i + 2) % 3] * d[(i + 1) % 3];
        Numbers r;
        for (size_t i = 0; i < 3; ++i)
          r.push_back(a[3 + i] + d[i] * std::cos(a[9]) + x[i] * std::sin(a[9]) +
                      k[i] * dot(k, d) * (1 - std::cos(a[9])));
        return r;
      },
      1e-5, "rotate");
}

TEST(LanguageGeometry, DerivativesOfVectorFunctions) {
  expectDerivatives(fill(kNormalize, 0, 0, 0.5f, 2), 3, 3, 1e-3, "normalize");
  expectDerivatives(fill(kLength, 0, 0, -2, 2), 6, 2, 1e-3, "length");
  expectDerivatives(fill(kFaceforward, 0, 0, 0.5f, 2), 9, 3, 1e-3, "faceforward");
  expectDerivatives(fill(kReflect, 0, 0, -1, 1), 6, 3, 1e-3, "reflect");
  expectDerivatives(fill(kCross, 0, 0, -1, 1), 6, 4, 1e-3, "cross");
  expectDerivatives(fill(kRotate, 0, 0, 0.5f, 2), 4, 3, 2e-3, "rotate the point");
  Table r = fill(kRotate, 0, 0, 0.5f, 2);
  for (int i = 6; i < 9; ++i)
    for (float& v : r.in[i][0]) v += 2;  // an axis that is not short
  expectDerivatives(r, 10, 3, 2e-3, "rotate about anything");
  expectDerivatives(fill(kRefract, 0, 0, 0.3f, 0.6f), 7, 3, 2e-3, "refract");
  Table s = fill(kSegment, 0, 0, 0, 1);
  for (int k = 0; k < kPoints; ++k)
    for (int i = 0; i < 3; ++i) s.in[3 + i][0][k] += 2, s.in[6 + i][0][k] += i == 0 ? 1.f : 0.3f;
  expectDerivatives(s, 9, 1, 2e-3, "segment");
  Table f = fill(kFresnel, 0, 0, 0.4f, 0.6f);
  for (float& v : f.in[6][0]) v += 0.4f;
  expectDerivatives(f, 7, 8, 5e-3, "fresnel");
  // undefined: zero, with zero derivatives
  Table z = fill(kNormalize, 0, 0, 0, 0);
  N_AVX2::kRun8(z, true);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(z.out[0][d][0], 0.f);
  z.op = kLength;
  N_AVX2::kRun8(z, true);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(z.out[0][d][0], 0.f);
}

TEST(LanguageGeometry, Matrices) {
  Plain p = {};
  for (int i = 0; i < 16; ++i)
    for (int k = 0; k < kPoints; ++k) {
      p.m[i][k] = 4 * random(uint32_t(i * kPoints + k)) - 2;
      if (k % 2 && i % 4 == 3) p.m[i][k] = i == 15;         // every second one affine
      if (k == 2) p.m[i][k] = float(i);                     // singular
      if (k == 3) p.m[i][k] = i % 5 == 0 && i ? 1.f : 0.f;  // affine and singular
      if (k == 4) p.m[i][k] = i % 5 == 3 ? 2.f : i == 0 ? 0.f : 0.f;
    }
  // a permutation with scale: no pivot on the diagonal
  for (int i = 0; i < 16; ++i) p.m[i][4] = i == 1 ? 2.f : i == 6 ? 4.f : i == 11 ? 8.f : i == 12 ? 16.f : 0.f;
  N_AVX2::kPlain8(p);
  for (int k = 0; k < kPoints; ++k) {
    if (k == 2 || k == 3) {
      for (int i = 0; i < 16; ++i) EXPECT_EQ(p.inverse[i][k], i % 5 == 0 ? 1.f : 0.f) << k;
      EXPECT_NEAR(p.determinant[k], 0, 1e-3);
      continue;
    }
    double worst = 0, size = 1;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        double sum = 0;
        for (int q = 0; q < 4; ++q) sum += double(p.m[4 * i + q][k]) * double(p.inverse[4 * q + j][k]);
        worst = std::max(worst, std::fabs(sum - (i == j)));
        size = std::max(size, std::fabs(double(p.inverse[4 * i + j][k])));
      }
    EXPECT_LT(worst, 2e-6 * size) << k;
    // elimination in doubles
    double a[16], det = 1;
    for (int i = 0; i < 16; ++i) a[i] = double(p.m[i][k]);
    for (int i = 0; i < 4; ++i) {
      int best = i;
      for (int j = i; j < 4; ++j)
        if (std::fabs(a[4 * j + i]) > std::fabs(a[4 * best + i])) best = j;
      if (best != i) det = -det;
      for (int q = 0; q < 4; ++q) std::swap(a[4 * i + q], a[4 * best + q]);
      det *= a[4 * i + i];
      for (int j = i + 1; j < 4; ++j) {
        const double f = a[4 * j + i] / a[4 * i + i];
        for (int q = i; q < 4; ++q) a[4 * j + q] -= f * a[4 * i + q];
      }
    }
    EXPECT_NEAR(p.determinant[k], det, 1e-5 * (1 + std::fabs(det))) << k;
  }
  EXPECT_EQ(p.inverse[3][4], 1 / 16.f);
  EXPECT_EQ(p.inverse[4][4], 0.5f);
  for (int op : {kPoint, kVector})
    expectValues(
        fill(op, 0, 0, 0.5f, 2),
        [&](const Numbers& a) {
          Numbers r;
          const bool point = op == kPoint;
          for (size_t j = 0; j < 4; ++j)
            r.push_back(a[0] * a[3 + j] + a[1] * a[7 + j] + a[2] * a[11 + j] + (point ? a[15 + j] : 0));
          for (size_t j = 0; j < 3; ++j) r[j] /= point ? r[3] : 1;
          r.pop_back();
          return r;
        },
        2e-6, "transform");
  for (int op : {kPoint, kVector, kNormal}) {
    Table t = fill(op, 0, 0, 0.5f, 2);
    for (int i = 3; i < 19; ++i)
      for (float& v : t.in[i][0]) v += (i - 3) % 5 == 0 ? 3.f : 0.f;
    expectDerivatives(t, 3, 3, 2e-3, "transform");
  }
  // a transformed normal stays perpendicular to transformed vectors
  Table n = fill(kNormal, 0, 0, 0.5f, 2), v = n;
  for (int i = 3; i < 19; ++i)
    for (int k = 0; k < kPoints; ++k) {
      v.in[i][0][k] += (i - 3) % 5 == 0 ? 3.f : 0.f;
      if (i % 4 == 2) v.in[i][0][k] = i == 18;  // affine
      n.in[i][0][k] = v.in[i][0][k];
    }
  for (int k = 0; k < kPoints; ++k)
    v.in[2][0][k] = -(v.in[0][0][k] * n.in[0][0][k] + v.in[1][0][k] * n.in[1][0][k]) / n.in[2][0][k];
  v.op = kVector;
  N_AVX2::kRun8(n, false);
  N_AVX2::kRun8(v, false);
  for (int k = 0; k < kPoints; ++k) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += double(n.out[i][0][k]) * double(v.out[i][0][k]);
    EXPECT_NEAR(sum, 0, 1e-5);
  }
  Table flat = fill(kPoint, 0, 0, 0, 0);  // w = 0
  N_AVX2::kRun8(flat, true);
  for (int d = 0; d < 3; ++d) EXPECT_EQ(flat.out[1][d][0], 0.f);
}

namespace {
// de Boor's, de Casteljau's and Lagrange's ways instead of matrices.
double splineByHand(SplineBasis b, double x, const double* p, int n) {
  const int step = b == SplineBasis::Bezier ? 3 : b == SplineBasis::Hermite ? 2 : 1, N = (n - 4) / step + 1;
  x = std::min(1.0, std::max(0.0, x)) * N;
  const int s = std::min(N - 1, int(x));
  const double t = x - s, *k = p + s * step;
  const auto mix = [](double a, double c, double w) { return a + (c - a) * w; };
  switch (b) {
    case SplineBasis::Bezier: {
      const double q[3] = {mix(k[0], k[1], t), mix(k[1], k[2], t), mix(k[2], k[3], t)};
      return mix(mix(q[0], q[1], t), mix(q[1], q[2], t), t);
    }
    case SplineBasis::CatmullRom: {  // Barry and Goldman's pyramid
      const double a0 = mix(k[0], k[1], t + 1), a1 = mix(k[1], k[2], t), a2 = mix(k[2], k[3], t - 1);
      return mix(mix(a0, a1, (t + 1) / 2), mix(a1, a2, t / 2), t);
    }
    case SplineBasis::BSpline: {  // de Boor with knots -2 -1 0 1 2 3
      const double a0 = mix(k[0], k[1], (t + 2) / 3), a1 = mix(k[1], k[2], (t + 1) / 3), a2 = mix(k[2], k[3], t / 3);
      return mix(mix(a0, a1, (t + 1) / 2), mix(a1, a2, t / 2), t);
    }
    case SplineBasis::Hermite: {  // as the Bezier curve of the same ends and slopes
      const double c[4] = {k[0], k[0] + k[1] / 3, k[2] - k[3] / 3, k[2]};
      return splineByHand(SplineBasis::Bezier, t, c, 4);
    }
    case SplineBasis::Linear:
      return mix(k[1], k[2], t);
    default:
      return k[1];
  }
}
}  // namespace

TEST(LanguageGeometry, Splines) {
  for (int basis = 0; basis < 6; ++basis)
    for (int count : {4, 7, 10}) {
      const auto b = SplineBasis(basis);
      Table t = fill(kSpline, basis, count, -1, 2);
      expectValues(
          t, [&](const Numbers& a) { return Numbers{splineByHand(b, a[0], &a[1], count)}; }, 3e-6, "spline");
      Table triple = fill(kSplineTriple, basis, count > 6 ? 6 : 4, -1, 2);
      N_AVX2::kRun8(triple, false);
      for (int k = 0; k < kPoints; ++k)
        for (int c = 0; c < 3; ++c) {
          double mine[6], first[6];
          for (int i = 0; i < triple.count; ++i)
            mine[i] = double(triple.in[1 + 3 * i + c][0][k]), first[i] = double(triple.in[1 + 3 * i + c][0][0]);
          const double x = double(triple.in[0][0][k]);
          ASSERT_NEAR(triple.out[c][0][k], splineByHand(b, x, mine, triple.count), 1e-5) << basis;
          ASSERT_NEAR(triple.out[3 + c][0][k], splineByHand(b, x, first, triple.count), 1e-5) << basis;
        }
      // derivatives inside segments, where differences see one polynomial
      const int segments = language::splineSegments(b, count);
      Table d = fill(kSpline, basis, count, -1, 2);
      for (int k = 0; k < kPoints; ++k)
        d.in[0][0][k] = (float(k % segments) + 0.1f + 0.8f * float(k) / kPoints) / float(segments);
      if (basis != int(SplineBasis::Constant)) {
        expectDerivatives(d, 1 + count, 1, 2e-2, "spline");
        Table onlyX = d;
        for (int i = 1; i < kIn; ++i)
          for (int k = 0; k < kPoints; ++k) onlyX.in[i][1][k] = onlyX.in[i][2][k] = 0;
        N_AVX2::kRun8(onlyX, true);
        N_AVX2::kRun8(d, true);
        for (int k = 0; k < kPoints; ++k) {
          ASSERT_NEAR(d.out[1][1][k], onlyX.out[0][1][k], 1e-5) << "plain knots";
          ASSERT_NEAR(d.out[2][1][k], d.out[0][1][k] - onlyX.out[0][1][k], 1e-4) << "plain x";
        }
      }
      Table outside = fill(kSpline, basis, count, 1.5f, 2);
      N_AVX2::kRun8(outside, true);
      EXPECT_EQ(outside.out[1][1][0], 0.f);
    }
  EXPECT_EQ(language::splineBasis("bezier"), SplineBasis::Bezier);
  EXPECT_EQ(language::splineBasis("nonsense"), SplineBasis::Linear);
}

TEST(LanguageGeometry, InverseSplines) {
  for (int basis : {0, 1, 2, 4})
    for (bool falls : {false, true}) {
      const int count = 7;
      Table t = fill(kSplineInverse, basis, count, 0, 1);
      Table forward = fill(kSpline, basis, count, 0, 1);
      for (int k = 0; k < kPoints; ++k) {
        for (int i = 0; i < count; ++i) {
          const float knot = float(i) + 0.3f * random(uint32_t(77 * k + i));
          t.in[1 + i][0][k] = forward.in[1 + i][0][k] = falls ? -knot : knot;
        }
        forward.in[0][0][k] = 0.05f + 0.9f * float(k) / (kPoints - 1);  // never an end of a segment
      }
      N_AVX2::kRun8(forward, false);
      for (int k = 0; k < kPoints; ++k) t.in[0][0][k] = forward.out[0][0][k];
      Table dual = t;
      N_AVX2::kRun8(t, false);
      for (int k = 0; k < kPoints; ++k) ASSERT_NEAR(t.out[0][0][k], forward.in[0][0][k], 2e-6) << basis << " " << k;
      N_AVX2::kRun8(dual, true);
      for (int i = 1; i < kIn; ++i)
        for (int k = 0; k < kPoints; ++k) forward.in[i][1][k] = forward.in[i][2][k] = 0;
      for (int k = 0; k < kPoints; ++k) forward.in[0][1][k] = 1;
      N_AVX2::kRun8(forward, true);
      for (int k = 0; k < kPoints; ++k) {
        ASSERT_EQ(dual.out[0][0][k], t.out[0][0][k]);
        // of the last steps only: right to a few per cent where the search ended by regula falsi
        const double slope = double(dual.in[0][1][k]) / double(forward.out[0][1][k]);
        ASSERT_NEAR(dual.out[0][1][k], slope, 0.15 * (0.02 + std::fabs(slope))) << basis << " " << k;
      }
      for (int k = 0; k < kPoints; ++k) t.in[0][0][k] = falls ? (k % 2 ? 50.f : -50.f) : (k % 2 ? -50.f : 50.f);
      N_AVX2::kRun8(t, true);
      for (int k = 0; k < kPoints; ++k) {
        ASSERT_EQ(t.out[0][0][k], k % 2 ? 0.f : 1.f);
        ASSERT_EQ(t.out[0][1][k], 0.f);
      }
    }
}

TEST(LanguageColor, PublishedFigures) {
  const language::ColorSystem& s = language::defaultColorSystem();
  EXPECT_NEAR(s.luminance[0], 0.2125072f, 1e-6);
  EXPECT_NEAR(s.luminance[1], 0.7153502f, 1e-6);
  EXPECT_NEAR(s.luminance[2], 0.0721426f, 1e-6);
  // IEC 61966-2-1, whose white is rounded a little otherwise
  const float known[9] = {0.4124f, 0.3576f, 0.1805f, 0.2126f, 0.7152f, 0.0722f, 0.0193f, 0.1192f, 0.9505f};
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(s.rgbToXyz[i], known[i], 1e-3) << i;
  for (const char* name :
       {"sRGB", "NTSC", "EBU", "PAL", "SECAM", "SMPTE", "HDTV", "CIE", "AdobeRGB", "XYZ", "ACES2065-1", "ACEScg"}) {
    const language::ColorSystem* other = language::findColorSystem(name);
    ASSERT_NE(other, nullptr) << name;
    EXPECT_NEAR(other->luminance[0] + other->luminance[1] + other->luminance[2], 1, 1e-5) << name;
  }
  EXPECT_EQ(language::findColorSystem("nonsense"), nullptr);
  EXPECT_EQ(language::findColorSpace("linear", "ACEScg"), ColorSpace::Rgb);
  EXPECT_EQ(language::findColorSpace("ACEScg", "ACEScg"), ColorSpace::Rgb);
  EXPECT_EQ(language::findConstructorSpace("sRGB", "ACEScg"), ColorSpace::Unknown);

  // black bodies: Wien's blue at 20000 K and red at 2000 K, the total in line with Planck's law, 800 K the trace
  Plain p = {};
  const float kelvin[8] = {500, 800, 1000, 2000, 3200, 6504, 11999, 20000};
  for (int k = 0; k < kPoints; ++k) p.x[k] = kelvin[k % 8];
  N_AVX2::kPlain8(p);
  EXPECT_EQ(p.body[0][0], 1e-6f);
  EXPECT_EQ(p.body[1][0], 0.f);
  for (int k = 1; k < 8; ++k)
    for (int c = 0; c < 3; ++c) {
      const float exact = language::blackbodyColor(s, kelvin[k])[size_t(c)];
      // the table's own interpolation is coarse where it is cold
      EXPECT_NEAR(p.body[c][k], exact,
                  (k == 1 || k == 7   ? 3e-6f
                   : kelvin[k] < 2000 ? 1e-2f
                                      : 3e-3f) *
                          exact +
                      1e-9f)
          << kelvin[k];
    }
  EXPECT_GT(p.body[0][3], 3 * p.body[1][3]);
  EXPECT_GT(p.body[2][7], p.body[0][7]);
  // daylight of 6504 K is white: the D65 point lies a little to the green of the locus
  EXPECT_NEAR(p.body[0][5] / p.body[1][5], 1, 0.08);
  EXPECT_NEAR(p.body[2][5] / p.body[1][5], 1, 0.08);
  // its luminance by the sum in doubles
  double y = 0;
  for (int i = 0; i < language::kWavelengths; ++i) {
    const double metres = (380 + 5 * i) * 1e-9;
    y += 3.74183e-16 * std::pow(metres, -5) / (std::exp(1.4388e-2 / (metres * 6504.0)) - 1) * 5e-9 *
         double(language::matchingFunctions()[3 * i + 1]);
  }
  const double weighed = double(s.luminance[0]) * double(p.body[0][5]) +
                         double(s.luminance[1]) * double(p.body[1][5]) +
                         double(s.luminance[2]) * double(p.body[2][5]);
  EXPECT_NEAR(weighed / y, 1, 1e-4);

  // wavelengths: nothing outside, red at 650, green at 530, blue at 450
  const float nm[8] = {100, 380, 450, 530, 650, 779, 785, 1000};
  for (int k = 0; k < kPoints; ++k) p.x[k] = nm[k % 8];
  N_AVX2::kPlain8(p);
  for (int k : {0, 6, 7})
    for (int c = 0; c < 3; ++c) EXPECT_EQ(p.wave[c][k], 0.f);
  EXPECT_GT(p.wave[0][4], 4 * p.wave[1][4] + 4 * p.wave[2][4]);
  EXPECT_GT(p.wave[1][3], 4 * p.wave[0][3] + 4 * p.wave[2][3]);
  EXPECT_GT(p.wave[2][2], 4 * p.wave[0][2] + 4 * p.wave[1][2]);
  // 652.5 nm lies between two entries
  for (float& x : p.x) x = 652.5f;
  N_AVX2::kPlain8(p);
  const double X = 0.5 * (0.2835 + 0.2187), Y = 0.5 * (0.1070 + 0.0816);
  EXPECT_NEAR(p.wave[0][0], (double(s.xyzToRgb[0]) * X + double(s.xyzToRgb[1]) * Y) / 2.52, 1e-6);
}

TEST(LanguageColor, SpacesByHandAndBack) {
  const auto convert = [](ColorSpace from, ColorSpace to, float r, float g, float b) {
    Table t = fill(kColor, int(from) * 8 + int(to), 0, 0, 0);
    t.in[0][0][0] = r, t.in[1][0][0] = g, t.in[2][0][0] = b;
    N_AVX2::kRun8(t, false);
    return std::array<float, 3>{t.out[0][0][0], t.out[1][0][0], t.out[2][0][0]};
  };
  const auto expect = [&](ColorSpace from, ColorSpace to, std::array<float, 3> c, std::array<float, 3> e) {
    const auto r = convert(from, to, c[0], c[1], c[2]);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(r[i], e[i], 2e-6f) << int(from) << " -> " << int(to) << " " << i;
  };
  expect(ColorSpace::Rgb, ColorSpace::Hsv, {1, 0, 0}, {0, 1, 1});
  expect(ColorSpace::Rgb, ColorSpace::Hsv, {0, 0.5f, 0}, {1 / 3.f, 1, 0.5f});
  expect(ColorSpace::Rgb, ColorSpace::Hsv, {0.25f, 0.25f, 1}, {2 / 3.f, 0.75f, 1});
  expect(ColorSpace::Rgb, ColorSpace::Hsv, {1, 0, 0.5f}, {11 / 12.f, 1, 1});
  expect(ColorSpace::Rgb, ColorSpace::Hsv, {0, 0, 0}, {0, 0, 0});
  expect(ColorSpace::Hsv, ColorSpace::Rgb, {1.0f / 12, 1, 1}, {1, 0.5f, 0});
  expect(ColorSpace::Hsv, ColorSpace::Rgb, {-2 / 3.f, 0.5f, 0.5f}, {0.25f, 0.5f, 0.25f});
  expect(ColorSpace::Hsv, ColorSpace::Rgb, {0.3f, 0, 0.7f}, {0.7f, 0.7f, 0.7f});
  expect(ColorSpace::Rgb, ColorSpace::Hsl, {1, 0.5f, 0.5f}, {0, 1, 0.75f});
  expect(ColorSpace::Rgb, ColorSpace::Hsl, {0.3f, 0.3f, 0.3f}, {0, 0, 0.3f});
  expect(ColorSpace::Hsl, ColorSpace::Rgb, {1 / 3.f, 1, 0.25f}, {0, 0.5f, 0});
  expect(ColorSpace::Hsl, ColorSpace::Rgb, {0.5f, 1, 0}, {0, 0, 0});
  expect(ColorSpace::Rgb, ColorSpace::Yiq, {1, 1, 1}, {1, 0, 0});
  expect(ColorSpace::Rgb, ColorSpace::Yiq, {1, 0, 0}, {0.299f, 0.596f, 0.212f});
  expect(ColorSpace::Yiq, ColorSpace::Rgb, {1, 1, 0}, {1.9557f, 0.7284f, -0.1082f});
  expect(ColorSpace::Xyz, ColorSpace::XyY, {1, 2, 5}, {0.125f, 0.25f, 2});
  expect(ColorSpace::XyY, ColorSpace::Xyz, {0.125f, 0.25f, 2}, {1, 2, 5});
  expect(ColorSpace::XyY, ColorSpace::Xyz, {0.3f, 0, 2}, {0, 2, 0});
  expect(ColorSpace::Srgb, ColorSpace::Rgb, {0.02f, 0.5f, 1}, {0.02f / 12.92f, 0.2140411f, 1});
  expect(ColorSpace::Rgb, ColorSpace::Srgb, {0.001f, 0.2140411f, 1}, {0.01292f, 0.5f, 1});
  for (int space = int(ColorSpace::Rgb); space <= int(ColorSpace::Srgb); ++space) {
    Table there = fill(kColor, space, 0, 0.05f, 0.95f), back = there;
    N_AVX2::kRun8(there, false);
    back.mode = space * 8;
    for (int i = 0; i < 3; ++i) std::memcpy(back.in[i][0], there.out[i][0], sizeof back.in[i][0]);
    N_AVX2::kRun8(back, false);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < kPoints; ++k)
        // the two matrices of YIQ are rounded to four digits each
        ASSERT_NEAR(back.out[i][0][k], there.in[i][0][k], space == int(ColorSpace::Yiq) ? 2e-3 : 1e-5) << space;
    // derivatives both ways, away from the grey axis, where hue jumps
    Table d = fill(kColor, space, 0, 0.05f, 0.15f);
    for (int k = 0; k < kPoints; ++k) d.in[k % 3][0][k] += 0.2f, d.in[(k / 3 + 1) % 3][0][k] += 0.15f;
    expectDerivatives(d, 3, 4, 1e-2, "from rgb");
    d.mode = space * 8;
    expectDerivatives(d, 3, 4, 1e-2, "to rgb");
  }
}

TEST(LanguageGeometry, SameBitsAtAllWidths) {
  std::vector<Kernel> others{N_AVX2::kRun1, N_AVX2::kRun4};
  if (cpuHasAvx512()) others.push_back(N_AVX3::kRun16);
  for (int op = 0; op < kOps; ++op)
    for (int mode = 0; mode < (op == kColor ? 56 : op >= kSpline ? 6 : 1); ++mode) {
      if (op == kColor && mode % 8 == 7) continue;
      Table a = fill(op, mode, op == kSplineTriple ? 6 : 10, -1, 2, 5), b = a;
      N_AVX2::kRun8(a, true);
      for (Kernel k : others) {
        k(b, true);
        ASSERT_EQ(std::memcmp(a.out, b.out, sizeof a.out), 0) << op << " " << mode;
      }
    }
  Plain p = {}, q;
  for (int k = 0; k < kPoints; ++k) {
    p.x[k] = 300 + 400 * float(k);
    for (int i = 0; i < 16; ++i) p.m[i][k] = random(uint32_t(k * 16 + i));
  }
  q = p;
  N_AVX2::kPlain8(p);
  N_AVX2::kPlain1(q);
  EXPECT_EQ(std::memcmp(&p, &q, sizeof p), 0);
}
}  // namespace kinora
#endif
