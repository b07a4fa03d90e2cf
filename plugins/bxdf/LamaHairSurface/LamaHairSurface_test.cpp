// LamaHairSurface against LamaHairChiang: mixes and sums return what their halves return, by their shares, for paths from
// the eye and from lights, and densities are mixed by the energies; coats reflect by Fresnel's equations and let the rest
// through, other tops hide as mixes do; eye and light agree on the whole fibre. The registry's statistics cover sampling
// and furnaces; that a scene's nodes become the structure is in tests/patterns.
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

// A narrow coat: its peak by Fresnel's equations, and beside it what hair sends through it. From a light the way in is
// that of the other direction, at the mirrored offset.
TEST(LamaHairSurface, CoatsLetThroughWhatTheyDoNotReflect) {
  const double tint[3] = {1, 0.5, 0.25}, through[3] = {0.9, 1, 0.5}, top = 0.8;
  for (const uint32_t traits : {kTraitEyePath, kTraitLightPath}) {
    const auto gold = returned(alone(), kGold, traits);
    for (const bool isArtistic : {false, true}) {
      const double face = 0.16, index = isArtistic ? 1.4 / 0.6 : 1.8;
      const auto coated =
          returned(surface(),
                   std::string(isArtistic ? "structure=IrL" : "structure=IRL") + "; op1_amount=0.8" + leaf(1, kGold) +
                       leaf(2, "color=1 0.5 0.25; through=0.9 1 0.5; roughness=0; coatIOR=" +
                                   std::to_string(isArtistic ? face : index)),
                   traits);
      for (size_t i = 0; i < coated.size(); ++i) {
        const double in = traits == kTraitEyePath ? kInclination : kDirections[i][0];
        const double f = reflectance(std::cos(in) * std::cos(kNormal), index);
        const double degree = kDegree, spread = degree * std::sqrt(3.0) / kPi;
        const double peak = 1 / (std::sqrt(2 * kPi) * degree * std::cos(kInclination) * 4 * spread);
        for (int k = 0; k < 3; ++k) {
          const double below = (1 - top + top * through[k] * (1 - tint[k] * f)) * gold[i].rgb[k];
          const double expected = below + (i == 0 ? top * tint[k] * f * peak : 0);
          EXPECT_NEAR(coated[i].rgb[k], expected, 2e-6 + (i == 0 ? 0.01 : 1e-4) * expected)
              << isArtistic << " direction " << i << " channel " << k;
        }
      }
    }
  }
}

TEST(LamaHairSurface, OpaqueTopsHideAsMixesDo) {
  for (const uint32_t traits : {kTraitEyePath, kTraitLightPath})
    for (const char* leaves : {"II", "ID", "IT", "DI"}) {
      const std::string rest = "; op1_amount=0.3" + leaf(1, kGold) + leaf(2, kDark) + "; leaf2_color=0.7 0.2 0.9";
      const auto layer = returned(surface(), std::string("structure=") + leaves + "L" + rest, traits),
                 mix = returned(surface(), std::string("structure=") + leaves + "M" + rest, traits);
      for (size_t i = 0; i < mix.size(); ++i) {
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(layer[i].rgb[k], mix[i].rgb[k], 1e-6 + 1e-5 * mix[i].rgb[k]) << leaves << " direction " << i;
        EXPECT_NEAR(layer[i].pdf, mix[i].pdf, 1e-6 + 1e-5 * mix[i].pdf) << leaves << " direction " << i;
      }
    }
}

TEST(LamaHairSurface, EyeAndLightAgreeOnACoatedFibre) {
  const Setting s =
      settingOf(surface(), "structure=IDMRL; op1_amount=0.4; op2_amount=0.9" + leaf(1, kGold) +
                               leaf(2, "color=0.6 0.7 0.2") + leaf(3, "color=1 1 1; roughness=0.7; coatIOR=2"));
  for (const double eye : {0.3, -0.8})
    for (const double light : {-0.4, 0.5})
      for (const double azimuth : {0.3, 1.8, -2.2}) {
        const double seen = wholeFibre(surface(), s, eye, light, azimuth, kTraitEyePath),
                     lit = wholeFibre(surface(), s, light, eye, -azimuth, kTraitLightPath);
        EXPECT_NEAR(lit, seen, 0.01 * seen + 1e-6) << "eye " << eye << " light " << light << " " << azimuth;
      }
}

}  // namespace
}  // namespace testing
}  // namespace kinora
