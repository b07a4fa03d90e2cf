// Shadows of glass. Without caustics (the stock default) shadow rays go straight through glass and take its tint:
// every kind of glass between a floor and every kind of light against closed forms, however samples are split between
// lights and bxdfs, and beside the refracted paths of allowCaustics 1. The camera stands between floor and glass.
// Misses: glass within glass, whose straight rays know nothing of what surrounds it, and absorption along them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979, kFloor = 0.2;

double fresnel(double cosine, double ior) {
  const double inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double s = (cosine - ior * inside) / (cosine + ior * inside);
  const double p = (ior * cosine - inside) / (ior * cosine + inside);
  return (s * s + p * p) / 2;
}

struct Glass {
  const char* name;
  const char* bxdf;
  double ior;
  bool isThin, isRough;
  // What a straight ray keeps, and what a plane sheet passes with all reflections between its faces.
  double straight(double cosine) const {
    const double f = fresnel(cosine, ior);
    return isThin ? (1 - f) / (1 + f) : (1 - f) * (1 - f);
  }
  double whole(double cosine) const {
    const double f = fresnel(cosine, ior);
    return (1 - f) / (1 + f);
  }
};
#define SURFACE \
  "\"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" [1] "
const Glass kGlasses[] = {
    {"clear", "\"PxrGlass\" \"g\"", 1.5, false, false},
    {"clear, nearly air", "\"PxrGlass\" \"g\" \"float ior\" [1.001]", 1.001, false, false},
    {"rough", "\"PxrGlass\" \"g\" \"float roughness\" [0.3]", 1.5, false, true},
    {"slightly rough", "\"PxrGlass\" \"g\" \"float roughness\" [0.1] \"float ior\" [1.33]", 1.33, false, true},
    {"clear surface", SURFACE "\"float glassRoughness\" [0]", 1.5, false, false},
    {"thin", SURFACE "\"int thinGlass\" [1] \"float glassRoughness\" [0]", 1.5, true, false},
    {"rough thin", SURFACE "\"int thinGlass\" [1] \"float glassRoughness\" [0.3]", 1.5, true, true},
    {"rough surface", SURFACE "\"float glassRoughness\" [0.4]", 1.5, false, true},
};
#undef SURFACE

struct Light {
  std::string name, rib;
  bool isDelta;
  // Irradiance of the floor through what passes a share of light by the cosine of its angle.
  std::function<double(const std::function<double(double)>&)> irradiance;
};

double overHemisphere(const std::function<double(double)>& share) {
  double sum = 0;
  constexpr int n = 2000;
  for (int i = 0; i < n; ++i) {
    const double c = (i + 0.5) / n;
    sum += 2 * kPi * c * share(c) / n;
  }
  return sum;
}

constexpr double kHeight = 4;  // of the rectangle over the floor, half a side 1
std::vector<Light> lights() {
  std::vector<Light> list;
  for (const int angle : {0, 30, 40, 45, 60, 75}) {
    const double c = std::cos(angle * kPi / 180);
    list.push_back({"distant at " + std::to_string(angle),
                    "AttributeBegin Rotate " + std::to_string(angle) +
                        " 1 0 0 Light \"PxrDistantLight\" \"l\" \"float intensity\" [1] \"float angleExtent\" [0] "
                        "AttributeEnd\n",
                    true, [c](const auto& share) { return c * share(c); }});
  }
  list.push_back({"rectangle",
                  "AttributeBegin Translate 0 0 -2 Scale 2 2 1 Light \"PxrRectLight\" \"l\" \"float intensity\" [1] "
                  "AttributeEnd\n",
                  false, [](const auto& share) {
                    double sum = 0;
                    constexpr int n = 200;
                    for (int i = 0; i < n; ++i)
                      for (int j = 0; j < n; ++j) {
                        const double x = (i + 0.5) / n * 2 - 1, y = (j + 0.5) / n * 2 - 1;
                        const double d2 = x * x + y * y + kHeight * kHeight, c = kHeight / std::sqrt(d2);
                        sum += c * c * share(c) / d2 * 4 / (n * n);
                      }
                    return sum;
                  }});
  list.push_back({"dome", "Light \"PxrDomeLight\" \"l\" \"float intensity\" [1]\n", false, overHemisphere});
  return list;
}

struct Splits {
  int lights = 1, directions = 1;
};

RenderRequest scene(const Light& light, const Glass* glass, int bounces, bool caustics, Splits splits = {},
                    int samples = 64) {
  // Squares of one mesh across the z axis: two of them bound one medium. The winding looks along -z, or +z where
  // turned.
  const auto sheets = [](const std::vector<std::pair<double, bool>>& at) {
    const char* corners[] = {"-300 -300 ", "300 -300 ", "300 300 ", "-300 300 "};
    std::string counts, indices, points;
    for (size_t k = 0; k < at.size(); ++k) {
      counts += "4 ";
      for (size_t i = 0; i < 4; ++i) {
        indices += std::to_string(4 * k + i) + " ";
        points += corners[at[k].second ? 3 - i : i] + std::to_string(at[k].first) + " ";
      }
    }
    return "PointsPolygons [" + counts + "] [" + indices + "] \"vertex point P\" [" + points + "]\n";
  };
  RenderRequest r;
  // the floor's middle, little of it: the rectangle's light is nearly constant there
  r.rib = orthographic(8, 0.02, samples) +
          unbiased(bounces, "\"int numLightSamples\" [" + std::to_string(splits.lights) +
                                "] \"int numIndirectSamples\" [" + std::to_string(splits.directions) + "]");
  if (!caustics) {
    const std::string on = "\"int allowCaustics\" [1]";
    r.rib.replace(r.rib.find(on), on.size(), "");
  }
  r.rib += "WorldBegin\n" + light.rib;
  if (glass) {
    r.rib += std::string("AttributeBegin Bxdf ") + glass->bxdf + "\n";
    if (glass->isThin)
      r.rib += sheets({{-1, false}});
    else
      r.rib += sheets({{-1, false}, {-1.2, true}});
    r.rib += "AttributeEnd\n";
  }
  r.rib +=
      "Bxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [0.2 0.2 0.2]\n" + sheets({{2, false}}) + "WorldEnd\n";
  return r;
}

// Light that the floor sends, its own light that comes back from the glass included where paths go on.
double shown(const Light& light, const Glass& glass, bool straight, bool bounces) {
  const double once =
      kFloor / kPi * light.irradiance([&](double c) { return straight ? glass.straight(c) : glass.whole(c); });
  const double back = overHemisphere([&](double c) { return 1 - glass.whole(c); }) / kPi;
  return bounces ? once / (1 - kFloor * back) : once;
}

TEST(GlassShadows, StraightRaysKeepWhatFresnelSays) {
  for (const Light& light : lights()) {
    const auto open = overSeeds(scene(light, nullptr, 0, false), 4);
    const double bare = kFloor / kPi * light.irradiance([](double) { return 1.0; });
    for (const Glass& glass : kGlasses) {
      SCOPED_TRACE(light.name + " through " + glass.name);
      // the light's own scale is its own test's business
      const double expected = shown(light, glass, true, false) / bare * open.mean();
      const auto seen = overSeeds(scene(light, &glass, 0, false), 8);
      EXPECT_MEAN(seen, expected, 0.012 * open.mean());
    }
  }
}

TEST(GlassShadows, SplitsOfSamplesChangeNoMean) {
  for (const Light& light : lights()) {
    if (light.isDelta) continue;
    for (const Glass& glass : kGlasses) {
      SCOPED_TRACE(light.name + " through " + glass.name);
      const double expected = shown(light, glass, true, false);
      for (const Splits s : {Splits{0, 8}, Splits{4, 1}, Splits{1, 4}}) {
        SCOPED_TRACE(std::to_string(s.lights) + " light samples, " + std::to_string(s.directions) + " directions");
        EXPECT_MEAN(overSeeds(scene(light, &glass, 0, false, s, 128), 12), expected, 0.02 * expected);
      }
    }
  }
}

// Even light, so that what the floor and the glass send each other is even too.
TEST(GlassShadows, BesideRefractedPaths) {
  for (const Light& light : lights()) {
    if (light.name != "dome" && light.name != "distant at 0" && light.name != "distant at 45") continue;
    for (const Glass& glass : kGlasses) {
      SCOPED_TRACE(light.name + " through " + glass.name);
      const double expected = shown(light, glass, true, true);
      // what rough glass sends back is that of clear glass, nearly
      EXPECT_MEAN(overSeeds(scene(light, &glass, 6, false, {}, 128), 8), expected,
                  (glass.isRough ? 0.025 : 0.012) * expected);
      if (light.isDelta && glass.isRough) continue;  // by chance alone: too noisy to judge
      const auto refracted = overSeeds(scene(light, &glass, 12, true, {}, 256), 8);
      if (light.isDelta) {
        // no sampled direction meets a point-like light, and no shadow ray passes glass, but for paths that leave the
        // sheets by their far edges
        EXPECT_LT(refracted.mean(), 1e-5 * expected);
      } else {
        const double whole = shown(light, glass, false, true);
        // rough slabs send a few per cent more back than straight rays know
        EXPECT_MEAN(refracted, whole, (glass.isRough ? 0.1 : 0.015) * whole);
      }
    }
  }
}

// Glass that the camera sees refracts twice, rough or clear, with caustics or without: under an even sky it vanishes.
TEST(GlassShadows, GlassSeenByTheCameraIsRefracted) {
  for (const char* roughness : {"0", "0.1", "0.4"}) {
    RenderRequest r;
    r.rib =
        orthographic(8, 0.9, 64) +
        "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [40] \"float clampLuminance\" [1e30] \"float "
        "rouletteThreshold\" [0]\nWorldBegin Light \"PxrDomeLight\" \"l\"\nBxdf \"PxrGlass\" \"g\" \"float "
        "roughness\" [" +
        std::string(roughness) + "]\nTranslate 0 0 3 Sphere 1 -1 1 360 WorldEnd\n";
    SCOPED_TRACE(roughness);
    EXPECT_MEAN(overSeeds(r, 8), 1.0, 0.015);
  }
}

}  // namespace
}  // namespace kinora::tests
