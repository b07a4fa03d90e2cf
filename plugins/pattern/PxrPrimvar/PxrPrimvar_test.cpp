// Proves defaults by type, conversion between outputs, and transformation of points and normals.
#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrPrimvar, FloatAndItsDefault) {
  TestContext t("PxrPrimvar", 3);
  t.setText("varname", "weight");
  t.set("defaultFloat", 0.75f);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultF"), 0.75f);
  EXPECT_TRUE(t.out("resultF").uniform());
  t.setPrimvar("weight", {{1.f, 2.f, 3.f}}, 0.5f);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultF", 2), 3.f);
  EXPECT_FLOAT_EQ(t.at("resultRGB", 1, 2), 2.f);
  EXPECT_FLOAT_EQ(t.at("width"), 0.5f);
}

TEST(PxrPrimvar, ColorAndFloat2) {
  TestContext t("PxrPrimvar", 2);
  t.setText("varname", "Cs");
  t.setText("type", "color");
  t.set("defaultColor", Numbers{{0.1f}, {0.2f}, {0.3f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultB"), 0.3f);
  EXPECT_FLOAT_EQ(t.at("width"), 0.f);
  t.setPrimvar("Cs", {{0.5f, 0.6f}, {0.7f, 0.8f}});
  t.setText("type", "float2");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultG", 1), 0.8f);
  EXPECT_FLOAT_EQ(t.at("resultB", 1), 0.f);
  EXPECT_FLOAT_EQ(t.at("resultF", 1), 0.6f);
}

TEST(PxrPrimvar, MovesPointsAndNormals) {
  TestContext t("PxrPrimvar", 2);
  t.setText("varname", "v");
  t.setPrimvar("v", {{1.f, 0.f}, {2.f, 0.f}, {3.f, 1.f}});
  // scale 2, 3, 4, then shift by 10, 20, 30; and its inverse
  t.matrices["render>object"] = {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 10, 20, 30, 1};
  t.matrices["object>render"] = {0.5f, 0, 0, 0, 0, 1 / 3.f, 0, 0, 0, 0, 0.25f, 0, -5, -20 / 3.f, -7.5f, 1};
  t.setText("type", "point");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultP", 0, 1), 26.f);
  t.setText("type", "vector");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultP", 0, 2), 12.f);
  t.setText("type", "normal");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultP", 0, 0), 0.5f);
  EXPECT_FLOAT_EQ(t.at("resultP", 1, 2), 0.25f);
  t.setText("coordsys", "nowhere");  // unknown spaces leave it where it is
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultP", 0, 1), 2.f);
  t.setText("coordsys", "object");
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
