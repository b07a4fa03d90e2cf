// Proves: PxrLightProbe's rays in closed form, darkness beyond the disk, the way back, the densities of light paths,
// footprints, widths, refused frames.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;

TEST(PxrLightProbe, DistanceFromTheMiddleIsTheAngle) {
  const TestProjection p("PxrLightProbe", {}, frame(96, 64));
  for (double theta : {0.0, 0.01, 0.7, M_PI / 2, 2.5, 3.1})
    for (double phi : {0.0, 1.0, 2.2, 4.0}) {
      const auto r = p.ray(48 + 32 * theta / M_PI * std::cos(phi), 32 - 32 * theta / M_PI * std::sin(phi));
      EXPECT_NEAR(r[3], std::sin(theta) * std::cos(phi), 2e-6) << theta << " " << phi;
      EXPECT_NEAR(r[4], std::sin(theta) * std::sin(phi), 2e-6);
      EXPECT_NEAR(r[5], std::cos(theta), 2e-6);
      for (size_t k = 0; k < 3; ++k) EXPECT_EQ(r[k], 0);
    }
}

TEST(PxrLightProbe, BeyondTheDiskIsNothing) {
  const TestProjection p("PxrLightProbe", {}, frame(96, 64));
  Columns c(3);
  for (uint32_t i = 0; i < 3; ++i) {
    c.a[0][i] = i == 0 ? 1.f : i == 1 ? 90.f : 48.f;
    c.a[1][i] = i == 2 ? 32.f : 2.f;
  }
  p.rays(c);
  for (uint32_t i = 0; i < 2; ++i) {
    EXPECT_EQ(c.a[11][i], 0) << "weight";
    EXPECT_LT(c.a[7][i], -1e9f);
    EXPECT_EQ(c.a[10][i], -1) << "away from everything";
  }
  EXPECT_EQ(c.a[11][2], 1);
}

TEST(PxrLightProbe, TheWayBackAndLightPaths) {
  TestProjection p("PxrLightProbe", {}, frame(64, 64));
  expectWidthsAgree(p);
  expectDensityCounts(p, M_PI * 32 * 32);
  for (double x : {8.0, 32.0, 50.0})
    for (double y : {20.0, 33.0}) expectSpreadsArePixels(p, x, y);
  Columns c(512);
  fill(c, p.info, 1);
  for (uint32_t i = 0; i < c.n; ++i)  // into the disk
    for (int k = 0; k < 2; ++k) c.a[k][i] = 32 + (c.a[k][i] - 32) * 0.7f;
  p.rays(c);
  for (uint32_t i = 0; i < c.n; ++i)
    for (int k = 0; k < 3; ++k) c.a[14 + k][i] = 7 * c.a[8 + k][i];
  p.connect(c);
  for (uint32_t i = 0; i < c.n; ++i) {
    ASSERT_NEAR(c.a[20][i], c.a[0][i], 2e-3) << i;
    ASSERT_NEAR(c.a[21][i], c.a[1][i], 2e-3) << i;
    ASSERT_GT(c.a[22][i], 0);
    ASSERT_EQ(c.a[22][i], c.a[23][i]);
  }
  Columns odd(3);
  odd.a[15] = {0, 1, NAN};
  odd.a[15].resize(padded(3));
  p.connect(odd);
  EXPECT_EQ(odd.a[22][0], 0) << "at the eye";
  EXPECT_EQ(odd.a[22][2], 0);
  expectBadFramesRefused("PxrLightProbe");
}

}  // namespace
}  // namespace kinora
