// Proves: what lights say of their own shadows (shadowColor, shadowDistance, shadowFalloff and its gamma, shadowSubset,
// shadowExcludeSubset, traceLightPaths, thinShadow, visibleInRefractionPath) on a white plane behind a wall, for every
// kind of light and however samples are split between lights and directions, against closed forms and against the same
// scene without the wall; what surfaces say of the shadows that they cast (shadowColor, shadowMode); that values which mean nothing are told of once. Misses: PxrVCM (tests/probes), surfaces of
// several resolutions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "plugin/registry.h"
#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

struct Kind {
  const char *name, *light, *geometry, *parameters = "";
};
#define LAMP "Translate 0 0 -1 Scale 2 2 2 "
const Kind kKinds[] = {
    {"PxrRectLight", "Scale 3 3 1 ", ""},
    {"PxrDiskLight", "Scale 3 3 1 ", ""},
    {"PxrSphereLight", LAMP, ""},
    {"PxrCylinderLight", LAMP, ""},
    {"PxrDistantLight", "", "", "\"float angleExtent\" [20] "},
    {"PxrDomeLight", "", ""},
    {"PxrEnvDayLight", "Rotate -90 1 0 0 ", ""},
    {"PointLight", "Translate 0 0 -1 ", ""},
    {"PxrMeshLight", "", "Polygon \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]\n"},
    {"PxrPortalLight", "Scale 3 3 1 ", ""},
};
#undef LAMP
const Kind& kSunlight = kKinds[4];
// By light samples alone (or almost), by directions alone, and by both.
const char* const kSplits[] = {"", "\"int numLightSamples\" [4]",
                               "\"int numLightSamples\" [0] \"int numIndirectSamples\" [8]"};

// A wall at a distance before the plane, below 0 behind it; 0: none. The camera does not see it.
std::string wall(double distance, const std::string& bxdf = "", const std::string& group = "walls") {
  if (distance == 0) return "";
  const std::string z = std::to_string(2 - distance) + " ";
  return "AttributeBegin Attribute \"visibility\" \"int camera\" [0] Attribute \"grouping\" \"string membership\" "
         "[\"" +
         group + "\"]\n" + (bxdf.empty() ? "Bxdf \"PxrDiffuse\" \"black\" \"color diffuseColor\" [0 0 0]\n" : bxdf) +
         "Polygon \"P\" [-50 -50 " + z + "50 -50 " + z + "50 50 " + z + "-50 50 " + z + "]\nAttributeEnd\n";
}

RenderRequest scene(const Kind& kind, const std::string& light, const std::string& walls, const std::string& split,
                    const std::string& attributes = "", const char* more = "\"int allowCaustics\" [0]") {
  RenderRequest r;
  r.rib = orthographic(16, 1e-4, 16) + unbiased(0, split + " " + more) +
          "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + kind.light + "Light \"" +
          kind.name + "\" \"l\" " + (light.find("angleExtent") < light.size() ? "" : kind.parameters) + light + "\n" +
          kind.geometry + "AttributeEnd\n" + walls + attributes +
          "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n"
          "Polygon \"P\" [-50 -50 2  -50 50 2  50 50 2  50 -50 2]\nWorldEnd\n";
  return r;
}
// A point is found by its samples alone.
bool isSampledOnly(const Kind& k, const char* split) {
  return std::string(k.name) == "PointLight" && std::string(split).find("[0]") != std::string::npos;
}

// Of red that is left in shadows, and no other colour: by lights of every kind and both halves of the estimate.
// shadowed(kind, share, split): the scene that leaves so much of it.
template <class Shadowed>
void expectSharesLeft(Shadowed&& shadowed) {
  for (const Kind& k : kKinds)
    for (const char* split : kSplits) {
      if (isSampledOnly(k, split)) continue;
      SCOPED_TRACE(std::string(k.name) + " " + split);
      const auto free = overSeeds(scene(k, "", "", ""), 16);
      for (const double share : {1.0, 0.25}) {
        const auto leaves = shadowed(k, share, split);
        const auto left = overSeeds(leaves, 16);
        EXPECT_NEAR(left.mean(), share * free.mean(), 5 * (left.standardError() + free.standardError()) + 1e-5);
        EXPECT_LT(left.standardError(), 0.03 * left.mean());
        EXPECT_LT(overSeeds(leaves, 1, "Ci", 1).mean(), 1e-3 * free.mean());
      }
    }
}

TEST(LightShadows, ColorIsTheShareThatIsLeft) {
  expectSharesLeft([](const Kind& k, double share, const char* split) {
    return scene(k, "\"color shadowColor\" [" + std::to_string(share) + " 0 0]", wall(0.3), split);
  });
}

// A narrow sun overhead: the wall stands as far away as it is before the plane.
TEST(LightShadows, FadeByTheDistanceOfWhatCastsThem) {
  const struct {
    const char* light;
    double strength;
  } cases[] = {
      {"\"float shadowDistance\" [0.25]", 0},
      {"\"float shadowDistance\" [0.35]", 1},
      {"\"float shadowDistance\" [0.4] \"float shadowFalloff\" [0.2]", 0.5},
      {"\"float shadowDistance\" [0.4] \"float shadowFalloff\" [0.2] \"float shadowFalloffGamma\" [2]", 0.25},
      {"\"float shadowDistance\" [0.6] \"float shadowFalloff\" [0.2]", 1},
      {"\"float shadowDistance\" [0.4] \"float shadowFalloff\" [0.4] \"color shadowColor\" [0.6 0.6 0.6]", 0.1},
      {"\"float shadowDistance\" [0]", 0},
  };
  const std::string half = "Bxdf \"PxrSurface\" \"b\" \"float diffuseGain\" [0] \"float presence\" [0.5]\n";
  for (const auto& c : cases) {
    SCOPED_TRACE(c.light);
    const std::string sun = std::string("\"float angleExtent\" [0] \"float intensity\" [1] ");
    const double free = overSeeds(scene(kSunlight, sun, "", ""), 1).mean();
    EXPECT_GT(free, 0.1);
    EXPECT_NEAR(overSeeds(scene(kSunlight, sun + c.light, wall(0.3), ""), 1).mean(), (1 - c.strength) * free,
                1e-4 * free);
    EXPECT_NEAR(overSeeds(scene(kSunlight, sun + c.light, wall(0.3, half), ""), 1).mean(),
                (1 - 0.5 * c.strength) * free, 1e-4 * free);
  }
}

// What casts shadows is what visibility:transmission and the lit object's subset say, not what stops the rays that find
// the light.
TEST(LightShadows, AreThoseOfVisibilityHoweverTheLightIsFound) {
  const std::string black = "Bxdf \"PxrDiffuse\" \"black\" \"color diffuseColor\" [0 0 0]\n",
                    half = "Bxdf \"PxrSurface\" \"b\" \"float diffuseGain\" [0] \"float presence\" [0.5]\n";
  const auto visible = [](int indirect, int transmission) {
    return "Attribute \"visibility\" \"int indirect\" [" + std::to_string(indirect) + "] \"int transmission\" [" +
           std::to_string(transmission) + "]\n";
  };
  const auto trace = [](const char* what, const char* group) {
    return std::string("Attribute \"trace\" \"string ") + what + "\" [\"" + group + "\"]\n";
  };
  const std::string castsNone = wall(0.3, visible(1, 0) + black), castsAlone = wall(0.3, visible(0, 1) + black),
                    far = wall(0.6, black, "far"), farHalf = wall(0.6, half, "far");
  const struct {
    std::string walls, attributes;
    double share;
  } cases[] = {
      {castsNone, "", 1},
      {castsAlone, "", 0},
      {castsNone + far, "", 0},
      {castsNone + farHalf, "", 0.5},
      {wall(0.3, visible(0, 1) + half), "", 0.5},
      {castsNone + wall(0.6, visible(0, 1) + half), "", 0.5},
      {wall(0.3), trace("shadowexcludesubset", "walls"), 1},
      {wall(0.3) + wall(-1, "", "far"), trace("shadowsubset", "far"), 1},
      {wall(0.3) + far, trace("shadowsubset", "far"), 0},
      {wall(0.3), trace("reflectexcludesubset", "walls"), 0},
  };
  for (const Kind& k : {kKinds[0], kSunlight, kKinds[5], kKinds[8]})
    for (const char* split : kSplits) {
      SCOPED_TRACE(std::string(k.name) + " " + split);
      const auto free = overSeeds(scene(k, "", "", ""), 16);
      for (const auto& c : cases) {
        SCOPED_TRACE(c.walls + c.attributes);
        const auto m = overSeeds(scene(k, "", c.walls, split, c.attributes), 8);
        EXPECT_NEAR(m.mean(), c.share * free.mean(),
                    5 * (m.standardError() + free.standardError()) + 1e-3 * free.mean());
        if (c.share > 0) {
          EXPECT_LT(m.standardError(), 0.04 * m.mean());
        }
      }
    }
}

std::string coloring(const std::string& bxdf, double share, const std::string& more = "") {
  return "Bxdf \"" + bxdf + "\" \"b\" \"color shadowColor\" [" + std::to_string(share) + " 0 0] " + more + "\n";
}

TEST(LightShadows, SurfacesColorThoseThatTheyCast) {
  expectSharesLeft([](const Kind& k, double share, const char* split) {
    return scene(k, "", wall(0.3, coloring("PxrSurface", share)), split);
  });
}

// Every material that has the parameter, beside what its glass lets through without it.
TEST(LightShadows, EveryMaterialWithAShadowColorHasOne) {
  const std::string sun = "\"float angleExtent\" [0] \"float intensity\" [1] ";
  const auto of = [&](const std::string& bxdf) {
    return overSeeds(scene(kSunlight, sun, wall(0.3, bxdf), ""), 1).mean();
  };
  const double free = overSeeds(scene(kSunlight, sun, "", ""), 1).mean();
  EXPECT_GT(free, 0.1);
  Registry registry;
  int count = 0;
  for (const Descriptor* d : registry.all(kinora::Kind::Bxdf)) {
    const bool has = std::any_of(d->params, d->params + d->paramCount,
                                 [](const Param& p) { return std::string(p.name) == "shadowColor"; });
    if (!has) continue;
    ++count;
    const std::string more = std::string(d->name) == "LamaSurface" ? "\"string structure\" [\"D\"]" : "";
    const double none = of(coloring(d->name, 0, more));
    EXPECT_NEAR(of(coloring(d->name, 0.25, more)), none + 0.25 * (free - none), 1e-4 * free) << d->name;
    EXPECT_NEAR(of(coloring(d->name, 3, more)), free, 1e-4 * free) << d->name << ": at most all";
  }
  EXPECT_GE(count, 14);
}

TEST(LightShadows, ColorsOfSurfacesMeetPresenceGlassPatternsAndLayers) {
  const std::string sun = "\"float angleExtent\" [0] \"float intensity\" [1] ";
  const auto of = [&](const std::string& walls, const std::string& light = "") {
    return overSeeds(scene(kSunlight, sun + light, walls, ""), 1).mean();
  };
  const double free = of("");
  const auto expect = [&](double share, const std::string& bxdf) {
    EXPECT_NEAR(of(wall(0.3, bxdf)), share * free, 1e-4 * free) << bxdf;
  };
  expect(0.5 + 0.5 * 0.25, coloring("PxrSurface", 0.25, "\"float presence\" [0.5]"));
  expect(0.25,
         "Pattern \"PxrMix\" \"p\" \"color color1\" [0.25 0 0]\nBxdf \"PxrSurface\" \"b\" "
         "\"reference color shadowColor\" [\"p:resultRGB\"]\n");
  // glass by its tint and by the colour, or by the colour alone
  const std::string glass = "\"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" [1] ";
  const double tinted = of(wall(0.3, coloring("PxrSurface", 0, glass))) / free;
  EXPECT_GT(tinted, 0.5);
  EXPECT_LT(tinted, 0.99);
  expect(tinted + 0.25 * (1 - tinted), coloring("PxrSurface", 0.25, glass));
  expect(0.25, coloring("PxrSurface", 0.25, glass + "\"int shadowMode\" [1]"));
  expect(0, coloring("PxrSurface", 0, glass + "\"int shadowMode\" [1]"));
  // the first slab that says one, from the base up
  const std::string base = "Bxdf \"LamaDiffuse\" \"base\" ", top = "Bxdf \"LamaSheen\" \"top\" ",
                    quarter = "\"color shadowColor\" [0.25 0 0]\n", half = "\"color shadowColor\" [0.5 0 0]\n",
                    layer =
                        "Bxdf \"LamaLayer\" \"l\" \"reference bxdf materialBase\" [\"base\"] "
                        "\"reference bxdf materialTop\" [\"top\"]\n"
                        "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"l\"]";
  expect(0.25, base + quarter + top + half + layer + "\n");
  expect(0.5, base + "\n" + top + half + layer + "\n");
  expect(0.25, base + "\n" + top + half + layer + quarter);
  // two walls multiply, and a light's own colour counts for what they take
  const std::string walls = wall(0.3, coloring("PxrSurface", 0.5)) + wall(0.6, coloring("PxrSurface", 0.5));
  EXPECT_NEAR(of(walls), 0.25 * free, 1e-4 * free);
  EXPECT_NEAR(of(walls, "\"color shadowColor\" [0.5 0.5 0.5]"), 0.625 * free, 1e-4 * free);
}

// From the plane a sky is shadowed where the wall is nearer than the distance: within a cone about the normal.
TEST(LightShadows, DistanceIsAlongTheRay) {
  for (const char* split : kSplits) {
    const auto m = overSeeds(scene(kKinds[5], "\"float shadowDistance\" [0.35]", wall(0.3), split), 16);
    EXPECT_NEAR(m.mean(), std::pow(0.3 / 0.35, 2), 5 * m.standardError() + 1e-5) << split;
    EXPECT_LT(m.standardError(), 0.01);
  }
}

TEST(LightShadows, SubsetsChooseWhatCastsThem) {
  for (const Kind& k : {kKinds[0], kKinds[5]})
    for (const char* split : kSplits) {
      SCOPED_TRACE(std::string(k.name) + " " + split);
      const auto free = overSeeds(scene(k, "", "", ""), 8);
      const auto isFree = [&](const std::string& light, const std::string& walls,
                              const std::string& attributes = "") {
        EXPECT_SAME_MEAN(overSeeds(scene(k, light, walls, split, attributes), 8), free, 0.03);
      };
      const auto isDark = [&](const std::string& light, const std::string& walls,
                              const std::string& attributes = "") {
        // but for what passes the wall's ends
        EXPECT_LT(overSeeds(scene(k, light, walls, split, attributes), 1).mean(), 1e-3 * free.mean());
      };
      const std::string other = wall(0.6, "", "far");
      isDark("\"string shadowSubset\" [\"walls\"]", wall(0.3));
      isFree("\"string shadowSubset\" [\"far\"]", wall(0.3) + wall(-1, "", "far"));
      isDark("\"string shadowSubset\" [\"far\"]", wall(0.3) + other);
      isFree("\"string shadowExcludeSubset\" [\"walls\"]", wall(0.3));
      isDark("\"string shadowExcludeSubset\" [\"walls\"]", wall(0.3) + other);
      isFree("\"string shadowExcludeSubset\" [\"walls far\"]", wall(0.3) + other);
      isDark("\"string shadowExcludeSubset\" [\"walls\"] \"int traceLightPaths\" [1]", wall(0.3));
      // the light's subset stands instead of the lit object's
      const std::string excludes = "Attribute \"trace\" \"string shadowexcludesubset\" [\"walls\"]\n";
      isDark("\"string shadowSubset\" [\"walls\"]", wall(0.3), excludes);
      isFree("\"color shadowColor\" [0.1 0.1 0.1]", wall(0.3), excludes);
    }
}

// A sheet of glass over the plane. As tinted shadows its share is that of straight rays; of a light that glass blocks
// what refracted paths bring is all that there is, which is the whole truth.
TEST(LightShadows, GlassBlocksWithoutThinShadow) {
  const std::string glass = wall(0.3, "Bxdf \"PxrGlass\" \"g\" \"float roughness\" [0.3] \"float ior\" [1.3]\n");
  const auto of = [&](const char* light, const char* caustics, int bounces) {
    RenderRequest r =
        scene(kKinds[0], light,
              glass + wall(0.4, "Bxdf \"PxrGlass\" \"g2\" \"float roughness\" [0.3] \"float ior\" [1.3]\n"), "", "",
              caustics);
    const std::string from = "\"int maxIndirectBounces\" [0]";
    r.rib.replace(r.rib.find(from), from.size(), "\"int maxIndirectBounces\" [" + std::to_string(bounces) + "]");
    return overSeeds(r, 24);
  };
  const char *tinted = "\"int allowCaustics\" [0]", *caustics = "\"int allowCaustics\" [1]";
  EXPECT_GT(of("", tinted, 0).mean(), 0.1);
  EXPECT_EQ(of("\"int thinShadow\" [0]", tinted, 0).mean(), 0);
  EXPECT_EQ(of("\"int traceLightPaths\" [1]", tinted, 0).mean(), 0);
  const auto whole = of("", caustics, 4);
  EXPECT_SAME_MEAN(of("\"int thinShadow\" [0]", tinted, 4), whole, 0.05);
  EXPECT_SAME_MEAN(of("\"int traceLightPaths\" [1]", tinted, 4), whole, 0.05);
  // with a shadow's color the tinted part is left alone
  const auto part = of("\"color shadowColor\" [0.5 0.5 0.5]", tinted, 0),
             all = of("\"color shadowColor\" [1 1 1]", tinted, 0);
  EXPECT_NEAR(part.mean(), 0.5 * (of("", tinted, 0).mean() + all.mean()), 0.01 * all.mean());
}

// Seen by the camera through clear glass.
TEST(LightShadows, ClearGlassDoesNotShowWhatIsNotInRefractionPaths) {
  const auto seen = [&](const char* light, const char* bxdf) {
    RenderRequest r;
    r.rib = orthographic(4, 1e-2, 64) + unbiased(4) + "WorldBegin\nLight \"PxrDomeLight\" \"l\" " + light +
            "\nAttributeBegin " + bxdf +
            "\nPolygon \"P\" [-50 -50 1  50 -50 1  50 50 1  -50 50 1]\nAttributeEnd\nWorldEnd\n";
    return overSeeds(r, 4).mean();
  };
  const char* clear =
      "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] "
      "\"float reflectionGain\" [1] \"float glassRoughness\" [0] \"int thinGlass\" [1]";
  const double f = 0.04, reflected = 2 * f / (1 + f);
  EXPECT_NEAR(seen("", clear), 1, 0.01);
  EXPECT_NEAR(seen("\"int visibleInRefractionPath\" [0]", clear), reflected, 0.01);
}

TEST(LightShadows, SaysWhatMeansNothing) {
  const auto said = [](const std::string& light) {
    SceneRender render(scene(kSunlight, light, wall(0.3), ""));
    EXPECT_TRUE(render.ok());
    return render.messages();
  };
  for (const char* light :
       {"\"float shadowFalloffGamma\" [0]", "\"float shadowFalloffGamma\" [-2]", "\"float shadowFalloff\" [0.5]",
        "\"color shadowColor\" [2 0 0]", "\"color shadowColor\" [-1 0 0]"}) {
    const auto messages = said(light);
    const long told = std::count_if(messages.begin(), messages.end(), [](const std::string& m) {
      return m.find("LIGHT-SHADOW") != std::string::npos && m.find("'l'") != std::string::npos;
    });
    EXPECT_EQ(told, 1) << light;
  }
  const auto missing = said("\"string shadowSubset\" [\"nobody\"]");
  EXPECT_EQ(std::count_if(missing.begin(), missing.end(),
                          [](const std::string& m) { return m.find("nobody") != std::string::npos; }),
            1);
  EXPECT_TRUE(said("\"float shadowDistance\" [0.4] \"float shadowFalloff\" [3]").empty());
}

}  // namespace
}  // namespace kinora::tests
