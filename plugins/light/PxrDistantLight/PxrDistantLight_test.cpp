// Proves: direction and sign, irradiance of cones and of the delta light, normalisation, densities, flux through the
// world's disk, widths, degenerate placements. Misses: shadows, which are the host's.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrDistantLight";
constexpr double kPi = 3.14159265358979;

TEST(PxrDistantLight, TravelsAlongLocalZ) {
  TestLight light(kName, {});
  EXPECT_GT(irradianceBySampling(light, {0, 0, 0}, {0, 0, -1}, 32), 0);
  EXPECT_EQ(irradianceBySampling(light, {0, 0, 0}, {0, 0, 1}, 32), 0);
}

TEST(PxrDistantLight, Irradiance) {
  // the default: 50000 over 0.53 degrees gives 3.36
  TestLight sun(kName, {});
  EXPECT_NEAR(irradianceBySampling(sun, {0, 0, 0}, {0, 0, -1}), 3.36, 0.01);
  for (float angle : {0.001f, 0.53f, 10.f, 90.f, 180.f}) {
    TestLight light(kName, {set("intensity", 2), set("angleExtent", angle)});
    const double s = std::sin(angle * kPi / 360), expected = 2 * kPi * s * s;
    EXPECT_NEAR(light.closedForm({0, 0, 0}, {0, 0, -1}), expected, 1e-5 * expected) << angle;
    EXPECT_NEAR(irradianceBySampling(light, {1, 2, 3}, {0, 0, -1}), expected, 1e-3 * expected) << angle;
    if (angle > 0.1f) {
      const Looked looked = lookAround(light, {0, 0, 0}, {0, 0, -1}, {0, 0, -1}, angle * kPi / 360 * 1.05);
      EXPECT_NEAR(looked.irradiance, expected, 3e-3 * expected) << angle;
      EXPECT_NEAR(looked.pdf, 1, 3e-3) << angle;
    }
    TestLight normalized(kName, {set("intensity", 2), set("angleExtent", angle), set("areaNormalize", 1)});
    const double sun = std::sin(0.53 * kPi / 360), same = 2 * kPi * sun * sun;
    EXPECT_NEAR(irradianceBySampling(normalized, {0, 0, 0}, {0, 0, -1}), same, 1e-3 * same);
  }
}

TEST(PxrDistantLight, DeltaWhereTheAngleIsZero) {
  TestLight light(kName, {set("intensity", 2), set("angleExtent", 0)}, turned(1, 1, 1, {5, 5, 5}));
  EXPECT_TRUE(light.description.isDelta);
  Rays r(1);
  std::vector<uint32_t> flags;
  light.sample(r, &flags);
  EXPECT_EQ(flags[0], uint32_t(kSampleDelta));
  EXPECT_EQ(r.a[12][0], 1);
  EXPECT_EQ(r.a[9][0], 2);
  EXPECT_TRUE(std::isinf(r.a[8][0]));
  light.evaluate(r);
  EXPECT_EQ(r.a[16][0], 0) << "no ray hits it by chance";
  EXPECT_EQ(r.a[13][0], 0);
}

TEST(PxrDistantLight, DensitiesAgree) {
  for (float angle : {0.01f, 0.53f, 30.f, 180.f}) {
    TestLight light(kName, {set("angleExtent", angle)}, turned(1, 1, 1, {0, 0, 0}));
    expectDensitiesAgree(light, pointsAround(light, 100));
  }
}

TEST(PxrDistantLight, EmitsThroughTheWholeWorld) {
  for (float angle : {0.f, 0.53f, 60.f}) {
    TestLight light(kName, {set("intensity", 2), set("angleExtent", angle)}, turned(1, 1, 1, {0, 0, 0}));
    light.worldRadius = 3;
    light.worldCenter = {1, 2, 3};
    // each direction sends its radiance through a disk of the world's size
    const double h = 2 * std::pow(std::sin(angle * kPi / 720), 2);
    const double expected = kPi * 9 * 2 * (angle > 0 ? 2 * kPi * h : 1);
    EXPECT_NEAR(emittedPower(light), expected, 1e-3 * expected) << angle;
    EXPECT_NEAR(light.description.power * kPi * 9, expected, 1e-3 * expected) << angle;
    Rays r(1024);
    fillGrid(r.a[0], r.a[1], 32, 1);
    fillGrid(r.a[3], r.a[2], 32, 2);
    light.emit(r);
    for (uint32_t i = 0; i < r.n; ++i) {
      const Vec o{r.a[4][i], r.a[5][i], r.a[6][i]}, d{r.a[7][i], r.a[8][i], r.a[9][i]};
      const double along = dot(light.worldCenter - o, d);
      EXPECT_NEAR(along, 3, 1e-4) << "starts on the plane that touches the world";
      const Vec off = light.worldCenter - o - d * along;
      EXPECT_LE(dot(off, off), 9.001);
    }
  }
}

TEST(PxrDistantLight, WidthsGiveTheSameBits) {
  TestLight light(kName, {set("angleExtent", 20)}, turned(2, 1, 1, {0, 1, 0}));
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrDistantLight, DegeneratePlacements) {
  expectDegenerateIsSafe(kName, false);
  TestLight light(kName, {}, scaleMove(1, 1, 0, {0, 0, 0}));
  ASSERT_TRUE(light.made());
  EXPECT_EQ(light.description.power, 0);
  EXPECT_FALSE(light.warnings.empty());
}
}  // namespace
}  // namespace kinora
