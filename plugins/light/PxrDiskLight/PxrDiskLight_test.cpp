// Proves: irradiance against closed forms from touching to far away, at grazing points and on tilted receivers;
// ellipses against looking; densities, power, the dark back, widths, degenerate placements. Misses: motion.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrDiskLight";
constexpr double kPi = 3.14159265358979;

TEST(PxrDiskLight, IrradianceOnItsAxis) {
  for (double radius : {0.5, 3.0})
    for (double h : {0.003, 0.1, 1.0, 10.0, 1e4}) {
      TestLight light(kName, {set("intensity", 2)}, scaleMove(2 * radius, 2 * radius, 1, {1, 2, 3}));
      // E = pi L r^2 / (r^2 + h^2)
      const double expected = 2 * kPi / (1 + h * h);
      const Vec p{1, 2, 3 + h * radius};
      EXPECT_NEAR(light.closedForm(p, {0, 0, -1}), expected, 2e-5 * expected) << h;
      EXPECT_NEAR(irradianceBySampling(light, p, {0, 0, -1}), expected, 1e-3 * expected) << h;
    }
}

TEST(PxrDiskLight, IrradianceOffItsAxis) {
  // element parallel to the disk: F = (1 - (h^2 + x^2 - r^2) / sqrt((h^2 + x^2 + r^2)^2 - 4 r^2 x^2)) / 2
  TestLight light(kName, {}, scaleMove(2, 2, 2, {0, 0, 0}));
  for (double h : {0.02, 0.3, 2.0, 50.0})
    for (double x : {0.4, 0.98, 1.02, 1.5, 6.0}) {
      const double s = h * h + x * x, f = 0.5 * (1 - (s - 1) / std::sqrt((s + 1) * (s + 1) - 4 * x * x));
      const Vec p{x * 0.6, x * -0.8, h};
      EXPECT_NEAR(light.closedForm(p, {0, 0, -1}), kPi * f, 1e-4 * kPi * f) << h << ' ' << x;
      EXPECT_NEAR(irradianceBySampling(light, p, {0, 0, -1}), kPi * f, 4e-3 * kPi * f) << h << ' ' << x;
    }
}

TEST(PxrDiskLight, TiltedReceiversAndEllipses) {
  for (const Matrix& m : {scaleMove(1, 1, 1, {0, 0, 0}), turned(3, 1, 0.5, {1, 0, 0}), turned(-1, 1, 2, {0, 0, 0})}) {
    TestLight light(kName, {}, m);
    const Vec z = unit({m[8], m[9], m[10]}), x = unit({m[0], m[1], m[2]}), c{m[12], m[13], m[14]};
    for (double tilt : {0.3, 1.0, 1.4}) {
      const Vec p = c + z * 0.4 + x * 1.1;
      const Vec n = unit(z * -std::cos(tilt) + x * std::sin(tilt) * -1);
      const double e = light.closedForm(p, n);
      EXPECT_NEAR(irradianceBySampling(light, p, n), e, 4e-3 * e + 1e-5) << tilt;
      const Looked looked = lookAround(light, p, n, z * -1, 1.5707);
      EXPECT_NEAR(looked.irradiance, e, 6e-3 * e) << tilt;
      EXPECT_NEAR(looked.pdf, 1, 1e-2);
    }
  }
}

TEST(PxrDiskLight, DensitiesAgreeAndVaryLittle) {
  for (const Matrix& m : {identity(), turned(3, 1, 0.2, {1, 2, 3}), turned(0.01, 0.01, 0.01, {10, 0, 0})}) {
    TestLight light(kName, {set("emissionFocus", 1)}, m);
    expectDensitiesAgree(light, pointsAround(light, 200, 0.05, 1e4));
  }
  // the solid angle's estimate 1 / pdf: its relative deviation stays below a half wherever the point is
  TestLight round(kName, {});
  for (double h : {1e-3, 0.03, 0.3, 3.0})
    for (double x : {0.0, 0.3, 0.49, 0.51, 0.7, 3.0}) {
      Rays r(4096);
      fillGrid(r.a[3], r.a[4], 64, 1);
      std::fill(r.a[0].begin(), r.a[0].end(), float(x));
      std::fill(r.a[2].begin(), r.a[2].end(), float(h));
      round.sample(r);
      double sum = 0, squares = 0;
      for (uint32_t i = 0; i < r.n; ++i) {
        ASSERT_GT(r.a[12][i], 0);
        sum += 1 / r.a[12][i];
        squares += 1 / (double(r.a[12][i]) * r.a[12][i]);
      }
      const double mean = sum / r.n;
      EXPECT_LT(std::sqrt(std::fmax(0, squares / r.n / (mean * mean) - 1)), 0.5) << h << ' ' << x;
    }
}

TEST(PxrDiskLight, EmittedPower) {
  TestLight disk(kName, {}, turned(4, 2, 3, {1, 1, 1}));
  const double power = kPi * kPi * 2;  // half axes 2 and 1
  EXPECT_NEAR(emittedPower(disk), power, 1e-3 * power);
  EXPECT_NEAR(disk.description.power, power, 1e-4 * power);
  TestLight normalized(kName, {set("areaNormalize", 1)}, turned(4, 2, 3, {1, 1, 1}));
  EXPECT_NEAR(emittedPower(normalized), kPi, 1e-3 * kPi);
  TestLight shaped(kName, {set("emissionFocus", 3), set("coneAngle", 40), set("coneSoftness", 0.2f)});
  EXPECT_NEAR(emittedPower(shaped), shaped.description.power, 5e-3 * shaped.description.power);
}

TEST(PxrDiskLight, DarkBehind) {
  TestLight light(kName, {});
  EXPECT_EQ(irradianceBySampling(light, {0.1, 0, -1}, {0, 0, 1}, 32), 0);
  EXPECT_EQ(lookAround(light, {0, 0, -1}, {0, 0, 1}, {0, 0, 1}, 1, 32).irradiance, 0);
  EXPECT_GT(irradianceBySampling(light, {0.1, 0, 1}, {0, 0, -1}, 32), 0);
  TestLight mirrored(kName, {}, scaleMove(1, 1, -1, {0, 0, 0}));
  EXPECT_GT(irradianceBySampling(mirrored, {0.1, 0, -1}, {0, 0, 1}, 32), 0) << "the side of local +Z";
}

TEST(PxrDiskLight, WidthsGiveTheSameBits) {
  TestLight light(kName, {set("emissionFocus", 2)}, turned(2, 1, 1, {0, 1, 0}));
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrDiskLight, DegeneratePlacements) { expectDegenerateIsSafe(kName, true); }
}  // namespace
}  // namespace kinora
