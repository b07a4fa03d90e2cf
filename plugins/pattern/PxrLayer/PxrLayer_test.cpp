// PxrLayer hands its members on, with weights of 0 where a lobe is switched off. That a whole network renders as its
// flat material is proved in tests/patterns/layered_material_test.cpp.
#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrLayer, HandsOnWhatIsSwitchedOn) {
  TestContext t("PxrLayer", 3);
  t.set("diffuseColor", {{0.1f, 0.2f, 0.3f}, {0.4f}, {0.5f}});
  t.set("specularFaceColor", 0.5f);
  t.set("specularGain", {{1.f, 0.5f, 0.f}});
  t.set("specularRoughness", 0.7f);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_diffuseColor", 1), 0.2f);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_diffuseGain"), 1);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_specularFaceColor"), 0) << "specular is off by default";
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_specularRoughness"), 0.7f);
  t.set("enableSpecular", 1);
  t.set("enableDiffuse", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_diffuseGain"), 0);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_specularFaceColor", 1, 2), 0.25f);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_specularFaceColor", 2), 0);
}

TEST(PxrLayer, TakesTheOlderNamesOfGlass) {
  TestContext t("PxrLayer", 1);
  t.set("refractionGain", 0.25f);
  t.set("glassIor", 1.7f);
  ASSERT_TRUE(t.run(1));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_refractionGain"), 0.25f);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_glassIor"), 1.7f);
  t.set("rrRefractionGain", 0.5f);
  t.set("rrIor", 1.2f);
  ASSERT_TRUE(t.run(1));
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_refractionGain"), 0.5f);
  EXPECT_FLOAT_EQ(t.at("pxrMaterialOut_glassIor"), 1.2f);
}

TEST(PxrLayer, SameBitsAtAllWidths) {
  TestContext t("PxrLayer", 45);
  t.set("enableSpecular", 1);
  t.set("specularEdgeColor", {spread(45, 0, 1), spread(45, 0, 1, 3), spread(45, 0, 1, 5)});
  t.set("specularGain", {spread(45, 0, 2, 7)});
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
