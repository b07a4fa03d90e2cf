// LamaHairChiang against closed forms: shares of the paths by Fresnel's equations and Beer and Lambert's law, the absorption
// that colours and melanin mean, where each path's lobe stands and how wide it is, and that eye and light agree on the
// whole fibre. The registry's statistics cover densities and energy.
#include <gtest/gtest.h>

#include "plugins/bxdf/fiber_testing.h"

namespace kinora {
const Descriptor* kinoraStock_LamaHairChiang();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render
using namespace hair;

const Descriptor& plugin() { return *kinoraStock_LamaHairChiang(); }
Setting hairSetting(const std::string& text) { return settingOf(plugin(), text); }
// Of light that comes in an inclination at an offset: what each path keeps of it (R, TT, TRT with all longer ones).
void shares(double inclination, double azimuth, double ior, double absorption, double out[3]) {
  const double f = reflectance(std::cos(inclination) * std::cos(azimuth), ior), t = 1 - f;
  const double index = std::sqrt(ior * ior - std::pow(std::sin(inclination), 2)) / std::cos(inclination);
  const double turned = std::asin(std::sin(azimuth) / index), inside = std::asin(std::sin(inclination) / ior);
  const double passes = std::exp(-absorption * 2 * std::cos(turned) / std::cos(inside));
  out[0] = f;
  out[1] = t * t * passes;
  out[2] = t * t * passes * passes * f / (1 - f * passes);
}
double albedoOf(const std::string& setting, double inclination, double azimuth, int channel) {
  return hair::albedoOf(plugin(), hairSetting(setting), inclination, azimuth, channel);
}
constexpr const char* kOnly[3] = {"; colorTintTT=0 0 0; colorTintTRT=0 0 0", "; colorR=0 0 0; colorTintTRT=0 0 0",
                                  "; colorR=0 0 0; colorTintTT=0 0 0"};

TEST(LamaHairChiang, SharesOfPathsAreFresnelsAndBeerLamberts) {
  for (const double inclination : {0.0, 0.6, -1.1})
    for (const double azimuth : {0.0, 0.5, -1.2})
      for (int path = 0; path < 3; ++path)
        for (int channel = 0; channel < 3; ++channel) {
          const double absorption[3] = {0, 0.3, 1.5};
          double expected[3];
          shares(inclination, azimuth, 1.55, absorption[channel], expected);
          EXPECT_NEAR(
              albedoOf(std::string("colorMode=2; absorption=0 0.3 1.5") + kOnly[path], inclination, azimuth, channel),
              expected[path], 2e-6 + 2e-5 * expected[path])
              << "path " << path << " at " << azimuth;
        }
}

// Section 4.2 of the paper, and the absorption of pigments.
TEST(LamaHairChiang, ColoursAndPigmentsMeanAnAbsorption) {
  const double color[3] = {0.9, 0.4, 0.05};
  for (const double b : {0.1, 0.3, 0.8})
    for (int channel = 0; channel < 3; ++channel) {
      const double whole = 5.969 - 0.215 * b + 2.532 * b * b - 10.73 * std::pow(b, 3) + 5.574 * std::pow(b, 4) +
                           0.245 * std::pow(b, 5);
      double expected[3];
      shares(0.3, 0.4, 1.55, std::pow(std::log(color[channel]) / whole, 2), expected);
      EXPECT_NEAR(
          albedoOf("colorTT=0.9 0.4 0.05; azimuthalRoughness=" + std::to_string(b) + kOnly[1], 0.3, 0.4, channel),
          expected[1], 3e-5);
    }
  const double brown[3] = {0.419, 0.697, 1.37}, red[3] = {0.187, 0.4, 1.05};
  for (int channel = 0; channel < 3; ++channel) {
    double expected[3];
    shares(0, 0.4, 1.55, 0.5 * brown[channel] + 0.8 * red[channel], expected);
    EXPECT_NEAR(albedoOf(std::string("colorMode=1; eumelanin=0.5; pheomelanin=0.8") + kOnly[1], 0, 0.4, channel),
                expected[1], 3e-5);
  }
}

// Means of narrow lobes, and the variance along the fibre that a roughness means: a fourth of it for TT, four times for TRT.
TEST(LamaHairChiang, LobesStandWhereTheScalesPutThem) {
  const double inclination = 0.4, normal = 0.6, h = std::sin(normal), tilt = 3 * kDegree, roughness = 0.05;
  const double index = std::sqrt(1.55 * 1.55 - std::sin(inclination) * std::sin(inclination)) / std::cos(inclination);
  const double inside = std::asin(h / index);
  const double deviation = 0.726 * roughness + 0.812 * roughness * roughness;
  const double centre[3] = {2 * normal, kPi + 2 * normal - 2 * inside, 2 * normal - 4 * inside};
  const double turn[3] = {-2 * tilt, tilt, 4 * tilt}, wide[3] = {deviation, deviation / 2, deviation * 2};
  for (int path = 0; path < 3; ++path) {
    // the longer paths go with TRT, to all sides: absorbing they are nothing
    const BoundBxdf b(
        *kinoraStock_LamaHairChiang(), widest(plugin()),
        hairSetting("colorMode=2; absorption=4 4 4; offset=3; longitudinalRoughness=0.05; azimuthalRoughness=0.05" +
                    std::string(kOnly[path])),
        fibre(inclination, {normal}));
    constexpr int kSide = 128;
    const double step = 0.35 * kDegree;
    const auto at = [&](int i) { return (double(i) + 0.5 - kSide / 2.0) * step; };
    Evaluation e(kSide * kSide);
    const double middle = -inclination + turn[path];
    for (int i = 0; i < kSide * kSide; ++i)
      e.set(uint32_t(i), direction(middle + at(i / kSide), centre[path] + at(i % kSide)));
    b.evaluateAt(0, e);
    double sum = 0, first = 0, second = 0, square = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const double a = at(i / kSide), w = e.pdf(uint32_t(i)) * std::cos(middle + a);
      sum += w;
      first += w * a;
      second += w * at(i % kSide);
      square += w * a * a;
    }
    EXPECT_GT(sum * step * step, 0.95) << path;
    EXPECT_NEAR(first / sum / kDegree, 0, 0.1 + 30 * wide[path] * wide[path]) << path;
    EXPECT_NEAR(second / sum / kDegree, 0, 0.05) << path;
    EXPECT_NEAR(std::sqrt(square / sum), wide[path], 0.03 * wide[path]) << path;
  }
}

// What a fibre as a whole sends from one direction to another is one number, asked from the eye or from the light.
TEST(LamaHairChiang, EyeAndLightAgreeOnTheWholeFibre) {
  const auto whole = [](const Setting& s, double from, double to, double azimuth, uint32_t traits) {
    return wholeFibre(plugin(), s, from, to, azimuth, traits);
  };
  for (const char* text : {"", "colorTT=0.9 0.7 0.2; azimuthalRoughness=0.6; longitudinalRoughness=0.5; offset=-4"})
    for (const double eye : {0.3, -0.8})
      for (const double light : {-0.4, 0.5, 0.0})
        for (const double azimuth : {0.3, 1.8, 3.0, -2.2}) {
          const double seen = whole(hairSetting(text), eye, light, azimuth, kTraitEyePath),
                       lit = whole(hairSetting(text), light, eye, -azimuth, kTraitLightPath);
          EXPECT_NEAR(lit, seen, 0.01 * seen + 1e-6)
              << text << " eye " << eye << " light " << light << " " << azimuth;
        }
}

}  // namespace
}  // namespace testing
}  // namespace kinora
