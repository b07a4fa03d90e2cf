// Proves what prepares displacement: layers against their sums, the meaning of maps against formulas, and equal bits at
// every width.
#include <algorithm>
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(DisplacementPatterns, LayersJoinAsTheySay) {
  TestContext t("PxrDispScalarLayer", 3);
  t.set("overallAmount", 2);
  t.set("baseLayerAmount", 0.5f);
  t.set("baseLayerDispScalar", Numbers{{1, 2, -3}});
  t.set("layer1Amount", 3);
  t.set("layer1DispScalar", Numbers{{0.1f, -0.2f, 0.3f}});
  t.set("layer1Mask", Numbers{{1, 0.5f, 0}});
  t.set("layer2DispScalar", 4);
  const double base[] = {0.5, 1, -1.5}, layer[] = {0.3, -0.6, 0.9}, mask[] = {1, 0.5, 0};
  for (const int comp : {1, 2, 3}) {
    t.set("layer1Comp", float(comp));
    for (const bool second : {false, true}) {
      t.set("layer2Enabled", second);
      t.set("layer2Comp", 1);
      ASSERT_TRUE(t.run(8));
      for (uint32_t i = 0; i < 3; ++i) {
        const double one = comp == 1   ? base[i] + mask[i] * layer[i]
                           : comp == 2 ? base[i] + mask[i] * (layer[i] - base[i])
                                       : std::max(base[i], mask[i] * layer[i]);
        EXPECT_NEAR(t.at("resultF", i), 2 * (one + (second ? 4 : 0)), 1e-5) << comp;
      }
      expectSameBitsAtAllWidths(t);
    }
  }
  t.set("baseLayerEnabled", 0);
  t.set("layer1Enabled", 0);
  t.set("layer2Enabled", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultF", 2), 0);
}

TEST(DisplacementPatterns, VectorsJoinByTheirLength) {
  TestContext t("PxrDispVectorLayer", 2);
  t.set("baseLayerDispVector", Numbers{{1, 0}, {0, 2}, {0, 0}});
  t.set("layer1DispVector", Numbers{{0, 0}, {0, 0}, {1.5f, 1.5f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultXYZ", 0, 0), 1);
  EXPECT_FLOAT_EQ(t.at("resultZ", 0), 1.5f);
  t.set("layer1Comp", 3);
  ASSERT_TRUE(t.run(8));
  const float longer[2][3] = {{0, 0, 1.5f}, {0, 2, 0}};
  for (uint32_t i = 0; i < 2; ++i)
    for (uint32_t k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(t.at("resultXYZ", i, k), longer[i][k]);
  expectSameBitsAtAllWidths(t);
}

TEST(DisplacementPatterns, MapsMeanWhatTheirModeSays) {
  TestContext t("PxrDispTransform", 5);
  const std::vector<float> x{0, 0.25f, 0.5f, 0.75f, 1};
  t.set("dispScalar", Numbers{x});
  t.set("dispHeight", 2);
  t.set("dispDepth", 0.5f);
  const auto spline = [](double v) {  // through -.5, -.5, 0, 2, 2, worked out piece by piece
    const double p[] = {-0.5, -0.5, 0, 2, 2};
    const int piece = v < 0.5 ? 0 : 1;
    const double s = 2 * v - piece;
    double sum = 0;
    const double w[] = {-s / 2 + s * s - s * s * s / 2, 1 - 2.5 * s * s + 1.5 * s * s * s,
                        s / 2 + 2 * s * s - 1.5 * s * s * s, -s * s / 2 + s * s * s / 2};
    for (int k = 0; k < 4; ++k) sum += w[k] * p[piece + k];
    return sum;
  };
  for (const int mode : {1, 2, 3}) {
    t.set("dispRemapMode", float(mode));
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 5; ++i) {
      const double v = x[i], e = mode == 1 ? 2 * v : mode == 2 ? (v < 0.5 ? 0.5 : 2) * (v - 0.5) : spline(v);
      EXPECT_NEAR(t.at("resultF", i), e, 1e-5) << mode << ": " << v;
      EXPECT_EQ(t.at("resultX", i), 0);
    }
    expectSameBitsAtAllWidths(t);
  }
}

TEST(DisplacementPatterns, DirectionsAndVectors) {
  TestContext t("PxrDispTransform", 2);
  t.set("dispScalar", Numbers{{1, -2}});
  t.set("useDispDirection", 1);
  t.set("dispDirection", Numbers{{3, 3}, {4, 4}, {0, 0}});
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultXYZ", 0, 0), 0.6, 1e-6);
  EXPECT_NEAR(t.at("resultXYZ", 1, 1), -1.6, 1e-6);
  EXPECT_EQ(t.at("resultF", 0), 0) << "not twice";
  expectSameBitsAtAllWidths(t);
  t.set("dispType", 2);
  t.set("vectorSpace", 2);
  t.set("dispVector", Numbers{{1, 0}, {2, 5}, {3, -1}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultY", 1), 5);
  EXPECT_FLOAT_EQ(t.at("resultZ", 0), 3);
  // tangent space: z, or y of Mudbox's maps, is the normal's
  t.set("vectorSpace", 3);
  for (const int type : {2, 3}) {
    t.set("dispType", float(type));
    t.set("dispVector", type == 2 ? Numbers{{0, 0}, {0, 0}, {1, 2}} : Numbers{{0, 0}, {1, 2}, {0, 0}});
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 2; ++i) {
      double l = 0;
      for (uint32_t k = 0; k < 3; ++k) l += std::pow(t.at("resultXYZ", i, k), 2);
      EXPECT_NEAR(std::sqrt(l), 1 + i, 1e-5);
    }
    expectSameBitsAtAllWidths(t);
  }
}

// y leads where t grows, whichever side of st's plane the normal is on.
TEST(DisplacementPatterns, TangentSpaceIsThatOfTheTextureCoordinates) {
  TestContext t("PxrDispTransform", 4);
  t.set("vectorSpace", 3);
  t.setBuiltin(Builtin::Tangent, Numbers{{1, 1, -1, -1}, {0, 0, 0, 0}, {0, 0, 0, 0}});
  t.setGradient("", 0, Numbers{{1, 1, -1, -1}, {0, 0, 0, 0}, {0, 0, 0, 0}});
  t.setGradient("", 1, Numbers{{0, 0, 0, 0}, {1, 1, 1, 1}, {0, 0, 0, 0}});
  t.setVectors(t.c.N, Numbers{{0, 0, 0, 0}, {0, 0, 0, 0}, {1, -1, 1, -1}});
  for (const int type : {2, 3}) {
    t.set("dispType", float(type));
    t.set("dispVector", type == 2 ? Numbers{{1}, {2}, {3}} : Numbers{{1}, {3}, {2}});
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 4; ++i) {
      EXPECT_FLOAT_EQ(t.at("resultXYZ", i, 0), i < 2 ? 1 : -1) << i;
      EXPECT_FLOAT_EQ(t.at("resultXYZ", i, 1), 2) << i;
      EXPECT_FLOAT_EQ(t.at("resultXYZ", i, 2), i % 2 ? -3 : 3) << i;
    }
    expectSameBitsAtAllWidths(t);
  }
}

}  // namespace kinora::patternTest
