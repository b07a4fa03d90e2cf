// White furnaces. Proves, through the whole renderer: a plane of each bxdf at its declared settings shows, under a
// constant sky, the albedo that an integration of the bxdf's own evaluate() gives (0.3 %); spheres of lossless
// settings vanish (1 %) under a sky and inside a closed glowing shell, where only scattered rays find light. The loop
// is over the registry. Misses: what an albedo should be (the kit's and each bxdf's own tests), textures, subsurface,
// and settings that are not declared.
#include <gtest/gtest.h>
#include <kinora/bxdf.h>

#include <algorithm>
#include <cmath>

#include "support/render_scene.h"
#include "testing/bxdf_case.h"
#include "testing/sphere_quadrature.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

struct Setting {
  const Descriptor* bxdf;
  std::string text;
  bool lossless;
};
std::vector<Setting> declaredSettings(const Registry& registry) {
  std::vector<Setting> list;
  for (const Descriptor* d : registry.all(Kind::Bxdf)) {
    const auto* traits = static_cast<const BxdfTraits*>(d->traits);
    list.push_back({d, "", false});
    for (const char* const* s = traits ? traits->lossless : nullptr; s && *s; ++s) list.push_back({d, *s, true});
    for (const char* const* s = traits ? traits->conserving : nullptr; s && *s; ++s) list.push_back({d, *s, false});
  }
  return list;
}
std::string nameOf(const Setting& s) { return std::string(s.bxdf->name) + " {" + s.text + "}"; }

// Radiance towards a direction at `cosine` under a sky of radiance 1 all round: the integral of evaluate() over all
// directions, plus what discrete lobes say when sampled, plus emission. As the renderer's eye paths see it (radiance
// is scaled by the square of the index at an interface).
std::array<double, 3> albedo(const Setting& s, double cosine) {
  using namespace testing;
  testing::Setting setting;
  std::string error;
  setting = defaultSetting(*s.bxdf);
  if (!s.text.empty() && !parseSetting(*s.bxdf, s.text, setting, error)) {
    ADD_FAILURE() << nameOf(s) << ": " << error;
    return {};
  }
  constexpr uint32_t kPoints = 2048;
  TestPoints p;
  p.N = {{0, 0, 1}};
  p.tangent = {{1, 0, 0}};
  p.wo.assign(kPoints, directionAbout({0, 0, 1}, cosine, 0));
  TestContextOptions options;
  options.slots = Slots::One;
  const BoundBxdf bxdf(*s.bxdf, *runnableTables(*s.bxdf).back(), setting, p, options);
  Random random(7);
  Generation g(kPoints);
  SphereCells cells({0, 0, 1}, 2);
  std::vector<Vec3> pilot;
  std::array<double, 3> discrete{};
  constexpr int kRounds = 32;
  for (int round = 0; round < kRounds; ++round) {
    for (uint32_t i = 0; i < kPoints; ++i)
      // the lobe's number is stratified: only it decides how much discrete lobes get
      for (int k = 0; k < 4; ++k)
        g.u(k)[i] = k == 2 ? float((i + random.uniform()) / kPoints) : random.uniformFloat();
    bxdf.generate(g);
    for (uint32_t i = 0; i < kPoints; ++i) {
      if (g.discrete(i))
        for (int k = 0; k < 3; ++k) discrete[size_t(k)] += double(g.weight(k, i)) / g.pdf(i) / (kRounds * kPoints);
      else if (round == 0 && g.valid(i))
        pilot.push_back(g.wi(i));
    }
  }
  cells.refine(pilot, 24);
  const auto evaluate = [&](uint32_t n, const float* const wi[3], double* out) {
    static thread_local Evaluation e(4096);
    if (e.count() != n) e = Evaluation(n);
    for (uint32_t i = 0; i < n; ++i) e.set(i, {wi[0][i], wi[1][i], wi[2][i]});
    bxdf.evaluateAt(0, e);
    for (int k = 0; k < 3; ++k)
      for (uint32_t i = 0; i < n; ++i) out[size_t(k) * n + i] = e.total(1, k, i);
  };
  const SphereIntegral integral = integrateSphere(cells, evaluate, 3, 3, 2e-5, 300000);
  std::array<double, 3> sum{};
  for (size_t k = 0; k < 3; ++k) sum[k] = discrete[k] + integral.total[k];
  if (bxdf.functions().emission) {
    std::vector<float> e(3 * size_t(bxdf.context().padded));
    float* rgb[3] = {e.data(), e.data() + bxdf.context().padded, e.data() + 2 * bxdf.context().padded};
    bxdf.functions().emission(&bxdf.context(), bxdf.context().closure, rgb);
    for (size_t k = 0; k < 3; ++k) sum[k] += rgb[k][0];
  }
  return sum;
}

std::string bxdfRib(const Setting& s) {
  return "Bxdf \"" + std::string(s.bxdf->name) + "\" \"b\"" + asRib(*s.bxdf, s.text) + "\n";
}

TEST(Furnace, PlaneShowsTheAlbedoOfEachBxdf) {
  const Registry registry;
  int checked = 0;
  for (const Setting& s : declaredSettings(registry))
    for (const double cosine : {0.95, 0.35}) {
      if (s.bxdf->flags & kBxdfFillsSpace) continue;  // planes are full of nothing
      const auto expected = albedo(s, cosine);
      const std::string angle = std::to_string(std::acos(cosine) * 180 / 3.14159265358979);
      RenderRequest r;
      r.rib = orthographic(16, 0.01, 64) + unbiased(0) +
              "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" + bxdfRib(s) +
              "Translate 0 0 5 Rotate " + angle +
              " 0 1 0\nPolygon \"vertex point P\" [-1 -1 0  -1 1 0  1 1 0  1 -1 0]\nWorldEnd\n";
      // More seeds until the error is small enough for the question: a quarter of what may differ. The first tells
      // whether few samples do.
      testing::Moments mean[3];
      for (uint32_t seed = 1; seed <= 33; ++seed) {
        r.settings.seed = seed;
        r.settings.samplesPerPixel = seed == 1 ? 64 : 256;
        SceneRender render(r);
        ASSERT_TRUE(render.ok()) << nameOf(s);
        const image::Image picture = render.channel("Ci");
        bool enough = true;
        if (seed == 2) std::fill(mean, mean + 3, testing::Moments());  // pixels of as many samples each
        for (int c = 0; c < 3; ++c) {
          for (size_t i = size_t(c); i < picture.pixels.size(); i += 3) mean[c].add(picture.pixels[i]);
          enough = enough && mean[c].standardError() <= 7.5e-4 * expected[size_t(c)];
        }
        if (enough) break;
      }
      for (int c = 0; c < 3; ++c) {
        const double e = expected[size_t(c)];
        EXPECT_NEAR(mean[c].mean(), e, 3e-3 * e + 1e-6) << nameOf(s) << " cosine " << cosine << " channel " << c
                                                        << ", standard error " << mean[c].standardError();
        EXPECT_LE(mean[c].standardError(), 1e-3 * e + 1e-7) << nameOf(s) << ": too noisy to judge";
      }
      ++checked;
    }
  EXPECT_GT(checked, 60);
}

// Very rough glass of a high index throws paths about inside for long: some settings need many samples to be judged.
void expectVanished(const std::string& rib, const Setting& s, const char* where) {
  RenderRequest r;
  r.rib = rib;
  testing::Moments m[3];
  image::Image picture;
  double worst = 1;
  for (uint32_t seed = 1; seed <= (worst > 0.005 ? 96 : 24); ++seed) {
    r.settings.seed = seed;
    SceneRender render(r);
    ASSERT_TRUE(render.ok()) << nameOf(s);
    picture = render.channel("Ci");
    worst = 0;
    for (int c = 0; c < 3; ++c) {
      for (size_t i = size_t(c); i < picture.pixels.size(); i += 3) m[c].add(picture.pixels[i]);
      worst = std::max(worst, m[c].standardError());
    }
    if (worst <= 0.003) break;
  }
  for (int c = 0; c < 3; ++c)
    // 1 % is the promise; three standard errors are chance
    if (std::abs(m[c].mean() - 1) > 0.01 + 3 * m[c].standardError() || m[c].standardError() > 0.005)
      ADD_FAILURE() << nameOf(s) << ' ' << where << ": " << m[c].mean() << " instead of 1, standard error "
                    << m[c].standardError() << "; picture: " << SceneRender::keep(picture, "furnace");
}

const char* const kSphere = "AttributeBegin Translate 0 0 5 Sphere 1 -1 1 360 AttributeEnd\n";

TEST(Furnace, LosslessSpheresVanishUnderASky) {
  const Registry registry;
  for (const Setting& s : declaredSettings(registry))
    if (s.lossless)
      expectVanished(orthographic(32, 0.7, 64) + unbiased(64) +
                         "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" + bxdfRib(s) +
                         kSphere + "WorldEnd\n",
                     s, "under a sky");
}

TEST(Furnace, LosslessSpheresVanishInsideAGlowingShell) {
  const Registry registry;
  for (const Setting& s : declaredSettings(registry))
    if (s.lossless)
      expectVanished(orthographic(32, 0.7, 64) + unbiased(64) +
                         "WorldBegin\nAttributeBegin Bxdf \"PxrConstant\" \"shell\" \"color emitColor\" [1 1 1]\n"
                         "Translate 0 0 5 Sphere 20 -20 20 360 AttributeEnd\n" +
                         bxdfRib(s) + kSphere + "WorldEnd\n",
                     s, "inside a shell");
}

// Glass in glass: one ball within another, two that overlap, by priority and without; rough and smooth. Nothing is
// lost.
TEST(Furnace, NestedGlassVanishes) {
  for (const char* roughness : {"0", "0.3"})
    for (const auto& [inner, priority] : {std::pair{"Translate 0 0 5 Sphere 0.6 -0.6 0.6 360", 2},
                                          std::pair{"Translate 0 0 5 Sphere 0.6 -0.6 0.6 360", 0},
                                          std::pair{"Translate 0.7 0 5 Sphere 0.8 -0.8 0.8 360", 2},
                                          std::pair{"Translate 0.7 0 5 Sphere 0.8 -0.8 0.8 360", -1}}) {
      const std::string glass =
          "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" "
          "[1] "
          "\"float glassRoughness\" [" +
          std::string(roughness) + "] \"float glassIor\" ";
      RenderRequest r;
      r.rib = orthographic(32, 0.6, 64) + unbiased(64) +
              "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n" + glass + "[1.5]\n" + kSphere +
              "AttributeBegin Attribute \"trace\" \"int intersectpriority\" [" + std::to_string(priority) + "]\n" +
              glass + "[1.33]\n" + inner + "\nAttributeEnd\nWorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const image::Image picture = render.channel("Ci");
      const auto m = overPixels(picture);
      EXPECT_NEAR(m.mean(), 1, 0.01) << inner << " priority " << priority << " roughness " << roughness
                                     << ", standard error " << m.standardError()
                                     << "; picture: " << SceneRender::keep(picture, "nested");
      EXPECT_LT(m.standardError(), 0.004);
    }
}

// The camera inside a closed diffuse shell that glows: radiance is e / (1 - albedo) everywhere.
TEST(Furnace, InsideAClosedDiffuseShell) {
  for (const double reflectance : {0.2, 0.5, 0.8}) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 64) + unbiased(64) +
            "WorldBegin\nBxdf \"PxrSurface\" \"shell\" \"color diffuseColor\" [" + std::to_string(reflectance) +
            " 0.5 0] " +
            "\"int diffuseDoubleSided\" [1] \"float glowGain\" [1] \"color glowColor\" [1 1 1]\nSphere 2 -2 2 "
            "360\nWorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const image::Image picture = render.channel("Ci");
    EXPECT_MEAN(overPixels(picture, 0), 1 / (1 - reflectance), 0.003 / (1 - reflectance));
    EXPECT_MEAN(overPixels(picture, 1), 2, 0.006);
    EXPECT_MEAN(overPixels(picture, 2), 1, 0.003);
  }
}

}  // namespace
}  // namespace kinora::tests
