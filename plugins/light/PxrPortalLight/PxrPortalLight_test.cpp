// Proves: a portal of an even dome is a rectangle of the dome's radiance (closed form); with a map, and the dome turned
// any way, its irradiance is the integral of the map over the rectangle in double precision, whether sampled or looked
// at; densities and widths agree; a matrix that is none is told. Misses: which dome a scene's portal shows
// (tests/truth/portals_test.cpp).
#include "plugins/light/dome_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrPortalLight";
const Setting kMapped = setText("domeColorMap", "map");

TEST(PxrPortalLight, OfAnEvenDomeIsARectangle) {
  for (const Matrix& m : {identity(), turned(2, 0.3, 1, {1, 2, 3})}) {
    TestLight light(kName, {set("intensity", 3), set("intensityMult", 0.5f), set("tint", 0.5f, 1, 1.5f)}, m);
    EXPECT_TRUE(light.warnings.empty());
    TestLight rectangle("PxrRectLight", {set("intensity", 1.5f)}, m);
    for (const Vec& p : pointsAround(light, 25, 0.2, 8)) {
      const Vec center{light.description.center[0], light.description.center[1], light.description.center[2]};
      const Vec n = unit(unit(center - p) + Vec{0.4, -0.2, 0.1});
      const double expected = rectangle.closedForm(p, n);
      EXPECT_NEAR(light.closedForm(p, n), expected, 1e-5 * expected);
      EXPECT_NEAR(irradianceBySampling(light, p, n, 256), expected, 3e-3 * expected + 1e-7);
    }
  }
}

// Rows: the portal's axes in the dome's frame, of any length.
std::vector<float> toDome(const Vec& z, const Vec& lengths, double handedness) {
  Vec x, y;
  frame(unit(z), x, y);
  const Vec rows[3] = {x * (lengths[0] * handedness), y * lengths[1], unit(z) * lengths[2]};
  std::vector<float> m(16, 0.f);
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) m[4 * i + j] = float(rows[i][j]);
  m[15] = 1;
  return m;
}

TEST(PxrPortalLight, ShowsTheDomeThroughTheRectangle) {
  const Picture picture(64, 32, smooth);
  const Matrix m = turned(2, 0.7, 1, {1, 2, 3});
  const auto row = [&](size_t i) { return Vec{m[4 * i], m[4 * i + 1], m[4 * i + 2]}; };
  for (const double hand : {1.0, -1.0})
    for (const Vec& z : {Vec{0, 0, 1}, Vec{0.3, -0.9, 0.2}, Vec{-0.5, 0.1, -0.7}}) {
      TestLight light(kName, {kMapped, Setting{"portalToDome", toDome(z, {2, 0.7, 3}, hand), ""}}, m, &picture.image);
      EXPECT_TRUE(light.warnings.empty());
      const std::vector<float> turn = toDome(z, {1, 1, 1}, hand);
      for (const Vec& p : {Vec{1, 2, 3} + unit(row(2)) * 0.8, Vec{1, 2, 3} + unit(row(2)) * 2 + row(0) * 0.7}) {
        const Vec n = unit(Vec{1, 2, 3} - p);
        // over the rectangle's area, by the midpoint rule
        constexpr int kSide = 300;
        double expected = 0;
        for (int a = 0; a < kSide; ++a)
          for (int b = 0; b < kSide; ++b) {
            const Vec at = Vec{1, 2, 3} + row(0) * ((a + 0.5) / kSide - 0.5) + row(1) * ((b + 0.5) / kSide - 0.5) - p;
            const double d2 = dot(at, at);
            const Vec wi = unit(at);
            const double local[3] = {dot(wi, unit(row(0))), dot(wi, unit(row(1))), dot(wi, unit(row(2)))};
            Vec dome{0, 0, 0};
            for (size_t i = 0; i < 3; ++i)
              for (size_t j = 0; j < 3; ++j) dome[j] += local[i] * double(turn[4 * i + j]);
            expected += lookUp(picture, dome) * -dot(wi, unit(row(2))) * std::fmax(0, dot(wi, n)) / d2 * (2 * 0.7) /
                        (kSide * kSide);
          }
        ASSERT_GT(expected, 0.05);
        EXPECT_NEAR(irradianceBySampling(light, p, n, 512), expected, 2e-3 * expected);
        EXPECT_NEAR(lookAround(light, p, n, n, 1.5, 900).irradiance, expected, 1e-2 * expected);
      }
    }
}

TEST(PxrPortalLight, DensitiesAndWidthsAgree) {
  const Picture picture(64, 32, patches);
  TestLight light(kName, {kMapped}, turned(2, 0.3, 1, {1, 2, 3}), &picture.image);
  expectDensitiesAgree(light, pointsAround(light, 20, 0.2, 8));
  expectWidthsAgree(light, pointsAround(light, 20, 0.2, 8));
  expectNoNaN(light);
}

TEST(PxrPortalLight, WhatIsNoMatrixIsTold) {
  for (const std::vector<float>& wrong :
       {std::vector<float>{1, 2, 3}, std::vector<float>(16, 0.f), std::vector<float>(16, 1.f)}) {
    TestLight light(kName, {Setting{"portalToDome", wrong, ""}});
    ASSERT_EQ(light.warnings.size(), 1u);
    EXPECT_NE(light.warnings[0].find("LIGHT-PORTAL"), std::string::npos);
    EXPECT_GT(irradianceBySampling(light, {0, 0, 1}, {0, 0, -1}), 0.5);
  }
  expectDegenerateIsSafe(kName, true);
}

}  // namespace
}  // namespace kinora
