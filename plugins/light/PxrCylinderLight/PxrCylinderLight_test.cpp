// Proves: irradiance against a published view factor and against looking, from near the wall to far away; sheared
// placements; densities, power, darkness inside and beyond the open ends, widths, degenerate placements. Misses:
// motion.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrCylinderLight";
constexpr double kPi = 3.14159265358979;

// View factor from an element whose normal meets a cylinder's end at a right angle to its axis (Howell, A Catalog of
// Radiation Heat Transfer Configuration Factors, B-30): radius r, length l, distance h from the axis.
double viewFactorAtEnd(double r, double l, double h) {
  const double L = l / r, H = h / r, X = (1 + H) * (1 + H) + L * L, Y = (1 - H) * (1 - H) + L * L;
  return std::atan(L / std::sqrt(H * H - 1)) / (kPi * H) +
         L / kPi *
             ((X - 2 * H) / (H * std::sqrt(X * Y)) * std::atan(std::sqrt(X * (H - 1) / (Y * (H + 1)))) -
              std::atan(std::sqrt((H - 1) / (H + 1))) / H);
}

TEST(PxrCylinderLight, IrradianceByThePublishedViewFactor) {
  for (double scale : {1.0, 5.0})
    for (double h : {1.02, 1.3, 3.0, 40.0, 1e4}) {  // in radii
      TestLight light(kName, {set("intensity", 2)}, scaleMove(scale, scale, scale, {1, 2, 3}));
      const double r = 0.5 * scale, e = 2 * kPi * 2 * viewFactorAtEnd(r, 0.5 * scale, h * r);
      const Vec p{1, 2 + h * r, 3};
      EXPECT_NEAR(light.closedForm(p, {0, -1, 0}), e, 1e-4 * e) << h;
      EXPECT_NEAR(irradianceBySampling(light, p, {0, -1, 0}), e, 1e-3 * e) << h;
    }
}

TEST(PxrCylinderLight, PlacesAroundAgreeWithLooking) {
  const Matrix sheared = {2, 0.1, 0, 0, 0.7, 1, 0.4, 0, 0.2, 0, 0.5, 0, 0.5, 0, 0, 1};
  for (const Matrix& m :
       {turned(1, 1, 1, {0, 0, 0}), turned(3, 1, 0.5, {1, 0, 0}), turned(-1, 1, 2, {0, 0, 0}), sheared}) {
    TestLight light(kName, {}, m);
    for (Vec p : pointsAround(light, 6, 1.02, 4)) {
      for (int c = 0; c < 3; ++c) p[size_t(c)] = float(p[size_t(c)]);
      const Vec center{light.description.center[0], light.description.center[1], light.description.center[2]};
      const Vec n = unit(center - p);
      const double distance = std::sqrt(dot(center - p, center - p));
      const Looked looked = lookAround(light, p, n, n, std::asin(light.description.radius / distance), 512);
      if (looked.pdf == 0) continue;  // beyond an end, within the wall's reach
      EXPECT_NEAR(irradianceBySampling(light, p, n), looked.irradiance, 8e-3 * looked.irradiance);
      EXPECT_NEAR(looked.pdf, 1, 6e-3);
      const double e = light.closedForm(p, n);
      if (e >= 0) {
        EXPECT_NEAR(irradianceBySampling(light, p, n), e, 2e-3 * e);
      }
    }
  }
}

TEST(PxrCylinderLight, DensitiesAgree) {
  for (const Matrix& m : {identity(), turned(3, 1, 0.2, {1, 2, 3}), turned(0.01, 0.01, 0.01, {1, 0, 0})}) {
    TestLight light(kName, {set("emissionFocus", 1)}, m);
    expectDensitiesAgree(light, pointsAround(light, 200, 1.05, 2e3));
  }
}

TEST(PxrCylinderLight, EmittedPower) {
  TestLight round(kName, {}, turned(3, 2, 2, {1, 1, 1}));  // radius 1, length 3
  const double power = kPi * 2 * kPi * 3;
  EXPECT_NEAR(emittedPower(round), power, 1e-3 * power);
  EXPECT_NEAR(round.description.power, power, 1e-4 * power);
  TestLight normalized(kName, {set("areaNormalize", 1)}, turned(3, 2, 1, {0, 0, 0}));
  EXPECT_NEAR(emittedPower(normalized), kPi, 2e-3 * kPi);
}

TEST(PxrCylinderLight, DarkInsideAndBeyondTheOpenEnds) {
  TestLight light(kName, {});
  EXPECT_EQ(irradianceBySampling(light, {0.1, 0, 0.2}, {0, 0, 1}, 32), 0);
  EXPECT_EQ(irradianceBySampling(light, {2, 0.1, 0.2}, {-1, 0, 0}, 32), 0);
  EXPECT_EQ(lookAround(light, {2, 0.1, 0.2}, {-1, 0, 0}, {-1, 0, 0}, 1, 64).irradiance, 0);
  EXPECT_GT(irradianceBySampling(light, {2, 1, 0}, {-1, 0, 0}, 32), 0);
  expectNoNaN(light);
}

TEST(PxrCylinderLight, WidthsGiveTheSameBits) {
  TestLight light(kName, {set("emissionFocus", 2)}, turned(2, 1, 1, {0, 1, 0}));
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrCylinderLight, DegeneratePlacements) { expectDegenerateIsSafe(kName, true); }
}  // namespace
}  // namespace kinora
