// Proves: irradiance by samples, by looking and by Lambert's closed form agree, near, far, behind, tilted and
// sheared; densities agree and integrate to 1; emitted power; maps, shaping and normalisation; widths; placements
// that leave no light. Misses: motion, IES profiles (tests/filters), near distances, which have no effect yet.
#include <algorithm>

#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrRectLight";

// Coaxial parallel squares' closed form: a point on the axis at distance h of a square of side 2a.
double onAxis(double a, double h) {
  const double q = std::sqrt(a * a + h * h);
  return 4 * (a / q) * std::atan(a / q);  // times L / 1: E = 2 L [2 a/q atan(a/q)]
}

TEST(PxrRectLight, IrradianceOnItsAxis) {
  TestLight light(kName, {set("intensity", 3)});
  for (double h : {0.02, 0.3, 1.0, 3.0, 5.0, 40.0}) {
    const double expected = 3 * onAxis(0.5, h);
    EXPECT_NEAR(light.closedForm({0, 0, h}, {0, 0, -1}), expected, 1e-6 * expected) << h;
    EXPECT_NEAR(irradianceBySampling(light, {0, 0, h}, {0, 0, -1}), expected, 5e-4 * expected) << h;
  }
  EXPECT_EQ(irradianceBySampling(light, {0, 0, -1}, {0, 0, 1}), 0) << "emits to the side of +Z only";
  EXPECT_EQ(irradianceBySampling(light, {3, 0, 0}, {-1, 0, 0}), 0) << "dark in its own plane";
}

TEST(PxrRectLight, SamplesAgreeWithLookingAndTheClosedForm) {
  const Matrix sheared = {2, 0.1, 0, 0, 0.7, 1, 0.4, 0, 0, 0, 1, 0, 0.5, 0, 0, 1};
  for (const Matrix& m : {identity(), turned(2, 0.3, 1, {1, 2, 3}), turned(-1, 3, -2, {0, 1, 0}), sheared}) {
    TestLight light(kName, {}, m);
    int compared = 0;
    for (Vec p : pointsAround(light, 25, 0.2, 8)) {
      for (int c = 0; c < 3; ++c) p[size_t(c)] = float(p[size_t(c)]);
      const Vec center{light.description.center[0], light.description.center[1], light.description.center[2]};
      const Vec n = unit(unit(center - p) + Vec{0.4, -0.2, 0.1});
      const double expected = light.closedForm(p, n), got = irradianceBySampling(light, p, n, 256);
      EXPECT_NEAR(got, expected, 3e-3 * expected + 1e-7) << p[0] << ' ' << p[1] << ' ' << p[2];
      if (expected > 0.05 && compared < 5) {
        ++compared;
        const double distance = std::sqrt(dot(center - p, center - p));
        const double half =
            distance > light.description.radius ? std::asin(light.description.radius / distance) : 3.14159265;
        const Looked looked = lookAround(light, p, n, unit(center - p), half, 700);
        // the rectangle's edge crosses cells of the grid of directions: half a per cent at its worst here
        EXPECT_NEAR(looked.irradiance, expected, 6e-3 * expected);
        // by area, the density of grazing directions varies widely, and so does this estimate
        EXPECT_NEAR(looked.pdf, 1, m == sheared ? 1.5e-2 : 6e-3);
      }
    }
    EXPECT_GT(compared, 3);
  }
}

// Samples counted by the rectangle's own cells against the solid angle (or, where the light goes by area, the area)
// of each cell in double precision: finds errors of the warp that integrals average away. Chi-square with 255 degrees
// of freedom: mean 255, standard deviation 23.
TEST(PxrRectLight, SamplesAreEvenInSolidAngle) {
  const double sx = 2, sy = 0.5;
  TestLight light(kName, {}, scaleMove(sx, sy, 1, {0, 0, 0}));
  const Vec points[] = {{0, 0, 0.02},
                        {0.3, 0.2, 0.5},
                        {1.2, 0.1, 0.01},
                        {0.99, 0.24, 0.1},
                        {3, 1, 0.4},
                        {-1.5, 2, 0.9},
                        {0, 0, 4},
                        {2, 0, 3},
                        {1.5, 0.9, 0.3},
                        {4, 4, 0.05},
                        {0, 1, 1.2},
                        {10, 1, 30},
                        {1.1781, 2.3028, 1.3659},
                        {-1.8, 1.5, 0.9},
                        {-1.3, -1.8, 1.1},
                        {0.2, -0.252, 0.0003},
                        {1.001, 0.1, 0.0005}};
  constexpr int kCells = 16;
  for (const Vec& p : points) {
    Rays r(1 << 18);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> u(0, 1 - 6e-8);
    for (uint32_t i = 0; i < r.n; ++i) {
      for (int c = 0; c < 3; ++c) r.a[c][i] = float(p[size_t(c)]);
      r.a[3][i] = float(u(random));
      r.a[4][i] = float(u(random));
    }
    light.sample(r);
    const auto corner = [&](double x, double y) {
      return std::atan((x - p[0]) * (y - p[1]) /
                       (p[2] * std::sqrt((x - p[0]) * (x - p[0]) + (y - p[1]) * (y - p[1]) + p[2] * p[2])));
    };
    const auto solid = [&](double x0, double x1, double y0, double y1) {
      return corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0);
    };
    const double whole = solid(-sx / 2, sx / 2, -sy / 2, sy / 2);
    // which of the two it uses here is its own affair: a constant density is the one by solid angle
    const bool bySolidAngle =
        std::all_of(r.a[12].begin(), r.a[12].begin() + r.n, [&](float pdf) { return pdf == r.a[12][0]; });
    if (bySolidAngle) {
      EXPECT_NEAR(r.a[12][0] * whole, 1, 1e-4) << p[0] << ' ' << p[1] << ' ' << p[2];
    }
    std::vector<double> counts(kCells * kCells, 0);
    for (uint32_t i = 0; i < r.n; ++i) {
      const double t = -p[2] / r.a[7][i];
      const int x = int(((p[0] + t * r.a[5][i]) / sx + 0.5) * kCells),
                y = int(((p[1] + t * r.a[6][i]) / sy + 0.5) * kCells);
      counts[size_t(std::clamp(y, 0, kCells - 1) * kCells + std::clamp(x, 0, kCells - 1))] += 1;
    }
    double chi = 0;
    for (int y = 0; y < kCells; ++y)
      for (int x = 0; x < kCells; ++x) {
        const double share = bySolidAngle
                                 ? solid((double(x) / kCells - 0.5) * sx, (double(x + 1) / kCells - 0.5) * sx,
                                         (double(y) / kCells - 0.5) * sy, (double(y + 1) / kCells - 0.5) * sy) /
                                       whole
                                 : 1.0 / (kCells * kCells);
        const double expected = share * r.n, got = counts[size_t(y * kCells + x)];
        chi += (got - expected) * (got - expected) / std::fmax(expected, 1);
      }
    EXPECT_LT(chi, 255 + 6 * 23) << p[0] << ' ' << p[1] << ' ' << p[2]
                                 << (bySolidAngle ? " by solid angle" : " by area");
  }
}

// The density by solid angle in double precision, for points of all heights over and beside the square.
TEST(PxrRectLight, DensityBySolidAngleIsAccurate) {
  TestLight light(kName, {});
  Rays r(1 << 16);
  std::mt19937 random(1);
  std::normal_distribution<double> g;
  std::uniform_real_distribution<double> u(0, 1);
  for (uint32_t i = 0; i < r.n; ++i) {
    const double spread = 0.01 * std::pow(500, u(random));
    r.a[0][i] = float(g(random) * spread);
    r.a[1][i] = float(g(random) * spread);
    r.a[2][i] = float(1e-4 * std::pow(5e4, u(random)));
    r.a[3][i] = float(u(random) * 0.999);
    r.a[4][i] = float(u(random) * 0.999);
  }
  light.sample(r);
  double worst = 0;
  uint32_t at = 0, count = 0;
  for (uint32_t i = 0; i < r.n; ++i) {
    const double x = r.a[0][i], y = r.a[1][i], z = r.a[2][i];
    const auto corner = [&](double cx, double cy) {
      return std::atan((cx - x) * (cy - y) / (z * std::sqrt((cx - x) * (cx - x) + (cy - y) * (cy - y) + z * z)));
    };
    const double whole = corner(0.5, 0.5) - corner(-0.5, 0.5) - corner(0.5, -0.5) + corner(-0.5, -0.5);
    if (whole < 0.0501) continue;  // by area below that
    ++count;
    const double off = std::fabs(whole * r.a[12][i] - 1);
    if (off > worst) worst = off, at = i;
  }
  EXPECT_GT(count, r.n / 2);
  EXPECT_LT(worst, 2e-4) << r.a[0][at] << ' ' << r.a[1][at] << ' ' << r.a[2][at];
}

TEST(PxrRectLight, DensitiesAgree) {
  for (const Matrix& m : {identity(), turned(10, 0.01, 1, {1, 2, 3}), turned(1, 1, 1, {1000, 0, 0})}) {
    TestLight light(kName, {}, m);
    expectDensitiesAgree(light, pointsAround(light, 200));
  }
  const Matrix sheared = {2, 0.1, 0, 0, 0.7, 1, 0.4, 0, 0, 0, 1, 0, 0.5, 0, 0, 1};
  TestLight light(kName, {set("emissionFocus", 3), set("coneAngle", 60), set("coneSoftness", 0.5f)}, sheared);
  expectDensitiesAgree(light, pointsAround(light, 200));
}

TEST(PxrRectLight, EmittedPower) {
  const double pi = 3.14159265358979;
  {
    TestLight light(kName, {set("intensity", 2), set("lightColor", 1, 0.5f, 0)}, turned(2, 3, 1, {0, 0, 5}));
    EXPECT_NEAR(emittedPower(light), pi * 6 * 2 * 0.5, 1e-3 * pi * 6);
    EXPECT_NEAR(light.description.power, pi * 6, 1e-4 * pi * 6);
    EXPECT_NEAR(light.description.radius, std::sqrt(13.0) / 2, 1e-5);
  }
  {
    TestLight light(kName, {set("areaNormalize", 1)}, turned(2, 3, 1, {0, 0, 5}));
    EXPECT_NEAR(emittedPower(light), pi, 1e-3 * pi);
  }
  for (auto& settings :
       std::vector<std::vector<Setting>>{{set("emissionFocus", 4)},
                                         {set("emissionFocus", 4), set("emissionFocusTint", 0.2f, 0.5f, 0.8f)},
                                         {set("coneAngle", 20), set("coneSoftness", 0.3f)},
                                         {set("coneAngle", 90), set("coneSoftness", 1.5f)}}) {
    TestLight light(kName, settings);
    const double power = emittedPower(light);
    EXPECT_NEAR(power, light.description.power, 3e-3 * power);
  }
  TestLight kept(kName, {set("emissionFocus", 4), set("emissionFocusNormalize", 1)});
  EXPECT_NEAR(emittedPower(kept), pi, 3e-3 * pi);
}

TEST(PxrRectLight, ShapingFollowsTheAngle) {
  TestLight light(kName, {set("coneAngle", 30)}, scaleMove(0.01, 0.01, 1, {0, 0, 0}));
  const auto at = [&](double degrees) {
    const double a = degrees * 3.14159265 / 180;
    return irradianceBySampling(light, {std::sin(a), 0, std::cos(a)}, {-std::sin(a), 0, -std::cos(a)}, 16);
  };
  EXPECT_GT(at(29), 0.8 * at(0) * std::cos(29 * 3.14159265 / 180));
  EXPECT_EQ(at(31), 0);
}

TEST(PxrRectLight, TemperatureAndExposure) {
  // 6500 K is nearly white: R:G:B about 1 : 0.943 : 0.992, of luminance 1
  TestLight light(kName, {set("enableTemperature", 1), set("exposure", 1)});
  Rays r(1);
  r.a[2][0] = 2;
  r.a[3][0] = r.a[4][0] = 0.5f;
  light.sample(r);
  const double red = r.a[9][0], green = r.a[10][0], blue = r.a[11][0];
  EXPECT_NEAR(green / red, 0.943, 0.01);
  EXPECT_NEAR(blue / red, 0.992, 0.02);
  EXPECT_NEAR(0.2126 * red + 0.7152 * green + 0.0722 * blue, 2, 1e-4);
}

TEST(PxrRectLight, MapStandsUprightSeenFromTheFront) {
  // red | green over blue | white
  const float texels[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  const HostImage image{texels, 2, 2, 3};
  TestLight light(kName, {setText("lightColorMap", "map")}, identity(), &image);
  const auto seen = [&](double x, double y) {  // straight from the front
    Rays r(1);
    r.a[0][0] = float(x);
    r.a[1][0] = float(y);
    r.a[2][0] = 1;
    r.a[7][0] = -1;
    r.a[8][0] = 100;
    light.look(r);
    return Vec{r.a[13][0], r.a[14][0], r.a[15][0]};
  };
  EXPECT_EQ(seen(0.45, 0.45), (Vec{1, 0, 0}));  // left edge of the map at +X, top at +Y
  EXPECT_EQ(seen(-0.45, 0.45), (Vec{0, 1, 0}));
  EXPECT_EQ(seen(0.45, -0.45), (Vec{0, 0, 1}));
  EXPECT_EQ(seen(-0.45, -0.45), (Vec{1, 1, 1}));
  expectDensitiesAgree(light, pointsAround(light, 100));
  EXPECT_NEAR(emittedPower(light), light.description.power, 2e-3 * light.description.power);
  TestLight grey(kName, {setText("lightColorMap", "map"), set("colorMapSaturation", 0)}, identity(), &image);
  EXPECT_NEAR(irradianceBySampling(grey, {0, 0, 1}, {0, 0, -1}),
              irradianceBySampling(TestLight(kName, {}), {0, 0, 1}, {0, 0, -1}) / 2, 1e-3);
}

TEST(PxrRectLight, WidthsGiveTheSameBits) {
  TestLight light(kName, {set("emissionFocus", 2), set("coneAngle", 70), set("coneSoftness", 0.2f)},
                  turned(2, 1, 1, {0, 1, 0}));
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrRectLight, DegeneratePlacements) {
  expectDegenerateIsSafe(kName, true);
  TestLight flat(kName, {}, scaleMove(1, 1, 0, {0, 0, 0}));  // no Z: still a rectangle
  EXPECT_NEAR(irradianceBySampling(flat, {0, 0, 1}, {0, 0, -1}), onAxis(0.5, 1), 2e-3);
  TestLight nan(kName, {set("intensity", std::numeric_limits<float>::quiet_NaN())});
  EXPECT_FALSE(nan.warnings.empty());
  expectNoNaN(nan);
}

TEST(PxrRectLight, NamesParametersWithoutEffectOnce) {
  TestLight light(kName,
                  {setText("cheapCausticsExcludeGroup", "balls"), set("msApprox", 0), setText("lightGroup", "key")});
  ASSERT_EQ(light.warnings.size(), 1u);
  EXPECT_NE(light.warnings[0].find("cheapCausticsExcludeGroup"), std::string::npos);
  EXPECT_EQ(light.warnings[0].find("lightGroup"), std::string::npos) << "light path expressions use it";
  EXPECT_EQ(light.warnings[0].find("msApprox"), std::string::npos) << "given, but at its default";
}
}  // namespace
}  // namespace kinora
