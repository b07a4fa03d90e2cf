// Proves: irradiance by the squared distance, the cone's edge and the beam by RISpec's formula (written here in
// double precision), flux, widths, and that of the placement neither scale nor shear counts. Misses: shadows, which
// are the host's.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PointLight";
constexpr double kPi = 3.14159265358979;

double smoothstep(double a, double b, double x) {
  if (a == b) return x >= a ? 1 : 0;
  const double t = std::fmin(1, std::fmax(0, (x - a) / (b - a)));
  return t * t * (3 - 2 * t);
}
// RISpec A.2, spotlight: what arrives at P from a light at the origin that shines along +z.
double spot(Vec P, double cone, double delta, double beam) {
  const double d2 = dot(P, P), cosine = P[2] / std::sqrt(d2);
  if (cosine < std::cos(cone)) return 0;
  return (beam > 0 ? std::pow(std::fmax(0, cosine), beam) : 1) / d2 *
         smoothstep(std::cos(cone), std::cos(cone - delta), cosine);
}

TEST(PointLight, FallsWithTheSquareOfTheDistance) {
  // a scale and a shear of the placement move nothing
  for (const Matrix& m :
       {identity(), scaleMove(3, -0.2, 5, {0, 0, 0}), Matrix{2, 1, 0, 0, 0, 1, 3, 0, 1, 0, 1, 0, 0, 0, 0, 1}}) {
    TestLight light(kName, {set("intensity", 5)}, m);
    EXPECT_TRUE(light.description.isDelta);
    EXPECT_FALSE(light.description.isInfinite);
    EXPECT_NEAR(light.description.power, 20 * kPi, 1e-4);
    for (const Vec P : {Vec{0, 0, 1}, Vec{0.01, 0, 0}, Vec{30, -40, 0}, Vec{1, 2, -2}}) {
      const Vec n = unit(P * -1.0);
      const double expected = 5 / dot(P, P);
      EXPECT_NEAR(light.closedForm(P, n), expected, 1e-6 * expected);
      EXPECT_NEAR(irradianceBySampling(light, P, n, 4), expected, 1e-5 * expected);
    }
  }
}

TEST(PointLight, TheConeIsRISpecs) {
  for (const auto& [cone, delta, beam] :
       {std::array<double, 3>{30, 5, 2}, {60, 60, 0}, {45, 0, 1}, {1, 0.5, 50}, {120, 100, 0}, {90, 20, 4}}) {
    TestLight light(kName,
                    {set("coneAngle", float(cone)), set("coneDeltaAngle", float(delta)),
                     set("beamDistribution", float(beam)), set("intensity", 3)},
                    scaleMove(1, 1, 2, {0, 0, 0}));
    double sum = 0, largest = 0;
    for (int i = 0; i <= 200; ++i) {
      const double angle = cone * kPi / 180 * 1.05 * (i + 0.37) / 200;
      const Vec P = Vec{std::sin(angle), 0, std::cos(angle)} * 2.0;
      const double expected = 3 * spot(P, cone * kPi / 180, delta * kPi / 180, beam);
      const double got = irradianceBySampling(light, P, unit(P * -1.0), 4);
      EXPECT_NEAR(got, expected, 2e-4 * 3 / 4) << cone << ' ' << delta << ' ' << beam << " at " << angle;
      sum += got;
      largest = std::fmax(largest, got);
    }
    EXPECT_GT(sum, 0);
    EXPECT_GT(largest, 0.7) << "unfaded on the axis: " << 3.0 / 4;
    EXPECT_NEAR(emittedPower(light), light.description.power, 2e-3 * light.description.power);
  }
}

TEST(PointLight, EmitsFromItsPoint) {
  TestLight light(kName, {set("intensity", 2), set("coneAngle", 40)}, turned(1, 1, 1, {0.3, -2, 5}));
  Rays r(64);
  for (uint32_t i = 0; i < r.n; ++i)
    for (int c = 0; c < 4; ++c) r.a[c][i] = float((i * (c + 3) % 64 + 0.5) / 64);
  light.emit(r);
  const Vec z = unit({0.3, -0.8, 0.52});
  for (uint32_t i = 0; i < r.n; ++i) {
    EXPECT_NEAR(r.a[4][i], 0.3, 1e-6);
    EXPECT_NEAR(r.a[5][i], -2, 1e-6);
    EXPECT_NEAR(r.a[6][i], 5, 1e-6);
    EXPECT_GE(r.a[7][i] * z[0] + r.a[8][i] * z[1] + r.a[9][i] * z[2], std::cos(40 * kPi / 180) - 1e-5);
  }
  TestLight round(kName, {set("intensity", 2)});
  EXPECT_NEAR(emittedPower(round), 8 * kPi, 1e-3 * 8 * kPi);
}

TEST(PointLight, WidthsAgreeAndNothingIsNaN) {
  for (const std::vector<Setting>& settings :
       {std::vector<Setting>{}, {set("coneAngle", 30), set("coneDeltaAngle", 10), set("beamDistribution", 2.5f)}}) {
    TestLight light(kName, settings, turned(1, 1, 1, {1, 2, 3}));
    std::vector<Vec> points;
    for (int i = 0; i < 100; ++i)
      points.push_back({1 + std::sin(i) * (1 + i % 7), 2 + std::cos(2.0 * i), 3 + std::sin(3.0 * i) * 4});
    expectWidthsAgree(light, points);
    expectNoNaN(light);
  }
  TestLight flat(kName, {set("coneAngle", 30)}, scaleMove(1, 1, 0, {0, 0, 0}));
  EXPECT_FALSE(flat.warnings.empty());
  EXPECT_EQ(flat.description.power, 0);
  TestLight closed(kName, {set("coneAngle", 0)});
  EXPECT_EQ(closed.description.power, 0);
  expectNoNaN(closed);
}
}  // namespace
}  // namespace kinora
