// Proves: factors of the four ways to measure distance against the ramp's own formula; intensity, inversion,
// strength; a ramp of no length is a step; infinitely far lights end the ramp.
#include "plugins/lightfilter/filter_testing.h"

namespace kinora {
namespace {
using namespace filterTesting;

TEST(PxrRampLightFilter, DistancesOfEachType) {
  const Vec at{1, 2, 4};
  const double distances[4] = {std::sqrt(9.0 + 4 + 16), 4, std::sqrt(21.0), std::sqrt(5.0)};
  for (int type = 0; type < 4; ++type) {
    const TestFilter f("PxrRampLightFilter", {{"rampType", {float(type)}}, {"beginDist", {1}}, {"endDist", {9}}});
    expectGrey(f.at(at, {4, 4, 0}), (distances[type] - 1) / 8, 1e-6, "type " + std::to_string(type));
    expectGrey(f.at({0, 0, 0.5}, {0, 0, 0}), 0);
    expectGrey(f.at({0, 40, 40}, {0, 0, 0}), 1);
  }
  const TestFilter f("PxrRampLightFilter", {});
  expectGrey(f.from(at, {0, 1, 0}, std::numeric_limits<double>::infinity()), 1);
}

TEST(PxrRampLightFilter, RampsMultiplyAndStrengthBlends) {
  Numbers n = {{"ramp_Knots", {0, 0.5f, 1}},
               {"ramp_Floats", {1, 0.25f, 0}},
               {"colorRamp_Knots", {0, 1}},
               {"endDist", {4}},
               {"colorRamp_Colors", {1, 1, 1, 0, 1, 2}},
               {"intensity", {2}}};
  const TestFilter f("PxrRampLightFilter", n);
  // t = .25: ramp .625, colour (.75, 1, 1.25)
  expectNear(f.at({0, 0, 1}), {2 * 0.625f * 0.75f, 2 * 0.625f, 2 * 0.625f * 1.25f}, 1e-6);
  n["density"] = {0.5f};
  const TestFilter half("PxrRampLightFilter", n);
  expectNear(half.at({0, 0, 1}), {0.5f + 0.625f * 0.75f, 0.5f + 0.625f, 0.5f + 0.625f * 1.25f}, 1e-6);
  const TestFilter inverted("PxrRampLightFilter", {{"invert", {1}}});
  expectGrey(inverted.at({0, 0, 2.5}), 0.75);
}

TEST(PxrRampLightFilter, ARampOfNoLengthIsAStep) {
  const TestFilter f("PxrRampLightFilter", {{"beginDist", {2}}, {"endDist", {2}}});
  expectGrey(f.at({0, 0, 1.99}), 0);
  expectGrey(f.at({0, 0, 2.01}), 1);
}

}  // namespace
}  // namespace kinora
