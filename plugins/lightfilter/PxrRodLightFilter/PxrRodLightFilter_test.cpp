// Proves: the rod's factor within, outside and at chosen distances into its soft edge, on faces and at round corners,
// with a side, its edge and a scale of its own, by linear and B-spline falloff, inverted, tinted and in part; that a
// broken ramp is told; that PxrBlockerLightFilter is the same shape. Misses: influence on diffuse and specular alone,
// and saturation (tests/truth).
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;

const Numbers kLinear = {{"falloff_Knots", {0, 1}}, {"falloff_Floats", {0, 1}}, {"edge", {0.5f}}};
const Texts kLine = {{"falloff_Interpolation", "linear"}};
Numbers with(Numbers a, const Numbers& b) {
  for (const auto& [name, value] : b) a[name] = value;
  return a;
}

TEST(PxrRodLightFilter, IsASphereByDefaultAndFallsOffWithDistance) {
  for (const char* name : {"PxrRodLightFilter", "PxrBlockerLightFilter"}) {
    const TestFilter f(name, kLinear, kLine, {1, 2, 3}, 2);  // radius 2 and an edge of 1 in render space
    const double s = 1 / std::sqrt(3.0);
    for (const Vec d : {Vec{1, 0, 0}, Vec{0, -1, 0}, Vec{s, s, -s}})
      for (const double r : {0.0, 0.5, 1.99, 2.25, 2.5, 2.9, 3.1, 40.0})
        expectGrey(f.at({1 + r * d[0], 2 + r * d[1], 3 + r * d[2]}), std::fmin(1, std::fmax(0, r - 2)), 2e-6,
                   name + std::string(" at ") + std::to_string(r));
  }
}

TEST(PxrRodLightFilter, ABoxHasRoundCorners) {
  const TestFilter f("PxrRodLightFilter",
                     with(kLinear, {{"width", {2}}, {"height", {4}}, {"depth", {6}}, {"radius", {0.25f}}}), kLine);
  const auto distance = [](Vec p) {
    double d2 = 0;
    const double half[3] = {1, 2, 3};
    for (size_t c = 0; c < 3; ++c) d2 += std::pow(std::fmax(0, std::fabs(p[c]) - half[c]), 2);
    return std::sqrt(d2) - 0.25;
  };
  for (const Vec p : {Vec{0.9, 1.9, -2.9}, Vec{1.5, 0, 0}, Vec{0, -2.6, 1}, Vec{0, 0, 3.4}, Vec{1.2, 2.3, 0},
                      Vec{-1.2, 2.2, 3.3}, Vec{1.9, 0, 0}, Vec{1.3, 2.3, -3.3}})
    expectGrey(f.at(p), std::fmin(1, std::fmax(0, distance(p) / 0.5)), 2e-6);
}

TEST(PxrRodLightFilter, SidesHaveTheirOwnExtentEdgeAndScale) {
  const TestFilter f("PxrRodLightFilter",
                     with(kLinear, {{"width", {2}},
                                    {"height", {2}},
                                    {"depth", {2}},
                                    {"radius", {0}},
                                    {"right", {0.5f}},
                                    {"rightEdge", {2}},
                                    {"back", {1}},
                                    {"scaleHeight", {3}}}),
                     kLine);
  expectGrey(f.at({-1.25, 0, 0}), 0.5);       // plain side: box to -1, edge .5
  expectGrey(f.at({1.5, 0, 0}), 0);           // moved side
  expectGrey(f.at({2.0, 0, 0}), 0.5);         // its edge is 1 wide
  expectGrey(f.at({0, 0, 2.125}), 0.25);      // the far side
  expectGrey(f.at({0, 3 * 1.375, 0}), 0.75);  // scaled, edge and all
}

TEST(PxrRodLightFilter, StrengthColourAndInversion) {
  Numbers n = with(kLinear, {{"intensity", {0.5f}},
                             {"density", {0.5f}},
                             {"colorRamp_Knots", {0, 1}},
                             {"colorRamp_Colors", {1, 0, 0, 0, 1, 0}}});
  const TestFilter f("PxrRodLightFilter", n, kLine);
  expectNear(f.at({0, 0, 0}), {0.75f, 0.5f, 0.5f}, 1e-6);
  // halfway through the edge: colour (.5, .5, 0) * .5, half of it in half strength
  expectNear(f.at({0, 0, 1.25}), {1 - 0.25f * 0.75f, 1 - 0.25f * 0.75f, 0.75f}, 1e-6);
  expectGrey(f.at({0, 0, 2}), 1);
  n["invert"] = {1};
  const TestFilter inverted("PxrRodLightFilter", n, kLine);
  expectGrey(inverted.at({0, 0, 0}), 1);
  expectNear(inverted.at({0, 0, 2}), {0.5f, 0.75f, 0.5f}, 1e-6);
}

TEST(PxrRodLightFilter, TheDefaultFalloffIsASmoothRise) {
  const TestFilter f("PxrRodLightFilter", {{"edge", {1}}});
  EXPECT_EQ(f.at({0, 0, 1})[0], 0);
  EXPECT_EQ(f.at({0, 0, 2})[0], 1);
  float last = 0;
  for (int i = 1; i <= 100; ++i) {
    const float now = f.at({0, 0, 1 + i / 100.0})[0];
    EXPECT_GE(now, last);
    EXPECT_LT(now - last, 0.03f) << "no step";
    last = now;
  }
  // the uniform cubic through the values 0 .2 .8 1 at the middle of its middle piece
  expectGrey(f.at({0, 0, 1.5}), (0 + 23 * 0.2 + 23 * 0.8 + 1) / 48, 1e-5);
}

TEST(PxrRodLightFilter, ABrokenRampIsTold) {
  for (const V& knots : {V{1, 0}, V{}, V{0, NAN}, V(80, 0.f)}) {
    const TestFilter f("PxrRodLightFilter", {{"falloff_Knots", knots}, {"falloff_Floats", V(knots.size(), 0.5f)}});
    ASSERT_TRUE(f.made());
    ASSERT_EQ(f.warnings.size(), 1u);
    EXPECT_NE(f.warnings[0].find("LIGHT-FILTER-RAMP"), std::string::npos);
    expectGrey(f.at({0, 0, 0}), 0);
    expectGrey(f.at({0, 0, 1.125}), 1);
  }
  const TestFilter fewer("PxrRodLightFilter", {{"falloff_Knots", V{0, 0.5, 1}}, {"falloff_Floats", V{1, 0}}});
  ASSERT_EQ(fewer.warnings.size(), 1u);
  EXPECT_NE(fewer.warnings[0].find("3 knots and 2 values"), std::string::npos) << fewer.warnings[0];
  expectGrey(fewer.at({0, 0, 1.125}), 1);
}

}  // namespace
}  // namespace kinora
