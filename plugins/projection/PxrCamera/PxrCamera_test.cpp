// Proves: shift, roll, depth of field from its own parameters, the shared checks, and the message about parameters
// that change nothing yet. Lens and raster in general: PxrPerspective's test.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;
constexpr const char* kName = "PxrCamera";

TEST(PxrCamera, ShiftAndRoll) {
  TestProjection shifted(kName, {{"shiftX", 0.5f}, {"shiftY", -0.25f}}, frame(100, 100));
  auto r = shifted.ray(50, 50);
  EXPECT_NEAR(r[3] / r[5], 0.5, 1e-6);
  EXPECT_NEAR(r[4] / r[5], -0.25, 1e-6);
  TestProjection rolled(kName, {{"roll", 90}}, frame(100, 100));
  r = rolled.ray(100, 50);  // what is at the right edge lies above
  EXPECT_NEAR(r[3] / r[5], 0, 1e-6);
  EXPECT_NEAR(r[4] / r[5], 1, 1e-6);
}

TEST(PxrCamera, SharedChecks) {
  const std::vector<Setting> settings = {{"fov", 50},  {"shiftX", 0.2f},      {"roll", 30},
                                         {"fStop", 1}, {"focalLength", 0.3f}, {"focalDistance", 4}};
  TestProjection p(kName, settings, frame(64, 48));
  EXPECT_TRUE(p.warnings.empty());
  expectRoundTrip(p);
  expectLightPathsAgree(p, 3, 5);
  expectWidthsAgree(p);
  expectOddPointsUnseen(p);
  expectBadFramesRefused(kName);
}

// Rays of one raster point through all of the lens meet on the plane of focus, wherever the camera stands.
TEST(PxrCamera, PlaneOfFocusThroughThreePoints) {
  ProjectionInfo info = frame(64, 48);
  // looks along world x, with world z up, from (-5, 2, 1)
  const double toCamera[16] = {0, 0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 2, -1, 5, 1};
  std::copy(toCamera, toCamera + 16, info.worldToCamera);
  // x = 1 + z / 2 in world space
  static const float kFocus[3][3] = {{1, 0, 0}, {2, 0, 2}, {1, 7, 0}};
  const std::vector<Setting> settings = {{"fov", 50},          {"fStop", 1},          {"focalLength", 0.6f},
                                         {"focalDistance", 4}, {"focus1", kFocus[0]}, {"focus2", kFocus[1]},
                                         {"focus3", kFocus[2]}};
  TestProjection p(kName, settings, info);
  EXPECT_TRUE(p.warnings.empty());
  for (double x : {5., 32., 60.})
    for (double y : {3., 24., 45.}) {
      const auto middle = p.ray(x, y);
      // camera (a, b, c) is world (c - 5, 2 - a, b + 1): on the plane where c - 5 = 1 + (b + 1) / 2
      const double t = 6.5 / (middle[5] - 0.5 * middle[4]);
      ASSERT_GT(t, 0);
      for (double u : {0.1, 0.9})
        for (double v : {0.2, 0.7}) {
          const auto r = p.ray(x, y, u, v);
          const double s = (6.5 - r[2] + 0.5 * r[1]) / (r[5] - 0.5 * r[4]);
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(r[size_t(c)] + s * r[size_t(c) + 3], t * middle[size_t(c) + 3], 1e-5);
        }
    }
  expectRoundTrip(p);
  expectLightPathsAgree(p, 3, 5);
  expectWidthsAgree(p);
  // on a line; through the lens: the plane of focalDistance is used, with a message
  static const float kLine[3] = {0, 0, -2}, kLens[3] = {-5, 2, 1};
  for (const float* third : {kLine, kLens}) {
    std::vector<Setting> bad = settings;
    bad.back().list = third;
    TestProjection q(kName, bad, info);
    ASSERT_EQ(q.warnings.size(), 1u) << q.warnings.size();
    EXPECT_NE(q.warnings[0].find("PROJECTION-FOCUS"), std::string::npos);
  }
}

// A real scene sets DepthOfField and PxrCamera, and its author's picture is sharp everywhere.
TEST(PxrCamera, DepthOfFieldRequestsAreForOtherProjections) {
  ProjectionInfo info = frame(64, 48);
  info.fStop = 2;
  info.focalLength = 0.4f;
  info.focalDistance = 3;
  TestProjection p(kName, {{"fov", 50}}, info);
  ASSERT_EQ(p.warnings.size(), 1u);
  EXPECT_NE(p.warnings[0].find("PROJECTION-LENS"), std::string::npos);
  const auto a = p.ray(7, 9, 0.1, 0.2), b = p.ray(7, 9, 0.9, 0.7);
  for (size_t c = 0; c < 6; ++c) EXPECT_EQ(a[c], b[c]);
  TestProjection own(kName, {{"fov", 50}, {"fStop", 1}, {"focalLength", 0.6f}, {"focalDistance", 4}}, info);
  EXPECT_TRUE(own.warnings.empty());
  EXPECT_NE(own.ray(7, 9, 0.1, 0.2)[0], own.ray(7, 9, 0.9, 0.7)[0]);
}

TEST(PxrCamera, NamesWhatHasNoEffect) {
  TestProjection p(kName, {{"radial1", 0.5f}, {"squeeze", 1}, {"natural", 1}}, frame(64, 48));
  ASSERT_EQ(p.warnings.size(), 1u);
  EXPECT_NE(p.warnings[0].find("'radial1', 'natural'"), std::string::npos) << p.warnings[0];
}
}  // namespace
}  // namespace kinora
