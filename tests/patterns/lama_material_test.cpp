// Trees of Lama nodes in whole scenes: they render as the node that they become, whatever order and names they have,
// values of leaves may be connected, and trees that cannot be kept are told. Formulas are in LamaSurface_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "patterns/ball_under_sky.h"

namespace kinora::tests {
namespace {

struct Seen {
  std::vector<int64_t> pixels;
  std::vector<std::string> messages;
};
Seen seen(const std::string& material) {
  SceneRender render(ballUnderSky(material));
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

// Layers, mixes and sums of hair, with the slabs that may stand beside it, become one node of LamaHairSurface.
TEST(LamaMaterial, TreesOfHairBecomeTheirStructure) {
  const std::string tree =
      R"(Bxdf "LamaHairChiang" "brown" "int colorMode" [1] "float eumelanin" [2] "float offset" [3]
Bxdf "LamaHairChiang" "white" "color colorTT" [0.9 0.9 0.9] "float azimuthalRoughness" [0.6]
Bxdf "LamaMix" "grey" "reference bxdf material1" ["brown"] "reference bxdf material2" ["white:bxdf_out"] "float mix" [0.4]
Bxdf "LamaDiffuse" "dust" "color color" [0.5 0.4 0.3] "float roughness" [0.3]
Bxdf "LamaAdd" "all" "reference bxdf material1" ["grey"] "reference bxdf material2" ["dust"] "float weight1" [0.8] "float weight2" [0.2]
)";
  const Seen s = seen(tree);
  EXPECT_TRUE(s.messages.empty()) << s.messages[0];
  const auto whole = quietly(tree + "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"all\"]\n");
  EXPECT_EQ(whole, quietly(tree)) << "a tree without a root";
  EXPECT_EQ(whole, quietly(R"(Bxdf "LamaHairSurface" "s" "string structure" ["IIMDP"]
  "int leaf1_colorMode" [1] "float leaf1_eumelanin" [2] "float leaf1_offset" [3]
  "color leaf2_colorTT" [0.9 0.9 0.9] "float leaf2_azimuthalRoughness" [0.6]
  "color leaf3_color" [0.5 0.4 0.3] "float leaf3_roughness" [0.3]
  "float op1_amount" [0.4] "float op2_amount" [0.8] "float op2_other" [0.2]
)"));
  // a coat over hair, and hair over something
  const std::string layers = R"(Bxdf "LamaHairChiang" "hair" "color colorTT" [0.9 0.6 0.3]
Bxdf "LamaDielectric" "wet" "int fresnelMode" [1] "float IOR" [1.33] "float roughness" [0.4] "color transmissionTint" [0.9 0.8 0.7]
Bxdf "LamaLayer" "coated" "reference bxdf materialBase" ["hair"] "reference bxdf materialTop" ["wet"] "float topMix" [0.8]
Bxdf "LamaDiffuse" "skin" "color color" [0.5 0.4 0.3]
Bxdf "LamaLayer" "all" "reference bxdf materialBase" ["skin"] "reference bxdf materialTop" ["coated"] "float topMix" [0.7]
)";
  EXPECT_EQ(quietly(layers), quietly(R"(Bxdf "LamaHairSurface" "s" "string structure" ["DIRLL"]
  "color leaf1_color" [0.5 0.4 0.3] "color leaf2_colorTT" [0.9 0.6 0.3]
  "color leaf3_color" [1 1 1] "color leaf3_through" [0.9 0.8 0.7] "float leaf3_roughness" [0.4] "float leaf3_coatIOR" [1.33]
  "float op1_amount" [0.8] "float op2_amount" [0.7]
)"));
  // a half that is not there is black
  const std::string hair = "Bxdf \"LamaHairChiang\" \"a\"\n", mix = "Bxdf \"LamaMix\" \"m\" \"float mix\" [0.25] ";
  EXPECT_EQ(quietly(hair + mix + "\"reference bxdf material2\" [\"a\"]\n"),
            quietly("Bxdf \"LamaHairSurface\" \"m\" \"string structure\" [\"EIM\"] \"float op1_amount\" [0.25]\n"));
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

// A half that is not there is black, whichever it is and however the amount is said; a top without a base shows as far
// as topMix says.
TEST(LamaMaterial, HalvesThatAreMissingAreBlack) {
  const std::string slabs = R"(Pattern "PxrToFloat" "part" "color input" [0.25 0.25 0.25]
Bxdf "LamaDiffuse" "a" "color color" [0.8 0.3 0.1]
Bxdf "LamaEmission" "none" "color color" [0 0 0]
)";
  const std::string mix = "Bxdf \"LamaMix\" \"m\" \"reference bxdf material2\" [\"a\"] ",
                    none = "\"reference bxdf material1\" [\"none\"] ", said = "\"float mix\" [0.25]\n",
                    connected = "\"reference float mix\" [\"part:resultF\"]\n";
  const auto quarter = quietly(slabs + mix + none + said);
  EXPECT_NE(quarter, quietly(slabs + mix + none + "\"float mix\" [0.5]\n"));
  EXPECT_EQ(quarter, quietly(slabs + mix + said));
  EXPECT_EQ(quarter, quietly(slabs + mix + connected));
  const std::string top = "Bxdf \"LamaLayer\" \"m\" \"reference bxdf materialTop\" [\"a\"] ";
  EXPECT_EQ(quarter, quietly(slabs + top + "\"float topMix\" [0.25]\n"));
  EXPECT_EQ(quarter, quietly(slabs + top + "\"reference float topMix\" [\"part:resultF\"]\n"));
  const std::string sum =
      "Bxdf \"LamaAdd\" \"m\" \"float weight1\" [0.5] \"float weight2\" [0.25] "
      "\"reference bxdf material2\" [\"a\"] ";
  EXPECT_EQ(quietly(slabs + sum), quietly(slabs + sum + none));
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
      "Bxdf \"LamaHairChiang\" \"a\" \"color colorTT\" [0.8 0.4 0.2]\nBxdf \"LamaConductor\" \"b\"\nBxdf \"LamaMix\" "
      "\"m\" \"reference bxdf material1\" [\"a\"] \"reference bxdf material2\" [\"b\"]\n",
      "a diffuse slab of its colorTT");
  told(
      "Bxdf \"LamaHairChiang\" \"a\"\nBxdf \"LamaDielectric\" \"b\"\nBxdf \"LamaLayer\" \"m\" \"reference bxdf "
      "materialTop\" [\"a\"] \"reference bxdf materialBase\" [\"b\"]\n",
      "layered, mixed and summed with hair");
  std::string hairs = "Bxdf \"LamaHairChiang\" \"m0\"\n";
  for (int i = 1; i < 6; ++i)
    hairs += "Bxdf \"LamaHairChiang\" \"h" + std::to_string(i) + "\"\nBxdf \"LamaAdd\" \"m" + std::to_string(i) +
             "\" \"reference bxdf material1\" [\"m" + std::to_string(i - 1) +
             "\"] \"reference bxdf material2\" [\"h" + std::to_string(i) + "\"]\n";
  told(hairs, "more than 4");
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

// Names of lobes: each is what its slab returns, by the name and by the number that Option "lpe" gives it; what has none
// keeps the lobe's own.
TEST(LamaMaterial, SlabsNameTheirLobes) {
  const auto channels = [](const std::string& material, std::vector<std::string>* said = nullptr) {
    RenderRequest r;
    const auto channel = [](const char* name, const char* expression) {
      return std::string("DisplayChannel \"color ") + name + "\" \"string source\" [\"color lpe:" + expression +
             "\"]\n";
    };
    r.rib =
        "Format 24 16 1\nHider \"raytrace\" \"int maxsamples\" [16]\nProjection \"perspective\" \"float fov\" "
        "[40]\nOption \"lpe\" \"string diffuse3\" [\"Paint\"]\n" +
        channel("paint", "C<RD'Paint'>L") + channel("third", "C<RD3>L") + channel("coat", "C<RS'Coat'>L") +
        channel("cloth", "C<RS'Cloth'>L") + channel("diffuse", "C<RD>L") + channel("specular", "C<RS>L") +
        "WorldBegin\nLight \"PxrDomeLight\" \"sky\"\nTranslate 0 0 3\n" + material + "Sphere 1 -1 1 360\nWorldEnd\n";
    r.channels = "Ci,paint,third,coat,cloth,diffuse,specular";
    SceneRender render(std::move(r));
    EXPECT_TRUE(render.ok());
    if (said) *said = render.messages();
    std::map<std::string, double> sums;
    for (const char* name : {"paint", "third", "coat", "cloth", "diffuse", "specular"})
      for (const float x : render.channel(name).pixels) sums[name] += x;
    return sums;
  };
  const auto slab = [](const char* plugin, const char* handle, const std::string& name, const char* more = "") {
    return std::string("Bxdf \"") + plugin + "\" \"" + handle + "\" \"string lobeName\" [\"" + name + "\"] " + more +
           "\n";
  };
  const std::string layer =
      "Bxdf \"LamaLayer\" \"l\" \"reference bxdf materialBase\" [\"base\"] \"reference bxdf materialTop\" "
      "[\"top\"]\n";
  for (const bool isTree : {false, true}) {
    const std::string root = isTree ? "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"base\"]\n" : "";
    auto c = channels(slab("LamaDiffuse", "base", "Paint") + root);
    EXPECT_GT(c["diffuse"], 1);
    EXPECT_EQ(c["paint"], c["diffuse"]);
    EXPECT_EQ(c["third"], c["diffuse"]);
    c = channels(slab("LamaDiffuse", "base", "") + root);
    EXPECT_GT(c["diffuse"], 1);
    EXPECT_EQ(c["paint"], 0);
    EXPECT_EQ(c["third"], 0);
    c = channels(slab("LamaConductor", "base", "Coat", "\"float roughness\" [0]") + root);
    EXPECT_GT(c["specular"], 1) << "a mirror's lobe is one too";
    EXPECT_EQ(c["coat"], c["specular"]);
  }
  // two in one material: coat and base, and a rough coat
  for (const char* roughness : {"\"float roughness\" [0]", "\"float roughness\" [0.4]"}) {
    auto c =
        channels(slab("LamaDiffuse", "base", "Paint") + slab("LamaDielectric", "top", "Coat", roughness) + layer);
    EXPECT_GT(c["paint"], 1);
    EXPECT_GT(c["coat"], 1);
    EXPECT_EQ(c["paint"], c["diffuse"]);
    EXPECT_EQ(c["coat"], c["specular"]);
  }
  // a third name: told, and the lobe is as without
  std::vector<std::string> said;
  auto c = channels(slab("LamaDiffuse", "base", "Paint") + slab("LamaDielectric", "top", "Coat") + layer +
                        slab("LamaSheen", "cloth", "Cloth") +
                        "Bxdf \"LamaLayer\" \"m\" \"reference bxdf materialBase\" [\"l\"] \"reference bxdf "
                        "materialTop\" [\"cloth\"]\n",
                    &said);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("BXDF-LAYERS: the slabs of the material 'm' have more than 2 names of lobes"),
            std::string::npos)
      << said[0];
  EXPECT_EQ(c["cloth"], 0);
  EXPECT_GT(c["specular"], c["coat"]);
}

// An eighth of a turn of x is between x and y, seen from outside, whichever side the camera is on; a whole one is none.
TEST(LamaMaterial, RotationTurnsTheDirectionOfAnisotropy) {
  const auto image = [](const std::string& material, bool isFront) {
    RenderRequest r;
    r.rib =
        "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [16]\nProjection "
        "\"orthographic\"\nIntegrator \"PxrDirectLighting\" \"i\"\nWorldBegin\nTranslate 0 0 2\nAttributeBegin "
        "Translate 0 0 -1 Light \"PxrSphereLight\" \"l\"\nAttributeEnd\n" +
        material + "Polygon \"P\" " +
        (isFront ? "[-1 -1 0  -1 1 0  1 1 0  1 -1 0]" : "[1 -1 0  1 1 0  -1 1 0  -1 -1 0]") + "\nWorldEnd\n";
    SceneRender render(std::move(r));
    EXPECT_TRUE(render.ok());
    for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    return render.channel("Ci");
  };
  const auto difference = [](const image::Image& a, const image::Image& b) {
    double most = 0, mean = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
      most = std::max(most, std::fabs(double(a.pixels[i]) - double(b.pixels[i])));
      mean += a.pixels[i] / double(a.pixels.size());
    }
    return most / mean;
  };
  const std::string root = "Bxdf \"LamaSurface\" \"s\" \"reference bxdf materialFront\" [\"a\"]\n";
  struct {
    const char *plugin, *direction, *rotation;
  } const cases[] = {{"LamaConductor", "anisotropyDirection", "anisotropyRotation"},
                     {"LamaGeneralizedSchlick", "anisotropyDirection", "anisotropyRotation"},
                     {"LamaDielectric", "direction", "rotation"}};
  for (const auto& c : cases)
    for (const bool isFront : {true, false})
      for (const std::string& more : {std::string(), root}) {
        SCOPED_TRACE(std::string(c.plugin) + (isFront ? " front" : " back") + (more.empty() ? "" : " in a tree"));
        const auto of = [&](const char* direction, const char* rotation) {
          return image(std::string("Bxdf \"") + c.plugin +
                           "\" \"a\" \"float roughness\" [0.4] \"float anisotropy\" " + "[0.9] \"vector " +
                           c.direction + "\" [" + direction + "] \"float " + c.rotation + "\" [" + rotation + "]\n" +
                           more,
                       isFront);
        };
        const auto turned = of("1 0 0", "0.125");
        EXPECT_LT(difference(turned, of(isFront ? "1 1 0" : "1 -1 0", "0")), 1e-3);
        EXPECT_GT(difference(turned, of(isFront ? "1 -1 0" : "1 1 0", "0")), 0.03);
        EXPECT_LT(difference(of("1 0 0", "1"), of("1 0 0", "0")), 1e-3);
      }
}

}  // namespace
}  // namespace kinora::tests
