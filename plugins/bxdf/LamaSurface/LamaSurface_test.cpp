// The slabs of layered materials, alone and combined, against formulas written here in double precision: Lambert,
// Fresnel of conductors and dielectrics, Schlick, sheen, what layers let through, mixes and sums. The registry's
// statistics cover sampling, reciprocity and furnaces; that a scene's nodes become the structure is in tests/patterns.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <complex>

#include <kinora/testing/statistics.h>
#include "testing/bound_bxdf.h"

namespace kinora {
const Descriptor* kinoraStock_LamaSurface();
const Descriptor* kinoraStock_LamaConductor();
const Descriptor* kinoraStock_LamaDielectric();
const Descriptor* kinoraStock_LamaGeneralizedSchlick();
const Descriptor* kinoraStock_LamaIridescence();
const Descriptor* kinoraStock_PxrDisneyBsdf();
const Descriptor* kinoraStock_PxrSurface();
const Descriptor* kinoraStock_PxrLayerSurface();
const Descriptor* kinoraStock_LamaDiffuse();
const Descriptor* kinoraStock_LamaSSS();
const Descriptor* kinoraStock_LamaSheen();
const Descriptor* kinoraStock_LamaTricolorSSS();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render
constexpr double kPi = 3.14159265358979;
constexpr double kCosines[] = {1.0, 0.8, 0.5, 0.3, 0.1};

Setting settingOf(const Descriptor* d, const std::string& text) {
  Setting s;
  std::string error;
  EXPECT_TRUE(parseSetting(*d, text, s, error)) << error;
  return s;
}
Vec3 at(double cosine, double angle) {
  const double s = std::sqrt(std::max(1 - cosine * cosine, 0.));
  return {float(s * std::cos(angle)), float(s * std::sin(angle)), float(cosine)};
}
TestPoints seenAt(double cosine, uint32_t n = 1) {
  TestPoints p;
  p.wo = {at(cosine, 0)};
  p.P.assign(n, {0, 0, 0});
  return p;
}
// Weight with cosine of one pair of directions, all lobes together.
std::array<double, 3> valueOf(const Descriptor* d, const std::string& setting, double cosO, double cosI,
                              double angle) {
  TestContextOptions options;
  options.slots = Slots::One;
  const BoundBxdf b(*d, *runnableTables(*d).front(), settingOf(d, setting), seenAt(cosO), options);
  Evaluation e(1);
  e.set(0, at(cosI, angle));
  b.evaluate(e);
  return {e.weight(0, 0, 0), e.weight(0, 1, 0), e.weight(0, 2, 0)};
}
// Mean of weight over density: the albedo; mirrors apart.
struct Returned {
  std::array<double, 3> mirrored{}, spread{};
};
Returned returnedBy(const Descriptor* d, const std::string& setting, double cosO) {
  constexpr uint32_t n = 32768;
  TestContextOptions options;
  options.slots = Slots::One;
  const BoundBxdf b(*d, *runnableTables(*d).back(), settingOf(d, setting), seenAt(cosO, n), options);
  Generation g(n);
  Random random(7);
  for (uint32_t i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k) g.u(k)[i] = k == 2 ? (float(i) + 0.5f) / n : random.uniformFloat();
  b.generate(g);
  Returned r;
  for (uint32_t i = 0; i < n; ++i)
    if (g.valid(i))
      for (int k = 0; k < 3; ++k) (g.discrete(i) ? r.mirrored : r.spread)[size_t(k)] += g.weight(k, i) / g.pdf(i) / n;
  return r;
}
double conductor(double c, std::complex<double> m) {
  const std::complex<double> t = std::sqrt(m * m - (1 - c * c));  // m cos of the refracted angle
  const double s = std::norm((c - t) / (c + t)), p = std::norm((m * m * c - t) / (m * m * c + t));
  return (s + p) / 2;
}

TEST(LamaSurface, ConductorsAreFresnels) {
  const Descriptor* d = kinoraStock_LamaConductor();
  const double n[3] = {0.18, 0.42, 1.37}, k[3] = {3.42, 2.35, 1.77};
  for (const double c : kCosines) {
    const Returned r = returnedBy(d, "roughness=0", c);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(r.mirrored[i], conductor(c, {n[i], k[i]}), 2e-4) << c;
  }
  // the artists' parameters: Gulbrandsen's index of the same reflectance
  const double face[3] = {0.9, 0.6, 0.3}, edge[3] = {1, 0.5, 0.1};
  for (const double c : kCosines) {
    const Returned r =
        returnedBy(d, "fresnelMode=1; reflectivity=0.9 0.6 0.3; edgeColor=1 0.5 0.1; roughness=0; tint=1 1 0.5", c);
    for (size_t i = 0; i < 3; ++i) {
      const double f = face[i], s = std::sqrt(f);
      const double m = edge[i] * (1 - f) / (1 + f) + (1 - edge[i]) * (1 + s) / (1 - s);
      const double e = std::sqrt((f * (m + 1) * (m + 1) - (m - 1) * (m - 1)) / (1 - f));
      EXPECT_NEAR(r.mirrored[i], (i == 2 ? 0.5 : 1) * conductor(c, {m, e}), 5e-4) << c;
      if (c == 1) {
        EXPECT_NEAR(r.mirrored[i], (i == 2 ? 0.5 : 1) * f, 5e-4);
      }
    }
  }
}

TEST(LamaSurface, SchlicksAreByTheirColoursAndProfile) {
  const double face[3] = {0.1, 0.2, 0.4}, edge[3] = {1, 0.5, 0.2};
  for (const double profile : {0.2, 0.5})
    for (const double c : kCosines) {
      const Returned r = returnedBy(kinoraStock_LamaGeneralizedSchlick(),
                                    "fresnelMode=1; reflectivity=0.1 0.2 0.4; reflectivity90=1 0.5 0.2; roughness=0; "
                                    "reflectivityProfile=" +
                                        std::to_string(profile),
                                    c);
      for (size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(r.mirrored[i], face[i] + (edge[i] - face[i]) * std::pow(1 - c, 1 / profile), 1e-4);
    }
  const Returned r = returnedBy(kinoraStock_LamaGeneralizedSchlick(), "IOR=1.5 2 1; roughness=0", 1);
  EXPECT_NEAR(r.mirrored[0], 0.04, 1e-5);
  EXPECT_NEAR(r.mirrored[1], 1. / 9, 1e-5);
  EXPECT_NEAR(r.mirrored[2], 0, 1e-7);
}

// Airy's formula at every wavelength, summed over the observer's curves.
TEST(LamaSurface, FilmsAreAirys) {
  const auto bell = [](double nm, double height, double middle, double below, double above) {
    const double t = (nm - middle) * (nm < middle ? below : above);
    return height * std::exp(-0.5 * t * t);
  };
  for (const double eta : {1.3, 2.})
    for (const double thickness : {0., 200., 450., 1200.})
      for (const double c : {1., 0.7, 0.3}) {
        const double inside = std::sqrt(1 - (1 - c * c) / (eta * eta));
        const double r[2] = {std::pow((c - eta * inside) / (c + eta * inside), 2),
                             std::pow((eta * c - inside) / (eta * c + inside), 2)};
        double sum[3] = {0, 0, 0}, total[3] = {0, 0, 0};
        for (double nm = 380; nm <= 780; nm += 1) {
          const double half = std::pow(std::sin(2 * kPi * eta * thickness * inside / nm), 2);
          double f = 0;
          for (const double face : r) {
            const double finesse = 4 * face / ((1 - face) * (1 - face));
            f += 0.5 * finesse * half / (1 + finesse * half);
          }
          const double x = bell(nm, 0.362, 442, 0.0624, 0.0374) + bell(nm, 1.056, 599.8, 0.0264, 0.0323) +
                           bell(nm, -0.065, 501.1, 0.0490, 0.0382);
          const double y = bell(nm, 0.821, 568.8, 0.0213, 0.0247) + bell(nm, 0.286, 530.9, 0.0613, 0.0322);
          const double z = bell(nm, 1.217, 437, 0.0845, 0.0278) + bell(nm, 0.681, 459, 0.0385, 0.0725);
          const double rgb[3] = {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
                                 0.0557 * x - 0.2040 * y + 1.0570 * z};
          for (int k = 0; k < 3; ++k) {
            sum[k] += rgb[k] * f;
            total[k] += rgb[k];
          }
        }
        const Returned got = returnedBy(kinoraStock_LamaIridescence(),
                                        "roughness=0; relativeFilmThickness=0; filmIOR=" + std::to_string(eta) +
                                            "; minFilmThickness=" + std::to_string(thickness),
                                        c);
        for (size_t k = 0; k < 3; ++k)
          EXPECT_NEAR(got.mirrored[k], std::clamp(sum[k] / total[k], 0., 1.), 3e-3)
              << eta << " " << thickness << " " << c << " channel " << k;
      }
}

// A clear coat over Lambert: the base gets what the worse of the two directions lets through; the furnace is that
// integral and the mirror.
TEST(LamaSurface, CoatsLetThroughWhatTheyDoNotReflect) {
  const Descriptor* d = kinoraStock_LamaSurface();
  const std::string setting =
      "structure=DRL; leaf1_color=0.8 0.5 0.2; leaf1_roughness=0; leaf2_color=1 1 1; leaf2_roughness=0; "
      "leaf2_ior=1.5; "
      "leaf2_through=1 1 0.5";
  const double color[3] = {0.8, 0.5, 0.2};
  const auto through = [](double c) { return 1 - conductor(c, 1.5); };
  for (const double o : kCosines) {
    for (const double i : kCosines) {
      const auto f = valueOf(d, setting, o, i, 1);
      for (size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(f[k], color[k] / kPi * i * std::min(through(o), through(i)) * (k == 2 ? 0.5 : 1), 2e-5);
    }
    double rest = 0;
    constexpr int kSteps = 4000;
    for (int s = 0; s < kSteps; ++s) {
      const double c = (s + 0.5) / kSteps;
      rest += 2 * c * std::min(through(o), through(c)) / kSteps;
    }
    const Returned r = returnedBy(d, setting, o);
    EXPECT_NEAR(r.mirrored[0], conductor(o, 1.5), 2e-3);
    EXPECT_NEAR(r.spread[0], color[0] * rest, 6e-3);
    EXPECT_LE(r.mirrored[0] + r.spread[0], 1);
  }
}

TEST(LamaSurface, OpaqueTopsHideTheBaseByTopMix) {
  const Descriptor* d = kinoraStock_LamaSurface();
  for (const double mix : {0., 0.25, 1.}) {
    const auto f = valueOf(d,
                           "structure=DDL; leaf1_color=0.8 0.8 0.8; leaf2_color=0.2 0.4 0.6; leaf1_roughness=0; "
                           "leaf2_roughness=0; op1_amount=" +
                               std::to_string(mix),
                           0.7, 0.6, 2);
    const double top[3] = {0.2, 0.4, 0.6};
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(f[k], (mix * top[k] + (1 - mix) * 0.8) / kPi * 0.6, 1e-6) << mix;
  }
}

TEST(LamaSurface, AMixOfTwinsIsTheTwin) {
  const Descriptor* d = kinoraStock_LamaSurface();
  const std::string one =
                        "leaf1_color=0.8 0.5 0.2; leaf1_second=0.4 0.6 1.2; leaf1_third=3 2 1; leaf1_roughness=0.4; ",
                    two =
                        "leaf2_color=0.8 0.5 0.2; leaf2_second=0.4 0.6 1.2; leaf2_third=3 2 1; leaf2_roughness=0.4; ";
  for (const std::string kind : {"D", "C", "A", "S", "H"})
    for (const double o : {0.9, 0.4}) {
      const auto single = valueOf(d, one + "structure=" + kind, o, 0.6, 2.9);
      const auto pair = valueOf(d, one + two + "op1_amount=0.3; structure=" + kind + kind + "M", o, 0.6, 2.9);
      for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(pair[k], single[k], 1e-5 * single[k]) << kind;
      EXPECT_GT(single[0], 0);
    }
}

TEST(LamaSurface, SumsNeverGain) {
  const Descriptor* d = kinoraStock_LamaSurface();
  const auto sum = [&](const std::string& colors, const std::string& weights) {
    return valueOf(d, "structure=DDP; leaf1_roughness=0; leaf2_roughness=0; " + colors + weights, 0.7, 1, 0)[0] * kPi;
  };
  EXPECT_NEAR(sum("leaf1_color=0.3 0.3 0.3; leaf2_color=0.2 0.2 0.2; ", "op1_amount=1; op1_other=1"), 0.5, 1e-5);
  EXPECT_NEAR(sum("leaf1_color=0.3 0.3 0.3; leaf2_color=0.2 0.2 0.2; ", "op1_amount=1; op1_other=0.5"), 0.4, 1e-5);
  EXPECT_NEAR(sum("leaf1_color=1 1 1; leaf2_color=1 1 1; ", "op1_amount=1; op1_other=1"), 1, 1e-5);
  EXPECT_NEAR(sum("leaf1_color=0.9 0.9 0.9; leaf2_color=0.6 0.6 0.6; ", "op1_amount=1; op1_other=1"), 1, 1e-5);
}

// Ratios between pairs of directions are those of the distribution and the visibility; the greatest albedo stays
// below 1, and layers take off what the table says.
TEST(LamaSurface, SheenIsContyAndKullas) {
  const Descriptor* d = kinoraStock_LamaSurface();
  for (const double roughness : {0.2, 0.6, 1.}) {
    const std::string setting = "structure=H; leaf1_color=1 1 1; leaf1_roughness=" + std::to_string(roughness);
    const double a = std::pow(0.1 + 0.9 * roughness, 2);
    double scale = 0;
    for (const double o : {0.8, 0.3})
      for (const double i : {0.7, 0.2})
        for (const double angle : {0.5, 2.}) {
          const Vec3 h = normalized(at(o, 0) + at(i, angle));
          const double f = (2 + 1 / a) * std::pow(1 - double(h.z) * h.z, 0.5 / a) / (2 * kPi) / (4 * (o + i - o * i));
          const double got = valueOf(d, setting, o, i, angle)[0] / (f * i);
          if (scale == 0) scale = got;
          EXPECT_NEAR(got, scale, 2e-3 * scale) << roughness << " " << o << " " << i;
        }
    EXPECT_LE(scale, 1.0001);
    for (const double o : kCosines) {
      const Returned sheen = returnedBy(d, setting, o);
      EXPECT_LE(sheen.spread[0], 1.01);
    }
  }
}

TEST(LamaSurface, GlassIsAbsorbentByItsColourAtTheRadius) {
  const Descriptor* d = kinoraStock_LamaDielectric();
  const BoundBxdf b(*d, *runnableTables(*d).front(),
                    settingOf(d, "reflectivity=0.04; absorptionColor=0.5 1 0.1; absorptionRadius=2"), seenAt(1));
  std::vector<float> v(4 * b.context().padded, -1.f);
  const auto row = [&](uint32_t i) { return v.data() + i * b.context().padded; };
  const InteriorArgs a{row(3), {row(0), row(1), row(2)}};
  b.functions().interior(&b.context(), &a);
  EXPECT_NEAR(row(3)[0], 1.5, 1e-5) << "the index of 0.04";
  EXPECT_NEAR(row(0)[0], -std::log(0.5) / 2, 1e-6);
  EXPECT_EQ(row(1)[0], 0);
  EXPECT_NEAR(row(2)[0], -std::log(0.1) / 2, 1e-6);
}

// Light given off is not scaled by sums, shared by mixes and reduced by what lies on it.
TEST(LamaSurface, EmissionIsSharedAndCovered) {
  const Descriptor* d = kinoraStock_LamaSurface();
  const auto given = [&](const std::string& setting, double cosO) {
    const BoundBxdf b(*d, *runnableTables(*d).front(), settingOf(d, setting), seenAt(cosO));
    std::vector<float> v(3 * b.context().padded, -1.f);
    float* rgb[3] = {v.data(), v.data() + b.context().padded, v.data() + 2 * b.context().padded};
    b.functions().emission(&b.context(), b.context().closure, rgb);
    return double(rgb[1][0]);
  };
  EXPECT_NEAR(given("structure=E; leaf1_color=1 3 1", 0.5), 3, 1e-6);
  EXPECT_NEAR(given("structure=DEP; leaf1_color=1 1 1; leaf2_color=1 3 1; op1_other=2", 0.5), 6, 1e-5);
  EXPECT_NEAR(given("structure=DEM; leaf2_color=1 3 1; op1_amount=0.25", 0.5), 0.75, 1e-6);
  EXPECT_NEAR(given("structure=ERL; leaf1_color=1 3 1; leaf2_color=1 1 1; leaf2_roughness=0", 0.5),
              3 * (1 - conductor(0.5, 1.5)), 1e-4);
  EXPECT_EQ(given("structure=D", 0.5), 0);
}

// No text that a scene could give is taken for a tree that it is not.
TEST(LamaSurface, BrokenStructuresAreADiffuseSurface) {
  const Descriptor* d = kinoraStock_LamaSurface();
  for (const std::string text : {"L", "DL", "DD", "KDL", "UXMYM", "DDDDDDDDDLLLLLLLL", "D L", "DDDMMMM"}) {
    Setting s = settingOf(d, "leaf1_color=0.5 0.5 0.5");
    for (uint32_t i = 0; i < d->paramCount; ++i)
      if (std::string(d->params[i].name) == "structure") s.strings[i] = {text};
    TestContextOptions options;
    options.slots = Slots::One;
    const BoundBxdf b(*d, *runnableTables(*d).front(), s, seenAt(0.8), options);
    Evaluation e(1);
    e.set(0, at(0.6, 1));
    b.evaluate(e);
    EXPECT_NEAR(e.weight(0, 0, 0), 0.5 / kPi * 0.6, 1e-6) << text;
  }
}

// Without a dielectric (index 1) the opaque part is the course's diffuse and sheen.
TEST(PxrDisneyBsdf, DiffuseAndSheenAreTheCourses) {
  const Descriptor* d = kinoraStock_PxrDisneyBsdf();
  const double base[3] = {0.8, 0.4, 0.2}, r = 0.7, luminance = 0.3 * 0.8 + 0.6 * 0.4 + 0.1 * 0.2;
  const auto weight = [](double c) { return std::pow(1 - c, 5); };
  for (const double o : kCosines)
    for (const double i : kCosines)
      for (const double angle : {0.3, 2.5}) {
        const auto f =
            valueOf(d, "baseColor=0.8 0.4 0.2; roughness=0.7; ior=1; sheen=0.6; sheenTint=0.3", o, i, angle);
        const Vec3 h = normalized(at(o, 0) + at(i, angle));
        const double half = dot(h, at(i, angle)), fl = weight(i), fv = weight(o), retro = 2 * r * half * half;
        const double diffuse = (1 - fl / 2) * (1 - fv / 2) + retro * (fl + fv + fl * fv * (retro - 1));
        for (size_t k = 0; k < 3; ++k) {
          const double sheen = 0.6 * (0.7 + 0.3 * base[k] / luminance) * weight(half);
          EXPECT_NEAR(f[k], (base[k] / kPi * diffuse + sheen) * i, 2e-5) << o << " " << i;
        }
      }
}

TEST(PxrDisneyBsdf, PartsAreWhatTheirParametersSay) {
  const Descriptor* d = kinoraStock_PxrDisneyBsdf();
  for (const double c : kCosines) {
    const double schlick = std::pow(1 - c, 5);
    const Returned metal = returnedBy(d, "baseColor=0.9 0.5 0.1; metallic=1; roughness=0", c);
    EXPECT_NEAR(metal.mirrored[0], 0.9 + 0.1 * schlick, 1e-4);
    EXPECT_NEAR(metal.mirrored[2], 0.1 + 0.9 * schlick, 1e-4);
    const Returned plastic = returnedBy(d, "baseColor=0 0 0; roughness=0; ior=1.5; specReflectScale=0.5", c);
    EXPECT_NEAR(plastic.mirrored[0], 0.5 * conductor(c, 1.5), 1e-4);
    // half of the diffuse passes a sheet of diffTrans 1, all at 2
    const auto back = valueOf(d, "baseColor=0.6 0.6 0.6; ior=1; diffTrans=1; thin=1", c, -0.5, 1);
    EXPECT_NEAR(back[0], 0.3 / kPi * 0.5, 1e-6);
  }
}

// What a bump reflects that leans towards the light, beside what it would: Chiang, Li and Burley's curve. Not the other
// way round, where nothing leans, and where it is switched off.
TEST(BumpShadowing, FadesWhatLeansTowardsTheLight) {
  const struct {
    const Descriptor* plugin;
    std::string parameter, normal, more;
  } cases[] = {
      {kinoraStock_PxrSurface(), "shadowBumpTerminator", "bumpNormal", ""},
      {kinoraStock_PxrSurface(), "shadowBumpTerminator", "diffuseBumpNormal", ""},
      {kinoraStock_PxrSurface(), "shadowBumpTerminator", "bumpNormal",
       "; diffuseGain=0; specularEdgeColor=1 1 1; specularFaceColor=1 1 1; specularRoughness=0.5"},
      {kinoraStock_PxrSurface(), "shadowBumpTerminator", "bumpNormal",
       "; diffuseGain=0; fuzzGain=1; fuzzConeAngle=60"},
      {kinoraStock_PxrSurface(), "shadowBumpTerminator", "bumpNormal", "; diffuseGain=0; subsurfaceGain=1"},
      {kinoraStock_PxrLayerSurface(), "shadowBumpTerminator", "bumpNormal", ""},
      {kinoraStock_PxrDisneyBsdf(), "shadowBumpTerminator", "bumpNormal", "; sheen=1; clearcoat=1"},
      {kinoraStock_LamaDiffuse(), "bumpShadowing", "normal", ""},
      {kinoraStock_LamaSheen(), "bumpShadowing", "normal", "; roughness=1"},
      {kinoraStock_LamaSSS(), "bumpShadowing", "sssNormal", ""},
      {kinoraStock_LamaTricolorSSS(), "bumpShadowing", "sssNormal", ""},
      {kinoraStock_LamaConductor(), "bumpShadowing", "normal", "; roughness=0.6"},
      {kinoraStock_LamaGeneralizedSchlick(), "bumpShadowing", "normal", "; roughness=0.6"},
      {kinoraStock_LamaIridescence(), "bumpShadowing", "normal", "; roughness=0.6"},
      {kinoraStock_LamaSurface(), "leaf1_bumpShadowing", "leaf1_normal", ""},
  };
  for (const auto& c : cases) {
    const auto ratio = [&](const char* normal, double cosine, double angle) {
      const std::string rest = "; " + c.normal + "=" + normal + c.more;
      const double off = valueOf(c.plugin, c.parameter + "=0" + rest, 0.9, cosine, angle)[1];
      EXPECT_GT(off, 1e-6) << c.plugin->name << rest;
      EXPECT_NEAR(valueOf(c.plugin, c.parameter + "=1" + rest, 0.9, cosine, angle)[1],
                  valueOf(c.plugin, rest.substr(2), 0.9, cosine, angle)[1], 1e-9)
          << "it is on by itself";
      return valueOf(c.plugin, c.parameter + "=1" + rest, 0.9, cosine, angle)[1] / off;
    };
    for (const double cosine : {0.02, 0.1, 0.4}) {
      const double sine = std::sqrt(1 - cosine * cosine), g = cosine / ((0.6 * sine + 0.8 * cosine) * 0.8);
      EXPECT_NEAR(ratio("0.6 0 0.8", cosine, 0), g * (1 + g - g * g), 2e-3) << c.plugin->name << c.more;
    }
    EXPECT_NEAR(ratio("0.6 0 0.8", 0.9, kPi), 1, 1e-5) << c.plugin->name << c.more;
    EXPECT_NEAR(ratio("0 0 1", 0.1, 0), 1, 1e-5) << c.plugin->name << c.more;
    EXPECT_NEAR(ratio("0 0 0", 0.1, 0), 1, 1e-9) << c.plugin->name << c.more << ": not bumped";
  }
}

}  // namespace
}  // namespace testing
}  // namespace kinora
