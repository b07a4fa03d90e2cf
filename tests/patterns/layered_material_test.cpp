// Layered materials in whole scenes: connecting a layer as one struct is connecting its members, and a layer of full
// mask renders as the plain material of its values, bit for bit.
#include <gtest/gtest.h>

#include "patterns/ball_under_sky.h"

namespace kinora::tests {
namespace {

std::vector<int64_t> pixelsOf(const std::string& material) {
  SceneRender render(ballUnderSky(material));
  EXPECT_TRUE(render.ok());
  for (const std::string& m : render.messages()) ADD_FAILURE() << m;
  return render.ok() ? stateOf(render.film()) : std::vector<int64_t>();
}

const char* const kLayers = R"(Pattern "PxrLayer" "red" "color diffuseColor" [0.8 0.1 0.1] "int enableSpecular" [1]
  "color specularEdgeColor" [1 1 1] "color specularFaceColor" [0.2 0.2 0.2] "float specularRoughness" [0.4]
Pattern "PxrLayer" "blue" "color diffuseColor" [0.1 0.1 0.9] "float fuzzGain" [0.5]
)";

TEST(LayeredMaterial, StructConnectsAllMembers) {
  const std::string layers = kLayers;
  const auto whole = pixelsOf(layers + R"(Pattern "PxrLayerMixer" "mix" "float layer1Mask" [0.3]
  "reference vstruct baselayer" ["red:pxrMaterialOut"] "reference vstruct layer1" ["blue:pxrMaterialOut"]
Bxdf "PxrLayerSurface" "m" "reference vstruct inputMaterial" ["mix:pxrMaterialOut"]
)");
  const auto apart = pixelsOf(layers + R"(Pattern "PxrLayerMixer" "mix" "float layer1Mask" [0.3]
  "int baselayer_enableSpecular" [1]
  "reference color baselayer_diffuseColor" ["red:pxrMaterialOut_diffuseColor"]
  "reference color baselayer_specularEdgeColor" ["red:pxrMaterialOut_specularEdgeColor"]
  "reference color baselayer_specularFaceColor" ["red:pxrMaterialOut_specularFaceColor"]
  "reference float baselayer_specularRoughness" ["red:pxrMaterialOut_specularRoughness"]
  "reference color layer1_diffuseColor" ["blue:pxrMaterialOut_diffuseColor"]
  "reference float layer1_fuzzGain" ["blue:pxrMaterialOut_fuzzGain"]
Bxdf "PxrLayerSurface" "m"
  "reference float diffuseGain" ["mix:pxrMaterialOut_diffuseGain"]
  "reference color diffuseColor" ["mix:pxrMaterialOut_diffuseColor"]
  "reference color specularEdgeColor" ["mix:pxrMaterialOut_specularEdgeColor"]
  "reference color specularFaceColor" ["mix:pxrMaterialOut_specularFaceColor"]
  "reference float specularRoughness" ["mix:pxrMaterialOut_specularRoughness"]
  "reference float fuzzGain" ["mix:pxrMaterialOut_fuzzGain"]
)");
  ASSERT_FALSE(whole.empty());
  EXPECT_EQ(whole, apart);
}

// The layer "red" as a material of its own.
const char* const kRed = R"(Bxdf "PxrSurface" "m" "color diffuseColor" [0.8 0.1 0.1]
  "color specularEdgeColor" [1 1 1] "color specularFaceColor" [0.2 0.2 0.2] "float specularRoughness" [0.4]
)";

TEST(LayeredMaterial, OneLayerIsThePlainMaterial) {
  const auto layered = pixelsOf(kLayers + std::string(R"(
Bxdf "PxrLayerSurface" "m" "reference vstruct inputMaterial" ["red:pxrMaterialOut"]
)"));
  const auto plain = pixelsOf(kRed);
  ASSERT_FALSE(layered.empty());
  EXPECT_EQ(layered, plain);
  // what the scene connects by itself stays
  const auto own = pixelsOf(kLayers + std::string(R"(Pattern "PxrToFloat3" "grey" "float input" [0.5]
Bxdf "PxrLayerSurface" "m" "reference vstruct inputMaterial" ["red:pxrMaterialOut"]
  "reference color diffuseColor" ["grey:resultRGB"]
)"));
  EXPECT_NE(own, plain);
}

// A mixer may lie under a mixer: what it has stays on.
TEST(LayeredMaterial, MixersNest) {
  const auto nested = pixelsOf(kLayers + std::string(R"(Pattern "PxrLayerMixer" "inner" "float layer1Mask" [0]
  "reference vstruct baselayer" ["red:pxrMaterialOut"] "reference vstruct layer1" ["blue:pxrMaterialOut"]
Pattern "PxrLayerMixer" "outer" "float layer1Mask" [0]
  "reference vstruct baselayer" ["inner:pxrMaterialOut"]
Bxdf "PxrLayerSurface" "m" "reference vstruct inputMaterial" ["outer:pxrMaterialOut"]
)"));
  const auto plain = pixelsOf(kRed);
  ASSERT_FALSE(nested.empty());
  EXPECT_EQ(nested, plain);
}

// A layer of which nothing is said is none, whatever its switch and its mask; one value of it makes it one.
TEST(LayeredMaterial, LayersOfNothingAreNone) {
  const auto mixed = [](const std::string& more) {
    return pixelsOf(kLayers + ("Pattern \"PxrLayerMixer\" \"mix\" \"reference vstruct baselayer\" "
                               "[\"red:pxrMaterialOut\"] " +
                               more +
                               "\nBxdf \"PxrLayerSurface\" \"m\" \"reference vstruct inputMaterial\" "
                               "[\"mix:pxrMaterialOut\"]\n"));
  };
  const auto plain = pixelsOf(kLayers + std::string(R"(
Bxdf "PxrLayerSurface" "m" "reference vstruct inputMaterial" ["red:pxrMaterialOut"]
)"));
  ASSERT_FALSE(plain.empty());
  EXPECT_EQ(mixed(""), plain);
  EXPECT_EQ(mixed("\"int layer2Enabled\" [1] \"float layer2Mask\" [0.5]"), plain);
  EXPECT_NE(mixed("\"color layer1_diffuseColor\" [0.18 0.18 0.18]"), plain);
}

}  // namespace
}  // namespace kinora::tests
