// Proves: constant domes give pi L, maps are oriented and looked up as the light's text says (independently written
// here in double precision), samples agree with looking for smooth maps, a sun of one texel and odd sizes, densities
// agree and integrate to 1, flux, widths, broken maps and placements. Misses: image files, which are the host's.
#include "plugins/light/dome_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrDomeLight";
const Setting kMapped = setText("lightColorMap", "map");

// Irradiance on a surface facing n by quadrature over the map; finer than its texels.
double irradiance(const Picture& p, Vec n) {
  const int columns = int(p.w) * 8, rows = int(p.h) * 8;
  double sum = 0;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const double theta = kPi * (j + 0.5) / rows, phi = -2 * kPi * (i + 0.5) / columns;
      const Vec d{std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
      const double cosine = dot(d, n);
      if (cosine > 0) sum += lookUp(p, d) * cosine * std::sin(theta);
    }
  return sum * kPi / rows * 2 * kPi / columns;
}

TEST(PxrDomeLight, ConstantGivesPiL) {
  TestLight light(kName, {set("intensity", 2), set("exposure", -1)}, turned(5, 5, 5, {9, 9, 9}));
  EXPECT_NEAR(light.closedForm({0, 0, 0}, {0, 1, 0}), kPi, 1e-6);
  EXPECT_NEAR(irradianceBySampling(light, {3, 1, 2}, unit({1, 2, -1})), kPi, 3e-3 * kPi);
  const Looked looked = lookAround(light, {0, 0, 0}, {0, 1, 0}, {0, 1, 0}, kPi, 512);
  EXPECT_NEAR(looked.irradiance, kPi, 3e-3 * kPi);
  EXPECT_NEAR(looked.pdf, 1, 1e-5);
  EXPECT_NEAR(emittedPower(light), 4 * kPi * kPi * 100, 1e-3 * 4 * kPi * kPi * 100);
}

TEST(PxrDomeLight, Orientation) {
  // four texels around, two rows: told apart by number
  const Picture p(4, 2, [](double u, double v, int c) {
    return c == 0 ? float(std::floor(u * 4) + 10 * std::floor(v * 2)) : 0.f;
  });
  const auto red = [&](const TestLight& light, Vec d) {
    Rays r(1);
    for (int c = 0; c < 3; ++c) r.a[5 + c][0] = float(unit(d)[size_t(c)]);
    light.evaluate(r);
    return r.a[13][0];
  };
  TestLight light(kName, {kMapped}, identity(), &p.image);
  const double h = std::sqrt(0.5);  // texel centres of the upper row are 45 degrees up
  // u = 1/8: an eighth of a turn from +X towards -Y
  EXPECT_NEAR(red(light, {0.5, -0.5, h}), 0, 1e-4);
  EXPECT_NEAR(red(light, {-0.5, -0.5, h}), 1, 1e-4);
  EXPECT_NEAR(red(light, {-0.5, 0.5, h}), 2, 1e-4);
  EXPECT_NEAR(red(light, {0.5, 0.5, h}), 3, 1e-4);
  EXPECT_NEAR(red(light, {-0.5, -0.5, -h}), 11, 1e-4);
  EXPECT_NEAR(red(light, {1, 0, 1}), 1.5, 1e-4) << "periodic: between the last and the first column";
  // Rotate -90 about X turns +Z to +Y (row vectors), as scenes write it for a Y-up world
  TestLight upright(kName, {kMapped}, {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}, &p.image);
  EXPECT_NEAR(red(upright, {-0.5, h, 0.5}), 1, 1e-4);  // local (-.5, -.5, h): y becomes -z
  // mirrored in X: u runs the other way
  TestLight mirrored(kName, {kMapped}, scaleMove(-3, 3, 3, {1, 1, 1}), &p.image);
  EXPECT_NEAR(red(mirrored, {0.5, -0.5, h}), 1, 1e-4);
}

TEST(PxrDomeLight, SamplesAgreeWithQuadrature) {
  for (const auto f : {&smooth, &sun, &patches}) {
    const Picture p(100, 51, f);
    TestLight light(kName, {kMapped}, identity(), &p.image);
    for (Vec n : {Vec{0, 0, 1}, Vec{0, 0, -1}, unit({1, -1, 0.3})}) {
      const double expected = irradiance(p, n);
      // away from the sun few samples are left, about one of 500, since rays find that light as well: three deviations
      const bool isAway = f == &sun && n[2] < 0;
      const uint32_t side = isAway ? 1536 : 512;
      const double tolerance = isAway ? 3 / std::sqrt(side * side / 500.) : 3e-3;
      EXPECT_NEAR(irradianceBySampling(light, {0, 0, 0}, n, side), expected, tolerance * expected + 1e-6);
    }
    const Looked looked = lookAround(light, {0, 0, 0}, {0, 0, 1}, {0, 0, 1}, kPi, 1500);
    EXPECT_NEAR(looked.pdf, 1, f == &sun ? 3e-2 : 3e-3);  // a texel of the sun is met by few of the directions
  }
}

TEST(PxrDomeLight, DensitiesAgreeAndNoValueLacksOne) {
  const Picture tiny(1, 1, smooth), strip(64, 1, smooth), column(1, 64, smooth);
  const Picture a(100, 51, sun), b(33, 20, patches);
  for (const Picture* p : {&tiny, &strip, &column, &a, &b}) {
    TestLight light(kName, {kMapped}, turned(1, 1, 1, {0, 0, 0}), &p->image);
    expectDensitiesAgree(light, std::vector<Vec>(64, Vec{0, 0, 0}));
    Rays r(200000);
    std::mt19937 random(1);
    std::normal_distribution<double> g;
    for (uint32_t i = 0; i < r.n; ++i) {
      const Vec d = unit({g(random), g(random), g(random)});
      for (int c = 0; c < 3; ++c) r.a[5 + c][i] = float(d[size_t(c)]);
    }
    light.look(r);
    uint32_t bare = 0;
    // rounding may look a hair across a cell's edge: values there are near 0
    for (uint32_t i = 0; i < r.n; ++i) bare += r.a[16][i] <= 0 && mean3(r, 13, i) > 1e-4;
    EXPECT_EQ(bare, 0u) << p->w << ' ' << p->h;
  }
}

TEST(PxrDomeLight, MapsFinerThanTheDistribution) {
  const Picture p(3001, 1501, patches);
  TestLight light(kName, {kMapped}, identity(), &p.image);
  expectDensitiesAgree(light, std::vector<Vec>(64, Vec{0, 0, 0}));
  // mean radiance 2 over u in 25 % of the circle, v in [.1, .6]
  const double solid = 0.25 * 2 * kPi * (std::cos(0.1 * kPi) - std::cos(0.6 * kPi));
  EXPECT_NEAR(light.description.power, 2 * solid, 5e-3 * solid);
  EXPECT_NEAR(irradianceBySampling(light, {0, 0, 0}, {0, 0, 1}),
              0.25 * 2 * kPi * 0.5 * (1 - std::pow(std::sin(0.1 * kPi), 2)) * 2, 1e-2);
}

TEST(PxrDomeLight, MapAdjustments) {
  const Picture p(8, 4, [](double, double, int c) { return c == 0 ? 4.f : 1.f; });
  TestLight gamma(kName, {kMapped, set("colorMapGamma", 2, 2, 2)}, identity(), &p.image);
  EXPECT_NEAR(irradianceBySampling(gamma, {0, 0, 0}, {0, 0, 1}), kPi * (2 + 1 + 1) / 3, 1e-2);
  TestLight grey(kName, {kMapped, set("colorMapSaturation", 0)}, identity(), &p.image);
  EXPECT_NEAR(irradianceBySampling(grey, {0, 0, 0}, {0, 0, 1}), kPi * (4 * 0.2126 + 0.7874), 2e-2);
}

TEST(PxrDomeLight, EmitsThroughTheWholeWorld) {
  const Picture p(100, 51, sun);
  TestLight light(kName, {kMapped}, turned(1, 1, 1, {0, 0, 0}), &p.image);
  light.worldRadius = 3;
  EXPECT_NEAR(emittedPower(light), light.description.power * kPi * 9, 5e-3 * light.description.power * kPi * 9);
}

TEST(PxrDomeLight, WidthsGiveTheSameBits) {
  const Picture p(100, 51, sun);
  TestLight light(kName, {kMapped}, turned(1, 1, 1, {0, 0, 0}), &p.image);
  expectWidthsAgree(light, pointsAround(light, 301));
}

TEST(PxrDomeLight, BrokenMaps) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Picture p(8, 4, smooth);
  p.texels[5] = nan;
  p.texels[17] = std::numeric_limits<float>::infinity();
  TestLight light(kName, {kMapped}, identity(), &p.image);
  EXPECT_EQ(light.warnings.size(), 1u);
  expectNoNaN(light);
  const Picture black(8, 4, [](double, double, int) { return 0.f; });
  TestLight dark(kName, {kMapped}, identity(), &black.image);
  EXPECT_EQ(dark.description.power, 0);
  expectNoNaN(dark);
  const HostImage empty{p.texels.data(), 0, 4, 3}, huge{p.texels.data(), 1u << 19, 1u << 19, 3};
  for (const HostImage* image : {&empty, &huge}) {
    TestLight without(kName, {kMapped}, identity(), image);
    EXPECT_EQ(without.warnings.size(), 2u);
    EXPECT_NEAR(irradianceBySampling(without, {0, 0, 0}, {0, 0, 1}, 64), 0.25 * kPi, 5e-3);
  }
  TestLight missing(kName, {kMapped});
  EXPECT_TRUE(missing.made());
  const HostImage greyscale{p.texels.data() + 24, 4, 4, 1};
  TestLight one(kName, {kMapped}, identity(), &greyscale);
  expectDensitiesAgree(one, std::vector<Vec>(64, Vec{0, 0, 0}));
}

TEST(PxrDomeLight, DegeneratePlacements) {
  expectDegenerateIsSafe(kName, false);
  TestLight flat(kName, {}, scaleMove(1, 1, 0, {0, 0, 0}));
  EXPECT_EQ(flat.description.power, 0);
  EXPECT_EQ(flat.warnings.size(), 1u);
}
}  // namespace
}  // namespace kinora
