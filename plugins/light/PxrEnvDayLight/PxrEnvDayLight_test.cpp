// Proves: the sun stands where almanacs have it; its irradiance is that of its disc whatever its size; the sky is
// blue away from the sun, warmer in haze and at its brightest around the sun; the ground reflects what sky and sun
// give; the density integrates to 1 and agrees with samples; power, widths, sun below the horizon. Misses: the
// model's own truth.
#include "plugins/light/light_testing.h"

namespace kinora {
namespace {
using namespace lightTesting;
constexpr const char* kName = "PxrEnvDayLight";
constexpr double kPi = 3.14159265358979;

std::array<double, 3> seen(const TestLight& light, Vec d) {
  Rays r(1);
  d = unit(d);
  for (int c = 0; c < 3; ++c) r.a[5 + c][0] = float(d[size_t(c)]);
  light.look(r);
  return {r.a[13][0], r.a[14][0], r.a[15][0]};
}
// Where the light is brightest, by its own samples.
Vec brightest(const TestLight& light) {
  Rays r(4096);
  fillGrid(r.a[3], r.a[4], 64, 1);
  light.sample(r);
  uint32_t best = 0;
  for (uint32_t i = 1; i < r.n; ++i)
    if (mean3(r, 9, i) > mean3(r, 9, best)) best = i;
  return {r.a[5][best], r.a[6][best], r.a[7][best]};
}

TEST(PxrEnvDayLight, TheSunStandsWhereAlmanacsHaveIt) {
  // solar noon at the equinox: elevation 90 - latitude, due south (-X); the equation of time is -7.5 minutes
  TestLight noon(kName, {set("month", 3), set("day", 20), set("hour", 12.125f), set("zone", 0), set("latitude", 40),
                         set("longitude", 0)});
  Vec s = brightest(noon);
  EXPECT_NEAR(std::asin(s[2]) * 180 / kPi, 50, 1);
  EXPECT_LT(s[0], -0.6);
  EXPECT_NEAR(s[1], 0, 0.03);
  // June solstice at noon, 23.4 degrees north: overhead; morning sun stands in the east (+Y)
  TestLight tropic(kName, {set("month", 6), set("day", 21), set("hour", 12.03f), set("zone", 0),
                           set("latitude", 23.44f), set("longitude", 0)});
  EXPECT_GT(brightest(tropic)[2], 0.999);
  TestLight morning(kName, {set("month", 3), set("day", 20), set("hour", 8), set("zone", 0), set("latitude", 0),
                            set("longitude", 0)});
  s = brightest(morning);
  EXPECT_GT(s[1], 0.8);
  EXPECT_NEAR(std::asin(s[2]) * 180 / kPi, 28, 2);
  // a given direction
  TestLight given(kName, {set("month", 0), set("sunDirection", 1, 0, 1)});
  s = brightest(given);
  EXPECT_NEAR(s[0], s[2], 0.01);
}

TEST(PxrEnvDayLight, IrradianceByBothRoads) {
  for (float size : {0.f, 1.f, 8.f}) {
    TestLight light(kName, {set("month", 0), set("sunDirection", 0.5f, 0.3f, 1), set("sunSize", size)});
    const Vec n = unit({0.2, 0, 1}), sun = unit({0.5, 0.3, 1});
    const double half = size > 0 ? 0.276 * kPi / 180 * size : 0;
    // the disc apart from the rest, which a grid of directions resolves
    TestLight sky(kName, {set("month", 0), set("sunDirection", 0.5f, 0.3f, 1), set("sunSize", 0)});
    double e = lookAround(sky, {0, 0, 0}, n, n, kPi / 2).irradiance;
    if (size > 0)
      e += lookAround(light, {0, 0, 0}, n, sun, half, 512).irradiance -
           lookAround(sky, {0, 0, 0}, n, sun, half, 512).irradiance;
    EXPECT_NEAR(irradianceBySampling(light, {0, 0, 0}, n), e, 4e-3 * e) << size;
    EXPECT_NEAR(lookAround(sky, {0, 0, 0}, n, n, kPi).pdf, 1, 3e-3);
  }
  // whatever the disc's size, its power is the same
  TestLight one(kName, {set("month", 0), set("sunDirection", 0, 0, 1), set("skyTint", 0, 0, 0)});
  TestLight eight(kName, {set("month", 0), set("sunDirection", 0, 0, 1), set("skyTint", 0, 0, 0), set("sunSize", 8)});
  const double e = irradianceBySampling(one, {0, 0, 0}, {0, 0, 1});
  EXPECT_NEAR(irradianceBySampling(eight, {0, 0, 0}, {0, 0, 1}), e, 3e-3 * e);
  EXPECT_GT(e, 0.5);
  EXPECT_LT(e, 1.5) << "128 klx above the air, 300 klx are pi";
}

TEST(PxrEnvDayLight, TheSkyLooksLikeOne) {
  TestLight clear(kName, {set("month", 0), set("sunDirection", 1, 0, 1)});
  const auto away = seen(clear, {-0.7, 0, 0.8}), near = seen(clear, {1, 0.2, 1}), low = seen(clear, {-1, 0, 0.02});
  EXPECT_GT(away[2], 1.3 * away[0]) << "blue";
  EXPECT_GT(near[1], 2 * away[1]) << "brighter about the sun";
  EXPECT_GT(low[1], away[1]) << "brighter at the horizon";
  TestLight haze(kName, {set("month", 0), set("sunDirection", 1, 0, 1), set("haziness", 8)});
  const auto grey = seen(haze, {-0.7, 0, 0.8});
  EXPECT_LT(grey[2] / grey[0], away[2] / away[0]);
  TestLight evening(kName, {set("month", 0), set("sunDirection", 1, 0, 0.05f), set("skyTint", 0, 0, 0)});
  const auto red = seen(evening, {1, 0, 0.05});
  EXPECT_GT(red[0], 2 * red[2]) << "a low sun is red";
}

TEST(PxrEnvDayLight, TheGroundReflectsSkyAndSun) {
  const auto settings = [](float mode) {
    return std::vector<Setting>{set("month", 0), set("sunDirection", 0.5f, 0.3f, 1), set("groundMode", mode),
                                set("groundColor", 0.5f, 0.5f, 0.5f), set("intensity", 2)};
  };
  TestLight ground(kName, settings(2));
  const double e = irradianceBySampling(ground, {0, 0, 0}, {0, 0, 1});
  const auto down = seen(ground, {0.1, 0.2, -1});
  EXPECT_NEAR((down[0] + down[1] + down[2]) / 3, 0.5 * e / kPi, 0.01 * e);
  TestLight horizon(kName, settings(1));
  const auto at = seen(horizon, {1, 0.3, 0}), below = seen(horizon, {1, 0.3, -0.4});
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(at[c], below[c], 1e-3 * at[c]);
}

TEST(PxrEnvDayLight, DensitiesPowerAndWidths) {
  TestLight light(kName, {set("month", 6)}, turned(1, 1, 1, {1, 2, 3}));
  expectDensitiesAgree(light, pointsAround(light, 100));
  EXPECT_NEAR(emittedPower(light), light.description.power * kPi * light.worldRadius * light.worldRadius,
              0.02 * light.description.power * kPi * light.worldRadius * light.worldRadius);
  expectWidthsAgree(light, pointsAround(light, 301));
  expectNoNaN(light);
  expectDegenerateIsSafe(kName, false);
}

TEST(PxrEnvDayLight, NightIsDuskWithAMessage) {
  TestLight night(kName, {set("month", 6), set("hour", 0)});
  EXPECT_EQ(night.warnings.size(), 1u);
  TestLight dusk(kName, {set("month", 0), set("sunDirection", 1, 0, -0.05f)});
  EXPECT_GT(seen(dusk, {0, 0, 1})[2], seen(night, {0, 0, 1})[2]);
  EXPECT_GT(seen(night, {0, 0, 1})[2], 0);
  expectNoNaN(night);
}
}  // namespace
}  // namespace kinora
