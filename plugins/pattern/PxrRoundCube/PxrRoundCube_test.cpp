// Proves which face a point takes and what coordinates it gets; that blends keep their shares over samples; textures'
// numbers; reference variables; equal bits at all widths. Misses: how blended textures look.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

struct Cube : TestContext {
  std::vector<uint32_t> seed, sample;
  explicit Cube(uint32_t n) : TestContext("PxrRoundCube", n), seed(padded(n), 7u), sample(padded(n)) {
    for (uint32_t i = 0; i < sample.size(); ++i) sample[i] = i < n ? i : n - 1;
    c.sampleSeed = seed.data();
    c.sampleIndex = sample.data();
  }
};

TEST(PxrRoundCube, FacesByTheNormal) {
  Cube t(6);
  t.setVectors(t.c.P, {std::vector<float>(6, 0.2f), std::vector<float>(6, 0.3f), std::vector<float>(6, 0.4f)});
  t.setVectors(t.c.N, {{1, -1, 0, 0, 0.1f, 0}, {0, 0, 1, -1, 0, 0.1f}, {0, 0, 0, 0, 0.99f, -0.99f}});
  t.set("frequency", 2);
  t.set("numberOfTextures", 6);
  t.set("transitionWidth", 0);
  ASSERT_TRUE(t.run(8));
  const float s[6] = {-0.8f, 0.8f, 0.4f, 0.4f, 0.4f, -0.4f}, up[6] = {0.6f, 0.6f, -0.8f, 0.8f, 0.6f, 0.6f};
  for (uint32_t i = 0; i < 6; ++i) {
    EXPECT_FLOAT_EQ(t.at("resultMulti", i, 0), s[i]) << i;
    EXPECT_FLOAT_EQ(t.at("resultMulti", i, 1), 1 - up[i]) << i;
    EXPECT_FLOAT_EQ(t.at("resultMulti", i, 2), float(i)) << i;
    EXPECT_NEAR(t.at("resultMask", i), 1, 1e-4f) << i;
  }
  t.set("numberOfTextures", 3);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultMulti", 3, 2), 1);
  t.set("numberOfTextures", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultMulti", 3, 2), 0);
  EXPECT_EQ(t.outManifold("resultMulti").dimensions, 2u);
}

TEST(PxrRoundCube, BlendsKeepTheirShares) {
  constexpr uint32_t kSamples = 8192;
  Cube t(kSamples);
  t.setVectors(t.c.N, {std::vector<float>(kSamples, 0.8f), std::vector<float>(kSamples, 0.f),
                       std::vector<float>(kSamples, 0.6f)});
  t.set("numberOfTextures", 3);
  t.set("transitionWidth", 0.5f);  // weights 0.8 - 0.4 and 0.6 - 0.4
  ASSERT_TRUE(t.run(8));
  int x = 0, z = 0;
  for (uint32_t i = 0; i < kSamples; ++i) {
    x += t.at("resultMulti", i, 2) == 0;
    z += t.at("resultMulti", i, 2) == 2;
  }
  EXPECT_EQ(x + z, int(kSamples));
  EXPECT_NEAR(double(x) / kSamples, 2.0 / 3, 4 * std::sqrt(2.0 / 9 / kSamples));
}

TEST(PxrRoundCube, ReferenceVariables) {
  Cube t(3);
  t.setPrimvar("__Pref", {{5, 5, 5}, {6, 6, 6}, {7, 7, 7}}, 0.25f);
  t.setPrimvar("__Nref", {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}});
  t.set("use", 1);
  t.set("frequency", 2);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultMulti", 0, 0), 10);
  EXPECT_FLOAT_EQ(t.at("resultMulti", 0, 1), 1 + 14);
  EXPECT_FLOAT_EQ(t.outManifold("resultMulti").radius.data[0][0], 0.5f);
}

TEST(PxrRoundCube, SameBitsAtAllWidths) {
  Cube t(45);
  t.setVectors(t.c.P, {spread(45, -3, 3), spread(45, -2, 2, 11), spread(45, -1, 1, 13)});
  t.setVectors(t.c.N, {spread(45, -1, 1, 17), spread(45, -1, 1, 19), spread(45, -1, 1, 23)});
  t.set("numberOfTextures", 6);
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
