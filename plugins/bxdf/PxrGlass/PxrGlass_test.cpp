// PxrGlass against what a smooth boundary does in closed form (Fresnel, Snell, total reflection), its tints and its
// inside. The registry's statistics cover roughness and energy; what glass looks like in a scene is not judged here.
#include <gtest/gtest.h>

#include <kinora/testing/statistics.h>
#include "testing/bound_bxdf.h"

namespace kinora {
const Descriptor* kinoraStock_PxrGlass();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render

Setting settingOf(const std::string& text) {
  Setting s;
  std::string error;
  EXPECT_TRUE(parseSetting(*kinoraStock_PxrGlass(), text, s, error)) << error;
  return s;
}
double fresnel(double cosI, double eta) {  // eta: ior of wo's side over the other's
  const double s2 = eta * eta * (1 - cosI * cosI);
  if (s2 >= 1) return 1;
  const double cosT = std::sqrt(1 - s2);
  const double rs = (eta * cosI - cosT) / (eta * cosI + cosT), rp = (cosI - eta * cosT) / (cosI + eta * cosT);
  return (rs * rs + rp * rp) / 2;
}
TestPoints pointsAt(double cosine, bool entering, uint32_t n) {
  TestPoints p;
  p.wo = {{float(std::sqrt(1 - cosine * cosine)), 0, float(cosine)}};
  p.entering = {uint8_t(entering)};
  p.P.assign(n, {0, 0, 0});
  return p;
}
struct Shares {
  double reflected[3] = {0, 0, 0}, transmitted[3] = {0, 0, 0};
  Vec3 through;
};
// Weight over probability of all samples, by the side they leave on.
Shares sample(const std::string& setting, double cosine, bool entering, uint32_t traits) {
  constexpr uint32_t n = 4096;
  TestContextOptions options;
  options.traits = traits;
  const BoundBxdf b(*kinoraStock_PxrGlass(), *runnableTables(*kinoraStock_PxrGlass()).back(), settingOf(setting),
                    pointsAt(cosine, entering, n), options);
  Generation g(n);
  Random random(3);
  for (uint32_t i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k) g.u(k)[i] = k == 2 ? (float(i) + 0.5f) / n : random.uniformFloat();
  b.generate(g);
  Shares s;
  for (uint32_t i = 0; i < n; ++i) {
    if (!g.valid(i)) continue;
    EXPECT_TRUE(g.discrete(i));
    const bool through = g.flags(i) & kSampleTransmit;
    if (through) s.through = g.wi(i);
    for (int k = 0; k < 3; ++k) (through ? s.transmitted : s.reflected)[k] += g.weight(k, i) / g.pdf(i) / n;
  }
  return s;
}

TEST(PxrGlass, ClearGlassIsFresnelAndSnell) {
  for (const double ior : {1.2, 1.5, 2.4})
    for (const bool entering : {true, false})
      for (const double cosine : {1.0, 0.8, 0.4, 0.1}) {
        SCOPED_TRACE("ior " + std::to_string(ior) + (entering ? " entering" : " leaving") + " cos " +
                     std::to_string(cosine));
        const double eta = entering ? 1 / ior : ior, f = fresnel(cosine, eta);
        const Shares s = sample("ior=" + std::to_string(ior), cosine, entering, kTraitEyePath);
        // the stratified choice is off by at most a stratum or two
        EXPECT_NEAR(s.reflected[0], f, 1e-3);
        EXPECT_NEAR(s.transmitted[1], (1 - f) * eta * eta, 1e-3 * eta * eta);
        if (f < 1) {
          const double sine = eta * std::sqrt(1 - cosine * cosine);
          EXPECT_NEAR(s.through.x, -sine, 1e-5);
          EXPECT_NEAR(s.through.z, -std::sqrt(1 - sine * sine), 1e-5);
        }
        const Shares power = sample("ior=" + std::to_string(ior), cosine, entering, kTraitLightPath);
        EXPECT_NEAR(power.reflected[0] + power.transmitted[0], 1, 1e-6);
      }
}

TEST(PxrGlass, TintsAreApart) {
  const Shares white = sample("", 0.7, true, kTraitLightPath);
  const Shares s = sample(
      "reflectionColor=0.5 0.25 1; reflectionGain=0.8; transmissionColor=1 0.5 0.2; "
      "transmissionGain=0.5",
      0.7, true, kTraitLightPath);
  const double r[3] = {0.4, 0.2, 0.8}, t[3] = {0.5, 0.25, 0.1};
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(s.reflected[k], white.reflected[k] * r[k], 2e-3);
    EXPECT_NEAR(s.transmitted[k], white.transmitted[k] * t[k], 2e-3);
  }
  // the other name of the same colour
  const Shares other = sample("transmissionColor=0.3 0.3 0.3; refractionColor=1 0.5 0.2", 0.7, true, kTraitLightPath);
  EXPECT_NEAR(other.transmitted[2] / other.transmitted[0], 0.2, 1e-5);
  EXPECT_NEAR(sample("reflectionGain=0", 0.7, true, kTraitLightPath).reflected[0], 0, 0);
  EXPECT_NEAR(sample("transmissionGain=0", 0.7, true, kTraitLightPath).transmitted[0], 0, 0);
}

TEST(PxrGlass, InsideIsAbsorptionByChannel) {
  TestPoints points = pointsAt(1, true, 3);
  const BoundBxdf b(*kinoraStock_PxrGlass(), *runnableTables(*kinoraStock_PxrGlass()).front(),
                    settingOf("ior=1.3; absorptionGain=2; absorptionColor=0.5 0.8 1"), points);
  std::vector<float> v(4 * b.context().padded, -1.f);
  const auto row = [&](uint32_t i) { return v.data() + i * b.context().padded; };
  const InteriorArgs a{row(3), {row(0), row(1), row(2)}};
  b.functions().interior(&b.context(), &a);
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_FLOAT_EQ(row(3)[i], 1.3f);
    EXPECT_FLOAT_EQ(row(0)[i], 1.f);
    EXPECT_FLOAT_EQ(row(1)[i], 1.6f);
    EXPECT_FLOAT_EQ(row(2)[i], 2.f);
  }
  const auto* traits = static_cast<const BxdfTraits*>(kinoraStock_PxrGlass()->traits);
  const Setting on = settingOf(""), off = settingOf("transmissionGain=0");
  EXPECT_TRUE(traits->enclosesMedium(ResolvedValues(*kinoraStock_PxrGlass(), on).data(), 0));
  EXPECT_FALSE(traits->enclosesMedium(ResolvedValues(*kinoraStock_PxrGlass(), off).data(), 0));
}

}  // namespace
}  // namespace testing
}  // namespace kinora
