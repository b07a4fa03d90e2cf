// Proves: shift, roll, tilt, squeeze, size, distortion and vignetting for camera and light paths, depth of field from its
// own parameters, the magnifier, the shared checks, and the message about parameters that change nothing. Lens and raster
// in general: PxrPerspective's test.
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

TEST(PxrCamera, SqueezeAndSize) {
  TestProjection p(kName, {{"squeeze", 2}, {"lensScale", 4}, {"shiftX", 0.5f}}, frame(100, 100));
  EXPECT_TRUE(p.warnings.empty());
  const auto r = p.ray(100, 0);
  EXPECT_NEAR(r[3] / r[5], 1.5 * 2 / 4, 1e-6);
  EXPECT_NEAR(r[4] / r[5], 1. / 4, 1e-6);
  expectRoundTrip(p);
  expectLightPathsAgree(p, 3, 5);
  for (const char* name : {"squeeze", "lensScale"}) {
    TestProjection bad(kName, {{name, 0.f}}, frame(100, 100));
    ASSERT_EQ(bad.warnings.size(), 1u);
    EXPECT_NE(bad.warnings[0].find(name), std::string::npos);
    EXPECT_NEAR(bad.ray(100, 0)[3] / bad.ray(100, 0)[5], 1, 1e-6);
  }
}

// At 45 degrees off the axis the fourth power of the cosine is a quarter.
TEST(PxrCamera, NaturalVignetting) {
  for (const float natural : {0.f, 0.4f, 1.f}) {
    TestProjection p(kName, {{"natural", natural}}, frame(100, 100));
    EXPECT_TRUE(p.warnings.empty());
    Columns c(2);
    c.a[0][0] = c.a[1][0] = c.a[1][1] = 50;
    c.a[0][1] = 100;
    p.rays(c);
    EXPECT_NEAR(c.a[11][0], 1, 1e-6);
    EXPECT_NEAR(c.a[11][1], 1 - 0.75 * natural, 1e-6);
  }
  TestProjection p(kName, {{"natural", 0.7f}, {"fov", 70}, {"fStop", 1}, {"focalLength", 0.3f}, {"focalDistance", 4}},
                   frame(64, 48));
  expectRoundTrip(p);
  expectLightPathsAgree(p, 3, 5);
  expectWidthsAgree(p);
  expectOddPointsUnseen(p);
  TestProjection bad(kName, {{"natural", 3}}, frame(100, 100));
  ASSERT_EQ(bad.warnings.size(), 1u);
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

// Where a point of the ideal picture is shown, and how the picture is stretched there, by differences.
TEST(PxrCamera, Distortion) {
  static const float kCenter[3] = {0.1f, -0.2f, 0};
  struct {
    float radial1, radial2, x, y;
    bool isWhole;  // the polynomial reaches the picture's corners
  } const kLenses[] = {{0.2f, 0, 0, 0, true},    {-0.03f, 0, 0, 0, true}, {-0.05f, 0.03f, 0.02f, -0.04f, true},
                       {0, 0.1f, 0.1f, 0, true}, {-0.4f, 0, 0, 0, false}, {0, -0.2f, 0, 0, false}};
  for (const auto& k : kLenses) {
    const std::vector<Setting> settings = {{"fov", 60},
                                           {"radial1", k.radial1},
                                           {"radial2", k.radial2},
                                           {"assymX", k.x / 2},
                                           {"lensAsymmetryX", k.x / 2},
                                           {"assymY", k.y},
                                           {"distortionCtr", kCenter}};
    TestProjection p(kName, settings, frame(60, 40));
    EXPECT_TRUE(p.warnings.empty());
    int shown = 0;
    for (double x = 0.5; x < 60; x += 3)
      for (double y = 0.5; y < 40; y += 3) {
        Columns c(1);
        c.a[0][0] = float(x);
        c.a[1][0] = float(y);
        p.rays(c);
        if (c.a[11][0] == 0) continue;
        ++shown;
        EXPECT_EQ(c.a[11][0], 1);
        const double scale = std::tan(30 * 3.14159265358979 / 180) * c.a[10][0];
        const double px = c.a[8][0] / scale - kCenter[0], py = c.a[9][0] / scale - kCenter[1], r2 = px * px + py * py;
        EXPECT_NEAR(px * (1 + (k.radial1 + k.x) * r2 + k.radial2 * r2 * r2) + kCenter[0], x / 20 - 1.5, 2e-5);
        EXPECT_NEAR(py * (1 + (k.radial1 + k.y) * r2 + k.radial2 * r2 * r2) + kCenter[1], 1 - y / 20, 2e-5);
      }
    if (k.isWhole) {
      EXPECT_EQ(shown, 20 * 14);
      expectRoundTrip(p);
      expectLightPathsAgree(p, 3, 8);
    } else {
      EXPECT_LT(shown, 20 * 14 - 10);
      EXPECT_GT(shown, 30);
    }
    expectWidthsAgree(p);
    expectOddPointsUnseen(p);
    // what the lens folds back is not shown: points farther and farther out are found in the picture once
    double last = 0;
    bool isOut = false;
    for (int i = 0; i < 200; ++i) {
      Columns c(1);
      c.a[14][0] = float((kCenter[0] + i * 0.02) * std::tan(30 * 3.14159265358979 / 180));
      c.a[15][0] = float(kCenter[1] * std::tan(30 * 3.14159265358979 / 180));
      c.a[16][0] = 1;
      p.connect(c);
      isOut = isOut || c.a[22][0] == 0;
      EXPECT_EQ(c.a[22][0] == 0, isOut) << i;
      if (!isOut) {
        EXPECT_GT(c.a[20][0], last) << i;
      }
      last = c.a[20][0];
    }
    EXPECT_TRUE(isOut);
  }
}

// The hood and the lens are disks of one size: with depth of field the share of the lens that sees through both, without
// it the picture's weight is their overlap.
TEST(PxrCamera, OpticalVignetting) {
  const auto overlap = [](double d) {
    return d >= 2 ? 0 : (2 * std::acos(d / 2) - d / 2 * std::sqrt(4 - d * d)) / 3.14159265358979;
  };
  for (const float optical : {0.3f, 1.f}) {
    const std::vector<Setting> pinhole = {{"fov", 70}, {"optical", optical}};
    std::vector<Setting> lens = pinhole;
    lens.insert(lens.end(), {{"fStop", 1}, {"focalLength", 0.3f}, {"focalDistance", 4}});
    TestProjection sharp(kName, pinhole, frame(64, 48)), blurred(kName, lens, frame(64, 48));
    EXPECT_TRUE(sharp.warnings.empty() && blurred.warnings.empty());
    for (const auto& [x, y] : {std::pair(32., 24.), std::pair(63., 24.), std::pair(5., 45.)}) {
      const double expected = overlap(optical * std::hypot(x / 24 - 32. / 24, 1 - y / 24));
      Columns one(1);
      one.a[0][0] = float(x);
      one.a[1][0] = float(y);
      sharp.rays(one);
      EXPECT_NEAR(one.a[11][0], expected, 2e-6);
      Columns many(64 * 64);
      double sum = 0;
      for (uint32_t i = 0; i < many.n; ++i) {
        many.a[0][i] = float(x);
        many.a[1][i] = float(y);
        many.a[2][i] = (float(i % 64) + 0.5f) / 64;
        many.a[3][i] = (float(i / 64) + 0.5f) / 64;
      }
      blurred.rays(many);
      for (uint32_t i = 0; i < many.n; ++i) sum += many.a[11][i];
      EXPECT_NEAR(sum / many.n, expected, 0.01);
    }
    expectRoundTrip(sharp);
    expectLightPathsAgree(sharp, 3, 5);
    expectWidthsAgree(blurred);
    expectOddPointsUnseen(blurred);
  }
}

// The plane of focus of a tilted lens meets the plane of the lens at focalLength / sin(tilt) above its middle.
TEST(PxrCamera, Tilt) {
  const double length = 0.2, slope = std::sin(5 * 3.14159265358979 / 180) / length;
  TestProjection p(kName,
                   {{"fov", 50}, {"fStop", 2}, {"focalLength", float(length)}, {"focalDistance", 4}, {"tilt", 5}},
                   frame(64, 48));
  EXPECT_TRUE(p.warnings.empty());
  for (double x : {5., 32., 60.})
    for (double y : {3., 24., 45.}) {
      const auto middle = p.ray(x, y);
      // y slope + z / 4 = 1
      const double t = 1 / (middle[4] * slope + middle[5] / 4);
      if (t < 0) continue;  // sharp behind the camera
      for (double u : {0.1, 0.9}) {
        const auto r = p.ray(x, y, u, 0.7);
        const double s = (1 - r[1] * slope) / (r[4] * slope + r[5] / 4);
        for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(r[c] + s * r[c + 3], t * middle[c + 3], 2e-5 * t);
      }
    }
  expectRoundTrip(p);
  expectWidthsAgree(p);
  TestProjection steep(kName, {{"fStop", 0.5f}, {"focalLength", 0.2f}, {"focalDistance", 4}, {"tilt", 89}},
                       frame(64, 48));
  ASSERT_EQ(steep.warnings.size(), 1u);
  EXPECT_NE(steep.warnings[0].find("PROJECTION-FOCUS"), std::string::npos);
}

TEST(PxrCamera, MagnifierFootprintsAndSizeOfTheLens) {
  static const float kAt[3] = {0.5f, -0.25f, 4};
  const auto at = [](const TestProjection& p, int what) {
    Columns c(1);
    c.a[0][0] = c.a[1][0] = 50;
    c.a[2][0] = 0.9f;
    c.a[3][0] = 0.3f;
    p.rays(c);
    return double(c.a[size_t(what)][0]);
  };
  TestProjection plain(kName, {{"fov", 60}}, frame(100, 100)),
      zoomed(kName, {{"fov", 60}, {"enhance", kAt}}, frame(100, 100));
  EXPECT_TRUE(zoomed.warnings.empty());
  const double scale = std::tan(30 * 3.14159265358979 / 180);
  auto r = zoomed.ray(50, 50);
  EXPECT_NEAR(r[3] / r[5], 0.5 * scale, 1e-6);
  EXPECT_NEAR(r[4] / r[5], -0.25 * scale, 1e-6);
  r = zoomed.ray(100, 0);
  EXPECT_NEAR(r[3] / r[5], 0.75 * scale, 1e-6);
  EXPECT_NEAR(r[4] / r[5], 0, 1e-6);
  expectRoundTrip(zoomed);
  const auto rim = zoomed.ray(50, 50);  // the same direction in the whole picture
  const double cosine = rim[5], dimmer = std::pow(cosine, 1.5);
  EXPECT_NEAR(at(zoomed, 13) / at(plain, 13), dimmer, 1e-4);
  TestProjection fine(kName, {{"fov", 60}, {"enhance", kAt}, {"enhanceDiffAdjust", 1}}, frame(100, 100));
  EXPECT_NEAR(at(fine, 13) / at(plain, 13), dimmer / 4, 1e-4);
  TestProjection coarse(kName, {{"fov", 60}, {"detail", 1.5f}}, frame(100, 100));
  EXPECT_NEAR(at(coarse, 13) / at(plain, 13), std::exp2(1.5), 1e-4);
  const std::vector<Setting> lens = {{"fStop", 1}, {"focalLength", 0.6f}, {"focalDistance", 4}};
  std::vector<Setting> twice = lens, none = lens;
  twice.emplace_back("dofMult", 2.f);
  none.insert(none.end(), {{"enhance", kAt}, {"enhanceDisableDOF", 1}});
  EXPECT_NEAR(at(TestProjection(kName, twice, frame(100, 100)), 5),
              2 * at(TestProjection(kName, lens, frame(100, 100)), 5), 1e-6);
  EXPECT_EQ(at(TestProjection(kName, none, frame(100, 100)), 5), 0);
  static const float kBad[3] = {0, 0, -1};
  TestProjection bad(kName, {{"enhance", kBad}}, frame(100, 100));
  ASSERT_EQ(bad.warnings.size(), 1u);
}

TEST(PxrCamera, NamesWhatHasNoEffect) {
  TestProjection p(kName, {{"lensType", 1}, {"squeeze", 1}, {"splitDiopterAngle", 1}}, frame(64, 48));
  ASSERT_EQ(p.warnings.size(), 1u);
  EXPECT_NE(p.warnings[0].find("'lensType', 'splitDiopterAngle'"), std::string::npos) << p.warnings[0];
}
}  // namespace
}  // namespace kinora
