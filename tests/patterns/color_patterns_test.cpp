// Proves the colour patterns against values worked out by hand, and all of them for equal bits at every width and for
// uniform results of uniform inputs. It does not prove agreement with any other renderer.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {
namespace {
Numbers rgb(float r, float g, float b) { return {{r}, {g}, {b}}; }
void expectRgb(const TestContext& t, float r, float g, float b, float tolerance = 1e-5f) {
  EXPECT_NEAR(t.at("resultRGB", 0, 0), r, tolerance);
  EXPECT_NEAR(t.at("resultRGB", 0, 1), g, tolerance);
  EXPECT_NEAR(t.at("resultRGB", 0, 2), b, tolerance);
}
}  // namespace

TEST(ColorPatterns, ExposureGammaClampInvert) {
  TestContext e("PxrExposure", 1);
  e.set("inputRGB", rgb(1, 2, 4));
  e.set("stops", -2);
  ASSERT_TRUE(e.run(8));
  expectRgb(e, 0.25f, 0.5f, 1);
  TestContext g("PxrGamma", 1);
  g.set("inputRGB", rgb(0.25f, -0.25f, 1));
  g.set("gamma", 2);
  ASSERT_TRUE(g.run(8));
  expectRgb(g, 0.5f, -0.5f, 1);
  TestContext c("PxrClamp", 1);
  c.set("inputRGB", rgb(-1, 0.5f, 2.25f));
  ASSERT_TRUE(c.run(8));
  expectRgb(c, 0, 0.5f, 1);
  c.set("modulus", 1);
  ASSERT_TRUE(c.run(8));
  expectRgb(c, 0, 0.5f, 0.25f);
  TestContext i("PxrInvert", 1);
  i.set("inputRGB", rgb(0.1f, 0.5f, 1));
  i.set("invertChannel1", 0);
  ASSERT_TRUE(i.run(8));
  expectRgb(i, 0.9f, 0.5f, 0);
  i.set("colorModel", 2);
  i.set("inputRGB", rgb(1, 0, 0));
  i.set("invertChannel2", 0);  // hue alone: red becomes cyan
  ASSERT_TRUE(i.run(8));
  expectRgb(i, 0, 1, 1);
}

// Colours brighter than white keep their hue, powers of numbers below 0 their parity, and what lies within limits itself.
TEST(ColorPatterns, BeyondWhiteAndBelowBlack) {
  TestContext h("PxrHSL", 1);
  h.set("inputRGB", rgb(1, 0.5f, 0.5f));
  h.set("luminance", 2);
  ASSERT_TRUE(h.run(8));
  expectRgb(h, 1.5f, 1.5f, 1.5f);
  TestContext i("PxrInvert", 1);
  i.set("inputRGB", rgb(2, 0.5f, 0.5f));
  i.set("colorModel", 1);
  i.set("invertChannel0", 0);
  i.set("invertChannel1", 0);
  ASSERT_TRUE(i.run(8));  // scaled to 1 .25 .25, of lightness .625, which becomes .375
  expectRgb(i, 1.5f, 0, 0, 1e-4f);
  TestContext p("PxrArithmetic", 1);
  p.set("input1", rgb(-7, -2, -2));
  p.set("input2", rgb(2, 2, 3));
  p.set("operation", 6);
  ASSERT_TRUE(p.run(8));
  expectRgb(p, 49, 4, -8, 1e-3f);
  TestContext c("PxrClamp", 1);
  c.set("inputRGB", rgb(0, 1, 1.25f));
  c.set("modulus", 1);
  ASSERT_TRUE(c.run(8));
  expectRgb(c, 0, 1, 0.25f);
}

TEST(ColorPatterns, RemapBiasAndGain) {
  TestContext t("PxrRemap", 1);
  t.set("inputRGB", rgb(2, 3, 9));
  t.set("inputMin", 2);
  t.set("inputMax", 4);
  t.set("outputMin", 10);
  t.set("outputMax", 20);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 10, 15, 20);
  t.set("bias", 0.25f);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 10, 12.5f, 20, 1e-4f);
  t.set("bias", 0.5f);
  t.set("gain", 0.8f);
  t.set("inputRGB", rgb(2.5f, 3, 3.5f));
  ASSERT_TRUE(t.run(8));
  // bias(0.5, 1 - gain) / 2
  expectRgb(t, 11, 15, 19, 1e-3f);
}

TEST(ColorPatterns, HueSaturationLightness) {
  TestContext t("PxrHSL", 1);
  t.set("inputRGB", rgb(0.8f, 0.2f, 0.4f));
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.8f, 0.2f, 0.4f);
  t.set("hue", 120);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.4f, 0.8f, 0.2f);
  t.set("hue", 0.f);
  t.set("saturation", 0.f);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.5f, 0.5f, 0.5f);
  t.set("saturation", 1);
  t.set("inputRGB", rgb(8, 2, 4));  // brighter than white comes back as it was
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 8, 2, 4, 1e-4f);
}

TEST(ColorPatterns, BlendModes) {
  const struct {
    int code;
    float r, g, b;
  } kWant[] = {// bottom 0.2 0.5 0.8, top 0.5 0.4 0.6
               {3, 0.2f, 0.4f, 0.6f},    {5, 0.3f, 0.1f, 0.2f},  {7, 0.4f, 1, 1},         {8, 0.5f, 0.5f, 0.44f},
               {9, 0.2f, 0.4f, 0.84f},   {10, 0, 0, 1},          {12, 0.5f, 0.5f, 0.8f},  {14, 0, 0, 0.4f},
               {15, 0.7f, 0.9f, 1},      {16, 0.2f, 0.3f, 1},    {18, 0.1f, 0.2f, 0.48f}, {19, 0.5f, 0.4f, 0.6f},
               {20, 0.2f, 0.4f, 0.84f},  {21, 0.2f, 0.5f, 0.8f}, {23, 0.6f, 0.7f, 0.92f}, {25, 0, 0.1f, 0.2f},
               {2, 0.4f, 0.8333333f, 1}, {1, 0, 0, 0.6666667f}};
  for (const auto& w : kWant) {
    SCOPED_TRACE(w.code);
    TestContext t("PxrBlend", 1);
    t.set("operation", float(w.code));
    t.set("bottomRGB", rgb(0.2f, 0.5f, 0.8f));
    t.set("topRGB", rgb(0.5f, 0.4f, 0.6f));
    ASSERT_TRUE(t.run(8));
    expectRgb(t, w.r, w.g, w.b);
    EXPECT_FLOAT_EQ(t.at("resultA"), 1);
    t.set("topA", 0.5f);
    ASSERT_TRUE(t.run(8));
    if (w.code == 19) expectRgb(t, 0.35f, 0.45f, 0.7f);
    t.set("topA", 0.f);
    ASSERT_TRUE(t.run(8));
    expectRgb(t, 0.2f, 0.5f, 0.8f);
  }
  // modes of the whole colour keep what their names say
  TestContext t("PxrBlend", 1);
  t.set("bottomRGB", rgb(0.2f, 0.5f, 0.8f));
  t.set("topRGB", rgb(0.5f, 0.4f, 0.6f));
  const auto light = [](const TestContext& c) {
    return 0.2126f * c.at("resultR") + 0.7152f * c.at("resultG") + 0.0722f * c.at("resultB");
  };
  const float bottom = 0.2126f * 0.2f + 0.7152f * 0.5f + 0.0722f * 0.8f,
              top = 0.2126f * 0.5f + 0.7152f * 0.4f + 0.0722f * 0.6f;
  for (int code : {0, 11, 22, 17}) {
    t.set("operation", float(code));
    ASSERT_TRUE(t.run(8));
    EXPECT_NEAR(light(t), code == 17 ? top : bottom, 1e-5f) << code;
  }
  t.set("bottomA", 0.f);  // nothing below: the top alone
  t.set("operation", 18);
  t.set("topA", 0.25f);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.5f, 0.4f, 0.6f);
  EXPECT_FLOAT_EQ(t.at("resultA"), 0.25f);
}

TEST(ColorPatterns, LayersGoOneOverTheOther) {
  TestContext t("PxrLayeredBlend", 1);
  t.set("backgroundRGB", rgb(1, 1, 1));
  t.set("enable_0", 1);
  t.set("RGB_0", rgb(0.5f, 0.5f, 0.5f));
  t.set("operation_0", 18);
  t.set("RGB_1", rgb(0, 1, 0));  // not enabled
  t.set("enable_7", 1);
  t.set("RGB_7", rgb(1, 0, 0));
  t.set("A_7", 0.5f);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.75f, 0.25f, 0.25f);
}

TEST(ColorPatterns, CorrectsInOrder) {
  TestContext t("PxrColorCorrect", 1);
  t.set("inputRGB", rgb(0.2f, 0.5f, -0.8f));
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.2f, 0.5f, -0.8f);  // defaults change nothing, not even what is below zero
  t.set("inputRGB", rgb(0.25f, 0.25f, 0.25f));
  t.set("gamma", 2);
  t.set("contrast", 1);
  t.set("contrastPivot", 0.25f);
  t.set("rgbGain", rgb(1, 2, 1));
  t.set("exposure", 1);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 1.5f, 3, 1.5f);  // 0.25 -> 0.5 -> 0.75 -> gain -> doubled
  t.set("clampOutput", 1);
  t.set("inputMask", 0.5f);
  ASSERT_TRUE(t.run(8));
  expectRgb(t, 0.625f, 0.625f, 0.625f);
}

TEST(ColorPatterns, NumbersOfColours) {
  TestContext f("PxrToFloat", 1);
  f.set("input", rgb(0.3f, 0.6f, 0.9f));
  const float want[] = {0.3f, 0.6f, 0.9f, 0.6f, 0.2126f * 0.3f + 0.7152f * 0.6f + 0.0722f * 0.9f};
  for (int mode = 0; mode < 5; ++mode) {
    f.set("mode", float(mode));
    ASSERT_TRUE(f.run(8));
    EXPECT_NEAR(f.at("resultF"), want[mode], 1e-6f);
  }
  TestContext c("PxrToFloat3", 1);
  c.set("input", 0.5f);
  ASSERT_TRUE(c.run(8));
  expectRgb(c, 0.5f, 0.5f, 0.5f);
  c.set("inputG", 0.25f);
  ASSERT_TRUE(c.run(8));
  expectRgb(c, 0, 0.25f, 0);
  TestContext t("PxrThreshold", 3);
  t.set("inputRGB", Numbers{{0.4f, 0.5f, 0.6f}, {0.4f, 0.5f, 0.6f}, {0.4f, 0.5f, 0.6f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultF", 0), 0);
  EXPECT_NEAR(t.at("resultF", 1), 0.5f, 1e-4f);
  EXPECT_FLOAT_EQ(t.at("resultF", 2), 1);
  EXPECT_FLOAT_EQ(t.at("resultRGB", 2, 1), 1);
}

TEST(ColorPatterns, SameBitsAndUniformity) {
  for (const char* name : {"PxrExposure", "PxrGamma", "PxrClamp", "PxrInvert", "PxrRemap", "PxrHSL",
                           "PxrColorCorrect", "PxrThreshold"}) {
    SCOPED_TRACE(name);
    TestContext t(name, 45);
    t.set("inputRGB", 0.5f);
    ASSERT_TRUE(t.run(8));
    EXPECT_TRUE(t.out(t.outputNames()[0]).uniform());
    t.set("inputRGB", Numbers{spread(45, -0.5f, 2), spread(45, 0, 1, 11), spread(45, 0, 3, 13)});
    if (!std::strcmp(name, "PxrInvert")) t.set("colorModel", 1);
    if (!std::strcmp(name, "PxrGamma")) t.set("gamma", 2.2f);
    if (!std::strcmp(name, "PxrExposure")) t.set("stops", Numbers{spread(45, -3, 3, 17)});
    if (!std::strcmp(name, "PxrRemap")) t.set("gain", 0.3f), t.set("bias", 0.7f), t.set("clampInput", 0.f);
    if (!std::strcmp(name, "PxrHSL")) t.set("hue", Numbers{spread(45, -400, 400, 19)});
    if (!std::strcmp(name, "PxrColorCorrect")) t.set("hsv", rgb(0.3f, 0.7f, 1.2f)), t.set("gamma", 1.7f);
    expectSameBitsAtAllWidths(t);
    for (float v : t.all(t.outputNames()[0], 0)) EXPECT_TRUE(std::isfinite(v));
  }
  for (int code = 0; code < 27; ++code) {
    SCOPED_TRACE(code);
    TestContext t("PxrBlend", 45);
    t.set("operation", float(code));
    t.set("topRGB", Numbers{spread(45, 0, 1), spread(45, 0, 1, 11), spread(45, 0, 1, 13)});
    t.set("bottomRGB", Numbers{spread(45, 0, 1, 17), spread(45, 0, 1, 19), spread(45, 0, 1, 23)});
    t.set("topA", Numbers{spread(45, 0, 1, 29)});
    expectSameBitsAtAllWidths(t);
    for (float v : t.all("resultRGB", 0)) EXPECT_TRUE(v >= 0 && v <= 1) << v;
  }
}

}  // namespace kinora::patternTest
