// Proves: rays and footprints at known raster positions, the lens and its circle of confusion, the way back, light paths
// weighing like camera paths.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;
constexpr const char* kName = "PxrOrthographic";

TEST(PxrOrthographic, RaysAreParallel) {
  ProjectionInfo info = frame(100, 50);
  info.screenWindowGiven = 1;
  info.screenWindow[0] = -4;
  info.screenWindow[1] = 4;
  info.screenWindow[2] = -2;
  info.screenWindow[3] = 2;
  TestProjection p(kName, {}, info);
  const auto r = p.ray(75, 0);
  EXPECT_NEAR(r[0], 2, 1e-5);
  EXPECT_NEAR(r[1], 2, 1e-5);
  EXPECT_EQ(r[2], 0);
  EXPECT_EQ(r[5], 1);
  Columns c(1);
  p.rays(c);
  EXPECT_NEAR(c.a[12][0], 0.5 * 8 / 100, 1e-6);
  EXPECT_EQ(c.a[13][0], 0);
}

// Radius 0.2, sharp at 2.
ProjectionInfo withLens(uint32_t width = 64, uint32_t height = 48) {
  ProjectionInfo info = frame(width, height);
  info.fStop = 1.5f;
  info.focalLength = 0.6f;
  info.focalDistance = 2;
  return info;
}

TEST(PxrOrthographic, ALensIsSharpAtItsDistance) {
  const TestProjection sharp(kName, {}, frame(64, 48)), p(kName, {}, withLens());
  for (double u : {0.1, 0.5, 0.9})
    for (double v : {0.0, 0.4, 0.8}) {
      const auto a = sharp.ray(13, 40), b = p.ray(13, 40, u, v);
      const double t = 2 / b[5];
      EXPECT_NEAR(b[0] + t * b[3], a[0], 1e-6);
      EXPECT_NEAR(b[1] + t * b[4], a[1], 1e-6);
      EXPECT_EQ(b[2], 0);
      EXPECT_LT(std::hypot(b[0] - a[0], b[1] - a[1]), 0.2 + 1e-6);
      EXPECT_NEAR(b[3] * b[3] + b[4] * b[4] + b[5] * b[5], 1, 1e-6);
    }
  const auto rim = p.ray(13, 40, 1 - 1e-7, 0.5), middle = p.ray(13, 40);
  EXPECT_NEAR(std::hypot(rim[0] - middle[0], rim[1] - middle[1]), 0.2, 1e-4);
}

// A point at depth z is spread over a disk of radius R |1 - z / F|, evenly.
TEST(PxrOrthographic, CircleOfConfusion) {
  const TestProjection p(kName, {}, withLens());
  constexpr uint32_t kSide = 64;
  for (const double z : {0.5, 2.0, 3.0, 8.0}) {
    Columns c(kSide * kSide);
    for (uint32_t i = 0; i < c.n; ++i) {
      c.a[2][i] = (float(i % kSide) + 0.5f) / kSide;
      c.a[3][i] = (float(i / kSide) + 0.5f) / kSide;
      c.a[16][i] = float(z);
    }
    p.connect(c);
    const double radius = 0.2 * std::fabs(1 - z / 2) * 24;  // pixels: 24 a screen unit
    double sum = 0, largest = 0;
    for (uint32_t i = 0; i < c.n; ++i) {
      const double r = std::hypot(c.a[20][i] - 32, c.a[21][i] - 24);
      sum += r * r / c.n;
      largest = std::fmax(largest, r);
      ASSERT_GT(c.a[22][i], 0);
    }
    EXPECT_NEAR(sum, radius * radius / 2, 2e-3 * radius * radius + 1e-8) << z;
    EXPECT_LE(largest, radius + 1e-4) << z;
    EXPECT_GE(largest, 0.97 * radius) << z;
  }
}

TEST(PxrOrthographic, LensSharedChecks) {
  TestProjection p(kName, {}, withLens());
  expectWidthsAgree(p);
  expectLightPathsAgree(p, 3, 2);
  expectOddPointsUnseen(p);
  ProjectionInfo narrow = withLens();  // points at 1000 are to be within the rounding that the check allows
  narrow.focalLength = 0.06f;
  expectRoundTrip(TestProjection(kName, {}, narrow));
  ProjectionInfo shaped = withLens();
  shaped.apertureSides = 5;
  shaped.apertureDensity = 0.5f;
  expectLightPathsAgree(TestProjection(kName, {}, shaped), 3, 2);
  ProjectionInfo odd = withLens();
  odd.focalDistance = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(TestProjection(kName, {}, odd).ray(3, 4, 0.9, 0.9)[5], 1) << "no lens";
}

TEST(PxrOrthographic, ConnectUndoesRays) { expectRoundTrip(TestProjection(kName, {}, frame(640, 480))); }
TEST(PxrOrthographic, LightPathsWeighLikeCameraPaths) {
  expectLightPathsAgree(TestProjection(kName, {}, frame(64, 48)), 3, 2);
}
TEST(PxrOrthographic, WidthsGiveTheSameBits) {
  TestProjection p(kName, {}, frame(640, 480));
  expectWidthsAgree(p);
}
TEST(PxrOrthographic, BadNumbers) {
  expectBadFramesRefused(kName);
  expectOddPointsUnseen(TestProjection(kName, {}, frame(64, 48)));
}
}  // namespace
}  // namespace kinora
