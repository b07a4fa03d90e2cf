// PxrLayerMixer: members are blended one by one, in the order of the layers; a lobe that a layer lacks stays as it is
// below, one that is new comes in with its own shape.
#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrLayerMixer, BlendsByTheMask) {
  TestContext t("PxrLayerMixer", 3);
  t.set("baselayer_diffuseColor", {{0.2f}, {0.4f}, {0.6f}});
  t.set("layer1_diffuseColor", {{1.f}, {0.f}, {0.6f}});
  t.set("layer1_diffuseGain", 0.5f);
  t.set("layer1Mask", {{0.f, 0.5f, 1.f}});
  ASSERT_TRUE(t.run(8));
  const float red[] = {0.2f, 0.6f, 1.f}, gain[] = {1.f, 0.75f, 0.5f};
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(t.at("pxrMaterialOut_diffuseColor", i), red[i], 1e-6f);
    EXPECT_NEAR(t.at("pxrMaterialOut_diffuseColor", i, 2), 0.6f, 1e-6f);
    EXPECT_NEAR(t.at("pxrMaterialOut_diffuseGain", i), gain[i], 1e-6f);
  }
  t.set("layer1Mask", 7.f);  // never beyond the layer
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("pxrMaterialOut_diffuseColor"), 1.f, 1e-6f);
  t.set("layer1Enabled", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_diffuseColor"), 0.2f);
}

TEST(PxrLayerMixer, LayersLieOnEachOther) {
  TestContext t("PxrLayerMixer", 1);
  t.set("layer2Enabled", 1);
  t.set("layer4Enabled", 1);
  t.set("baselayer_diffuseGain", 0.f);
  t.set("layer1_diffuseGain", 1.f);
  t.set("layer1Mask", 0.5f);  // 0.5
  t.set("layer2_diffuseGain", 1.f);
  t.set("layer2Mask", 0.5f);  // 0.75
  t.set("layer3_diffuseGain", 100.f);
  t.set("layer4_diffuseGain", 0.f);
  t.set("layer4Mask", 0.25f);
  ASSERT_TRUE(t.run(4));
  EXPECT_NEAR(t.at("pxrMaterialOut_diffuseGain"), 0.5625f, 1e-6f);
}

TEST(PxrLayerMixer, LobesComeInWithTheirOwnShape) {
  TestContext t("PxrLayerMixer", 1);
  t.set("layer1_enableSpecular", 1);
  t.set("layer1_specularFaceColor", 0.8f);
  t.set("layer1_specularRoughness", 0.9f);
  t.set("baselayer_specularFaceColor", 0.3f);
  t.set("layer1Mask", 0.5f);
  ASSERT_TRUE(t.run(4));
  EXPECT_NEAR(t.at("pxrMaterialOut_specularFaceColor"), 0.4f, 1e-6f) << "the base's specular is off";
  EXPECT_NEAR(t.at("pxrMaterialOut_specularRoughness"), 0.9f, 1e-6f);
  t.set("baselayer_enableSpecular", 1);
  ASSERT_TRUE(t.run(4));
  EXPECT_NEAR(t.at("pxrMaterialOut_specularFaceColor"), 0.55f, 1e-6f);
  EXPECT_NEAR(t.at("pxrMaterialOut_specularRoughness"), 0.55f, 1e-6f);
  t.set("layer1_enableSpecular", 0);
  ASSERT_TRUE(t.run(4));
  EXPECT_NEAR(t.at("pxrMaterialOut_specularFaceColor"), 0.3f, 1e-6f) << "what the layer lacks stays";
}

TEST(PxrLayerMixer, NormalsLeanByTheMask) {
  TestContext t("PxrLayerMixer", 1);
  ASSERT_TRUE(t.run(4));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_bumpNormal", 0, 2), 0) << "no bump anywhere";
  t.set("layer1_bumpNormal", {{1.f}, {0.f}, {0.f}});
  t.set("layer1Mask", 0.25f);
  ASSERT_TRUE(t.run(4));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_bumpNormal", 0, 0), 0.25f);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_bumpNormal", 0, 2), 0.75f) << "the base's is the surface's normal";
}

TEST(PxrLayerMixer, SameBitsAtAllWidths) {
  TestContext t("PxrLayerMixer", 45);
  t.set("layer2Enabled", 1);
  t.set("baselayer_diffuseColor", {spread(45, 0, 1), spread(45, 0, 1, 3), spread(45, 0, 1, 5)});
  t.set("layer2_bumpNormal", {spread(45, -1, 1), spread(45, -1, 1, 3), spread(45, -1, 1, 5)});
  t.set("layer1Mask", {spread(45, -0.5f, 1.5f, 7)});
  t.set("layer2Mask", {spread(45, 0, 1, 9)});
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
