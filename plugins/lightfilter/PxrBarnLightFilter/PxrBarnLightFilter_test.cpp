// Proves: which points a barn lights, at its edges and corners, by the light's own directions, from its apex, along
// an axis, sheared, and from the light's own origin; soft edges in closed form; the space before it; strength by
// distance; inversion and colour.
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;
constexpr const char* kName = "PxrBarnLightFilter";

// Where the line from P to the light meets z = 0.
Vec crossing(Vec P, Vec light) {
  const double t = P[2] / (P[2] - light[2]);
  return {P[0] + t * (light[0] - P[0]), P[1] + t * (light[1] - P[1]), 0};
}

TEST(PxrBarnLightFilter, AWindowCutsTheLinesToTheLight) {
  const TestFilter f(kName, {{"width", {2}}, {"height", {1}}, {"radius", {0}}});
  const Vec light{0.3, 0.2, -2};
  int open = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec P{-4 + 8 * ((i * 7) % 20 + 0.5) / 20, -2 + 4 * ((i / 20) + 0.5) / 20, 1.7};
    const Vec c = crossing(P, light);
    const bool lit = std::fabs(c[0]) < 1 && std::fabs(c[1]) < 0.5;
    open += lit;
    EXPECT_EQ(f.at(P, light)[0], lit ? 1.f : 0.f) << P[0] << " " << P[1];
  }
  EXPECT_GT(open, 40);
  EXPECT_LT(open, 360);
  // just inside and outside of the edge
  expectGrey(f.at({0.999, 0, 1e-3}, {0.999, 0, -1}), 1);
  expectGrey(f.at({1.001, 0, 1e-3}, {1.001, 0, -1}), 0);
  // an infinitely far light
  expectGrey(f.from({0.5, 0, 3}, {0, 0, -1}, std::numeric_limits<double>::infinity()), 1);
  expectGrey(f.from({1.5, 0, 3}, {0, 0, -1}, std::numeric_limits<double>::infinity()), 0);
  expectGrey(f.from({0, 0, 3}, {0, 0, 1}, 5), 0);
}

TEST(PxrBarnLightFilter, EdgesAreSoftAndCornersRound) {
  const TestFilter f(kName, {{"radius", {0.25f}}, {"edge", {0.5f}}, {"leftEdge", {2}}, {"top", {1}}});
  const auto straight = [&](double x, double y) { return f.from({x, y, 1}, {0, 0, -1}, 5); };
  for (const double d : {-0.1, 0.1, 0.25, 0.4, 0.6}) {
    expectGrey(straight(0.5 + d, 0), 1 - smooth(d / 0.5), 2e-6, "right");
    expectGrey(straight(-0.5 - d, 0), 1 - smooth(d / 1.0), 2e-6, "left");
    expectGrey(straight(0, 1.5 + d), 1 - smooth(d / 0.5), 2e-6, "top");
    // the corner's middle at (.25, -.25)
    const double r = (0.25 + d) / std::sqrt(2.0);
    expectGrey(straight(0.25 + r, -0.25 - r), 1 - smooth(d / 0.5), 2e-6, "corner");
  }
}

TEST(PxrBarnLightFilter, AnalyticProjectionsIgnoreWhereTheLightIsMet) {
  const Vec anywhere[2] = {{3, 1, -1}, {0, 9, -4}};
  for (const Vec& light : anywhere) {
    const TestFilter apex(kName, {{"barnMode", {1}}, {"radius", {0}}, {"apex", {2}}});
    expectGrey(apex.at({0.99, 0, 2}, light), 1);  // a cone from (0, 0, -2): twice as wide at z = 2
    expectGrey(apex.at({1.01, 0, 2}, light), 0);
    const TestFilter along(kName, {{"barnMode", {1}}, {"radius", {0}}, {"directional", {1}}, {"shearX", {0.5f}}});
    expectGrey(along.at({1.49, 0, 2}, light), 1);  // its middle is at x = 1 there
    expectGrey(along.at({0.49, 0, 2}, light), 0);
    Placement place{};
    for (int c = 0; c < 4; ++c) place.localToRender[5 * c] = 1;
    place.localToRender[12] = 1;
    place.localToRender[14] = -1;
    const LightFilterInfo info{&place};
    const TestFilter own(kName, {{"barnMode", {1}}, {"radius", {0}}, {"useLightDirection", {1}}}, {}, {0, 0, 0}, 1,
                         nullptr, &info);
    expectGrey(own.at({-0.01, 0, 1}, light), 1);  // from (1, 0, -1): halfway, (.495, 0, 0)
    expectGrey(own.at({0.01, 0, 1}, light), 0);
  }
}

TEST(PxrBarnLightFilter, BeforeItsPlane) {
  const Numbers n = {{"barnMode", {1}}, {"radius", {0}}, {"apex", {2}}};
  const double expected[3][2] = {{1, 1}, {1, 0}, {0, 0}};
  for (int before = 0; before < 3; ++before) {
    Numbers m = n;
    m["preBarn"] = {float(before)};
    const TestFilter f(kName, m);
    expectGrey(f.at({0.1, 0, -1}, {0, 0, -2}), expected[before][0]);  // the cone is half as wide there
    expectGrey(f.at({0.3, 0, -1}, {0, 0, -2}), expected[before][1]);
    expectGrey(f.at({0.3, 0, 1}, {0, 0, -2}), 1);
  }
}

TEST(PxrBarnLightFilter, StrengthInversionAndColour) {
  Numbers n = {{"radius", {0}},         {"intensity", {0.25f}},      {"densityNear", {1}},
               {"densityNearVal", {0}}, {"densityFar", {3}},         {"densityPow", {2}},
               {"edge", {0.5f}},        {"colorRamp_Knots", {0, 1}}, {"colorRamp_Colors", {1, 1, 1, 1, 0.5f, 0}}};
  const TestFilter f(kName, n);
  const auto behind = [](const TestFilter& k, double x, double z) { return k.from({x, 0, z}, {0, 0, -1}, 50); };
  expectGrey(behind(f, 5, 0.5), 1);  // no strength yet
  // the way is .5, its square .25; the doors' colour (.25, .125, 0)
  expectNear(behind(f, 5, 2), {1 - 0.25f * 0.75f, 1 - 0.25f * 0.875f, 1 - 0.25f}, 1e-6);
  expectNear(behind(f, 5, 9), {0.25f, 0.125f, 0}, 1e-6);
  n["invert"] = {1};
  const TestFilter inverted(kName, n);
  expectGrey(behind(inverted, 0, 9), 0.25);
  expectNear(behind(inverted, 5, 9), {1, 0.5f, 0}, 1e-6);
}

}  // namespace
}  // namespace kinora
