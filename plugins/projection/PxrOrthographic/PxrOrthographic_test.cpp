// Proves: rays and footprints at known raster positions, the way back, light paths weighing like camera paths.
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
