// Proves: PxrPanini's rays in closed form, perspective without compression, the way back, the densities of light paths,
// footprints, widths, refused numbers.
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
