// Trees of Lama nodes in whole scenes: they render as the node that they become, whatever order and names they have,
// values of leaves may be connected, and trees that cannot be kept are told. Formulas are in LamaSurface_test.cpp.
#include <gtest/gtest.h>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

struct Seen {
  std::vector<int64_t> pixels;
  std::vector<std::string> messages;
};
Seen seen(const std::string& material) {
  RenderRequest r;
  r.rib = R"(Format 24 16 1
Hider "raytrace" "int maxsamples" [4]
Projection "perspective" "float fov" [40]
WorldBegin
Light "PxrDomeLight" "sky" "color lightColor" [0.8 0.9 1]
Translate 0 0 3
)" + material +
          "Sphere 1 -1 1 360\nWorldEnd\n";
  SceneRender render(std::move(r));
  EXPECT_TRUE(render.ok());
  return {render.ok() ? stateOf(render.film()) : std::vector<int64_t>(), render.messages()};
}
std::vector<int64_t> quietly(const std::string& material) {
  const Seen s = seen(material);
  for (const std::string& m : s.messages) ADD_FAILURE() << m;
  return s.pixels;
}

TEST(LamaMaterial, ARootOfOneSlabIsTheSlab) {
  const std::string slab = "Bxdf \"LamaDiffuse\" \"a\" \"color color\" [0.8 0.3 0.1] \"float roughness\" [0.4]\n";
  const auto alone = quietly(slab);
  EXPECT_EQ(alone, quietly(slab + "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"a\"]\n"));
  EXPECT_EQ(alone,
            quietly(slab + "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"a\"] \"reference bxdf "
                           "materialBack\" [\"a\"]\n"));
  EXPECT_EQ(alone,
            quietly("Bxdf \"LamaDiffuse\" \"a\" \"color diffuseColor\" [0.8 0.3 0.1] \"float roughness\" [0.4]\n"));
}

// Scattering below the surface, by both sets of names, alone and as the one slab of a tree.
TEST(LamaMaterial, ASlabThatScattersBelowIsOneToo) {
  const std::string root = "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"a\"]\n";
  const std::string reach = "\"color sssRadius\" [90 60 30] \"float sssBleed\" [0.5] ";
  for (const char* mode : {"0", "1", "2", "3"})
    for (const char* inversion : {"0", "1"}) {
      const std::string slab = "Bxdf \"LamaSSS\" \"a\" \"color color\" [0.8 0.3 0.1] " + reach + "\"int sssMode\" [" +
                               mode + "] \"int albedoInversionMethod\" [" + inversion + "]\n";
      EXPECT_EQ(quietly(slab), quietly(slab + root)) << mode << " " << inversion;
    }
  const std::string said = "Bxdf \"LamaSSS\" \"a\" \"color color\" [0.8 0.3 0.1] " + reach + "\n",
                    named = "Bxdf \"LamaSSS\" \"a\" \"color sssColor\" [0.8 0.3 0.1] " + reach + "\n";
  const std::string diffuse = "Bxdf \"LamaDiffuse\" \"a\" \"color color\" [0.8 0.3 0.1]\n";
  EXPECT_EQ(quietly(said), quietly(named));
  EXPECT_EQ(quietly(named), quietly(named + root));
  EXPECT_NE(quietly(said), quietly(diffuse));
  for (const char* none : {"\"color sssRadius\" [0 0 0]", "\"color sssRadius\" [1 1 1] \"float sssScale\" [0]"}) {
    const std::string slab = std::string("Bxdf \"LamaSSS\" \"a\" \"color color\" [0.8 0.3 0.1] ") + none + "\n";
    EXPECT_EQ(quietly(slab), quietly(slab + root)) << none;
    EXPECT_NE(quietly(slab), quietly(said)) << none;
  }
  // under a coat
  const std::string coated = R"(Bxdf "LamaDielectric" "coat" "float roughness" [0.2] "int fresnelMode" [1]
Bxdf "LamaLayer" "all" "reference bxdf materialTop" ["coat"] "reference bxdf materialBase" ["a"]
)";
  EXPECT_NE(quietly(named + coated), quietly(diffuse + coated));
}

// Three profiles, alone and in a tree; hair is a root by itself.
TEST(LamaMaterial, TricolorAndHairAreRootsToo) {
  const std::string root = "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"a\"]\n";
  const std::string three =
      "Bxdf \"LamaTricolorSSS\" \"a\" \"color nearColor\" [0.8 0.3 0.1] \"color midColor\" [0.9 0.2 0.1] \"color "
      "farColor\" [0.5 0.1 0.1] \"float nearRadius\" [20] \"float midRadius\" [60] \"float farRadius\" [150] \"float "
      "nearWeight\" [0.5] \"float sssScale\" [1.5]\n";
  EXPECT_EQ(quietly(three), quietly(three + root));
  const std::string hair = "Bxdf \"LamaHairChiang\" \"a\" \"color colorTT\" [0.8 0.4 0.2]\n";
  EXPECT_EQ(quietly(hair), quietly(hair + root));
}

TEST(LamaMaterial, TreesBecomeTheirStructure) {
  const std::string tree = R"(Pattern "PxrVary" "grey" "color inputRGB" [0.5 0.25 0.75]
Bxdf "LamaDiffuse" "base" "color color" [0.8 0.3 0.1]
Bxdf "LamaConductor" "metal" "float roughness" [0.3]
Bxdf "LamaMix" "mixed" "reference bxdf material1" ["base"] "reference bxdf material2" ["metal:bxdf_out"] "float mix" [0.4]
Bxdf "LamaDielectric" "coat" "float roughness" [0.2] "int fresnelMode" [1] "float IOR" [1.6]
Bxdf "LamaLayer" "all" "reference bxdf materialTop" ["coat"] "reference bxdf materialBase" ["mixed"] "float topMix" [0.8]
)";
  const auto whole = quietly(tree + "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"all\"]\n");
  EXPECT_EQ(whole, quietly(tree)) << "a tree without a root";
  EXPECT_EQ(whole, quietly(R"(Bxdf "LamaSurface" "s" "string structure" ["DCMRL"]
  "color leaf1_color" [0.8 0.3 0.1] "float leaf1_roughness" [0]
  "color leaf2_color" [1 1 1] "color leaf2_second" [0.18 0.42 1.37] "color leaf2_third" [3.42 2.35 1.77]
  "float leaf2_roughness" [0.3] "float leaf3_roughness" [0.2] "float leaf3_ior" [1.6] "color leaf3_color" [1 1 1]
  "float op1_amount" [0.4] "float op2_amount" [0.8]
)"));
}

TEST(LamaMaterial, ValuesOfLeavesMayBeConnected) {
  const std::string plain = R"(Bxdf "LamaDiffuse" "a" "color color" [0.8 0.3 0.1]
Bxdf "LamaSheen" "b" "float roughness" [0.5]
Bxdf "LamaLayer" "m" "reference bxdf materialTop" ["b"] "reference bxdf materialBase" ["a"] "float topMix" [0.5]
)";
  const std::string connected = R"(Pattern "PxrToFloat3" "c" "float input" [0.5]
Pattern "PxrToFloat" "half" "color input" [0.5 0.5 0.5]
Bxdf "LamaDiffuse" "a" "color color" [0.8 0.3 0.1]
Bxdf "LamaSheen" "b" "reference float roughness" ["half:resultF"]
Bxdf "LamaLayer" "m" "reference bxdf materialTop" ["b"] "reference bxdf materialBase" ["a"] "reference float topMix" ["half:resultF"]
)";
  EXPECT_EQ(quietly(plain), quietly(connected));
}

TEST(LamaMaterial, WhatCannotBeKeptIsTold) {
  const auto told = [](const std::string& material, const std::string& what) {
    const Seen s = seen(material);
    bool found = false;
    for (const std::string& m : s.messages)
      found = found || (m.find("BXDF-LAYERS") != m.npos && m.find(what) != m.npos);
    EXPECT_TRUE(found) << what;
    EXPECT_LE(s.messages.size(), 3u);
  };
  told("Bxdf \"LamaSurface\" \"s\"\n", "no slab");
  told("Bxdf \"LamaLayer\" \"s\"\n", "no slab");
  for (const std::string text : {"DL", "DD", "K", "", "UXMQM", "DDDDDDDDDLLLLLLLL"})
    told("Bxdf \"LamaSurface\" \"s\" \"string structure\" [\"" + text + "\"]\n", "is no tree");
  told(
      "Bxdf \"PxrDiffuse\" \"a\" \"color diffuseColor\" [0.5 0.5 0.5]\nBxdf \"LamaSurface\" \"s\" \"reference bxdf "
      "materialFront\" [\"a\"]\n",
      "diffuseColor");
  told(
      "Bxdf \"LamaSSS\" \"a\" \"color sssRadius\" [9 9 9]\nBxdf \"LamaSSS\" \"b\"\nBxdf \"LamaTricolorSSS\" "
      "\"c\"\nBxdf "
      "\"LamaMix\" \"m\" \"reference bxdf material1\" [\"a\"] \"reference bxdf material2\" [\"b\"]\nBxdf \"LamaMix\" "
      "\"n\" \"reference bxdf material1\" [\"m\"] \"reference bxdf material2\" [\"c\"]\n",
      "more than 2 slabs");
  told(
      "Bxdf \"LamaHairChiang\" \"a\" \"color colorTT\" [0.8 0.4 0.2]\nBxdf \"LamaDiffuse\" \"b\"\nBxdf \"LamaMix\" "
      "\"m\" \"reference bxdf material1\" [\"a\"] \"reference bxdf material2\" [\"b\"]\n",
      "a diffuse slab of its colorTT");
  told(
      "Bxdf \"LamaDiffuse\" \"a\"\nBxdf \"LamaDiffuse\" \"b\"\nBxdf \"LamaSurface\" \"s\" \"reference bxdf "
      "materialFront\" [\"a\"] \"reference bxdf materialBack\" [\"b\"]\n",
      "back");
  // each mix reads the one before twice: 2^40 leaves
  std::string chain = "Bxdf \"LamaDiffuse\" \"m0\"\n", empty = "Bxdf \"LamaMix\" \"m0\"\n";
  for (int i = 1; i <= 40; ++i) {
    const std::string before = "m" + std::to_string(i - 1),
                      line = "Bxdf \"LamaMix\" \"m" + std::to_string(i) + "\" \"reference bxdf material1\" [\"" +
                             before + "\"] \"reference bxdf material2\" [\"" + before + "\"]\n";
    chain += line;
    empty += line;
  }
  told(chain, "more than 8");
  told(empty, "more than 8");
}

}  // namespace
}  // namespace kinora::tests
