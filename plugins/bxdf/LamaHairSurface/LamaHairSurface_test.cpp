// LamaHairSurface against LamaHairChiang: mixes and sums return what their halves return, by their shares, for paths from
// the eye and from lights, and densities are mixed by the energies. The registry's statistics cover sampling and
// furnaces; that a scene's nodes become the structure is in tests/patterns.
#include <gtest/gtest.h>

#include <array>

#include "plugins/bxdf/fiber_testing.h"

namespace kinora {
const Descriptor* kinoraStock_LamaHairChiang();
const Descriptor* kinoraStock_LamaHairSurface();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render
using namespace hair;

const Descriptor& alone() { return *kinoraStock_LamaHairChiang(); }
const Descriptor& surface() { return *kinoraStock_LamaHairSurface(); }

constexpr double kInclination = 0.4, kNormal = 0.5;
constexpr std::array<std::array<double, 2>, 7> kDirections = {
    {{-0.4, 1.0}, {-0.3, 2.6}, {0.2, 0.3}, {-0.8, -1.2}, {-0.45, 3.1}, {0.7, -2.4}, {-0.4, 0.6}}};

struct Returned {
  double rgb[3], pdf;
};
std::vector<Returned> returned(const Descriptor& d, const std::string& setting, uint32_t traits) {
  TestContextOptions options;
  options.traits = traits;
  options.slots = Slots::One;
  const BoundBxdf b(d, widest(d), settingOf(d, setting), fibre(kInclination, {kNormal}), options);
  Evaluation e(uint32_t(kDirections.size()));
  for (uint32_t i = 0; i < kDirections.size(); ++i) e.set(i, direction(kDirections[i][0], kDirections[i][1]));
  b.evaluateAt(0, e);
  std::vector<Returned> all(kDirections.size());
  for (uint32_t i = 0; i < kDirections.size(); ++i) {
    for (int c = 0; c < 3; ++c) all[i].rgb[c] = e.weight(0, c, i);
    all[i].pdf = e.pdf(i);
  }
  return all;
}
double energyOf(const std::string& setting) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += albedoOf(alone(), settingOf(alone(), setting), kInclination, kNormal, c);
  return sum / 3;
}
// "a=1; b=2" of a leaf.
std::string leaf(int number, const std::string& setting) {
  const std::string prefix = "leaf" + std::to_string(number) + "_";
  std::string text = "; " + prefix + setting;
  for (size_t at = 2; (at = text.find("; ", at)) != std::string::npos; at += 2) text.insert(at + 2, prefix);
  return text;
}

const std::string kGold = "colorTT=0.9 0.7 0.2; azimuthalRoughness=0.6; longitudinalRoughness=0.5",
                  kDark = "colorMode=2; absorption=0.3 1 2; offset=-4; azimuthalRoughness=0.4";

TEST(LamaHairSurface, MixesAndSumsReturnTheirShares) {
  struct Case {
    const char* tree;
    double first, second;
  };
  for (const uint32_t traits : {kTraitEyePath, kTraitLightPath}) {
    const auto gold = returned(alone(), kGold, traits), dark = returned(alone(), kDark, traits);
    const double goldEnergy = energyOf(kGold), darkEnergy = energyOf(kDark);
    for (const Case& c :
         {Case{"structure=IIM; op1_amount=0.3", 0.7, 0.3}, Case{"structure=IIM; op1_amount=0", 1, 0},
          Case{"structure=IIM; op1_amount=1", 0, 1}, Case{"structure=IIP; op1_amount=0.5; op1_other=0.25", 0.5, 0.25},
          // a sum that would return more than arrives
          Case{"structure=IIP; op1_amount=1; op1_other=1", 0.5, 0.5},
          Case{"structure=IEMIP; op1_amount=0.5; op2_amount=1; op2_other=0.25", 0.5, 0}}) {
      std::string setting = c.tree + leaf(1, kGold) + leaf(2, kDark);
      double second = c.second;
      if (std::string(c.tree).find("IEMIP") != std::string::npos) {
        setting = c.tree + leaf(1, kGold) + leaf(3, kDark);
        second = 0.25;
      }
      const auto both = returned(surface(), setting, traits);
      const double energy = c.first * goldEnergy + second * darkEnergy;
      for (size_t i = 0; i < both.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          const double expected = c.first * gold[i].rgb[k] + second * dark[i].rgb[k];
          EXPECT_NEAR(both[i].rgb[k], expected, 1e-6 + 1e-5 * expected) << c.tree << " direction " << i;
        }
        const double pdf = (c.first * goldEnergy * gold[i].pdf + second * darkEnergy * dark[i].pdf) / energy;
        EXPECT_NEAR(both[i].pdf, pdf, 1e-6 + 1e-4 * pdf) << c.tree << " direction " << i;
      }
    }
  }
}

// Diffuse beside hair reflects on the side that is seen, translucent lets through to the other, by Lambert's law.
TEST(LamaHairSurface, DiffuseSlabsStandBesideHair) {
  const auto gold = returned(alone(), kGold, kTraitEyePath);
  const double color[3] = {0.8, 0.4, 0.1};
  for (const bool isThrough : {false, true}) {
    const auto both = returned(surface(),
                               std::string("structure=I") + (isThrough ? "T" : "D") + "M; op1_amount=0.6" +
                                   leaf(1, kGold) + leaf(2, "color=0.8 0.4 0.1"),
                               kTraitEyePath);
    for (size_t i = 0; i < both.size(); ++i) {
      const double cosine = std::cos(kDirections[i][0]) * std::cos(kDirections[i][1] - kNormal);
      const double lambert = std::max(isThrough ? -cosine : cosine, 0.0) / kPi;
      for (int k = 0; k < 3; ++k) {
        const double expected = 0.4 * gold[i].rgb[k] + 0.6 * color[k] * lambert;
        EXPECT_NEAR(both[i].rgb[k], expected, 1e-6 + 1e-5 * expected) << isThrough << " direction " << i;
      }
    }
  }
}

}  // namespace
}  // namespace testing
}  // namespace kinora
