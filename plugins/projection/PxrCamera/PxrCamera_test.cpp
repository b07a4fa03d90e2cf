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

TEST(PxrCamera, NamesWhatHasNoEffect) {
  TestProjection p(kName, {{"radial1", 0.5f}, {"squeeze", 1}, {"natural", 1}}, frame(64, 48));
  ASSERT_EQ(p.warnings.size(), 1u);
  EXPECT_NE(p.warnings[0].find("'radial1', 'natural'"), std::string::npos) << p.warnings[0];
}
}  // namespace
}  // namespace kinora
