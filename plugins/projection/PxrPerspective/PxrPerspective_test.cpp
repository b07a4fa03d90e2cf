// Proves: rays at known raster positions, screen windows, the circle of confusion, zoom, footprints, and with the
// shared checks that connect() undoes rays() and weighs as they do. Misses: what the renderer does with footprints.
#include "plugins/projection/projection_testing.h"

namespace kinora {
namespace {
using namespace projectionTesting;
constexpr const char* kName = "PxrPerspective";

TEST(PxrPerspective, FovCoversTheShorterSide) {
  TestProjection p(kName, {{"fov", 60}}, frame(200, 100));
  const double s = std::tan(3.14159265358979 / 6);
  auto r = p.ray(100, 50);
  EXPECT_NEAR(r[3], 0, 1e-6);
  EXPECT_NEAR(r[4], 0, 1e-6);
  EXPECT_NEAR(r[5], 1, 1e-6);
  r = p.ray(100, 0);  // top: +y
  EXPECT_NEAR(r[4] / r[5], s, 1e-5);
  r = p.ray(0, 100);  // left bottom
  EXPECT_NEAR(r[3] / r[5], -2 * s, 1e-5);
  EXPECT_NEAR(r[4] / r[5], -s, 1e-5);
  TestProjection tall(kName, {{"fov", 60}}, frame(100, 200));
  r = tall.ray(100, 0);
  EXPECT_NEAR(r[3] / r[5], s, 1e-5);
  EXPECT_NEAR(r[4] / r[5], 2 * s, 1e-5);
}

TEST(PxrPerspective, ScreenWindowScalesThePlane) {
  ProjectionInfo info = frame(100, 100);
  info.screenWindowGiven = 1;
  info.screenWindow[0] = 0;
  info.screenWindow[1] = 0.5f;
  info.screenWindow[2] = -1;
  info.screenWindow[3] = 1;
  TestProjection p(kName, {{"fov", 60}}, info);
  const double s = std::tan(3.14159265358979 / 6);
  const auto r = p.ray(100, 50);
  EXPECT_NEAR(r[3] / r[5], 0.5 * s, 1e-5);
  EXPECT_NEAR(r[4], 0, 1e-6);
}

TEST(PxrPerspective, CircleOfConfusion) {
  ProjectionInfo info = frame(100, 100);
  info.fStop = 2;
  info.focalLength = 0.4f;
  info.focalDistance = 5;
  TestProjection p(kName, {}, info);
  // lens of diameter 0.4 / 2; at z the circle has the radius R |z - focus| / focus
  for (double z : {2.5, 5.0, 20.0}) {
    Columns c(4096);
    fill(c, info, 1);
    std::fill(c.a[0].begin(), c.a[0].end(), 30.f);
    std::fill(c.a[1].begin(), c.a[1].end(), 80.f);
    p.rays(c);
    const double sx = -0.4, sy = -0.6;  // of the pinhole's ray at unit z, fov 90
    double most = 0, sum2 = 0, widest = 0;
    for (uint32_t i = 0; i < c.n; ++i) {
      const double t = z / c.a[10][i];
      const double dx = c.a[5][i] + t * c.a[8][i] - sx * z, dy = c.a[6][i] + t * c.a[9][i] - sy * z;
      most = std::fmax(most, std::sqrt(dx * dx + dy * dy));
      sum2 += (dx * dx + dy * dy) / c.n;
      widest = std::fmax(widest, std::hypot(c.a[5][i], c.a[6][i]));
    }
    const double radius = 0.1 * std::fabs(z - 5) / 5;
    EXPECT_NEAR(widest, 0.1, 1e-3);
    EXPECT_NEAR(most, radius, 0.01 * radius + 1e-5) << z;
    EXPECT_NEAR(sum2, radius * radius / 2, 0.03 * radius * radius + 1e-9) << "evenly over the disk";
  }
  // the plug-in's own numbers replace those of the request, one by one
  TestProjection own(kName, {{"fStop", 4}}, info);
  Columns c(4096);
  fill(c, info, 1);
  own.rays(c);
  double widest = 0;
  for (uint32_t i = 0; i < c.n; ++i) widest = std::fmax(widest, std::hypot(c.a[5][i], c.a[6][i]));
  EXPECT_NEAR(widest, 0.05, 1e-3);
}

// Points of the lens by (u, v) on a grid.
std::vector<std::array<double, 2>> lensPoints(const ProjectionInfo& info) {
  TestProjection p(kName, {}, info);
  constexpr uint32_t kSide = 256;
  Columns c(kSide * kSide);
  for (uint32_t i = 0; i < c.n; ++i) {
    c.a[0][i] = c.a[1][i] = 50;
    c.a[2][i] = (float(i % kSide) + 0.5f) / kSide;
    c.a[3][i] = (float(i / kSide) + 0.5f) / kSide;
  }
  p.rays(c);
  std::vector<std::array<double, 2>> points;
  for (uint32_t i = 0; i < c.n; ++i) points.push_back({c.a[5][i] / 0.1, c.a[6][i] / 0.1});  // in radii of the lens
  return points;
}
ProjectionInfo lens() {
  ProjectionInfo info = frame(100, 100);
  info.fStop = 2;
  info.focalLength = 0.4f;
  info.focalDistance = 5;
  info.apertureRoundness = 1;
  return info;
}

// A regular polygon with corners on the circle, one of them at `angle` from +x; <r^2> = (2 + cos(2 pi / n)) / 6.
TEST(PxrPerspective, ApertureWithStraightSides) {
  constexpr double kPi = 3.14159265358979;
  for (const auto& [sides, angle] : {std::pair<int, double>{3, 0}, {4, 45}, {6, 0}, {6, 20}, {9, -7}}) {
    ProjectionInfo info = lens();
    info.apertureSides = float(sides);
    info.apertureAngle = float(angle);
    info.apertureRoundness = 0;
    double sum = 0, beyond = 0, corner = -1;
    std::array<double, 2> middle{};
    const auto points = lensPoints(info);
    for (const auto& [x, y] : points) {
      sum += (x * x + y * y) / double(points.size());
      middle[0] += x / double(points.size());
      middle[1] += y / double(points.size());
      for (int k = 0; k < sides; ++k) {
        const double a = angle * kPi / 180 + 2 * kPi * (k + 0.5) / sides;
        beyond = std::fmax(beyond, x * std::cos(a) + y * std::sin(a) - std::cos(kPi / sides));
      }
      corner = std::fmax(corner, x * std::cos(angle * kPi / 180) + y * std::sin(angle * kPi / 180));
    }
    EXPECT_LT(beyond, 2e-4) << sides;
    EXPECT_NEAR(corner, 1, 0.02) << sides << " corners, one at " << angle;
    EXPECT_NEAR(sum, (2 + std::cos(2 * kPi / sides)) / 6, 1e-3) << sides;
    EXPECT_NEAR(middle[0], 0, 1e-3);
    EXPECT_NEAR(middle[1], 0, 1e-3);
  }
}

// Sides that bow out and in, and densities that rise and fall: <r^2> by integrals over the shape.
TEST(PxrPerspective, ApertureRoundnessDensityAndAspect) {
  constexpr double kPi = 3.14159265358979;
  for (const auto& [sides, roundness, density] : {std::array<double, 3>{5, 0.5, 0},
                                                  {6, -0.8, 0},
                                                  {3, -1, 0},
                                                  {6, 1, 0},
                                                  {0, 1, 1},
                                                  {0, 1, -1},
                                                  {0, 0, 0.4},
                                                  {7, 0.3, -0.6}}) {
    ProjectionInfo info = lens();
    info.apertureSides = float(sides);
    info.apertureRoundness = float(roundness);
    info.apertureDensity = float(density);
    double above = 0, below = 0;  // over a slice of angle: edge^4 and edge^2
    for (int i = 0; i < 100000; ++i) {
      const double half = sides < 3 ? kPi : kPi / sides, a = half * (i + 0.5) / 100000;
      const double straight = sides < 3 ? 1 : std::cos(half) / std::cos(a),
                   edge = straight + roundness * (1 - straight);
      const double r = sides < 3 ? 1 : edge;
      above += r * r * r * r;
      below += r * r;
    }
    // along the radius: rho (1 + d (2 rho - 1))
    const double d = density, third = (1 - d) / 4 + 2 * d / 5, first = (1 - d) / 2 + 2 * d / 3;
    double sum = 0, largest = 0;
    const auto points = lensPoints(info);
    for (const auto& [x, y] : points) {
      sum += (x * x + y * y) / double(points.size());
      largest = std::fmax(largest, std::hypot(x, y));
    }
    EXPECT_NEAR(sum, above / below * third / first, 2e-3) << sides << ' ' << roundness << ' ' << density;
    EXPECT_LE(largest, 1 + 1e-5);
    EXPECT_GT(largest, 0.95);
  }
  for (const double aspect : {2.0, 0.5}) {
    ProjectionInfo info = lens();
    info.apertureAspect = float(aspect);
    double x2 = 0, y2 = 0;
    for (const auto& [x, y] : lensPoints(info)) {
      x2 += x * x;
      y2 += y * y;
    }
    EXPECT_NEAR(std::sqrt(y2 / x2), aspect, 1e-3 * aspect) << "height over width";
  }
}

TEST(PxrPerspective, ApertureSharedChecks) {
  ProjectionInfo info = lens();
  info.resolution[0] = 64;
  info.resolution[1] = 48;
  info.apertureSides = 5;
  info.apertureAngle = 11;
  info.apertureRoundness = -0.3f;
  info.apertureDensity = 0.7f;
  info.apertureAspect = 1.5f;
  TestProjection p(kName, {{"fov", 50}, {"focalDistance", 4}}, info);
  expectRoundTrip(p);
  expectLightPathsAgree(p, 3, 5);
  expectWidthsAgree(p);
  expectOddPointsUnseen(p);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  info.apertureSides = info.apertureAngle = info.apertureRoundness = info.apertureDensity = info.apertureAspect = nan;
  TestProjection odd(kName, {}, info);
  EXPECT_TRUE(std::isfinite(odd.ray(10, 10, 0.3, 0.7)[0]));
}

TEST(PxrPerspective, FootprintIsHalfAPixel) {
  TestProjection p(kName, {}, frame(100, 100));
  Columns c(1);
  c.a[0][0] = c.a[1][0] = 50;
  p.rays(c);
  EXPECT_NEAR(c.a[13][0], 0.5 * 2 / 100, 1e-6);  // a pixel is 2/100 wide at unit distance
  EXPECT_EQ(c.a[12][0], 0);
  // the solid angles of all pixels together are that of the picture: 4 atan(1 / sqrt 3) * ... = 2 pi / 3 for fov 90
  Columns all(10000);
  for (uint32_t i = 0; i < all.n; ++i) {
    all.a[0][i] = float(i % 100) + 0.5f;
    all.a[1][i] = float(i / 100) + 0.5f;
  }
  p.rays(all);
  double omega = 0;
  for (uint32_t i = 0; i < all.n; ++i) omega += 4.0 * all.a[13][i] * all.a[13][i];
  EXPECT_NEAR(omega, 2 * 3.14159265358979 / 3, 1e-3);
}

TEST(PxrPerspective, ZoomsOverTheShutter) {
  TestProjection p(kName, {{"fov", 90}, {"fovEnd", 60}}, frame(100, 100));
  const auto open = p.ray(100, 50, 0.5, 0.5, 0), close = p.ray(100, 50, 0.5, 0.5, 1);
  EXPECT_NEAR(open[3] / open[5], 1, 1e-5);
  EXPECT_NEAR(close[3] / close[5], std::tan(3.14159265358979 / 6), 1e-5);
  expectRoundTrip(p);
}

TEST(PxrPerspective, ConnectUndoesRays) {
  ProjectionInfo info = frame(640, 480);
  expectRoundTrip(TestProjection(kName, {{"fov", 40}}, info));
  info.fStop = 2;
  info.focalLength = 0.4f;
  info.focalDistance = 3;
  expectRoundTrip(TestProjection(kName, {{"fov", 40}}, info));
}

TEST(PxrPerspective, LightPathsWeighLikeCameraPaths) {
  expectLightPathsAgree(TestProjection(kName, {{"fov", 70}}, frame(64, 48)), 3, 5);
  ProjectionInfo info = frame(64, 48);
  info.fStop = 1;
  info.focalLength = 0.6f;
  info.focalDistance = 2;
  expectLightPathsAgree(TestProjection(kName, {{"fov", 70}}, info), 3, 5);
}

TEST(PxrPerspective, WidthsGiveTheSameBits) {
  ProjectionInfo info = frame(640, 480);
  info.fStop = 2;
  info.focalLength = 0.4f;
  info.focalDistance = 3;
  TestProjection p(kName, {{"fovEnd", 60}}, info);
  expectWidthsAgree(p);
}

TEST(PxrPerspective, BadNumbers) {
  expectBadFramesRefused(kName);
  TestProjection p(kName, {{"fov", 180}}, frame(64, 48));
  ASSERT_TRUE(p.made());
  EXPECT_EQ(p.warnings.size(), 1u);
  expectOddPointsUnseen(p);
  TestProjection nan(kName, {{"fov", std::numeric_limits<float>::quiet_NaN()}}, frame(64, 48));
  ASSERT_TRUE(nan.made());
  EXPECT_EQ(nan.warnings.size(), 1u);
  expectRoundTrip(nan);
}

TEST(PxrPerspective, ClippingHidesFromLightPaths) {
  ProjectionInfo info = frame(64, 48);
  info.clipping[0] = 1;
  info.clipping[1] = 10;
  TestProjection p(kName, {}, info);
  Columns c(3);
  const float z[] = {0.5f, 5, 20};
  for (uint32_t i = 0; i < 3; ++i) c.a[16][i] = z[i];
  p.connect(c);
  EXPECT_EQ(c.a[22][0], 0);
  EXPECT_GT(c.a[22][1], 0);
  EXPECT_EQ(c.a[22][2], 0);
}
}  // namespace
}  // namespace kinora
