// Proves: irradiance against the closed form from touching to a hundred thousand radii away, ellipsoids against
// looking, densities, power, intersections of far rays, darkness inside, widths, degenerate placements. Misses:
// motion.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrSphereLight";
constexpr double kPi = 3.14159265358979;

TEST(PxrSphereLight, Irradiance) {
  for (double radius : {0.5, 4.0})
    for (double d : {1.001, 1.2, 3.0, 100.0, 1e5}) {
      TestLight light(kName, {set("intensity", 2)}, scaleMove(2 * radius, 2 * radius, 2 * radius, {0, 0, 0}));
      const Vec p{0, d * radius, 0};
      const double expected = 2 * kPi / (d * d);
      EXPECT_NEAR(light.closedForm(p, {0, -1, 0}), expected, 1e-6 * expected);
      EXPECT_NEAR(irradianceBySampling(light, p, {0, -1, 0}), expected, 1e-3 * expected) << d;
      if (d < 1000) {
        const Looked looked = lookAround(light, p, {0, -1, 0}, {0, -1, 0}, std::asin(1 / d) * 1.05, 512);
        EXPECT_NEAR(looked.irradiance, expected, 3e-3 * expected) << d;
        EXPECT_NEAR(looked.pdf, 1, 3e-3) << d;
      }
    }
}

TEST(PxrSphereLight, EllipsoidsAgreeWithLooking) {
  const Matrix sheared = {2, 0.1, 0, 0, 0.7, 1, 0.4, 0, 0.2, 0, 0.5, 0, 0.5, 0, 0, 1};
  for (const Matrix& m : {turned(3, 1, 0.5, {1, 0, 0}), turned(-1, 1, 2, {0, 0, 0}), sheared}) {
    TestLight light(kName, {}, m);
    for (Vec p : pointsAround(light, 6, 1.02, 5)) {
      for (int c = 0; c < 3; ++c) p[size_t(c)] = float(p[size_t(c)]);
      const Vec center{light.description.center[0], light.description.center[1], light.description.center[2]};
      const Vec n = unit(center - p);
      const double distance = std::sqrt(dot(center - p, center - p));
      const Looked looked = lookAround(light, p, n, n, std::asin(light.description.radius / distance), 512);
      EXPECT_NEAR(irradianceBySampling(light, p, n), looked.irradiance, 3e-3 * looked.irradiance);
      EXPECT_NEAR(looked.pdf, 1, 5e-3);
    }
  }
}

TEST(PxrSphereLight, DensitiesAgree) {
  for (const Matrix& m : {identity(), turned(3, 1, 0.2, {1, 2, 3}), turned(0.01, 0.01, 0.01, {10, 0, 0})}) {
    TestLight light(kName, {set("emissionFocus", 1)}, m);
    expectDensitiesAgree(light, pointsAround(light, 200, 1.001, 1e4));
  }
}

TEST(PxrSphereLight, EmittedPower) {
  TestLight sphere(kName, {}, scaleMove(4, 4, 4, {1, 1, 1}));
  EXPECT_NEAR(emittedPower(sphere), kPi * 4 * kPi * 4, 1e-3 * kPi * 4 * kPi * 4);
  EXPECT_NEAR(sphere.description.power, kPi * 4 * kPi * 4, 1e-4 * kPi * 4 * kPi * 4);
  // oblate spheroid of semi-axes 1, 1, 1/2: area 2 pi (1 + (1 - e^2) / e atanh e), e^2 = 3/4
  const double e = std::sqrt(0.75), area = 2 * kPi * (1 + (1 - e * e) / e * std::atanh(e));
  TestLight oblate(kName, {set("areaNormalize", 0)}, turned(2, 2, 1, {0, 0, 0}));
  EXPECT_NEAR(emittedPower(oblate), kPi * area, 2e-3 * kPi * area);
  EXPECT_NEAR(oblate.description.power, kPi * area, 2e-4 * kPi * area);
  TestLight normalized(kName, {set("areaNormalize", 1)}, turned(2, 2, 1, {0, 0, 0}));
  EXPECT_NEAR(emittedPower(normalized), kPi, 2e-3 * kPi);
  TestLight shaped(kName, {set("emissionFocus", 3), set("coneAngle", 40), set("coneSoftness", 0.2f)});
  // a tenth of the emitted rays lie in the cone: the estimate's own error is about 0.5 %
  EXPECT_NEAR(emittedPower(shaped), shaped.description.power, 2e-2 * shaped.description.power);
}

TEST(PxrSphereLight, ShapingFollowsItsZAxis) {
  TestLight light(kName, {set("coneAngle", 30)});
  EXPECT_GT(irradianceBySampling(light, {0, 0, 5}, {0, 0, -1}, 32), 0);
  EXPECT_EQ(irradianceBySampling(light, {0, 0, -5}, {0, 0, 1}, 32), 0);
  TestLight open(kName, {});
  EXPECT_NEAR(irradianceBySampling(open, {0, 0, -5}, {0, 0, 1}, 128), kPi * 0.01, 1e-4)
      << "the default cone cuts nothing";
}

TEST(PxrSphereLight, IntersectionsFarAwayHitWhereTheyShould) {
  TestLight light(kName, {});
  for (double d : {0.6, 10.0, 1e4}) {
    Rays r(201);
    for (uint32_t i = 0; i < r.n; ++i) {
      r.a[0][i] = float((double(i) - 100) / 100 * 0.6);  // offset across, beyond the rim on both sides
      r.a[2][i] = float(-d);
      r.a[7][i] = 1;
      r.a[8][i] = 1e30f;
    }
    light.look(r);
    for (uint32_t i = 0; i < r.n; ++i) {
      const double x = r.a[0][i];
      if (std::fabs(std::fabs(x) - 0.5) < 2e-7 * d + 1e-6) continue;
      EXPECT_EQ(r.a[13][i] > 0, std::fabs(x) < 0.5) << d << ' ' << x;
      if (std::fabs(x) < 0.5) {
        EXPECT_NEAR(r.a[8][i], d - std::sqrt(0.25 - x * x), 1e-3 + 1e-6 * d);
      }
    }
  }
}

TEST(PxrSphereLight, DarkInside) {
  TestLight light(kName, {});
  EXPECT_EQ(irradianceBySampling(light, {0.1, 0, 0.2}, {0, 0, 1}, 32), 0);
  EXPECT_EQ(irradianceBySampling(light, {0, 0, 0}, {0, 0, 1}, 32), 0);
  expectNoNaN(light);
}

TEST(PxrSphereLight, WidthsGiveTheSameBits) {
  TestLight light(kName, {set("emissionFocus", 2)}, turned(2, 1, 1, {0, 1, 0}));
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrSphereLight, DegeneratePlacements) { expectDegenerateIsSafe(kName, true); }
}  // namespace
}  // namespace kinora
