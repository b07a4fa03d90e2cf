// PxrMarschnerHair against closed forms: shares of the paths by Fresnel's equations, where each path's lobe stands, what an
// average over the width is for eye and light. The registry's statistics cover densities and energy.
#include <gtest/gtest.h>

#include "plugins/bxdf/fiber_testing.h"

namespace kinora {
const Descriptor* kinoraStock_PxrMarschnerHair();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render
using namespace hair;

const Descriptor& plugin() { return *kinoraStock_PxrMarschnerHair(); }
Setting hairSetting(const std::string& text) { return settingOf(plugin(), text); }
constexpr const char* kWhite = "specularColorTT=1 1 1; specularColorTRT=1 1 1; ";

TEST(PxrMarschnerHair, SharesOfPathsAreFresnels) {
  const std::string only[3] = {"specularGainTT=0; specularGainTRT=0; specularGainGLINTS=0",
                               "specularGainR=0; specularGainTRT=0; specularGainGLINTS=0",
                               "specularGainR=0; specularGainTT=0; specularGainGLINTS=0"};
  for (const double inclination : {0.0, 0.6, -1.1})
    for (const double azimuth : {0.0, 0.5, -1.2}) {
      const double f = reflectance(std::cos(inclination) * std::cos(azimuth), 1.55), t = 1 - f;
      const double expected[3] = {f, t * t, t * f};  // the last with all longer paths
      for (int path = 0; path < 3; ++path) {
        const double seen = albedoOf(plugin(), hairSetting(kWhite + only[path]), inclination, azimuth, 1);
        EXPECT_NEAR(seen, expected[path], 2e-6 + 2e-5 * expected[path]) << "path " << path << " at " << azimuth;
      }
    }
}

// Where density is greatest, of lobes a degree wide.
TEST(PxrMarschnerHair, LobesStandWhereTheScalesPutThem) {
  const double inclination = 0.4, normal = 0.6, h = std::sin(normal), tilt = -3 * kDegree;
  const double index = std::sqrt(1.55 * 1.55 - std::sin(inclination) * std::sin(inclination)) / std::cos(inclination);
  const double inside = std::asin(h / index);
  struct Case {
    const char* off;
    double inclination, azimuth;
  };
  const Case cases[3] = {
      {"specularGainTT=0; specularGainTRT=0; specularGainGLINTS=0", -inclination + 2 * tilt, 2 * normal},
      {"specularGainR=0; specularGainTRT=0; specularGainGLINTS=0", -inclination - tilt,
       kPi + 2 * normal - 2 * inside},
      {"specularGainR=0; specularGainTT=0; specularGainGLINTS=0", -inclination - 3 * tilt, 2 * normal - 4 * inside}};
  for (const Case& c : cases) {
    const std::string narrow = "specularConeAngleR=1; specularConeAngleTT=1; specularConeAngleTRT=1; ";
    const BoundBxdf b(*kinoraStock_PxrMarschnerHair(), widest(plugin()), hairSetting(kWhite + narrow + c.off),
                      fibre(inclination, {normal}));
    // weighted means over a window about where the lobe should be
    double sum = 0, first = 0, second = 0;
    constexpr int kSide = 64;
    Evaluation e(kSide * kSide);
    const auto at = [](int i) { return (double(i) + 0.5 - kSide / 2.0) * (0.25 * kDegree); };
    for (int i = 0; i < kSide * kSide; ++i)
      e.set(uint32_t(i), direction(c.inclination + at(i / kSide), c.azimuth + at(i % kSide)));
    b.evaluateAt(0, e);
    for (int i = 0; i < kSide * kSide; ++i) {
      const double w = e.pdf(uint32_t(i)) * std::cos(c.inclination + at(i / kSide));
      sum += w;
      first += w * at(i / kSide);
      second += w * at(i % kSide);
    }
    EXPECT_NEAR(first / sum / kDegree, 0, 0.05) << c.off;
    EXPECT_NEAR(second / sum / kDegree, 0, 0.05) << c.off;
    EXPECT_GT(sum * std::pow(0.25 * kDegree, 2), 0.9) << c.off;  // and nearly all of it is there
  }
}

// What a fibre as a whole sends from one direction to another is one number, asked from the eye or from the light: each sees
// its offsets evenly, and a width in proportion to the cosine of its inclination.
TEST(PxrMarschnerHair, EyeAndLightAgreeOnTheWholeFibre) {
  const auto whole = [](const Setting& s, double from, double to, double azimuth, uint32_t traits) {
    return wholeFibre(plugin(), s, from, to, azimuth, traits);
  };
  for (const char* text :
       {"diffuseGain=0", "diffuseGain=0.5; specularConeAngleR=15; specularConeAngleTT=20; specularOffset=5",
        "specularEccentricity=0.9; specularMixFresnel=0.3; specularColorTT=0.9 0.5 0.2"})
    for (const double eye : {0.3, -0.8})
      for (const double light : {-0.4, 0.5, 0.0})
        for (const double azimuth : {0.3, 1.8, 3.0, -2.2}) {
          // both look from azimuth 0: the section turns for the light
          const auto turned = [&](double axis) {
            const Vec3 d = direction(0, axis);
            return hairSetting(std::string(text) + "; eccentricityDirection=" + std::to_string(d.x) + " 0 " +
                               std::to_string(d.z));
          };
          const double seen = whole(turned(1.2), eye, light, azimuth, kTraitEyePath),
                       lit = whole(turned(1.2 - azimuth), light, eye, -azimuth, kTraitLightPath);
          EXPECT_NEAR(lit, seen, 0.01 * seen + 1e-6)
              << text << " eye " << eye << " light " << light << " " << azimuth;
        }
}

// Caustics of the second highlight: with a share of glints there is more about the angle where its azimuth turns back.
TEST(PxrMarschnerHair, GlintsStandAtTheCaustic) {
  const double edge = std::sqrt((4 - 1.55 * 1.55) / 3),
               turn = std::abs(2 * std::asin(edge) - 4 * std::asin(edge / 1.55));
  const BoundBxdf b(*kinoraStock_PxrMarschnerHair(), widest(plugin()),
                    hairSetting(std::string(kWhite).append(
                        "specularGainR=0; specularGainTT=0; specularGainTRT=0; specularGlintWidth=4")),
                    fibre(0, {0.3}));
  Evaluation e(3);
  e.set(0, direction(-9 * kDegree, -turn));  // beside the normal at 0.3
  e.set(1, direction(-9 * kDegree, turn));
  e.set(2, direction(-9 * kDegree, -turn - 0.5));
  b.evaluateAt(0, e);
  EXPECT_GT(e.pdf(0), 20 * e.pdf(1));
  EXPECT_GT(e.pdf(0), 20 * e.pdf(2));
}

}  // namespace
}  // namespace testing
}  // namespace kinora
