// Proves: a portal of an even dome is a rectangle of the dome's radiance (closed form); with a map, and the dome turned
// any way, its irradiance is the integral of the map over the rectangle in double precision, whether sampled or looked
// at; samples have the density of what is seen, from near, far and aslant, and light paths that of what passes; densities
// and widths agree; a dome that turns is at each time what a still one is that stands so, for samples, rays and light paths;
// a matrix and turns that are none are told. Misses: which dome a scene's portal shows
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

// Standard deviation over mean of what samples bring, by solid angle: 0 where their density is that of the radiance.
double noiseOf(const TestLight& light, Vec P) {
  Rays r(64 * 64);
  fillGrid(r.a[3], r.a[4], 64, 1);
  for (int c = 0; c < 3; ++c) std::fill(r.a[c].begin(), r.a[c].end(), float(P[size_t(c)]));
  light.sample(r);
  double sum = 0, squares = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    EXPECT_GT(r.a[12][i], 0);
    const double x = mean3(r, 9, i) / r.a[12][i];
    sum += x;
    squares += x * x;
  }
  const double mean = sum / r.n;
  return std::sqrt(squares / r.n - mean * mean) / mean;
}

TEST(PxrPortalLight, SamplesWhatIsSeen) {
  // a sun of 6 x 8 texels of a fine map, and of 2 x 2 of a coarse one
  const Picture even(64, 32, smooth),
      fine(2048, 1024,
           [](double u, double v, int) {
             return std::fabs(u - 0.3) < 0.0016 && std::fabs(v - 0.2) < 0.004 ? 20000.f : 0.05f;
           }),
      coarse(128, 64, [](double u, double v, int) {
        return std::fabs(u - 0.3) < 0.008 && std::fabs(v - 0.2) < 0.016 ? 1000.f : 0.05f;
      });
  // towards the sun: at u .3 of the dome's local xy plane, a fifth of pi from its pole
  const double phi = -0.3 * 2 * kPi, theta = 0.2 * kPi;
  const Vec toSun{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
  for (const auto& [picture, most] : {std::pair(&even, 0.15), std::pair(&fine, 1.0), std::pair(&coarse, 1.0)})
    for (const Vec& z : {toSun * -1.0, unit(Vec{0.2, 0.1, -1})}) {
      const std::vector<float> turn = toDome(z, {1, 1, 1}, 1);
      const Matrix m = turned(2, 0.7, 1, {1, 2, 3});
      const auto row = [&](size_t i) { return Vec{m[4 * i], m[4 * i + 1], m[4 * i + 2]}; };
      TestLight light(kName, {kMapped, Setting{"portalToDome", turn, ""}}, m, &picture->image);
      Vec local;  // the sun's direction, in the portal's axes
      for (size_t i = 0; i < 3; ++i) local[i] = dot(toSun, {turn[4 * i], turn[4 * i + 1], turn[4 * i + 2]});
      ASSERT_LT(local[2], -0.3);
      const Vec towards = unit(row(0)) * local[0] + unit(row(1)) * local[1] + unit(row(2)) * local[2];
      // points that see the sun through the middle and off it, near and far, and one that does not
      for (const double far : {0.05, 0.5, 1.5, 3.0})
        for (const double off : {0.0, 0.3})
          EXPECT_LT(noiseOf(light, Vec{1, 2, 3} - towards * far + row(0) * off), most) << far << ' ' << off;
      EXPECT_LT(noiseOf(light, Vec{1, 2, 3} - towards * 0.3 + row(0) * 1.2), most);
      EXPECT_NEAR(emittedPower(light), light.description.power, 0.03 * light.description.power);
    }
}

TEST(PxrPortalLight, DensitiesAndWidthsAgree) {
  for (const auto picture : {smooth, sun, patches}) {
    const Picture dome(64, 32, picture);
    TestLight light(kName, {kMapped}, turned(2, 0.3, 1, {1, 2, 3}), &dome.image);
    expectDensitiesAgree(light, pointsAround(light, 20, 0.2, 8));
    expectWidthsAgree(light, pointsAround(light, 20, 0.2, 8));
    expectNoNaN(light);
  }
}

TEST(PxrPortalLight, RaysThatComeBackHaveTheDensitiesOfLightPaths) {
  for (const auto picture : {smooth, sun, patches}) {
    const Picture dome(64, 32, picture);
    const TestLight light(kName, {kMapped}, turned(2, 0.3, 1, {1, 2, 3}), &dome.image);
    Rays r(1024), back(1024);
    fillGrid(r.a[0], r.a[1], 32, 4);
    fillGrid(r.a[2], r.a[3], 32, 5);
    light.emit(r);
    for (uint32_t i = 0; i < r.n; ++i)
      for (size_t c = 0; c < 3; ++c) {
        back.a[c][i] = r.a[4 + c][i] + r.a[7 + c][i];
        back.a[3 + c][i] = -r.a[7 + c][i];
        back.a[6][i] = 1;
      }
    LightDensityArgs a{};
    const void* one = light.data();
    a.light = &one;
    a.count = r.n;
    for (size_t c = 0; c < 3; ++c) {
      a.o[c] = back.a[c].data();
      a.d[c] = back.a[3 + c].data();
      a.N[c] = back.a[7 + c].data();
    }
    a.t = back.a[6].data();
    a.time = back.a[23].data();
    a.worldRadius = 1;
    a.pdfPosition = back.a[10].data();
    a.pdfDirection = back.a[11].data();
    light.functions().densities(&a);
    uint32_t off = 0;
    for (uint32_t i = 0; i < r.n; ++i) {
      EXPECT_GT(r.a[17][i], 0);
      off += !(std::fabs(back.a[11][i] - r.a[17][i]) <= 1e-3 * r.a[17][i]) || back.a[10][i] != r.a[16][i];
    }
    EXPECT_LE(off, 2u) << "directions between two cells may be either's";
  }
}

// v turned about the unit axis.
Vec turnedAbout(const Vec& axis, double angle, const Vec& v) {
  const Vec across{axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]};
  return v * std::cos(angle) + across * std::sin(angle) + axis * (dot(axis, v) * (1 - std::cos(angle)));
}

TEST(PxrPortalLight, DomesTurnWithTime) {
  const Picture even(64, 32, smooth), bright(64, 32, sun);
  const Matrix m = turned(2, 0.7, 1, {1, 2, 3});
  const auto row = [&](size_t i) { return Vec{m[4 * i], m[4 * i + 1], m[4 * i + 2]}; };
  const Vec about = unit(Vec{0.3, 1, -0.4});
  constexpr size_t kTurns = 33;
  const auto angleAt = [](double time) { return (time - 0.5) * 2; };  // radians
  std::vector<float> turns;
  for (size_t k = 0; k < kTurns; ++k) {
    const double half = angleAt(double(k) / (kTurns - 1)) / 2, side = k % 5 ? 1 : -1;  // q and -q are one turn
    turns.push_back(float(side * std::cos(half)));
    for (size_t c = 0; c < 3; ++c) turns.push_back(float(side * about[c] * std::sin(half)));
  }
  const std::vector<float> atRest = toDome(unit(Vec{0.3, -0.9, 0.2}), {1, 1, 1}, 1);
  for (const Picture* picture : {&even, &bright}) {
    TestLight light(kName, {kMapped, Setting{"portalToDome", atRest, ""}, Setting{"domeTurns", turns, ""}}, m,
                    &picture->image);
    EXPECT_TRUE(light.warnings.empty());
    expectDensitiesAgree(light, pointsAround(light, 20, 0.2, 8));
    expectWidthsAgree(light, pointsAround(light, 20, 0.2, 8));
    expectNoNaN(light);
    for (const double time : {0.0, 0.35, 0.5, 1.0}) {
      // the still one: portal's axes as the dome of that time has them
      std::vector<float> stands(16, 0.f);
      for (size_t j = 0; j < 3; ++j)
        for (size_t i = 0; i < 3; ++i)
          for (size_t k = 0; k < 3; ++k)
            stands[4 * j + k] +=
                float(dot(turnedAbout(about, angleAt(time), unit(row(j))), unit(row(i)))) * atRest[4 * i + k];
      stands[15] = 1;
      TestLight still(kName, {kMapped, Setting{"portalToDome", stands, ""}}, m, &picture->image);
      for (const Vec& p : {Vec{1, 2, 3} + unit(row(2)) * 0.8, Vec{1, 2, 3} + unit(row(2)) * 2 + row(0) * 0.7}) {
        Rays a(128 * 128), b(128 * 128);
        fillGrid(a.a[3], a.a[4], 128, 1);
        for (size_t c = 0; c < 3; ++c) std::fill(a.a[c].begin(), a.a[c].end(), float(p[c]));
        std::fill(a.a[23].begin(), a.a[23].end(), float(time));
        light.sample(a);
        light.evaluate(a);
        for (size_t c = 0; c < 9; ++c) b.a[c] = a.a[c];
        still.evaluate(b);
        double sum = 0, expected = 0, most = 0;
        uint32_t between = 0;
        for (uint32_t i = 0; i < a.n; ++i) most = std::fmax(most, mean3(b, 13, i));
        for (uint32_t i = 0; i < a.n; ++i) {
          ASSERT_GT(a.a[12][i], 0);
          sum += mean3(a, 9, i) / a.a[12][i] / a.n;
          expected += mean3(b, 13, i) / a.a[12][i] / a.n;
          ASSERT_NEAR(mean3(a, 9, i), mean3(b, 13, i), 2e-3 * most) << time;
          ASSERT_NEAR(mean3(a, 13, i), mean3(b, 13, i), 2e-3 * most) << time;
          between += !(std::fabs(a.a[16][i] - a.a[12][i]) <= 1e-4 * a.a[12][i]);
        }
        EXPECT_LE(between, a.n / 1000) << "directions between two cells may be either's";
        EXPECT_NEAR(sum, expected, 2e-3 * expected) << time;
      }
      // light paths, seen by who looks back along them
      Rays out(1024), back(1024);
      fillGrid(out.a[0], out.a[1], 32, 4);
      fillGrid(out.a[2], out.a[3], 32, 5);
      std::fill(out.a[23].begin(), out.a[23].end(), float(time));
      light.emit(out);
      for (uint32_t i = 0; i < out.n; ++i) {
        for (size_t c = 0; c < 3; ++c) {
          back.a[c][i] = out.a[4 + c][i] + out.a[7 + c][i];
          back.a[5 + c][i] = -out.a[7 + c][i];
        }
        back.a[8][i] = 1;
      }
      still.evaluate(back);
      double most = 0;
      for (uint32_t i = 0; i < out.n; ++i) most = std::fmax(most, mean3(back, 13, i));
      ASSERT_GT(most, 0);
      uint32_t off = 0;
      for (uint32_t i = 0; i < out.n; ++i) off += std::fabs(mean3(out, 13, i) - mean3(back, 13, i)) > 2e-3 * most;
      EXPECT_LE(off, 2u) << "of rays near the edge";
    }
  }
}

TEST(PxrPortalLight, WhatAreNoTurnsIsTold) {
  const Picture picture(64, 32, smooth);
  const TestLight still(kName, {kMapped}, identity(), &picture.image);
  for (const std::vector<float>& wrong : {std::vector<float>{1, 0, 0}, std::vector<float>{1, 0, 0, 0},
                                          std::vector<float>(8, 0.f), std::vector<float>{1, 0, 0, 0, 0, 0, 0, 0}}) {
    const TestLight light(kName, {kMapped, Setting{"domeTurns", wrong, ""}}, identity(), &picture.image);
    ASSERT_EQ(light.warnings.size(), 1u);
    EXPECT_NE(light.warnings[0].find("LIGHT-PORTAL"), std::string::npos);
    EXPECT_EQ(irradianceBySampling(light, {0, 0, 1}, {0, 0, -1}, 64),
              irradianceBySampling(still, {0, 0, 1}, {0, 0, -1}, 64));
  }
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
