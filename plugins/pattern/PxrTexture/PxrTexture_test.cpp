// Proves what PxrTexture asks of the texture room (place, footprint, options) and what it makes of the answer. The
// lookups themselves are proved in src/texture.
#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {
namespace {
TestContext makeContext() {
  TestContext t("PxrTexture", 21);
  t.setBuiltin(Builtin::St, {spread(21, 0, 1), spread(21, 0, 1, 5)});
  t.setBuiltin(Builtin::StRadius, {spread(21, 0.001f, 0.1f, 3)});
  t.onTexture = [](int, float s, float tt, float radius, const TextureOptions&, float rgba[4]) {
    rgba[0] = s;
    rgba[1] = tt;
    rgba[2] = radius;
    rgba[3] = 0.5f;
  };
  return t;
}
}  // namespace

TEST(PxrTexture, PlacesLookups) {
  TestContext t = makeContext();
  t.c.host = &t;
  t.set("blur", 0.25f);
  t.set("mipBias", 1);
  ASSERT_TRUE(t.run(8));
  const std::vector<float> s = spread(21, 0, 1), tt = spread(21, 0, 1, 5), r = spread(21, 0.001f, 0.1f, 3);
  for (uint32_t i = 0; i < 21; ++i) {
    EXPECT_FLOAT_EQ(t.at("resultR", i), s[i]);
    EXPECT_FLOAT_EQ(t.at("resultG", i), 1 - tt[i]);
    EXPECT_FLOAT_EQ(t.at("resultB", i), 2 * r[i] + 0.25f);
    EXPECT_FLOAT_EQ(t.at("resultA", i), 0.5f);
  }
  t.set("maxResolution", 2);
  t.set("blur", 0.f);
  t.set("mipBias", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultB", 4), 0.5f);
}

TEST(PxrTexture, ManifoldReplacesStAndIsNotInverted) {
  TestContext t = makeContext();
  t.c.host = &t;
  t.setManifold("manifold", {spread(21, 2, 3), spread(21, 4, 5)}, {{0.125f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 3), spread(21, 2, 3)[3]);
  EXPECT_FLOAT_EQ(t.at("resultG", 3), spread(21, 4, 5)[3]);
  EXPECT_FLOAT_EQ(t.at("resultB", 3), 0.125f);
}

TEST(PxrTexture, PassesOptionsAndCorrectsColour) {
  TestContext t = makeContext();
  t.c.host = &t;
  t.set("filter", 3);
  t.set("firstChannel", 2);
  t.set("linearize", 1);
  t.set("missingAlpha", 0.25f);
  TextureOptions seen;
  t.onTexture = [&](int, float, float, float, const TextureOptions& o, float rgba[4]) {
    seen = o;
    rgba[0] = 1, rgba[1] = 0.5f, rgba[2] = 0, rgba[3] = 1;
  };
  t.set("saturation", 0.f);
  t.set("colorScale", 2.f);
  t.set("colorOffset", 0.5f);
  t.set("alphaScale", 0.5f);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(seen.filter, 3);
  EXPECT_EQ(seen.firstChannel, 2);
  EXPECT_EQ(seen.linearize, 1);
  EXPECT_EQ(seen.missingColor[2], 1.f);
  EXPECT_EQ(seen.missingAlpha, 0.25f);
  const float grey = 0.2126f + 0.5f * 0.7152f;
  EXPECT_NEAR(t.at("resultR", 2), 2 * grey + 0.5f, 1e-6f);
  EXPECT_NEAR(t.at("resultB", 2), 2 * grey + 0.5f, 1e-6f);
  EXPECT_FLOAT_EQ(t.at("resultA", 2), 0.5f);
  t.c.traits = kTraitEyePath;  // not seen directly: box filter
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(seen.filter, 1);
  expectSameBitsAtAllWidths(t);
}

}  // namespace kinora::patternTest
