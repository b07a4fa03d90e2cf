// Proves what PxrTexture asks of the texture room (place, footprint, options) and what it makes of the answer. The
// lookups themselves are proved in src/texture.
#include <cmath>

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

// Half diameters are scaled, widened and turned over as the radius and the place are.
TEST(PxrTexture, PassesEllipses) {
  TestContext t = makeContext();
  t.c.host = &t;
  ASSERT_TRUE(t.run(8));
  EXPECT_TRUE(t.axesAsked[0].empty()) << "circles";
  std::vector<float> zero(21, 0.f), s1 = spread(21, -0.1f, 0.1f), t1 = spread(21, -0.2f, 0.3f, 5),
                                    s2 = spread(21, 0.1f, 0.5f, 4), t2 = spread(21, -0.5f, 0.2f, 11);
  s1[3] = t1[3] = s2[3] = t2[3] = 0;  // a circle among them
  s1[5] = t1[5] = 0;                  // as thin as a line
  s2[6] = t2[6] = 0;
  t.setEllipses("", {s1, t1}, {s2, t2});
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 21; ++i) {
    EXPECT_FLOAT_EQ(t.axesAsked[0][i], s1[i]) << i;
    EXPECT_FLOAT_EQ(t.axesAsked[1][i], -t1[i]) << i;
    EXPECT_FLOAT_EQ(t.axesAsked[2][i], s2[i]) << i;
    EXPECT_FLOAT_EQ(t.axesAsked[3][i], -t2[i]) << i;
  }
  t.set("blur", 0.25f);
  t.set("mipBias", 1);
  t.set("maxResolution", 2);
  ASSERT_TRUE(t.run(8));
  const auto length = [&](uint32_t axis, uint32_t i) {
    return std::hypot(t.axesAsked[2 * axis][i], t.axesAsked[2 * axis + 1][i]);
  };
  for (uint32_t i = 0; i < 21; ++i) {
    const float first = std::hypot(s1[i], t1[i]), second = std::hypot(s2[i], t2[i]);
    if (i == 3) {
      EXPECT_EQ(length(0, i) + length(1, i), 0.f) << "circles stay circles";
      continue;
    }
    EXPECT_NEAR(length(0, i), std::max(2 * first + 0.25f, 0.5f), 1e-6f) << i;
    EXPECT_NEAR(length(1, i), std::max(2 * second + 0.25f, 0.5f), 1e-6f) << i;
    if (i != 5 && i != 6) {
      EXPECT_NEAR(t.axesAsked[0][i] * -t1[i], t.axesAsked[1][i] * s1[i], 1e-6f) << i;
    } else {  // widened across the other axis
      EXPECT_NEAR(t.axesAsked[0][i] * t.axesAsked[2][i] + t.axesAsked[1][i] * t.axesAsked[3][i], 0, 1e-6f) << i;
    }
  }
  // a manifold has its own ones, or circles
  t.setManifold("manifold", {spread(21, 2, 3), spread(21, 4, 5)}, {{0.125f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_TRUE(t.axesAsked[0].empty());
  t.set("blur", 0.f), t.set("mipBias", 0), t.set("maxResolution", 0);
  t.setEllipses("manifold", {s2, t2}, {s1, t1});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.axesAsked[1][2], t2[2]) << "and is not turned over";
  const std::vector<float> expected = t.axesAsked[2];
  for (const uint32_t width : {1u, 4u, 16u})
    if (t.run(width)) {
      EXPECT_EQ(t.axesAsked[2], expected) << width;
    }
}

}  // namespace kinora::patternTest
