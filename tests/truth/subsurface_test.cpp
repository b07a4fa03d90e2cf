// Subsurface scattering through the whole renderer. Proves: closed objects of albedo 1 vanish in a furnace; walks give
// what a brute-force walk of this file's own gives in the same medium inside the same sphere (isotropic, anisotropic,
// heavy tails, unequal channels, a boundary with an index); with a boundary they give what glass of that index gives that
// is full of the medium; the albedo of a wide body is the one asked for, and what one scattering keeps agrees
// with Chandrasekhar's H functions; profiles of diffusion integrate to 1, and an edge of light on a plane blurs as a
// quadrature of their formulas says; open meshes, curves, lengths of 0, 1e20 and NaN, and backs have their fallback and
// their message; paths from both ends have what the path tracer has. Misses: what a profile or an inversion should
// look like to an eye, single scattering through curved boundaries, where it is an approximation, and in which direction light leaves a boundary (by a cosine's law, always).
#include <gtest/gtest.h>
#include <kinora/subsurface_albedo.h>
#include <kinora/testing/statistics.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979324;
using testing::Moments;
using testing::Random;

const char* const kSky = "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n";
// Lengths in render units, alike in all channels unless `more` says which.
std::string wax(const std::string& more) {
  return std::string(
             "Bxdf \"PxrSurface\" \"wax\" \"float diffuseGain\" [0] \"float subsurfaceGain\" [1] \"float "
             "unitLength\" "
             "[1] \"float subsurfaceDiffuseSwitch\" [0] ") +
         (more.find("subsurfaceDmfpColor") == std::string::npos ? "\"color subsurfaceDmfpColor\" [1 1 1] " : "") +
         more + "\n";
}
std::string type(int t) { return "\"int subsurfaceType\" [" + std::to_string(t) + "] "; }
std::string number(const char* name, double x) {
  char text[96];
  std::snprintf(text, sizeof text, "\"float %s\" [%.9g] ", name, x);
  return text;
}
std::string color(const char* name, double r, double g, double b) {
  char text[128];
  std::snprintf(text, sizeof text, "\"color %s\" [%.9g %.9g %.9g] ", name, r, g, b);
  return text;
}
std::string gray(const char* name, double x) { return color(name, x, x, x); }
const char* const kBall =
    "AttributeBegin Attribute \"identifier\" \"string name\" [\"ball\"]\nTranslate 0 0 5 Sphere 1 -1 1 360 "
    "AttributeEnd\n";
const char* const kCube =
    "PointsPolygons [4 4 4 4 4 4] [0 1 3 2  4 6 7 5  0 4 5 1  2 3 7 6  0 2 6 4  1 5 7 3]\n"
    "\"vertex point P\" [-1 -1 -1  -1 -1 1  -1 1 -1  -1 1 1  1 -1 -1  1 -1 1  1 1 -1  1 1 1]\n";

TEST(Subsurface, AlbedoOneVanishesInAFurnace) {
  for (const std::string& how : {type(4) + number("subsurfaceDmfp", 10), type(4) + number("subsurfaceDmfp", 2),
                                 type(4) + number("subsurfaceDmfp", 5) + number("subsurfaceDirectionality", 0.8),
                                 type(4) + number("subsurfaceDmfp", 5) + number("subsurfaceDirectionality", -0.5),
                                 type(5) + number("subsurfaceDmfp", 5) + number("subsurfaceBleed", 1),
                                 type(4) + number("subsurfaceDmfp", 1e20)}) {
    for (const std::string& what :
         {std::string(kBall), std::string("Translate 0 0 5 Rotate 30 1 1 0 Scale 0.7 0.7 0.7\n") + kCube}) {
      RenderRequest r;
      r.rib = orthographic(16, 0.5, 64) + unbiased(8) + "WorldBegin\n" + kSky +
              wax(how + gray("subsurfaceColor", 1)) + what + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      // facets of a diced ball lose what leaves below them: 0.5 % is the promise
      SCOPED_TRACE(how);
      EXPECT_MEAN(overPixels(render.channel("Ci")), 1, 0.005);
      EXPECT_TRUE(render.messages().empty()) << render.messages().front();
    }
  }
}

// Where the lengths are below a pixel's footprint a diffuse surface stands in; profiles without a gain do not count.
TEST(Subsurface, ProfilesWithoutGainReachNowhere) {
  const auto seen = [](const std::string& more) {
    RenderRequest r;
    r.rib = orthographic(8, 1.5, 4) + unbiased(8) + "WorldBegin\n" + kSky +
            wax(type(3) + gray("subsurfaceColor", 0.8) + number("subsurfaceDmfp", 0.001) +
                "\"float subsurfaceDiffuseSwitch\" [1] " + more) +
            kBall + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return render.ok() ? stateOf(render.film()) : std::vector<int64_t>();
  };
  const auto near = seen(number("shortSubsurfaceDmfp", 0.001) + number("longSubsurfaceDmfp", 0.001));
  EXPECT_EQ(near, seen("")) << "their usual lengths are long";
  EXPECT_NE(near, seen(number("longSubsurfaceGain", 0.1)));
}

// Placed, stretched, mirrored and moving objects: sides and lengths are those of the scene.
TEST(Subsurface, PlacedAndMovingObjectsVanishToo) {
  for (const char* place : {"Scale 0.9 1.2 0.7", "Scale -1 1 1",
                            "MotionBegin [0 1] Translate -0.3 0 0 Translate 0.3 0.2 0 MotionEnd Rotate 40 0 1 0"})
    for (const int t : {2, 4}) {
      RenderRequest r;
      r.rib = "Shutter 0 1\n" + orthographic(16, 0.2, 64) + unbiased(8) + "WorldBegin\n" + kSky +
              "ObjectBegin \"b\"\n" +
              wax(type(t) + gray("subsurfaceColor", 1) + number("subsurfaceDmfp", t == 2 ? 0.2 : 4)) +
              "Sphere 1 -1 1 360\nObjectEnd\nAttributeBegin Translate 0 0 5 " + place +
              "\nObjectInstance \"b\"\nAttributeEnd\nWorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      SCOPED_TRACE(std::string(place) + " type " + std::to_string(t));
      // profiles are those of planes: what bends away from the light's side shows
      EXPECT_MEAN(overPixels(render.channel("Ci")), 1, t == 2 ? 0.03 : 0.005);
      for (const std::string& m : render.messages()) EXPECT_EQ(m.find("SUBSURFACE"), std::string::npos) << m;
    }
}

// Fresnel's reflectance, unpolarised; eta: index on the side of the light over the other one.
double reflectance(double mu, double eta) {
  const double sin2 = eta * eta * (1 - mu * mu);
  if (sin2 >= 1) return 1;
  const double co = std::sqrt(1 - sin2), a = (eta * mu - co) / (eta * mu + co), b = (mu - eta * co) / (mu + eta * co);
  return (a * a + b * b) / 2;
}

// What enters a ball of radius 1 evenly by a cosine's law and comes out again, by the simplest walk there is: one
// channel, exponential or power-law flights, absorption by chance. Where the ball has an index, of what enters through
// its boundary, which reflects inside.
Moments bruteForce(double albedo, double length, double g, double tail, uint64_t seed, double ior = 1) {
  Random random(seed);
  Moments out;
  for (int path = 0; path < 400000; ++path) {
    double p[3] = {0, 0, 1}, d[3], mu, s;
    do {
      mu = std::sqrt(random.uniform());
    } while (ior > 1 && random.uniform() < reflectance(mu, 1 / ior));
    s = std::sqrt(1 - mu * mu) / ior;
    mu = std::sqrt(1 - s * s);
    const double phi = 2 * kPi * random.uniform();
    d[0] = s * std::cos(phi), d[1] = s * std::sin(phi), d[2] = -mu;
    bool alive = true, edge = true;
    while (alive) {
      const double e = -std::log(1 - random.uniform());
      const double t = tail > 0 ? (std::exp(e * (edge ? tail : tail / (1 + tail))) - 1) * length / tail : e * length;
      const double b = p[0] * d[0] + p[1] * d[1] + p[2] * d[2], c = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1;
      const double root = b * b - c, reach = -b + std::sqrt(root > 0 ? root : 0);
      if (t >= reach) {
        double size = 0, along = 0;
        for (int k = 0; k < 3; ++k) p[k] += reach * d[k], size += p[k] * p[k];
        for (double& k : p) k /= std::sqrt(size);
        for (int k = 0; k < 3; ++k) along += p[k] * d[k];
        if (ior == 1 || random.uniform() >= reflectance(std::fabs(along), ior)) break;
        for (int k = 0; k < 3; ++k) d[k] -= 2 * along * p[k];
        edge = true;
        continue;
      }
      for (int k = 0; k < 3; ++k) p[k] += t * d[k];
      edge = false;
      alive = random.uniform() < albedo;
      const double u = random.uniform();
      double cosine = 1 - 2 * u;
      if (g != 0) {
        const double q = (1 - g * g) / (1 - g + 2 * g * u);
        cosine = (1 + g * g - q * q) / (2 * g);
      }
      const double sine = std::sqrt(std::fmax(0, 1 - cosine * cosine)), angle = 2 * kPi * random.uniform();
      // any frame about d
      const double m =
          std::fabs(d[0]) < 0.6 ? std::sqrt(d[1] * d[1] + d[2] * d[2]) : std::sqrt(d[0] * d[0] + d[2] * d[2]);
      double x[3], y[3];
      if (std::fabs(d[0]) < 0.6)
        x[0] = 0, x[1] = d[2] / m, x[2] = -d[1] / m;
      else
        x[0] = d[2] / m, x[1] = 0, x[2] = -d[0] / m;
      y[0] = d[1] * x[2] - d[2] * x[1], y[1] = d[2] * x[0] - d[0] * x[2], y[2] = d[0] * x[1] - d[1] * x[0];
      double size = 0;
      for (int k = 0; k < 3; ++k) {
        d[k] = d[k] * cosine + sine * (std::cos(angle) * x[k] + std::sin(angle) * y[k]);
        size += d[k] * d[k];
      }
      for (double& k : d) k /= std::sqrt(size);
    }
    out.add(alive ? 1 : 0);
  }
  return out;
}

// LamaSSS in render units; lengths alike in all channels.
std::string bounded(double ior, const std::string& more) {
  return "Bxdf \"LamaSSS\" \"l\" \"float sssUnitLength\" [1] " + number("sssIOR", ior) + more + "\n";
}

TEST(Subsurface, AlbedoOneVanishesBehindABoundaryToo) {
  for (const std::string& how :
       {bounded(1.5, gray("sssRadius", 0.6)), bounded(1.3, gray("sssRadius", 0.4) + "\"int sssMode\" [1] "),
        bounded(2, gray("sssRadius", 0.5) + number("sssAnisotropy", 0.7)),
        bounded(1.4, gray("sssRadius", 0.5) + number("sssBleed", 1))})
    for (const std::string& what :
         {std::string(kBall), std::string("Translate 0 0 5 Rotate 30 1 1 0 Scale 0.7 0.7 0.7\n") + kCube}) {
      RenderRequest r;
      r.rib = orthographic(16, 0.5, 100) + unbiased(8) + "WorldBegin\n" + kSky + how + what + "WorldEnd\n";
      r.rib.replace(r.rib.find("sssRadius") - 7, 0, gray("color", 1));
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      SCOPED_TRACE(how);
      for (int c = 0; c < 3; ++c) EXPECT_MEAN(overPixels(render.channel("Ci"), c), 1, 0.005);
    }
}

TEST(Subsurface, WalksBehindABoundaryAgreeWithABruteForceWalk) {
  struct Case {
    double albedo[3], length, g, bleed, ior;
  };
  uint64_t seed = 100;
  for (const Case& k : {Case{{0.8, 0.5, 0.2}, 0.3, 0, 0, 1.5}, Case{{0.6, 0.8, 0.9}, 0.5, 0.7, 0, 1.3},
                        Case{{0.7, 0.9, 0.4}, 0.4, -0.5, 0, 2}, Case{{0.8, 0.6, 0.9}, 0.5, 0, 1, 1.4}}) {
    RenderRequest r;
    r.rib = orthographic(32, 0.6, 256) + unbiased(0) + "WorldBegin\n" + kSky +
            bounded(k.ior, color("color", k.albedo[0], k.albedo[1], k.albedo[2]) + gray("sssRadius", k.length) +
                               "\"int albedoInversionMethod\" [1] " + number("sssAnisotropy", k.g) +
                               number("sssBleed", k.bleed)) +
            kBall + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const float tail = float(k.bleed) * kMostTail;
    for (int c = 0; c < 3; ++c) {
      const double alpha = singleScatteringAlbedo(float(k.albedo[c]), float(k.g), tail, float(k.ior));
      const Moments expected = bruteForce(alpha, k.length, k.g, tail, seed++, k.ior);
      const Moments seen = overPixels(render.channel("Ci"), c);
      // 4 standard errors of both, and what the facets of a diced ball lose
      const double chance = 4 * std::hypot(expected.standardError(), seen.standardError());
      EXPECT_NEAR(seen.mean(), expected.mean(), chance + 0.001 * expected.mean())
          << "channel " << c << ", index " << k.ior;
      EXPECT_LE(chance, 0.012) << "too few samples to judge";
    }
  }
}

// The same medium in glass of that index. Over the whole of a ball that parallel rays see, directions of entry are spread
// by a cosine's law; the sky is as bright everywhere, so that it does not matter in which direction light leaves. What
// glass reflects outside it adds, and there is so much less that goes in.
TEST(Subsurface, ABoundaryIsThatOfGlassFullOfTheMedium) {
  for (const auto& [ior, a, g, length] : {std::tuple{1.5, 0.4, 0.0, 0.4}, std::tuple{1.3, 0.3, 0.6, 0.25}}) {
    const double alpha = singleScatteringAlbedo(float(a), float(g), 0, float(ior));
    const auto shown = [&](const std::string& material) {
      RenderRequest r;
      r.rib = orthographic(24, 1.05, 64) + unbiased(400) + "WorldBegin\n" + kSky + material + kBall + "WorldEnd\n";
      return overSeeds(r, 10, "Ci", 1);
    };
    const std::string inverted = "\"int albedoInversionMethod\" [1] ";
    const Moments walks =
        shown(bounded(ior, gray("color", a) + gray("sssRadius", length) + inverted + number("sssAnisotropy", g)));
    const Moments glass = shown(
        "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float "
        "reflectionGain\" [1] \"float glassRoughness\" [0] \"int multiScatter\" [1] " +
        number("glassIor", ior) + gray("extinction", 1 / length) + gray("ssAlbedo", alpha) + number("g", g) + "\n");
    const double enters = diffuseTransmittance(ior);
    const double chance = 4 * std::hypot(glass.standardError(), enters * walks.standardError());
    EXPECT_NEAR(1 - glass.mean(), enters * (1 - walks.mean()), chance) << "index " << ior;
    EXPECT_LE(chance, 0.02 * (1 - glass.mean())) << "too few samples to judge";
  }
}

TEST(Subsurface, WalksAgreeWithABruteForceWalkInABall) {
  struct Case {
    double albedo[3], dmfp, by[3], g, bleed;
  };
  const Case cases[] = {{{0.8, 0.8, 0.8}, 1, {1, 1, 1}, 0, 0},
                        {{0.9, 0.5, 0.2}, 3, {1, 0.4, 0.1}, 0, 0},
                        {{0.6, 0.8, 0.9}, 2, {0.2, 1, 0.5}, 0.7, 0},
                        {{0.7, 0.9, 0.5}, 1.5, {1, 0.5, 0.25}, -0.6, 0},
                        {{0.8, 0.6, 0.95}, 2, {1, 0.5, 0.25}, 0.3, 1}};
  uint64_t seed = 1;
  for (const Case& k : cases) {
    RenderRequest r;
    r.rib = orthographic(32, 0.6, 256) + unbiased(0) + "WorldBegin\n" + kSky +
            wax(type(5) + color("subsurfaceColor", k.albedo[0], k.albedo[1], k.albedo[2]) +
                number("subsurfaceDmfp", k.dmfp) + color("subsurfaceDmfpColor", k.by[0], k.by[1], k.by[2]) +
                number("subsurfaceDirectionality", k.g) + number("subsurfaceBleed", k.bleed)) +
            kBall + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const float tail = float(k.bleed) * kMostTail;
    for (int c = 0; c < 3; ++c) {
      const double alpha = singleScatteringAlbedo(float(k.albedo[c]), float(k.g), tail);
      const double length = meanFreePath(float(k.dmfp * k.by[c]), float(alpha), float(k.g));
      const Moments expected = bruteForce(alpha, length, k.g, tail, seed++);
      const Moments seen = overPixels(render.channel("Ci"), c);
      // 4 standard errors of both, and what the facets of a diced ball lose
      const double chance = 4 * std::hypot(expected.standardError(), seen.standardError());
      EXPECT_NEAR(seen.mean(), expected.mean(), chance + 0.001 * expected.mean())
          << "channel " << c << ", albedo " << k.albedo[c] << ", length " << length;
      EXPECT_LE(chance, 0.012) << "too few samples to judge";
    }
  }
}

// Albedo of a half space of isotropic scattering that light enters by a cosine's law: 1 - 2 sqrt(1 - a) times the
// integral of mu H(mu) (Chandrasekhar 1950, section 39), H by iteration on Gauss points.
double halfSpace(double a) {
  constexpr int n = 64;
  static double mu[n], weight[n];
  static const bool made = [] {
    for (int i = 0; i < n; ++i) {  // Gauss-Legendre by Newton's method
      double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1;
      for (int step = 0; step < 60; ++step) {
        double p0 = 1, p1 = x;
        for (int k = 2; k <= n; ++k) {
          const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
          p0 = p1, p1 = p2;
        }
        slope = n * (x * p1 - p0) / (x * x - 1);
        x -= p1 / slope;
      }
      mu[i] = 0.5 * (1 - x);
      weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
    return true;
  }();
  (void)made;
  double H[n];
  for (double& h : H) h = 1;
  for (int round = 0; round < 400; ++round) {
    double next[n];
    for (int i = 0; i < n; ++i) {
      double sum = 0;
      for (int j = 0; j < n; ++j) sum += weight[j] * mu[j] * H[j] / (mu[i] + mu[j]);
      next[i] = 1 / (std::sqrt(1 - a) + 0.5 * a * sum);
    }
    for (int i = 0; i < n; ++i) H[i] = 0.5 * (H[i] + next[i]);
  }
  double first = 0;
  for (int i = 0; i < n; ++i) first += weight[i] * mu[i] * H[i];
  return 1 - 2 * std::sqrt(1 - a) * first;
}

TEST(Subsurface, OneScatteringKeepsWhatAHalfSpaceNeeds) {
  for (double albedo = 0.05; albedo < 0.99; albedo += 0.07)
    EXPECT_NEAR(halfSpace(double(singleScatteringAlbedo(float(albedo), 0))), albedo, 0.003 * albedo + 2e-4) << albedo;
  EXPECT_EQ(singleScatteringAlbedo(1, 0.5f), 1.f);
  EXPECT_NEAR(singleScatteringAlbedo(0, -0.5f), 0, 0.01);
}

// A block so deep and wide that its middle is a half space.
TEST(Subsurface, WideBodiesHaveTheAlbedoAskedFor) {
  struct Case {
    double albedo[3], g, bleed;
  };
  for (const Case& k : {Case{{0.2, 0.5, 0.8}, 0, 0}, Case{{0.3, 0.6, 0.9}, 0.8, 0}, Case{{0.25, 0.55, 0.85}, -0.7, 0},
                        Case{{0.3, 0.6, 0.9}, 0, 0.5}, Case{{0.3, 0.6, 0.9}, 0, 1}}) {
    RenderRequest r;
    r.rib =
        orthographic(16, 0.1, 600) + unbiased(0) + "WorldBegin\n" + kSky +
        wax(type(5) + color("subsurfaceColor", k.albedo[0], k.albedo[1], k.albedo[2]) + number("subsurfaceDmfp", 1) +
            number("subsurfaceDirectionality", k.g) + number("subsurfaceBleed", k.bleed)) +
        "Translate 0 0 45 Scale 40 40 40\n" + kCube + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    for (int c = 0; c < 3; ++c) {
      const Moments seen = overPixels(render.channel("Ci"), c);
      // 1 % of the albedo for the fits, and chance
      EXPECT_NEAR(seen.mean(), k.albedo[c], 0.01 * k.albedo[c] + 0.002 + 4 * seen.standardError())
          << "g " << k.g << ", bleed " << k.bleed;
      EXPECT_LE(seen.standardError(), 0.0035) << "too few samples to judge";
    }
  }
}

// The same with a boundary, by mean free paths: light that is reflected inside costs the colour nothing. The
// free flights are short: light of these colours reaches a hundred times as far before it is absorbed.
TEST(Subsurface, WideBodiesBehindABoundaryHaveTheAlbedoAskedForToo) {
  struct Case {
    double albedo[3], g, bleed, ior, fit;
  };
  // how far off the fits may be: of exponential flights what tools/make_subsurface_albedo.py says, of power laws the
  // boundary's fit is that of exponential ones
  for (const Case& k : {Case{{0.2, 0.5, 0.8}, 0, 0, 1.33, 0.01}, Case{{0.3, 0.6, 0.8}, 0.6, 0, 1.5, 0.01},
                        Case{{0.3, 0.6, 0.8}, 0, 0, 2, 0.015}, Case{{0.3, 0.6, 0.8}, 0, 1, 1.4, 0.04}}) {
    RenderRequest r;
    r.rib = orthographic(16, 0.1, 600) + unbiased(0) + "WorldBegin\n" + kSky +
            bounded(k.ior, color("color", k.albedo[0], k.albedo[1], k.albedo[2]) + gray("sssRadius", 0.1) +
                               "\"int albedoInversionMethod\" [1] " + number("sssAnisotropy", k.g) +
                               number("sssBleed", k.bleed)) +
            "Translate 0 0 45 Scale 40 40 40\n" + kCube + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    for (int c = 0; c < 3; ++c) {
      const Moments seen = overPixels(render.channel("Ci"), c);
      EXPECT_NEAR(seen.mean(), k.albedo[c], k.fit * k.albedo[c] + 0.002 + 4 * seen.standardError())
          << "g " << k.g << ", bleed " << k.bleed << ", index " << k.ior;
      EXPECT_LE(seen.standardError(), 0.0035) << "too few samples to judge";
    }
  }
}

std::string single(const std::string& more) {
  return std::string("\"float singlescatterGain\" [1] ") +
         (more.find("singlescatterMfpColor") == std::string::npos ? gray("singlescatterMfpColor", 1) : "") + more;
}

// A half space under a sun: what scatters once is T T' a p / (n^2 (m + m')) times the sun's irradiance by its cosine
// (Chandrasekhar 1950, between Fresnel's boundaries as Hanrahan and Krueger 1993 have them), m and m' being the
// cosines inside, whatever the mean free paths are.
TEST(Subsurface, SingleScatteringOfAHalfSpace) {
  for (const auto& [ior, g, turn, light] : {std::tuple{1.0, 0.0, 40.0, 0.0}, std::tuple{1.5, 0.0, 30.0, 50.0},
                                            std::tuple{1.3, 0.6, 55.0, 35.0}, std::tuple{1.4, -0.7, 10.0, 60.0}}) {
    const double albedo[3] = {0.9, 0.6, 0.3};
    const auto shown = [&, light = light, turn = turn](const std::string& material) {
      RenderRequest r;
      r.rib = orthographic(16, 0.1, 256) + unbiased(0) + "WorldBegin\nAttributeBegin Rotate " +
              std::to_string(light) +
              " 1 0 0\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] \"float angleExtent\" "
              "[0]\nAttributeEnd\n" +
              material + "Translate 0 0 90 Rotate " + std::to_string(turn) + " 0 1 0 Scale 40 40 40\n" + kCube +
              "WorldEnd\n";
      return r;
    };
    SceneRender render(shown("Bxdf \"PxrSurface\" \"s\" \"float diffuseGain\" [0] \"float unitLength\" [1] " +
                             single(color("singlescatterColor", albedo[0], albedo[1], albedo[2]) +
                                    number("singlescatterMfp", 0.2) + color("singlescatterMfpColor", 1, 0.5, 0.1) +
                                    number("singlescatterIor", ior) + number("singlescatterDirectionality", g)) +
                             "\n"));
    SceneRender white(shown("Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [1 1 1]\n"));
    ASSERT_TRUE(render.ok() && white.ok());
    const double a = turn * kPi / 180, b = light * kPi / 180, outO = std::cos(a), outI = std::cos(a) * std::cos(b);
    const double inO = std::sqrt(1 - (1 - outO * outO) / (ior * ior)),
                 inI = std::sqrt(1 - (1 - outI * outI) / (ior * ior));
    // between the directions that lead out
    const double between = (std::cos(b) - outO * outI) / (ior * ior) + inO * inI;
    const double phase = (1 - g * g) / (4 * kPi * std::pow(1 + g * g + 2 * g * between, 1.5));
    const double through = (1 - reflectance(outO, 1 / ior)) * (1 - reflectance(outI, 1 / ior)) / (ior * ior);
    const double full = overPixels(white.channel("Ci"), 0).mean();
    ASSERT_GT(full, 0);
    for (int c = 0; c < 3; ++c) {
      const double expected = full * kPi * albedo[c] * through * phase / (inO + inI);
      EXPECT_MEAN(overPixels(render.channel("Ci"), c), expected, 0.01);
    }
  }
}

// Walks without those that scatter once, and single scattering in the same medium, are the walks again: over the whole of a
// ball under a sky that is the same everywhere, without a boundary.
TEST(Subsurface, SingleScatteringIsWhatWalksThenLeaveOut) {
  const double albedo = 0.6, dmfp = 1;
  const double alpha = singleScatteringAlbedo(float(albedo), 0), length = meanFreePath(float(dmfp), float(alpha), 0);
  const auto shown = [](const std::string& more) {
    RenderRequest r;
    r.rib = orthographic(24, 1.05, 64) + unbiased(0) + "WorldBegin\n" + kSky + wax(more) + kBall + "WorldEnd\n";
    return overSeeds(r, 10, "Ci", 1);
  };
  const std::string walks = type(4) + gray("subsurfaceColor", albedo) + number("subsurfaceDmfp", dmfp);
  const auto once = [&](double keeps) {
    return single(gray("singlescatterColor", keeps) + number("singlescatterMfp", length) +
                  number("singlescatterIor", 1));
  };
  const Moments all = shown(walks), rest = shown(walks + once(0));
  EXPECT_SAME_MEAN(shown(walks + once(alpha)), all, 0.003);
  EXPECT_LT(rest.mean(), all.mean() - 20 * rest.standardError());
}

// A lamp, which light samples find, and a glowing polygon like it, which only rays from where light scattered find.
TEST(Subsurface, SingleScatteringFindsWhatLightSamplesDo) {
  const auto scene = [](bool lamp) {
    RenderRequest r;
    r.rib = orthographic(16, 1, lamp ? 64 : 512) + unbiased(1) + "WorldBegin\n" +
            (lamp ? "AttributeBegin ConcatTransform [1 0 0 0  0 0 1 0  0 -1 0 0  0 1.6 5 1]\nLight \"PxrRectLight\" "
                    "\"l\" \"float intensity\" [5] AttributeEnd\n"
                  : "AttributeBegin Sides 1\nBxdf \"PxrSurface\" \"glow\" \"float diffuseGain\" [0] \"float "
                    "glowGain\" [5] \"color glowColor\" [1 1 1]\nPolygon \"vertex point P\" [-0.5 1.6 4.5  0.5 1.6 "
                    "4.5  0.5 1.6 5.5  -0.5 1.6 5.5]\nAttributeEnd\n") +
            "Bxdf \"PxrSurface\" \"s\" \"float diffuseGain\" [0] \"float unitLength\" [1] " +
            single(color("singlescatterColor", 0.9, 0.7, 0.5) + number("singlescatterMfp", 0.7) +
                   number("singlescatterDirectionality", 0.3)) +
            "\n" + kBall + "WorldEnd\n";
    return r;
  };
  EXPECT_SAME_MEAN(overSeeds(scene(true), 8), overSeeds(scene(false), 12), 0.015);
}

// Lengths in render units; of single scattering alone.
std::string plate(const std::string& more) {
  return "Bxdf \"PxrSurface\" \"s\" \"float diffuseGain\" [0] \"float unitLength\" [1] " +
         gray("singlescatterMfpColor", 1) + more + "\n";
}

// Light samples and directions of the phase function share the lights: as much as directions find alone, where nothing is in
// the way, in fog and beside glass that casts tinted shadows; where light scatters forward with a part of the noise that
// light samples have alone. A sky, and a lamp close to the ball, which is at another distance from where light scatters than
// from where it leaves.
TEST(Subsurface, DirectionsAndLightSamplesShareSingleScattering) {
  const std::string lamp =
      "AttributeBegin ConcatTransform [1 0 0 0  0 0 1 0  0 -1 0 0  0 0.3 6.7 1] Light \"PxrRectLight\" \"l\" \"float "
      "intensity\" [5] AttributeEnd\n"
      "AttributeBegin Translate 0 0 6.6 Light \"PxrSphereLight\" \"m\" \"float intensity\" [5] AttributeEnd\n";
  const std::string fog =
      "AttributeBegin Bxdf \"PxrVolume\" \"v\" \"color diffuseColor\" [0.5 0.5 0.5] \"color densityColor\" [0.3 0.2 "
      "0.4]\nVolume \"box\" [-4 4 -4 4 2 9] [0 0 0]\nAttributeEnd\n";
  const std::string glass =
      std::string(
          "AttributeBegin Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] "
          "\"color refractionColor\" [0.4 0.6 0.8] \"float glassIor\" [1.5]\nTranslate 0.1 0.2 6.2 Scale 0.7 2 "
          "0.1\n") +
      kCube + "AttributeEnd\n";
  for (const std::string& lights : {std::string(kSky), lamp})
    for (const std::string& beside : {std::string(), fog, glass}) {
      const auto scene = [&](int lightSamples, double gain = 1) {
        RenderRequest r;
        r.rib = orthographic(16, 0.9, lightSamples ? 32 : 64) +
                "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [0] \"float clampLuminance\" [1e30] "
                "\"float rouletteThreshold\" [0] \"int allowCaustics\" [0] \"int numLightSamples\" [" +
                std::to_string(lightSamples) + "]\nWorldBegin\n" + lights + beside +
                plate(number("singlescatterGain", gain) + number("singlescatterMfp", 0.7) +
                      number("singlescatterDirectionality", 0.8)) +
                kBall + "WorldEnd\n";
        return r;
      };
      SCOPED_TRACE(lights + beside);
      const Moments both = overSeeds(scene(1), 12), directions = overSeeds(scene(0), 12);
      // what is around the ball, and light samples show of the fog
      const Moments bothWithout = overSeeds(scene(1, 0), 12), directionsWithout = overSeeds(scene(0, 0), 12);
      const double body = both.mean() - bothWithout.mean();
      const double error = std::hypot(std::hypot(both.standardError(), directions.standardError()),
                                      std::hypot(bothWithout.standardError(), directionsWithout.standardError()));
      EXPECT_NEAR(body, directions.mean() - directionsWithout.mean(), 4 * error);
      EXPECT_LE(error, 0.04 * body) << "too noisy to judge";
      EXPECT_LT(both.standardError(), 0.02 * both.mean());
    }
}

// A plate between a camera and a sky: what passes unscattered is Fresnel's transmittance at both faces, as n^2 goes and
// comes, and Beer and Lambert's law along the way that is bent inside. A gain and a tint multiply it.
TEST(Subsurface, WhatPassesUnscatteredIsBeerLamberts) {
  for (const auto& [ior, turn] : {std::pair{1.0, 40.0}, std::pair{1.5, 0.0}, std::pair{1.4, 50.0}}) {
    RenderRequest r;
    r.rib = orthographic(12, 0.1, 64) + unbiased(0) + "WorldBegin\n" + kSky +
            plate(number("singlescatterDirectGain", 0.8) + color("singlescatterDirectGainTint", 1, 0.5, 0.25) +
                  number("singlescatterMfp", 0.7) + number("singlescatterIor", ior)) +
            "Translate 0 0 90 Rotate " + std::to_string(turn) + " 0 1 0 Scale 40 40 0.5\n" + kCube + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const double mu = std::cos(turn * kPi / 180), inside = std::sqrt(1 - (1 - mu * mu) / (ior * ior));
    const double through = std::pow(1 - reflectance(mu, 1 / ior), 2) * std::exp(-1 / inside / 0.7);
    const double tint[3] = {1, 0.5, 0.25};
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(overPixels(render.channel("Ci"), c).mean(), 0.8 * tint[c] * through, 2e-3 * through) << ior;
  }
}

// Before a background that is black on one side: a blurred boundary lets its light into the dark, as much as it takes from
// the other half, and keeps less of it than a clear one.
TEST(Subsurface, BlurSpreadsWhatPasses) {
  const auto shown = [](double blur, bool half) {
    RenderRequest r;
    r.rib =
        orthographic(16, 1, 256) + unbiased(1) + "WorldBegin\n" + kSky +
        plate(number("singlescatterDirectGain", 1) + number("singlescatterMfp", 1e6) +
              number("singlescatterBlur", blur)) +
        "AttributeBegin Translate 0 0 6 Scale 40 40 0.5\n" + kCube + "AttributeEnd\n" +
        (half ? "Bxdf \"PxrBlack\" \"k\"\nPolygon \"vertex point P\" [0 -40 8  0 40 8  40 40 8  40 -40 8]\n" : "") +
        "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return render.channel("Ci");
  };
  const auto columns = [](const image::Image& picture, int first, int last) {
    Moments m;
    for (int x = first; x < last; ++x)
      for (int y = 0; y < 16; ++y) m.add(picture.at(x, y)[1]);
    return m;
  };
  const image::Image sharp = shown(0, true), soft = shown(0.6, true), whole = shown(0.6, false);
  EXPECT_NEAR(columns(sharp, 0, 8).mean(), std::pow(1 - reflectance(1, 1 / 1.3), 2), 2e-3);
  EXPECT_EQ(columns(sharp, 8, 16).mean(), 0);
  EXPECT_GT(columns(soft, 8, 10).mean(), 0.1);
  EXPECT_GT(columns(soft, 8, 10).mean(), columns(soft, 14, 16).mean() * 1.5);
  const Moments both = columns(soft, 0, 16), all = columns(whole, 0, 16);
  EXPECT_NEAR(both.mean(), all.mean() / 2, 4 * std::hypot(both.standardError(), all.standardError() / 2));
  EXPECT_LT(all.mean(), columns(sharp, 0, 8).mean());
}

// Two plates of one body with a gap between them.
TEST(Subsurface, StraightWaysMayPassInnerSurfaces) {
  const auto shown = [](int mode, int most, const char* gain) {
    RenderRequest r;
    const std::string plateAt =
        "\nAttributeBegin Translate 0 0 @ Scale 40 40 0.5\n" + std::string(kCube) + "AttributeEnd\n";
    const auto at = [&](const char* z) { return std::string(plateAt).replace(plateAt.find('@'), 1, z); };
    r.rib =
        orthographic(8, 0.5, 64) + unbiased(0) + "WorldBegin\n" + kSky +
        "Attribute \"grouping\" \"string membership\" [\"body\"]\n" +
        plate(number(gain, 1) + number("singlescatterMfp", 2) + number("singlescatterIor", 1) +
              "\"string singlescatterSubset\" [\"body\"] \"int singlescatterContinuationRayMode\" [" +
              std::to_string(mode) + "] \"int singlescatterMaxContinuationHits\" [" + std::to_string(most) + "] ") +
        at("5") + at("7") + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"), 1);
  };
  const char* const direct = "singlescatterDirectGain";
  EXPECT_EQ(shown(0, 2, direct).mean(), 0);  // behind the first there is the second, and no bounce is left
  EXPECT_EQ(shown(1, 0, direct).mean(), 0);
  EXPECT_NEAR(shown(1, 2, direct).mean(), std::exp(-1.5), 1e-3);  // with the gap
  EXPECT_NEAR(shown(2, 2, direct).mean(), std::exp(-1.), 1e-3);   // without
  // what scatters does so within the plates, or all the way, and leaves behind both where it goes that way
  const Moments one = shown(0, 2, "singlescatterGain"), filled = shown(1, 2, "singlescatterGain");
  EXPECT_GT(filled.mean(), one.mean() + 4 * std::hypot(filled.standardError(), one.standardError()));
}

TEST(Subsurface, LightLinksCountForSingleScattering) {
  const auto shown = [](const std::string& links) {
    RenderRequest r;
    r.rib = orthographic(12, 0.8, 64) + unbiased(0) +
            "WorldBegin\nLight \"PxrDistantLight\" \"A\" \"float intensity\" [1]\nAttributeBegin Rotate 60 1 0 0\n"
            "Light \"PxrDistantLight\" \"B\" \"float intensity\" [2]\nAttributeEnd\n" +
            links + plate(single(number("singlescatterMfp", 0.5))) + kBall + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"), 1);
  };
  const auto subset = [](const char* which) {
    return std::string("Attribute \"lighting\" \"string subset\" [\"") + which + "\"]\n";
  };
  const Moments a = shown(subset("A")), b = shown(subset("B")), both = shown("");
  EXPECT_EQ(shown("Attribute \"lighting\" \"string excludesubset\" [\"A B\"]\n").mean(), 0);
  EXPECT_GT(a.mean(), 0);
  EXPECT_GT(b.mean(), 0);
  EXPECT_NEAR(a.mean() + b.mean(), both.mean(),
              4 * std::hypot(both.standardError(), std::hypot(a.standardError(), b.standardError())));
}

// A sheet has nothing below it, and says so; a ball that is inside out has it on both sides if asked.
TEST(Subsurface, SingleScatteringNeedsAnInside) {
  for (const char* gain : {"singlescatterGain", "singlescatterDirectGain"}) {
    const auto shown = [&](const std::string& more, const std::string& what, bool isOpen) {
      RenderRequest r;
      r.rib = orthographic(12, 0.5, 64) + unbiased(0) + "WorldBegin\n" + kSky +
              plate(number(gain, 1) + number("singlescatterMfp", 1) + more) +
              "Attribute \"identifier\" \"string name\" [\"sheet\"]\n" + what + "WorldEnd\n";
      SceneRender render(r);
      EXPECT_TRUE(render.ok());
      EXPECT_EQ(says(render, "SUBSURFACE-OPEN") || says(render, "met nothing of its object"), isOpen);
      EXPECT_EQ(says(render, "sheet"), isOpen);
      return overPixels(render.channel("Ci"), 1);
    };
    SCOPED_TRACE(gain);
    EXPECT_EQ(shown("", "Polygon \"vertex point P\" [-2 -2 5  -2 2 5  2 2 5  2 -2 5]\n", true).mean(), 0);
    const std::string inverted = "ReverseOrientation Translate 0 0 5 Sphere 1 -1 1 360\n";
    const Moments plain = shown("", "Translate 0 0 5 Sphere 1 -1 1 360\n", false),
                  turned = shown("\"int singlescatterDoubleSided\" [1] ", inverted, false);
    EXPECT_GT(plain.mean(), 0.05);
    EXPECT_EQ(shown("", inverted, false).mean(), 0);
    EXPECT_NEAR(turned.mean(), plain.mean(), 4 * std::hypot(plain.standardError(), turned.standardError()));
  }
}

// Light let through: what enters a plate by a cosine's law and is left of it behind, twice the exponential integral E3 of
// the thickness in mean free paths.
TEST(Subsurface, TransmitGainLetsLightThroughPlates) {
  const double thickness = 0.6;
  for (const int t : {2, 4}) {
    RenderRequest r;
    r.rib = orthographic(16, 0.2, 256) + unbiased(0) + "WorldBegin\n" + kSky +
            wax(type(t) + number("subsurfaceGain", 0) + number("subsurfaceTransmitGain", 0.7) +
                color("subsurfaceColor", 1, 0.5, 0.2) + number("subsurfaceDmfp", 1) +
                color("subsurfaceDmfpColor", 1, 0.5, 0.3)) +
            "Translate 0 0 5 Scale 40 40 0.3\n" + kCube + "WorldEnd\n";
    // one gain is said twice: the second counts
    r.rib.replace(r.rib.find("\"float subsurfaceGain\" [1] "), 27, "");
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const double tint[3] = {1, 0.5, 0.2}, by[3] = {1, 0.5, 0.3};
    for (int c = 0; c < 3; ++c) {
      double passes = 0;
      for (int i = 0; i < 4000; ++i) {
        const double mu = (i + 0.5) / 4000;
        passes += 2 * mu * std::exp(-thickness / (mu * by[c])) / 4000;
      }
      EXPECT_MEAN(overPixels(render.channel("Ci"), c), 0.7 * tint[c] * passes, 0.02);
    }
  }
}

// A block that is lit from behind shows nothing where backs do not count.
TEST(Subsurface, BacksMayBeLeftOut) {
  for (const int t : {2, 4}) {
    const auto shown = [&](const std::string& more) {
      RenderRequest r;
      r.rib =
          orthographic(16, 0.5, 64) + unbiased(0) +
          "WorldBegin\nAttributeBegin Rotate 180 0 1 0\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] "
          "\"float angleExtent\" [0]\nAttributeEnd\n" +
          wax(type(t) + gray("subsurfaceColor", 0.8) + number("subsurfaceDmfp", t == 2 ? 2 : 0.5) + more) +
          "Translate 0 0 5 Scale 1 1 0.3\n" + kCube + "WorldEnd\n";
      SceneRender render(r);
      EXPECT_TRUE(render.ok());
      return overPixels(render.channel("Ci"), 1);
    };
    EXPECT_GT(shown("").mean(), 0.001);
    EXPECT_EQ(shown("\"int considerBackside\" [0] ").mean(), 0);
    const std::string once = number("subsurfaceGain", 0) + single(number("singlescatterMfp", 0.5));
    EXPECT_GT(shown(once).mean(), 0.001);
    EXPECT_EQ(shown(once + "\"int singlescatterConsiderBackside\" [0] ").mean(), 0);
  }
}

// Walks pass the inner surfaces of parts that overlap, whichever way that is said.
TEST(Subsurface, ContinuationRaysMakeOneBody) {
  const auto shown = [](const std::string& more) {
    RenderRequest r;
    r.rib =
        orthographic(16, 0.3, 16) + unbiased(2) + "WorldBegin\n" + kSky +
        wax(type(4) + gray("subsurfaceColor", 1) + number("subsurfaceDmfp", 4) + more) +
        "Translate 0 0 5 PointsPolygons [4 4 4 4 4 4 4 4 4 4 4 4] [0 1 3 2  4 6 7 5  0 4 5 1  2 3 7 6  0 2 6 4  1 5 "
        "7 "
        "3  8 9 11 10  12 14 15 13  8 12 13 9  10 11 15 14  8 10 14 12  9 13 15 11]\n\"vertex point P\" [-1 -1 -1  "
        "-1 "
        "-1 1  -1 1 -1  -1 1 1  1 -1 -1  1 -1 1  1 1 -1  1 1 1  -0.5 -2 -0.5  -0.5 -2 1.5  -0.5 2 -0.5  -0.5 2 1.5  "
        "0.5 -2 -0.5  0.5 -2 1.5  0.5 2 -0.5  0.5 2 1.5]\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return hashOf(render.film());
  };
  const uint64_t joined = shown("\"int subsurfaceResolveSelfIntersections\" [1] ");
  EXPECT_EQ(shown("\"int continuationRayMode\" [1] "), joined);
  EXPECT_EQ(shown("\"int continuationRayMode\" [2] "), joined);
  EXPECT_NE(shown(""), joined);
}

// A block that is lit from behind: light that comes out at the front went in where the surface faces the other way.
TEST(Subsurface, TopologyIsFollowed) {
  const auto shown = [](const std::string& material) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 64) + unbiased(0) +
            "WorldBegin\nAttributeBegin Rotate 180 0 1 0\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] "
            "\"float angleExtent\" [0]\nAttributeEnd\n" +
            material + "\nTranslate 0 0 5 Scale 1 1 0.3\n" + kCube + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"), 1);
  };
  const std::string lama =
      "Bxdf \"LamaSSS\" \"l\" \"float sssUnitLength\" [1] " + gray("color", 0.8) + gray("sssRadius", 0.5);
  // walks, and a profile whose chords reach the back
  for (const std::string& material :
       {wax(type(4) + gray("subsurfaceColor", 0.8) + number("subsurfaceDmfp", 0.5) + "@"),
        wax(type(2) + gray("subsurfaceColor", 0.8) + number("subsurfaceDmfp", 2) + "@"), lama + "@"}) {
    const auto by = [&](double much) {
      std::string m = material;
      return m.replace(m.find('@'), 1,
                       number(m.find("Lama") == std::string::npos ? "followTopology" : "sssFollowTopology", much));
    };
    const Moments all = shown(by(0)), some = shown(by(0.25));
    SCOPED_TRACE(material);
    EXPECT_GT(all.mean(), 20 * all.standardError());
    // the same random numbers: the same paths, of which each is worth so much less
    EXPECT_NEAR(some.mean(), 0.75 * all.mean(), 1e-5 * all.mean());
    EXPECT_EQ(shown(by(1)).mean(), 0);
  }
}

// The profiles as they are published, per area, scaled to integrate to 1 by quadrature.
struct Profile {
  int type;
  double albedo, length, ior;
  double reduced = 1;  // albedo of the medium, dipoles
  double moments[2] = {0, 0};
  double whole = 1;
  Profile(int t, double a, double l, double i) : type(t), albedo(a), length(l), ior(i) {
    if (type >= 2) return;
    const int n = 4000;
    for (int k = 0; k < n; ++k) {
      const double mu = (k + 0.5) / n, sin2 = ior * ior * (1 - mu * mu);
      double f = 1;
      if (sin2 < 1) {
        const double co = std::sqrt(1 - sin2), rs = (ior * mu - co) / (ior * mu + co),
                     rp = (mu - ior * co) / (mu + ior * co);
        f = (rs * rs + rp * rp) / 2;
      }
      moments[0] += f * mu / n;
      moments[1] += f * mu * mu / n;
    }
    // the medium whose profile integrates to the albedo
    double low = 0.001, high = 0.99989;
    for (int k = 0; k < 50; ++k) {
      reduced = 0.5 * (low + high);
      (integral() < albedo ? low : high) = reduced;
    }
    whole = integral();
  }
  double raw(double r) const {
    if (type == 2) {
      const double d = length / (3.5 + 100 * std::pow(albedo - 0.33, 4));
      return (std::exp(-r / d) + std::exp(-r / (3 * d))) / (8 * kPi * d * r);
    }
    const double absorbed = 1 - reduced;  // in units of the reduced extinction
    const double D = type == 1 ? (2 * absorbed + reduced) / 3 : 1.0 / 3, decay = std::sqrt(absorbed / D);
    const double extinction = 1 / (length * decay);  // per unit
    const double A =
        type == 1 ? (1 + 3 * moments[1]) / (1 - 2 * moments[0]) : (1 + 2 * moments[0]) / (1 - 2 * moments[0]);
    const double zr = 1 / extinction, zv = zr + 4 * A * D / extinction, s = 1 / length;
    const double dr = std::sqrt(r * r + zr * zr), dv = std::sqrt(r * r + zv * zv);
    const double flux = zr * (1 + s * dr) * std::exp(-s * dr) / (dr * dr * dr) +
                        zv * (1 + s * dv) * std::exp(-s * dv) / (dv * dv * dv);
    if (type == 0) return reduced / (4 * kPi) * flux;
    const double fluence = std::exp(-s * dr) / dr - std::exp(-s * dv) / dv;
    return reduced * reduced / (4 * kPi) *
           ((1 - 3 * moments[1]) / 2 * flux + (1 - 2 * moments[0]) / 4 / (D / extinction) * fluence);
  }
  double operator()(double r) const { return raw(r) / whole; }
  // over the plane: r = e^x
  double integral() const {
    double sum = 0;
    const int n = 3000;
    for (int k = 0; k < n; ++k) {
      const double x = -12 + 17 * (k + 0.5) / n, r = length * std::exp(x);
      sum += 2 * kPi * r * r * raw(r) * 17 / n;
    }
    return sum;
  }
  // The part of the light on the half plane x > 0 that comes out at x.
  double edge(double x) const {
    double sum = 0;
    const int n = 6000;
    for (int k = 0; k < n; ++k) {
      const double y = -12 + 17 * (k + 0.5) / n, r = length * std::exp(y), c = -x / r;
      const double share = c <= -1 ? 1 : c >= 1 ? 0 : std::acos(c) / kPi;  // of the circle of radius r
      sum += 2 * kPi * r * r * (*this)(r)*share * 17 / n;
    }
    return sum;
  }
};

// Light straight down on the half x > 0 of a plane, cut by a sheet that no other ray sees.
TEST(Subsurface, AnEdgeOfLightBlursByTheProfile) {
  for (const auto& [type_, albedo, length] :
       {std::tuple{0, 0.7, 0.5}, std::tuple{1, 0.7, 0.5}, std::tuple{1, 0.95, 1.0}, std::tuple{2, 0.3, 0.6},
        std::tuple{2, 0.8, 1.0}}) {
    const Profile profile(type_, albedo, length, 1.4);
    EXPECT_NEAR(profile.integral() / profile.whole, 1, 1e-3);
    RenderRequest r;
    r.rib =
        "Format 20 80 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [128]\nScreenWindow -1 1 -1 "
        "1\n"
        "Projection \"orthographic\"\n" +
        unbiased(0) +
        "WorldBegin\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] \"float angleExtent\" [0]\n" +
        wax(type(type_) + gray("subsurfaceColor", albedo) + number("subsurfaceDmfp", length) +
            number("subsurfaceIor", 1.4)) +
        "Polygon \"vertex point P\" [-40 -40 5  -40 40 5  40 40 5  40 -40 5]\n"
        "AttributeBegin Attribute \"visibility\" \"int camera\" [0] \"int indirect\" [0]\nBxdf \"PxrBlack\" \"k\"\n"
        "Polygon \"vertex point P\" [-50 -50 4  -50 50 4  0 50 4  0 -50 4]\nAttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    RenderRequest plain = r;
    const image::Image picture = render.channel("Ci");
    // fully lit: what a diffuse plane of the albedo shows
    const std::string material =
        r.rib.substr(r.rib.find("Bxdf"), r.rib.find('\n', r.rib.find("Bxdf")) - r.rib.find("Bxdf"));
    plain.rib.replace(plain.rib.find(material), material.size(),
                      "Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [1 1 1]");
    SceneRender lit(plain);
    ASSERT_TRUE(lit.ok());
    const double full = lit.channel("Ci").at(19, 40)[0];
    ASSERT_GT(full, 0);
    for (int column = 0; column < 20; ++column) {
      Moments m;
      for (int y = 0; y < 80; ++y) m.add(picture.at(column, y)[0] / full);
      double expected = 0;  // mean over the pixel's width
      for (int k = 0; k < 8; ++k) expected += profile.edge(-1 + (column + (k + 0.5) / 8) * 0.1) / 8;
      EXPECT_NEAR(m.mean(), albedo * expected, 4.5 * m.standardError() + 0.003 * albedo)
          << "type " << type_ << ", albedo " << albedo << ", column " << column;
      EXPECT_LE(m.standardError(), 0.03) << "too few samples to judge";
    }
    if (::testing::Test::HasFailure()) std::printf("picture: %s\n", SceneRender::keep(picture, "edge").c_str());
  }
}

// A ball by profiles: no closed form, but a short length must look as a diffuse ball does, and albedo 1 gives no more
// than comes in on a plane.
TEST(Subsurface, ShortLengthsAreDiffuse) {
  for (const int t : {0, 1, 2, 3, 4, 5}) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 400) + unbiased(0) + "WorldBegin\n" + kSky +
            wax(type(t) + color("subsurfaceColor", 0.8, 0.5, 0.2) + number("subsurfaceDmfp", 0.02) +
                (t == 3 ? number("longSubsurfaceGain", 0.5) + color("longSubsurfaceColor", 0.2, 0.1, 0.4) +
                              number("longSubsurfaceDmfp", 0.04)
                        : "")) +
            kBall + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const double extra[3] = {0.1, 0.05, 0.2}, albedo[3] = {0.8, 0.5, 0.2};
    SCOPED_TRACE(t);
    for (int c = 0; c < 3; ++c)
      EXPECT_MEAN(overPixels(render.channel("Ci"), c), albedo[c] + (t == 3 ? extra[c] : 0), 0.012);
  }
}

TEST(Subsurface, WhatHasNoInsideIsDiffuseAndIsNamed) {
  // a sheet; a wisp of curves
  for (const char* what : {"Polygon \"vertex point P\" [-2 -2 5  -2 2 5  2 2 5  2 -2 5]\n",
                           "Basis \"bezier\" 3 \"bezier\" 3 Curves \"linear\" [2] \"nonperiodic\" \"P\" [-4 0 5 4 0 "
                           "5] \"constantwidth\" [3]\n"}) {
    RenderRequest r, plain;
    const std::string head = orthographic(16, 0.5, 64) + unbiased(0) + "WorldBegin\n" + kSky;
    const std::string rest =
        std::string("Attribute \"identifier\" \"string name\" [\"sheet\"]\n") + what + "WorldEnd\n";
    r.rib = head + wax(type(4) + color("subsurfaceColor", 0.8, 0.5, 0.2) + number("subsurfaceDmfp", 1)) + rest;
    plain.rib = head + "Bxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [0.8 0.5 0.2]\n" + rest;
    SceneRender render(r), diffuse(plain);
    ASSERT_TRUE(render.ok() && diffuse.ok());
    for (int c = 0; c < 3; ++c)
      EXPECT_SAME_MEAN(overPixels(render.channel("Ci"), c), overPixels(diffuse.channel("Ci"), c), 0.01);
    EXPECT_TRUE(says(render, "SUBSURFACE-OPEN") || says(render, "met nothing of its object")) << what;
    EXPECT_TRUE(says(render, "sheet")) << what;
  }
}

// A block whose underside is the floor's plane has an inside all the same.
TEST(Subsurface, WhatStandsOnAFloorIsClosed) {
  RenderRequest r;
  r.rib =
      "Format 24 24 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\nProjection "
      "\"perspective\" \"fov\" "
      "[30]\nTranslate 0 0 6 Rotate -25 1 0 0\n" +
      unbiased(8) + "WorldBegin\n" + kSky + "Bxdf \"PxrDiffuse\" \"f\" \"color diffuseColor\" [1 1 1]\n" +
      "Polygon \"vertex point P\" [-9 -1 -9  -9 -1 9  9 -1 9  9 -1 -9]\n" +
      wax(type(4) + gray("subsurfaceColor", 1) + number("subsurfaceDmfp", 5)) + kCube + "WorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  for (const std::string& m : render.messages()) ADD_FAILURE() << m;
}

// Walks without absorption in a body that is five hundred flights thick: some have no end, which is said, and nothing
// of their light is lost.
TEST(Subsurface, EndlessWalksAreCountedAndComeBack) {
  RenderRequest r;
  r.rib = orthographic(16, 0.5, 64) + unbiased(8) + "WorldBegin\n" + kSky +
          wax(type(4) + gray("subsurfaceColor", 1) + number("subsurfaceDmfp", 0.05)) + kBall + "WorldEnd\n";
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_MEAN(overPixels(render.channel("Ci")), 1, 0.005);
  EXPECT_TRUE(says(render, "had no end")) << render.messages().size();
  EXPECT_TRUE(says(render, "ball"));
}

TEST(Subsurface, BadLengthsAreDiffuseOrClear) {
  // infinity less infinity
  const std::string nan =
      "Pattern \"PxrExposure\" \"much\" \"color inputRGB\" [1 1 1] \"float stops\" [300]\n"
      "Pattern \"PxrMix\" \"nan\" \"reference color color1\" [\"much:resultRGB\"] \"reference color color2\" "
      "[\"much:resultRGB\"] \"float mix\" [0.5]\n";
  for (const std::string& length :
       {number("subsurfaceDmfp", 0), number("subsurfaceDmfp", -3), number("subsurfaceDmfp", 1e-30),
        std::string("\"reference color subsurfaceDmfpColor\" [\"nan:resultRGB\"] ")})
    for (const int t : {0, 1, 2, 4}) {
      RenderRequest r;
      const std::string material = wax(type(t) + gray("subsurfaceColor", 0.5) + length);
      r.rib = orthographic(8, 0.5, 16) + unbiased(0) + "WorldBegin\n" + kSky + nan + material + kBall + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      SCOPED_TRACE(length + std::to_string(t));
      EXPECT_MEAN(overPixels(render.channel("Ci")), 0.5, 0.01);
    }
  for (const int t : {0, 1, 2, 4}) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 256) + unbiased(0) + "WorldBegin\n" + kSky +
            wax(type(t) + gray("subsurfaceColor", 0.5) + number("subsurfaceDmfp", 1e20)) + kBall + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    for (const float v : render.channel("Ci").pixels) ASSERT_TRUE(std::isfinite(v) && v >= 0 && v < 4) << t;
    if (t == 4) EXPECT_MEAN(overPixels(render.channel("Ci")), 1, 0.01);  // nothing scatters on the way through
  }
}

// Inside out: seen from its inner side there is nothing, unless the material has two sides; then it is as it should be.
TEST(Subsurface, InsideOutMeshesNeedTwoSides) {
  const auto shown = [](const std::string& more) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 64) + unbiased(0) + "WorldBegin\n" + kSky +
            wax(type(4) + gray("subsurfaceColor", 0.8) + number("subsurfaceDmfp", 1) + more) + kBall + "WorldEnd\n";
    if (more.find("DoubleSided") != std::string::npos)
      r.rib.replace(r.rib.find("Translate 0 0 5"), 15, "ReverseOrientation Translate 0 0 5");
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"));
  };
  EXPECT_SAME_MEAN(shown(""), shown("\"int subsurfaceDoubleSided\" [1] "), 0.01);
  EXPECT_MEAN(shown("\"int subsurfaceDoubleSided\" [0] "), 0, 1e-6);
}

// Two balls that overlap, as one body by a group, against a mesh of their union is hard; against the furnace it is not.
TEST(Subsurface, SubsetsAreOneBody) {
  const auto shown = [](const std::string& more) {
    RenderRequest r;
    r.rib = orthographic(16, 0.3, 64) + unbiased(8) + "WorldBegin\n" + kSky +
            "Attribute \"grouping\" \"string membership\" [\"body\"]\n" +
            wax(type(4) + gray("subsurfaceColor", 1) + number("subsurfaceDmfp", 4) + more) + kBall +
            "AttributeBegin Translate 0.6 0 5 Sphere 0.9 -0.9 0.9 360 AttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"));
  };
  EXPECT_MEAN(shown("\"string subsurfaceSubset\" [\"body\"] "), 1, 0.005);
  // alone each comes out inside the other, where it is dark until it comes out of that too
  EXPECT_LT(shown("").mean(), 0.97);
}

// Where light comes out, light samples and what the next rays find share it: a lamp near a ball is the same light as a
// glowing polygon, which only rays find, and as the lamp with several samples and directions of each. All of it is in
// the channel of its lobe.
TEST(Subsurface, LightSamplesAndRaysShareWhatComesOut) {
  const auto scene = [](const std::string& integrator, bool lamp) {
    return orthographic(24, 1, lamp ? 100 : 512) + unbiased(1, integrator) + "WorldBegin\n" +
           (lamp ? "AttributeBegin ConcatTransform [1 0 0 0  0 0 1 0  0 -1 0 0  0 1.6 5 1]\nLight \"PxrRectLight\" "
                   "\"l\" "
                   "\"float intensity\" [5] AttributeEnd\n"
                 : "AttributeBegin Sides 1\nBxdf \"PxrSurface\" \"glow\" \"float diffuseGain\" [0] \"float "
                   "glowGain\" [5] "
                   "\"color glowColor\" [1 1 1]\nPolygon \"vertex point P\" [-0.5 1.6 4.5  0.5 1.6 4.5  0.5 1.6 5.5  "
                   "-0.5 1.6 5.5]\n"
                   "AttributeEnd\n") +
           wax(type(4) + color("subsurfaceColor", 0.9, 0.7, 0.5) + number("subsurfaceDmfp", 1)) + kBall +
           "WorldEnd\n";
  };
  RenderRequest lamp, polygon, split;
  lamp.rib = scene("", true);
  lamp.channels = "Ci,a,subsurface";
  polygon.rib = scene("", false);
  split.rib = scene("\"int numIndirectSamples\" [3] \"int numLightSamples\" [2]", true);
  split.channels = lamp.channels;
  EXPECT_SAME_MEAN(overSeeds(lamp, 8, "subsurface"), overSeeds(polygon, 14), 0.01);
  EXPECT_SAME_MEAN(overSeeds(lamp, 8, "subsurface"), overSeeds(split, 8, "subsurface"), 0.01);
}

// What the middle of the ball shows under the constant sky.
Moments underTheSky(const std::string& material) {
  RenderRequest r;
  r.rib = orthographic(16, 0.5, 1024) + unbiased(8) + "WorldBegin\n" + kSky + material + "\n" + kBall + "WorldEnd\n";
  SceneRender render(r);
  EXPECT_TRUE(render.ok());
  return overPixels(render.channel("Ci"), 1);
}

// The principled material has the same walks, below its dielectric.
TEST(Subsurface, PrincipledMaterialWalksToo) {
  const std::string bare = "Bxdf \"PxrDisneyBsdf\" \"d\" \"float specReflectScale\" [0] \"float subsurface\" [1] ";
  EXPECT_MEAN(underTheSky(bare + color("subsurfaceColor", 1, 1, 1) + color("scatterDistance", 8, 4, 2)), 1, 0.005);
  EXPECT_SAME_MEAN(underTheSky(bare + color("subsurfaceColor", 0.9, 0.6, 0.3) + color("scatterDistance", 2, 1, 0.5)),
                   underTheSky(wax(type(4) + color("subsurfaceColor", 0.9, 0.6, 0.3) +
                                   color("subsurfaceDmfpColor", 2, 1, 0.5) + number("subsurfaceDmfp", 1))),
                   0.005);
}

// LamaSSS against PxrSurface: its modes are types there, its lengths are in millimetres.
TEST(Subsurface, LayeredMaterialsScatterAlike) {
  const std::string lama = "Bxdf \"LamaSSS\" \"l\" \"float sssUnitLength\" [0.1] \"float sssScale\" [2] " +
                           color("sssColor", 0.9, 0.6, 0.3) + color("sssRadius", 5, 2.5, 1.25);
  const std::string surface = color("subsurfaceColor", 0.9, 0.6, 0.3) + color("subsurfaceDmfpColor", 1, 0.5, 0.25);
  const auto mode = [](int m) { return "\"int sssMode\" [" + std::to_string(m) + "] "; };
  EXPECT_SAME_MEAN(underTheSky(lama + mode(0) + number("sssBleed", 0.7)),
                   underTheSky(wax(type(5) + surface + number("subsurfaceDmfp", 1) + number("subsurfaceBleed", 0.7))),
                   0.005);
  EXPECT_SAME_MEAN(
      underTheSky(lama + mode(1) + number("sssAnisotropy", 0.4)),
      underTheSky(wax(type(4) + surface + number("subsurfaceDmfp", 1) + number("subsurfaceDirectionality", 0.4))),
      0.005);
  EXPECT_SAME_MEAN(underTheSky(lama + mode(2)), underTheSky(wax(type(2) + surface + number("subsurfaceDmfp", 1))),
                   0.005);
  // by mean free paths: what a profile of the same scale says, here of the middle channel
  const double a = 0.6, ofDiffuse = 3.5 + 100 * std::pow(a - 0.33, 4),
               ofFlights = 1.9 - a + 3.5 * (a - 0.8) * (a - 0.8);
  const auto middle = color("subsurfaceColor", a, a, a) + color("subsurfaceDmfpColor", 1, 1, 1);
  EXPECT_SAME_MEAN(underTheSky(lama + mode(3) + color("sssRadius", 2.5, 2.5, 2.5) + color("sssColor", a, a, a)),
                   underTheSky(wax(type(2) + middle + number("subsurfaceDmfp", 0.5 * ofDiffuse / ofFlights))), 0.005);
  EXPECT_MEAN(underTheSky(lama + number("sssScale", 0)), 0.6, 0.005);  // Lambert's law
  // by mean free paths a furnace is one too
  EXPECT_MEAN(underTheSky(lama + mode(1) + color("sssColor", 1, 1, 1) + "\"int albedoInversionMethod\" [1] "), 1,
              0.005);
}

// Two slabs that scatter below in one material are the mean of both, whatever each is made of.
TEST(Subsurface, TwoSlabsShareAMaterial) {
  const auto slab = [&](const char* plugin, const char* name, const std::string& more) {
    return std::string("Bxdf \"") + plugin + "\" \"" + name + "\" \"float sssUnitLength\" [1] " + more + "\n";
  };
  const auto walks = [&](const char* name) {
    return slab("LamaSSS", name,
                color("color", 0.9, 0.8, 0.2) + color("sssRadius", 0.4, 0.3, 0.1) + "\"int sssMode\" [1] ");
  };
  const auto burley = [&](const char* name) {
    return slab("LamaSSS", name, color("color", 0.3, 0.2, 0.6) + gray("sssRadius", 0.3) + "\"int sssMode\" [2] ");
  };
  const auto three = [&](const char* name) {
    return slab("LamaTricolorSSS", name,
                color("nearColor", 0.4, 0.7, 0.9) + color("midColor", 0.1, 0.2, 0.3) +
                    color("farColor", 0.9, 0.8, 0.3) + number("nearWeight", 0.4) + number("midWeight", 0.3) +
                    number("farWeight", 0.2) + number("nearRadius", 0.1) + number("midRadius", 0.3) +
                    number("farRadius", 1));
  };
  const std::string mix =
      "Bxdf \"LamaMix\" \"m\" \"reference bxdf material1\" [\"a\"] \"reference bxdf material2\" [\"b\"] \"float "
      "mix\" [0.3]";
  const auto agree = [&](const std::string& a, const std::string& b, const std::string& aAlone,
                         const std::string& bAlone) {
    const Moments first = underTheSky(aAlone), second = underTheSky(bAlone), both = underTheSky(a + b + mix);
    EXPECT_NEAR(
        both.mean(), 0.7 * first.mean() + 0.3 * second.mean(),
        4 * std::hypot(both.standardError(), std::hypot(0.7 * first.standardError(), 0.3 * second.standardError())));
    EXPECT_GT(std::fabs(first.mean() - second.mean()), 20 * both.standardError()) << "too alike to judge";
  };
  agree(walks("a"), burley("b"), walks("a"), burley("b"));
  agree(walks("a"), three("b"), walks("a"), three("b"));
}

// Three profiles by the names of Lama are type 3 of PxrSurface.
TEST(Subsurface, TricolorIsASumOfProfiles) {
  const std::string lama = "Bxdf \"LamaTricolorSSS\" \"l\" \"float sssUnitLength\" [0.1] \"float sssScale\" [2] " +
                           color("nearColor", 0.9, 0.6, 0.3) + color("midColor", 0.5, 0.9, 0.3) +
                           color("farColor", 0.2, 0.1, 0.8) + number("nearWeight", 0.5) + number("midWeight", 0.3) +
                           number("farWeight", 0.1) + number("nearRadius", 1) + number("midRadius", 2) +
                           number("farRadius", 8);
  const std::string surface = color("subsurfaceColor", 0.9, 0.6, 0.3) + color("shortSubsurfaceColor", 0.5, 0.9, 0.3) +
                              color("longSubsurfaceColor", 0.2, 0.1, 0.8) + number("shortSubsurfaceGain", 0.3) +
                              number("longSubsurfaceGain", 0.1) + number("subsurfaceDmfp", 0.2) +
                              number("shortSubsurfaceDmfp", 0.4) + number("longSubsurfaceDmfp", 1.6);
  std::string other = wax(type(3) + surface);
  other.replace(other.find("\"float subsurfaceGain\" [1]"), 26, "\"float subsurfaceGain\" [0.5]");
  EXPECT_SAME_MEAN(underTheSky(lama), underTheSky(other), 0.005);
  // without radii a diffuse surface of the sum
  EXPECT_MEAN(underTheSky("Bxdf \"LamaTricolorSSS\" \"l\" " + gray("nearColor", 0.9) + gray("midColor", 0.6) +
                          gray("farColor", 0.3) + number("nearWeight", 0.2) + number("midWeight", 0.3) +
                          number("farWeight", 0.5)),
              0.51, 0.005);
}

// Of a ball as wide as light reaches in it: in PxrVCM as in the path tracer.
TEST(Subsurface, BidirectionalPathsWalkToo) {
  const auto scene = [](const char* integrator) {
    RenderRequest r;
    r.rib = orthographic(16, 0.5, 64) + "Integrator \"" + integrator +
            "\" \"i\" \"int maxIndirectBounces\" [0] \"float clampLuminance\" [1e30]\nWorldBegin\n" + kSky +
            wax(type(4) + color("subsurfaceColor", 0.8, 0.5, 0.2) + number("subsurfaceDmfp", 1)) + kBall +
            "WorldEnd\n";
    return r;
  };
  const Moments forward = overSeeds(scene("PxrPathTracer"), 8), both = overSeeds(scene("PxrVCM"), 8);
  EXPECT_SAME_MEAN(both, forward, 0.01);
  // more than the albedo of the diffuse surface that stands in where an integrator follows no paths below: light crosses it
  EXPECT_GT(forward.mean(), 0.8 + 20 * forward.standardError());
}

}  // namespace
}  // namespace kinora::tests
