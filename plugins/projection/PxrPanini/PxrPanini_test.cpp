// Proves: PxrPanini's rays in closed form, perspective without compression, the lens and its circle of confusion,
// the way back, the densities of light paths, footprints, widths, refused numbers.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;

// The screen place of a direction, turned about the upright axis and raised, by the projection's definition.
void expectAt(const TestProjection& p, double turn, double elevation, double compression, double perUnit) {
  const double S = (compression + 1) / (compression + std::cos(turn));
  const double h = S * std::sin(turn) / perUnit, v = S * std::tan(elevation) / perUnit;
  const double half = 0.5 * p.info.resolution[1];  // pixels of a screen unit, wide pictures
  const auto r = p.ray(0.5 * p.info.resolution[0] + h * half, half - v * half);
  EXPECT_NEAR(r[3], std::sin(turn) * std::cos(elevation), 2e-6) << turn << " " << elevation;
  EXPECT_NEAR(r[4], std::sin(elevation), 2e-6);
  EXPECT_NEAR(r[5], std::cos(turn) * std::cos(elevation), 2e-6);
}

TEST(PxrPanini, RaysAreTheDefinitions) {
  for (float compression : {0.f, 0.4f, 1.f})
    for (float fov : {40.f, 90.f}) {
      const TestProjection p("PxrPanini", {{"fov", fov}, {"compression", compression}}, frame(128, 64));
      for (double turn : {-1.2, -0.3, 0.0, 0.8})
        for (double elevation : {-0.5, 0.0, 0.3})
          expectAt(p, turn, elevation, compression, std::tan(fov * M_PI / 360));
    }
  // upright pictures: fov spans their width
  const TestProjection upright("PxrPanini", {{"fov", 100.f}}, frame(64, 128));
  EXPECT_NEAR(upright.ray(64, 64)[3], std::sin(50 * M_PI / 180), 2e-6);
}

TEST(PxrPanini, WithoutCompressionItIsPerspective) {
  const TestProjection p("PxrPanini", {{"fov", 70.f}, {"compression", 0.f}}, frame(64, 48)),
      perspective("PxrPerspective", {{"fov", 70.f}}, frame(64, 48));
  for (double x : {0.0, 11.0, 32.0, 64.0})
    for (double y : {0.0, 20.0, 48.0}) {
      const auto a = p.ray(x, y), b = perspective.ray(x, y);
      for (size_t k = 0; k < 6; ++k) EXPECT_NEAR(a[k], b[k], 2e-6);
    }
}

TEST(PxrPanini, TheWayBackAndLightPaths) {
  for (float compression : {0.f, 0.5f, 1.f}) {
    TestProjection p("PxrPanini", {{"fov", 80.f}, {"compression", compression}}, frame(64, 48));
    expectRoundTrip(p);
    expectWidthsAgree(p);
    expectDensityCounts(p, 64 * 48);
    for (double x : {8.0, 32.0, 60.0})
      for (double y : {5.0, 30.0}) expectSpreadsArePixels(p, x, y);
    expectLightPathsAgree(TestProjection("PxrPanini", {{"fov", 50.f}, {"compression", compression}}, frame(64, 48)),
                          3, 3);
    expectOddPointsUnseen(p);
  }
}

// Radius 0.2, sharp at 2.
ProjectionInfo withLens() {
  ProjectionInfo info = frame(64, 48);
  info.fStop = 1.5f;
  info.focalLength = 0.6f;
  info.focalDistance = 2;
  return info;
}

TEST(PxrPanini, WithoutCompressionTheLensIsThatOfPerspective) {
  const TestProjection p("PxrPanini", {{"fov", 70.f}, {"compression", 0.f}}, withLens()),
      perspective("PxrPerspective", {{"fov", 70.f}}, withLens());
  Columns a(333), b(333);
  fill(a, p.info, 3);
  fill(b, p.info, 3);
  p.rays(a);
  perspective.rays(b);
  for (uint32_t i = 0; i < a.n; ++i) {
    for (size_t k = 5; k < 13; ++k) ASSERT_NEAR(a.a[k][i], b.a[k][i], 3e-6) << i << ' ' << k;
    ASSERT_NEAR(a.a[13][i] / b.a[13][i], 1, 1e-4) << "spread";
    for (size_t k = 14; k < 17; ++k) a.a[k][i] = b.a[k][i] = b.a[k - 9][i] + 5 * b.a[k - 6][i];
  }
  p.connect(a);
  perspective.connect(b);
  for (uint32_t i = 0; i < a.n; ++i) {
    for (size_t k = 17; k < 22; ++k) ASSERT_NEAR(a.a[k][i], b.a[k][i], 5e-4) << i << ' ' << k;
    ASSERT_NEAR(a.a[22][i] / b.a[22][i], 1, 1e-4);
    ASSERT_NEAR(a.a[23][i] / b.a[23][i], 1, 1e-4);
  }
}

// Rays of a place meet on the plane of focus. A point of the axis at depth z is seen from the lens point o, across the
// axis, where the turn is atan(o (1 / F - 1 / z)).
TEST(PxrPanini, CircleOfConfusion) {
  for (float compression : {0.3f, 1.f}) {
    const TestProjection p("PxrPanini", {{"fov", 80.f}, {"compression", compression}}, withLens());
    const auto middle =
        TestProjection("PxrPanini", {{"fov", 80.f}, {"compression", compression}}, frame(64, 48)).ray(50, 10);
    for (double u : {0.0, 0.6, 0.95}) {
      const auto r = p.ray(50, 10, u, 0.3);
      EXPECT_NEAR(r[0] + r[3] * 2 / r[5], middle[3] * 2 / middle[5], 5e-6);
      EXPECT_NEAR(r[1] + r[4] * 2 / r[5], middle[4] * 2 / middle[5], 5e-6);
    }
    for (const double z : {0.7, 2.0, 9.0}) {
      Columns c(1);
      c.a[2][0] = 1 - 1e-7f;  // the rim, at +x or -x
      c.a[3][0] = 0.5f;
      c.a[16][0] = float(z);
      p.connect(c);
      const double o = c.a[17][0];
      ASSERT_NEAR(std::fabs(o), 0.2, 1e-4);
      ASSERT_NEAR(c.a[18][0], 0, 1e-4);
      const double turn = std::atan(o * (0.5 - 1 / z)), half = std::tan(40 * M_PI / 180);
      const double h = (compression + 1) / (compression + std::cos(turn)) * std::sin(turn) / half;
      EXPECT_NEAR(c.a[20][0], 32 + 24 * h, 2e-3) << z;
      EXPECT_NEAR(c.a[21][0], 24, 5e-3);
    }
  }
}

TEST(PxrPanini, LensSharedChecks) {
  for (float compression : {0.f, 0.5f, 1.f}) {
    TestProjection p("PxrPanini", {{"fov", 80.f}, {"compression", compression}}, withLens());
    expectRoundTrip(p);
    expectWidthsAgree(p);
    expectOddPointsUnseen(p);
    expectLightPathsAgree(TestProjection("PxrPanini", {{"fov", 50.f}, {"compression", compression}}, withLens()), 3,
                          3);
  }
  // aside and back too
  expectRoundTrip(TestProjection("PxrPanini", {{"fov", 150.f}, {"compression", 1.f}}, withLens()));
}

TEST(PxrPanini, BadNumbers) {
  for (const Setting& s :
       {Setting("fov", 0.f), Setting("fov", 180.f), Setting("compression", -0.1f), Setting("compression", 1.5f)}) {
    const TestProjection p("PxrPanini", {s}, frame(64, 48));
    EXPECT_FALSE(p.made());
    EXPECT_FALSE(p.error.empty());
  }
  expectBadFramesRefused("PxrPanini");
}

}  // namespace
}  // namespace kinora
