// Proves: OmnidirectionalStereo's rays in closed form for both eyes, the way back by either, the densities of light
// paths, widths, refused numbers. Light tracing against path tracing is in tests/probes.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;

TEST(OmnidirectionalStereo, EyesStandAcrossTheDirection) {
  const double apart = 0.5;
  const TestProjection p("OmnidirectionalStereo", {{"interpupilaryDistance", float(apart)}}, frame(64, 64));
  for (double x : {0.0, 16.0, 32.0, 50.5})
    for (double y : {1.0, 16.0, 31.0})
      for (int eye : {0, 1}) {
        const double turn = (x / 64 - 0.5) * 2 * M_PI, up = (0.5 - y / 32) * M_PI, side = eye ? 1 : -1;
        const auto r = p.ray(x, y + 32 * eye);
        const double expected[6] = {side * apart / 2 * std::cos(turn),
                                    0,
                                    -side * apart / 2 * std::sin(turn),
                                    std::sin(turn) * std::cos(up),
                                    std::sin(up),
                                    std::cos(turn) * std::cos(up)};
        for (size_t k = 0; k < 6; ++k) EXPECT_NEAR(r[k], expected[k], 1e-6) << x << " " << y << " eye " << eye;
      }
  // straight ahead the left eye is on the left
  EXPECT_NEAR(p.ray(32, 16)[0], -0.25, 1e-6);
}

TEST(OmnidirectionalStereo, TheWayBackByEitherEye) {
  TestProjection p("OmnidirectionalStereo", {{"interpupilaryDistance", 0.4f}}, frame(64, 96));
  expectWidthsAgree(p);
  Columns c(512);
  fill(c, p.info, 1);
  for (uint32_t i = 0; i < c.n; ++i) c.a[2][i] = c.a[1][i] < 48 ? 0.3f : 0.7f;  // the eye that looks
  p.rays(c);
  for (uint32_t i = 0; i < c.n; ++i)
    for (int k = 0; k < 3; ++k) c.a[14 + k][i] = c.a[5 + k][i] + (2 + float(i % 7)) * c.a[8 + k][i];
  p.connect(c);
  for (uint32_t i = 0; i < c.n; ++i) {
    // near the poles a little of height is much of turn
    const float cosine = std::sqrt(c.a[8][i] * c.a[8][i] + c.a[10][i] * c.a[10][i]);
    if (cosine < 0.05f) continue;
    ASSERT_NEAR(c.a[20][i], c.a[0][i], 2e-3) << i;
    ASSERT_NEAR(c.a[21][i], c.a[1][i], 2e-3) << i;
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(c.a[17 + k][i], c.a[5 + k][i], 1e-5);
    ASSERT_GT(c.a[23][i], 0);
    ASSERT_EQ(c.a[22][i], 2 * c.a[23][i]) << "a point is shown to one of two eyes";
  }
}

TEST(OmnidirectionalStereo, DensitiesAndBadNumbers) {
  // eyes in one place: each half of the picture sees all directions, the lens number says which is asked
  const TestProjection p("OmnidirectionalStereo", {{"interpupilaryDistance", 0.f}}, frame(64, 96));
  expectDensityCounts(p, 64 * 48);
  const TestProjection q("OmnidirectionalStereo", {{"interpupilaryDistance", 2.f}}, frame(64, 96));
  Columns c(3);
  c.a[14] = {0.5f, 0, 3};  // between the eyes' places, at the middle, outside
  c.a[14].resize(padded(3));
  q.connect(c);
  EXPECT_EQ(c.a[22][0], 0);
  EXPECT_EQ(c.a[22][1], 0);
  EXPECT_GT(c.a[22][2], 0);
  EXPECT_FALSE(TestProjection("OmnidirectionalStereo", {{"interpupilaryDistance", -1.f}}, frame(64, 48)).made());
  EXPECT_FALSE(TestProjection("OmnidirectionalStereo", {}, frame(64, 1)).made());
  EXPECT_FALSE(TestProjection("OmnidirectionalStereo", {}, ProjectionInfo{}).made());
}

}  // namespace
}  // namespace kinora
