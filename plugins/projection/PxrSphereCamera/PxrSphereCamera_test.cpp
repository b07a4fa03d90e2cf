// Proves, for PxrSphereCamera and PxrCylinderCamera: rays of chosen raster places in closed form, the way back, the
// densities of light paths, widths, refused sweeps and frames; of these and others that depth of field is told of.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;

void expectRay(const TestProjection& p, double x, double y, double turn, double elevation) {
  const auto r = p.ray(x, y);
  const double d[3] = {std::sin(turn) * std::cos(elevation), std::sin(elevation),
                       std::cos(turn) * std::cos(elevation)};
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(r[c], 0);
    EXPECT_NEAR(r[3 + c], d[c], 1e-6) << x << " " << y;
  }
}

TEST(PxrSphereCamera, RowsAreElevations) {
  const TestProjection p("PxrSphereCamera", {}, frame(64, 32));
  for (double x : {0.0, 16.0, 32.0, 50.5, 64.0})
    for (double y : {1.0, 8.0, 16.0, 31.0}) expectRay(p, x, y, (x / 64 - 0.5) * 2 * M_PI, (0.5 - y / 32) * M_PI);
  const TestProjection part("PxrSphereCamera", {{"hsweep", 90.f}, {"vsweep", 60.f}}, frame(64, 32));
  expectRay(part, 0, 0, -M_PI / 4, M_PI / 6);
  expectRay(part, 64, 16, M_PI / 4, 0);
}

TEST(PxrSphereCamera, ACylindersRowsAreHeights) {
  const TestProjection p("PxrCylinderCamera", {}, frame(64, 32));
  for (double x : {0.0, 20.0, 32.0})
    for (double y : {0.0, 8.0, 16.0, 32.0}) expectRay(p, x, y, (x / 64 - 0.5) * 2 * M_PI, std::atan(1 - y / 16));
}

TEST(PxrSphereCamera, TheWayBackAndLightPaths) {
  for (const char* name : {"PxrSphereCamera", "PxrCylinderCamera"}) {
    const TestProjection whole(name, {}, frame(64, 48)),
        part(name, {{"hsweep", 80.f}, {"vsweep", 50.f}}, frame(64, 48));
    expectRoundTrip(whole);
    expectRoundTrip(part);
    TestProjection widths(name, {}, frame(640, 480));
    expectWidthsAgree(widths);
    expectDensityCounts(part, 64 * 48);
    for (double y : {10.0, 24.0, 40.0}) expectSpreadsArePixels(whole, 20, y);
  }
}

// Of all that have no lens.
TEST(PxrSphereCamera, DepthOfFieldIsTold) {
  for (const char* name : {"PxrSphereCamera", "PxrCylinderCamera", "PxrLightProbe", "OmnidirectionalStereo"}) {
    ProjectionInfo info = frame(64, 48);
    EXPECT_TRUE(TestProjection(name, {}, info).warnings.empty()) << name;
    info.fStop = 2;
    info.focalLength = 0.5f;
    info.focalDistance = 3;
    const TestProjection p(name, {}, info);
    ASSERT_EQ(p.warnings.size(), 1u) << name;
    EXPECT_TRUE(p.warnings[0].starts_with("PROJECTION-LENS")) << p.warnings[0];
    EXPECT_EQ(p.ray(30, 20, 0.9, 0.9), p.ray(30, 20)) << name;
  }
}

TEST(PxrSphereCamera, BadNumbers) {
  for (const char* name : {"PxrSphereCamera", "PxrCylinderCamera"}) {
    for (const char* sweep : {"hsweep", "vsweep"})
      for (float x : {0.f, -1.f, 361.f}) {
        const TestProjection p(name, {{sweep, x}}, frame(64, 48));
        EXPECT_FALSE(p.made());
        EXPECT_FALSE(p.error.empty());
      }
    EXPECT_FALSE(TestProjection(name, {}, ProjectionInfo{}).made());
    const TestProjection p(name, {}, frame(64, 48));
    Columns c(3);
    c.a[15] = {0, 1, NAN};
    c.a[15].resize(padded(3));
    p.connect(c);
    EXPECT_EQ(c.a[22][0], 0) << "at the eye";
    EXPECT_EQ(c.a[22][2], 0);
  }
}

}  // namespace
}  // namespace kinora
