// PxrDisney against the formulas of Burley's course of 2012, worked out here in double precision and in the course's
// own form; and how well it is sampled. The registry's statistics cover densities, reciprocity and the energy of
// metals.
#include <gtest/gtest.h>

#include <array>

#include <kinora/testing/statistics.h>
#include "testing/bound_bxdf.h"

namespace kinora {
const Descriptor* kinoraStock_PxrDisney();

namespace testing {
namespace {

const bool kFloatMode = (setThreadFloatMode(), true);  // as in a render
constexpr double kPi = 3.14159265358979323846;

Setting settingOf(const std::string& text) {
  Setting s;
  std::string error;
  EXPECT_TRUE(parseSetting(*kinoraStock_PxrDisney(), text, s, error)) << error;
  return s;
}
const WidthTable& widest() { return *runnableTables(*kinoraStock_PxrDisney()).back(); }
double schlick(double x) { return std::pow(1 - x, 5); }
double mix(double a, double b, double t) { return a + t * (b - a); }

// The tangent is x, the normal z.
struct Pair {
  Vec3 l, v;
};
std::vector<Pair> pairs(uint32_t n) {
  std::vector<Pair> r(n);
  Random random(5);
  const auto direction = [&] {
    const double z = 0.05 + 0.95 * random.uniform(), phi = 2 * kPi * random.uniform(), s = std::sqrt(1 - z * z);
    return Vec3{float(s * std::cos(phi)), float(s * std::sin(phi)), float(z)};
  };
  for (Pair& p : r) p = {direction(), direction()};
  return r;
}
// Weights of the four lobes for each pair; the weight includes the cosine of l.
std::vector<std::array<std::array<double, 3>, 4>> weights(const std::string& setting, const std::vector<Pair>& list) {
  TestPoints p;
  p.wo.clear();
  for (const Pair& x : list) p.wo.push_back(x.v);
  p.tangent = {{1, 0, 0}};
  const BoundBxdf b(*kinoraStock_PxrDisney(), widest(), settingOf(setting), p);
  Evaluation e(uint32_t(list.size()));
  for (uint32_t i = 0; i < list.size(); ++i) e.set(i, list[i].l);
  b.evaluate(e);
  std::vector<std::array<std::array<double, 3>, 4>> r(list.size());
  for (uint32_t i = 0; i < list.size(); ++i)
    for (uint32_t lobe = 0; lobe < 4; ++lobe)
      for (int k = 0; k < 3; ++k) r[i][lobe][size_t(k)] = e.weight(b.context().slotOfLobe[lobe], k, i);
  return r;
}
enum { kDiffuse, kSpecular, kCoat, kSheen };

TEST(PxrDisney, DiffuseSheenAndCoatAreTheCourses) {
  const double base[3] = {0.8, 0.4, 0.2}, roughness = 0.6, subsurface = 0.3, metallic = 0.25, sheen = 0.7,
               sheenTint = 0.4, coat = 0.8, gloss = 0.3;
  const auto list = pairs(200);
  const auto got = weights(
      "baseColor=0.8 0.4 0.2; roughness=0.6; subsurface=0.3; metallic=0.25; sheen=0.7; "
      "sheenTint=0.4; clearcoat=0.8; clearcoatGloss=0.3",
      list);
  for (size_t i = 0; i < list.size(); ++i) {
    const Vec3 h = normalized(list[i].l + list[i].v);
    const double nl = list[i].l.z, nv = list[i].v.z, nh = h.z, lh = dot(list[i].l, h);
    const double fl = schlick(nl), fv = schlick(nv), fh = schlick(lh);
    const double fd90 = 0.5 + 2 * lh * lh * roughness, fd = mix(1, fd90, fl) * mix(1, fd90, fv);
    const double fss90 = lh * lh * roughness, fss = mix(1, fss90, fl) * mix(1, fss90, fv);
    const double ss = 1.25 * (fss * (1 / (nl + nv) - 0.5) + 0.5);
    const double luminance = 0.3 * base[0] + 0.6 * base[1] + 0.1 * base[2];
    const double a = mix(0.1, 0.001, gloss), a2 = a * a;
    const double d = (a2 - 1) / (kPi * std::log(a2) * (1 + (a2 - 1) * nh * nh));
    const auto g = [](double x) { return 1 / (x + std::sqrt(0.0625 + x * x - 0.0625 * x * x)); };
    for (size_t k = 0; k < 3; ++k) {
      const double diffuse = mix(fd, ss, subsurface) * base[k] / kPi * (1 - metallic) * nl;
      const double cloth = fh * sheen * mix(1, base[k] / luminance, sheenTint) * (1 - metallic) * nl;
      EXPECT_NEAR(got[i][kDiffuse][k], diffuse, 1e-6 + 1e-5 * diffuse);
      EXPECT_NEAR(got[i][kSheen][k], cloth, 1e-6 + 1e-4 * cloth);
    }
    const double highlight = 0.25 * coat * g(nl) * g(nv) * mix(0.04, 1, fh) * d * nl;
    EXPECT_NEAR(got[i][kCoat][0], highlight, 1e-6 + 1e-3 * highlight);
  }
}

// The course's specular lobe: GTR2, masking of alpha ((1 + roughness) / 2)^2 for each direction apart, Schlick's
// Fresnel between its colours. All roughnesses, grazing directions too.
TEST(PxrDisney, SpecularIsTheCourses) {
  const double base[3] = {0.9, 0.5, 0.1};
  auto list = pairs(300);
  for (size_t i = 0; i < list.size(); i += 2)  // every other one near the mirror direction
    list[i].l = normalized(list[i].l + Vec3{-list[i].v.x, -list[i].v.y, list[i].v.z} * 20.f);
  for (const double roughness : {0.1, 0.3, 0.6, 1.})
    for (const double anisotropic : {0., 0.6, 1.})
      for (const double metallic : {0., 0.5, 1.}) {
        const auto got =
            weights("baseColor=0.9 0.5 0.1; specular=0.8; specularTint=0.7; roughness=" + std::to_string(roughness) +
                        "; anisotropic=" + std::to_string(anisotropic) + "; metallic=" + std::to_string(metallic),
                    list);
        const double aspect = std::sqrt(1 - 0.9 * anisotropic), alpha = roughness * roughness;
        const double ax = std::max(0.001, alpha / aspect), ay = std::max(0.001, alpha * aspect);
        const double luminance = 0.3 * base[0] + 0.6 * base[1] + 0.1 * base[2];
        for (size_t i = 0; i < list.size(); ++i) {
          const double nl = list[i].l.z, nv = list[i].v.z;
          // half vector in double precision: narrow highlights see the rounding of single precision
          double h[3], length = 0, lh = 0;
          for (int k = 0; k < 3; ++k) {
            h[k] = double((&list[i].l.x)[k]) + (&list[i].v.x)[k];
            length += h[k] * h[k];
          }
          for (int k = 0; k < 3; ++k) lh += (h[k] /= std::sqrt(length)) * (&list[i].l.x)[k];
          const double q = h[0] * h[0] / (ax * ax) + h[1] * h[1] / (ay * ay) + h[2] * h[2];
          const double d = 1 / (kPi * ax * ay * q * q), ag = std::pow(0.5 + roughness / 2, 2);
          const auto g = [&](double x) { return 1 / (x + std::sqrt(ag * ag + x * x - ag * ag * x * x)); };
          for (size_t k = 0; k < 3; ++k) {
            const double f0 = mix(0.8 * 0.08 * mix(1, base[k] / luminance, 0.7), base[k], metallic);
            const double expected = d * g(nl) * g(nv) * mix(f0, 1, schlick(lh)) * nl;
            EXPECT_NEAR(got[i][kSpecular][k], expected, 1e-6 + 1e-3 * expected)
                << roughness << " " << anisotropic << " " << metallic;
          }
        }
      }
}

TEST(PxrDisney, MetalHasNoDiffuseAndBlackSubsurfaceColorIsTheBase) {
  const auto list = pairs(50);
  const auto metal = weights("metallic=1; sheen=1", list), one = weights("subsurface=1", list),
             two = weights("subsurface=1; subsurfaceColor=0.2 0.5 0.8", list),
             red = weights("subsurface=1; subsurfaceColor=1 0 0", list);
  for (size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(metal[i][kDiffuse][1], 0);
    EXPECT_EQ(metal[i][kSheen][1], 0);
    EXPECT_EQ(one[i][kDiffuse], two[i][kDiffuse]);
    EXPECT_EQ(red[i][kDiffuse][1], 0);
    EXPECT_GT(red[i][kDiffuse][0], 0);
  }
}

TEST(PxrDisney, EmitsAndIsPresentAsTold) {
  TestPoints p;
  const BoundBxdf b(*kinoraStock_PxrDisney(), widest(), settingOf("emitColor=3 2 1; presence=0.25"), p);
  std::vector<float> v(3 * b.context().padded, -1.f);
  float* rgb[3] = {v.data(), v.data() + b.context().padded, v.data() + 2 * b.context().padded};
  b.functions().emission(&b.context(), b.context().closure, rgb);
  EXPECT_EQ(rgb[0][0], 3);
  EXPECT_EQ(rgb[2][0], 1);
  b.functions().presence(&b.context(), rgb[0]);
  EXPECT_EQ(rgb[0][0], 0.25f);
}

// Weight over density is what a path is multiplied by: near the albedo for a lobe that is sampled well. The bounds
// are a little above what is seen today; a technique that is missing or chosen too seldom goes far beyond them.
TEST(PxrDisney, SamplesHaveNoHeavyWeights) {
  const struct {
    const char* setting;
    double most;
  } cases[] = {{"", 1.6},
               {"roughness=0.05", 1.6},
               {"roughness=1; metallic=1; baseColor=1 1 1", 2.7},
               {"roughness=0.4; clearcoat=1; clearcoatGloss=0", 2.5},
               {"roughness=0.4; clearcoat=1", 2.5},
               {"roughness=0.9; sheen=1; baseColor=0.1 0.1 0.1", 6},
               {"roughness=0.3; metallic=1; anisotropic=1", 1.6},
               {"subsurface=1; roughness=0.8", 1.7}};
  constexpr uint32_t n = 16384;
  for (const auto& one : cases)
    for (const float cosine : {0.95f, 0.5f, 0.1f}) {
      TestPoints p;
      p.wo = {{std::sqrt(1 - cosine * cosine), 0, cosine}};
      p.P.assign(n, {0, 0, 0});
      TestContextOptions options;
      options.slots = Slots::One;
      const BoundBxdf b(*kinoraStock_PxrDisney(), widest(), settingOf(one.setting), p, options);
      Generation g(n);
      Random random(11);
      for (uint32_t i = 0; i < n; ++i)
        for (int k = 0; k < 4; ++k) g.u(k)[i] = random.uniformFloat();
      b.generate(g);
      double most = 0;
      uint32_t valid = 0;
      for (uint32_t i = 0; i < n; ++i)
        if (g.valid(i)) {
          ++valid;
          most = std::max(most, (double(g.weight(0, i)) + g.weight(1, i) + g.weight(2, i)) / 3 / g.pdf(i));
        }
      EXPECT_LE(most, one.most) << one.setting << " cos " << cosine;
      // facets of alpha 1 reflect nearly every other ray into the surface
      EXPECT_GT(valid, n / 2) << one.setting << " cos " << cosine;
    }
}

// What a white metal returns: samples against an integral of the course's formula over half vectors. The figures that
// the page names are among them.
TEST(PxrDisney, WhiteMetalReturnsWhatTheFormulaSays) {
  const auto returned = [](double roughness, double anisotropic, double cosine, double phi) {
    constexpr uint32_t n = 16384;
    const double sine = std::sqrt(1 - cosine * cosine);
    TestPoints p;
    p.wo = {{float(sine * std::cos(phi)), float(sine * std::sin(phi)), float(cosine)}};
    p.tangent = {{1, 0, 0}};
    p.P.assign(n, {0, 0, 0});
    TestContextOptions options;
    options.slots = Slots::One;
    const BoundBxdf b(*kinoraStock_PxrDisney(), widest(),
                      settingOf("baseColor=1 1 1; metallic=1; roughness=" + std::to_string(roughness) +
                                "; anisotropic=" + std::to_string(anisotropic)),
                      p, options);
    Generation g(n);
    for (uint32_t i = 0; i < n; ++i) {  // R3 sequence (Roberts)
      const double steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
      for (int k = 0; k < 3; ++k) g.u(k)[i] = float(std::min(std::fmod(0.5 + steps[k] * (i + 1), 1.0), 0.9999999));
      g.u(3)[i] = 0.5f;
    }
    b.generate(g);
    double sum = 0;
    for (uint32_t i = 0; i < n; ++i)
      if (g.valid(i)) sum += g.weight(0, i) / g.pdf(i);
    return sum / n;
  };
  // over half vectors: tangent of their angle / alpha = tan(x), and azimuth
  const auto integral = [](double roughness, double anisotropic, double cosine, double phi) {
    const double aspect = std::sqrt(1 - 0.9 * anisotropic), alpha = roughness * roughness, ax = alpha / aspect,
                 ay = alpha * aspect, ag = std::pow(0.5 + roughness / 2, 2), sine = std::sqrt(1 - cosine * cosine);
    const double v[3] = {sine * std::cos(phi), sine * std::sin(phi), cosine};
    const auto g = [&](double x) { return 2 * x / (x + std::sqrt(ag * ag + x * x - ag * ag * x * x)); };
    constexpr int n = 600;
    double sum = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double x = (i + 0.5) / n * kPi / 2, y = (j + 0.5) / n * 2 * kPi, t = std::tan(x);
        double h[3] = {ax * t * std::cos(y), ay * t * std::sin(y), 1}, length = 0, vh = 0;
        for (const double c : h) length += c * c;
        for (int k = 0; k < 3; ++k) vh += (h[k] /= std::sqrt(length)) * v[k];
        const double nl = 2 * vh * h[2] - v[2];
        if (vh <= 0 || nl <= 0) continue;
        // D (n.h) dh = sin cos dx dy / pi in these variables; dl = 4 (v.h) dh
        const double facets = std::sin(x) * std::cos(x) * 2 * kPi * (kPi / 2) / (n * n) / kPi;
        sum += facets * g(nl) * g(cosine) * vh / (cosine * h[2]);
      }
    return sum;
  };
  for (const double roughness : {0.25, 0.5, 0.75, 1.})
    for (const double anisotropic : {0., 0.5, 1.})
      for (const double cosine : {0.999, 0.6, 0.25})
        for (const double phi : {0.0, 0.8, 1.57}) {
          const double expected = integral(roughness, anisotropic, cosine, phi);
          EXPECT_NEAR(returned(roughness, anisotropic, cosine, phi), expected, 0.01 * expected + 0.002)
              << "roughness " << roughness << " anisotropic " << anisotropic << " cos " << cosine << " phi " << phi;
        }
  EXPECT_NEAR(returned(0.25, 0, 1, 0), 0.99, 0.006);
  EXPECT_NEAR(returned(0.5, 0, 1, 0), 0.88, 0.006);
  EXPECT_NEAR(returned(1, 0, 1, 0), 0.31, 0.006);
  EXPECT_NEAR(returned(0.25, 0, 0.25, 0), 0.51, 0.01);
  EXPECT_NEAR(returned(0.5, 0, 0.25, 0), 0.50, 0.01);
  EXPECT_NEAR(returned(1, 0, 0.25, 0), 0.49, 0.01);
  // a mirror is masked like the smoothest highlight, of alpha 1 / 4
  const double masking = 2 * 0.25 / (0.25 + std::sqrt(0.0625 + 0.0625 - 0.0625 * 0.0625));
  EXPECT_NEAR(returned(0, 0, 0.25, 0), masking * masking, 1e-3);
}

}  // namespace
}  // namespace testing
}  // namespace kinora
