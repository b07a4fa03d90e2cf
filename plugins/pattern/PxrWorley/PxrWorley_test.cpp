// Proves distances on the unjittered lattice in each metric, that the first distance is below the second wherever it
// is asked, clamps and inversion, flat cells, and equal bits at all widths. Misses: the statistics of jittered
// points.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PxrWorley, LatticeDistancesInEachMetric) {
  TestContext t("PxrWorley", 1);
  t.setManifold("manifold", {{0.6f}, {0.7f}, {0.9f}}, {{0.f}});
  t.set("frequency", 1);
  t.set("jitter", 0);
  t.set("c1", 1);
  t.set("c2", 0);
  // from the middle of the cell: 0.1 0.2 0.4
  const float expected[4] = {std::sqrt(0.21f), 0.7f, 0.4f, std::pow(0.0001f + 0.0016f + 0.0256f, 0.25f)};
  for (int metric = 0; metric < 4; ++metric) {
    t.set("distancemetric", float(metric));
    ASSERT_TRUE(t.run(8));
    EXPECT_NEAR(t.at("resultF"), expected[metric], 1e-5f) << metric;
  }
  t.set("distancemetric", 0);
  t.set("c1", 0);
  t.set("c2", 1);  // the next cell in z: 0.1 0.2 0.6
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF"), std::sqrt(0.41f), 1e-5f);
  t.set("invert", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultG"), 1 - std::sqrt(0.41f), 1e-5f);
  t.set("c2", 5);
  t.set("invert", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultF"), 1) << "clamped";
  t.set("clamp", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_GT(t.at("resultF"), 3);
}

TEST(PxrWorley, FirstIsBelowSecondAndCellsAreFlat) {
  TestContext t("PxrWorley", 200);
  t.setManifold("manifold", {spread(200, -3, 3), spread(200, -3, 3, 11), spread(200, -3, 3, 13)}, {{0.f}});
  t.set("clamp", 0);
  t.set("c1", -1);
  t.set("c2", 1);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 200; ++i) EXPECT_GE(t.at("resultF", i), 0) << i;
  TestContext cell("PxrWorley", 2);
  cell.setManifold("manifold", {{0.5f, 0.52f}, {0.5f, 0.5f}, {0.5f, 0.5f}}, {{0.f}});
  cell.set("frequency", 1);
  cell.set("jitter", 0);
  cell.set("shape", 1);
  ASSERT_TRUE(cell.run(8));
  EXPECT_EQ(cell.at("resultF", 0), cell.at("resultF", 1));
}

TEST(PxrWorley, SameBitsAtAllWidths) {
  TestContext t("PxrWorley", 45);
  t.setManifold("manifold", {spread(45, -9, 9), spread(45, -9, 9, 11), spread(45, -9, 9, 13)},
                {spread(45, 0, 2, 17)});
  t.set("randomScale", 0.5f);
  for (int metric = 0; metric < 4; ++metric) {
    t.set("distancemetric", float(metric));
    expectSameBitsAtAllWidths(t);
  }
}

}  // namespace kinora::patternTest
