// Proves the order rotate, scale, shift, invert; the choice of primvars; and equal bits at all widths.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrManifold2D, RotatesScalesShiftsThenInverts) {
  TestContext t("PxrManifold2D", 3);
  t.setBuiltin(Builtin::St, {{1.f, 0.f, 0.25f}, {0.f, 1.f, 0.5f}});
  t.setBuiltin(Builtin::StRadius, {{0.01f, 0.02f, 0.03f}});
  t.set("angle", 90);
  t.set("scaleS", 2);
  t.set("scaleT", -3);
  t.set("offsetS", 0.125f);
  t.set("offsetT", 0.5f);
  t.set("invertT", 0);
  ASSERT_TRUE(t.run(8));
  // a quarter turn takes (1, 0) to (0, 1) and (0, 1) to (-1, 0)
  EXPECT_NEAR(t.at("resultS", 0), 0.125f, 1e-6f);
  EXPECT_NEAR(t.at("resultT", 0), -3 + 0.5f, 1e-6f);
  EXPECT_NEAR(t.at("resultS", 1), -2 + 0.125f, 1e-6f);
  EXPECT_NEAR(t.at("resultT", 1), 0.5f, 1e-6f);
  EXPECT_FLOAT_EQ(t.outManifold("result").radius.data[0][1], 0.06f);
  EXPECT_EQ(t.outManifold("result").dimensions, 2u);
  t.set("invertT", 1);
  t.set("invertS", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultS", 0), 1 - 0.125f, 1e-6f);
  EXPECT_NEAR(t.at("resultT", 0), 1 - (-3 + 0.5f), 1e-6f);
}

TEST(PxrManifold2D, TurnsAndScalesFootprints) {
  TestContext t("PxrManifold2D", 2);
  t.setBuiltin(Builtin::St, {{1.f, 0.f}, {0.f, 1.f}});
  t.setBuiltin(Builtin::StRadius, {{0.01f, 0.02f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.outManifold("result").axis[0].components, 0u) << "circles";
  t.setEllipses("", {{0.1f, 0.f}, {0.2f, 0.f}}, {{-0.3f, 0.f}, {0.4f, 0.f}});
  t.set("angle", 90);
  t.set("scaleS", 2);
  t.set("scaleT", -3);
  t.set("offsetS", 0.125f);
  t.set("invertS", 1);
  t.set("invertT", 0);
  ASSERT_TRUE(t.run(8));
  const Manifold& m = t.outManifold("result");
  ASSERT_EQ(m.axis[0].components, 2u);
  // a quarter turn takes (a, b) to (-b, a)
  EXPECT_NEAR(m.axis[0].data[0][0], 2 * 0.2f, 1e-6f);
  EXPECT_NEAR(m.axis[0].data[1][0], -3 * 0.1f, 1e-6f);
  EXPECT_NEAR(m.axis[1].data[0][0], 2 * 0.4f, 1e-6f);
  EXPECT_NEAR(m.axis[1].data[1][0], -3 * -0.3f, 1e-6f);
  for (uint32_t k = 0; k < 2; ++k) EXPECT_EQ(std::fabs(m.axis[0].data[k][1]) + std::fabs(m.axis[1].data[k][1]), 0.f);
  // coordinates of other primitive variables have other footprints, which the context of the test does not know
  t.setPrimvar("map2", {{0.1f, 0.2f}, {0.3f, 0.4f}}, 0.5f);
  t.setText("primvarS", "map2");
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.outManifold("result").axis[0].components, 0u);
}

TEST(PxrManifold2D, ReadsPrimvars) {
  TestContext t("PxrManifold2D", 2);
  t.setBuiltin(Builtin::St, {{9.f, 9.f}, {8.f, 8.f}});
  t.setBuiltin(Builtin::StRadius, {{1.f, 1.f}});
  t.set("invertT", 0);
  t.setPrimvar("map2", {{0.1f, 0.2f}, {0.3f, 0.4f}}, 0.5f);
  t.setPrimvar("only", {{0.7f}}, 0.25f);
  t.setText("primvarS", "map2");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultS", 1), 0.2f);
  EXPECT_FLOAT_EQ(t.at("resultT", 1), 0.4f);
  EXPECT_FLOAT_EQ(t.outManifold("result").radius.data[0][0], 0.5f);
  t.setText("primvarS", "only");  // one component: t stays the surface's, then comes from primvarT
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultS", 1), 0.7f);
  EXPECT_FLOAT_EQ(t.at("resultT", 1), 8.f);
  t.setText("primvarT", "only");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultT", 1), 0.7f);
  EXPECT_TRUE(t.out("resultT").uniform());
  t.setText("primvarS", "missing");
  t.setText("primvarT", "");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultS", 0), 9.f);
}

TEST(PxrManifold2D, SameBitsAtAllWidths) {
  TestContext t("PxrManifold2D", 45);
  t.setBuiltin(Builtin::St, {spread(45, -3, 3), spread(45, 0, 1, 11)});
  t.setBuiltin(Builtin::StRadius, {spread(45, 0, 0.1f)});
  t.set("angle", Numbers{spread(45, -720, 720, 13)});
  t.set("scaleS", 3.3f);
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
