// Proves PxrMix's formula, that uniform inputs stay uniform, and equal bits at all widths.
#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrMix, BlendsByHand) {
  TestContext t("PxrMix", 5);
  t.set("color1", Numbers{{0.f}, {0.5f}, {1.f}});
  t.set("color2", Numbers{{1.f}, {1.f}, {3.f}});
  t.set("mix", Numbers{{0.f, 0.25f, 0.5f, 1.f, 2.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 0.25f);
  EXPECT_FLOAT_EQ(t.at("resultG", 2), 0.75f);
  EXPECT_FLOAT_EQ(t.at("resultB", 4), 5.f);
  EXPECT_FLOAT_EQ(t.at("resultRGB", 3, 2), 3.f);
  EXPECT_FALSE(t.out("resultRGB").uniform());
}

TEST(PxrMix, UniformStaysUniform) {
  TestContext t("PxrMix", 37);
  t.set("mix", 0.5f);
  ASSERT_TRUE(t.run(8));
  EXPECT_TRUE(t.out("resultRGB").uniform());
  EXPECT_TRUE(t.out("resultG").uniform());
  EXPECT_FLOAT_EQ(t.at("resultG"), 0.5f);
}

TEST(PxrMix, SameBitsAtAllWidths) {
  TestContext t("PxrMix", 45);
  t.set("color1", Numbers{spread(45, 0, 1), spread(45, -1, 2, 11), spread(45, 0, 3, 13)});
  t.set("mix", Numbers{spread(45, -0.5f, 1.5f)});
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
