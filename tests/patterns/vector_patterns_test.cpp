// Proves patterns of arithmetic, vectors and normals against values worked out by hand or by another formula, and
// equal bits at every width.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(VectorPatterns, CrossAndDot) {
  TestContext t("PxrCross", 3);
  t.set("vector1", Numbers{{1, 1, 2}, {0, 2, 4}, {0, 3, 6}});
  t.set("vector2", Numbers{{0, 4, 1}, {1, 5, 2}, {0, 6, 3}});
  t.set("normalizeResult", 0);
  ASSERT_TRUE(t.run(8));
  const float cross[2][3] = {{0, 0, 1}, {-3, 6, -3}};
  for (uint32_t i = 0; i < 2; ++i)
    for (uint32_t k = 0; k < 3; ++k) EXPECT_FLOAT_EQ(t.at("resultXYZ", i, k), cross[i][k]);
  t.set("normalizeResult", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultY", 1), 6 / std::sqrt(54.), 1e-6);
  EXPECT_EQ(t.at("resultX", 2), 0) << "parallel";
  EXPECT_EQ(t.at("resultZ", 2), 0) << "parallel";
  expectSameBitsAtAllWidths(t);
  TestContext d("PxrDot", 2);
  d.set("vector1", Numbers{{1, 2}, {2, -3}, {3, 4}});
  d.set("vector2", Numbers{{4}, {5}, {6}});
  ASSERT_TRUE(d.run(8));
  EXPECT_FLOAT_EQ(d.at("result", 0), 32);
  EXPECT_FLOAT_EQ(d.at("resultF", 1), 8 - 15 + 24);
  expectSameBitsAtAllWidths(d);
}

TEST(VectorPatterns, ArithmeticByTheStandardLibrary) {
  TestContext t("PxrArithmetic", 41);
  const std::vector<float> a = spread(41, -3, 3), b = spread(41, -2, 2, 11);
  t.set("input1", Numbers{a, a, a});
  t.set("input2", Numbers{b, b, b});
  const auto expected = [](int operation, double x, double y) {
    switch (operation) {
      case 0:
        return x + y;
      case 1:
        return x * y;
      case 2:
        return x - y;
      case 3:
        return y == 0 ? 0 : x / y;
      case 4:
        return std::fmin(x, y);
      case 5:
        return std::fmax(x, y);
      case 6:
        return y == 0 ? 1 : x == 0 ? 0 : std::copysign(std::pow(std::fabs(x), y), std::fmod(y, 2) == 0 ? 1 : x);
      default:
        return y == 0 ? 0 : x - std::floor(x / y) * y;
    }
  };
  for (int operation = 0; operation < 8; ++operation) {
    t.set("operation", float(operation));
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 41; ++i) {
      const double e = expected(operation, a[i], b[i]);
      EXPECT_NEAR(t.at("resultG", i), e, 2e-6 * (1 + std::fabs(e))) << operation << ": " << a[i] << ", " << b[i];
    }
    expectSameBitsAtAllWidths(t);
  }
}

TEST(VectorPatterns, SetRange) {
  TestContext t("PxrSetRange", 4);
  const std::vector<float> x{0, 1, 2, 4};
  t.set("input", Numbers{x, x, x});
  t.set("inputMin", 1);
  t.set("inputMax", 3);
  t.set("outputMin", 10);
  t.set("outputMax", 20);
  ASSERT_TRUE(t.run(8));
  const float free[] = {5, 10, 15, 25}, clamped[] = {10, 10, 15, 20};
  for (uint32_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(t.at("resultB", i), free[i]);
  t.set("clampOutput", 1);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(t.at("resultB", i), clamped[i]);
  t.set("inputMax", 1);  // a step
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 0), 10);
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 20);
}

TEST(VectorPatterns, SwitchRoundsAndGoesRound) {
  TestContext t("PxrSwitch", 7);
  t.setList("inputsRGB", {1, 10, 100, 2, 20, 200, 3, 30, 300});
  t.set("index", Numbers{{0, 0.49f, 0.51f, 2, 3, -1, 7.4f}});
  ASSERT_TRUE(t.run(8));
  const float expected[] = {1, 1, 2, 3, 1, 3, 2};
  for (uint32_t i = 0; i < 7; ++i) EXPECT_EQ(t.at("resultR", i), expected[i]) << i;
  EXPECT_EQ(t.at("resultB", 3), 300);
  t.connect("inputsRGB_1", Numbers{{-1}, {-1}, {-1}});  // a connection counts more than the list, whatever it gives
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultG", 2), -1);
  t.connect("inputsRGB_1", Numbers{{7}, {8}, {9}});
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultG", 2), 8);
  expectSameBitsAtAllWidths(t);
  t.set("index", 1e30f);
  ASSERT_TRUE(t.run(8));
  EXPECT_TRUE(t.out("resultRGB").uniform());
  TestContext none("PxrSwitch", 1);
  ASSERT_TRUE(none.run(8));
  EXPECT_EQ(none.at("resultR"), 0);
}

// Elements that are connected one by one: the list reaches as far as they do, and what nothing says is black.
TEST(VectorPatterns, SwitchHasGaps) {
  TestContext t("PxrSwitch", 4);
  t.connect("inputsRGB_0", Numbers{{1}, {2}, {3}});
  t.connect("inputsRGB_2", Numbers{{4}, {5}, {6}});
  t.set("index", Numbers{{0, 1, 2, 3}});
  ASSERT_TRUE(t.run(8));
  const float expected[] = {2, 0, 5, 2};
  for (uint32_t i = 0; i < 4; ++i) EXPECT_EQ(t.at("resultG", i), expected[i]) << i;
  for (int index = 0; index < 4; ++index) {
    t.set("index", float(index));
    ASSERT_TRUE(t.run(8));
    EXPECT_EQ(t.at("resultG"), expected[index]) << index;
  }
  t.setList("inputsRGB", {7, 7, 7, 8, 8, 8});
  t.set("index", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultG"), 8) << "in a gap the list counts";
}

TEST(VectorPatterns, ColorGrade) {
  TestContext t("PxrColorGrade", 3);
  const std::vector<float> x{0.1f, 0.5f, 0.9f};
  t.set("inputColor", Numbers{x, x, x});
  t.set("blackPoint", 0.2f);
  t.set("whitePoint", 0.7f);
  t.set("multiply", 1.5f);
  t.set("gain", 0.8f);
  t.set("lift", 0.05f);
  t.set("offset", -0.02f);
  t.set("gamma", 2);
  t.set("mask", 0.25f);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 3; ++i) {
    const double linear = (x[i] - 0.2) / 0.5 * 1.2 + 0.03, graded = linear > 0 ? std::sqrt(linear) : 0;
    EXPECT_NEAR(t.at("resultRGB", i, 1), x[i] + 0.25 * (graded - x[i]), 1e-6) << i;
  }
  t.set("clampWhite", 1);
  t.set("mask", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultR", 2), 1);
  expectSameBitsAtAllWidths(t);
}

TEST(VectorPatterns, NormalsAreAdjusted) {
  TestContext t("PxrAdjustNormal", 2);
  // seen from 60 degrees off the normal; the input leans 60 degrees away
  const float h = std::sqrt(0.75f);
  t.setVectors(t.c.wo, {{h, h}, {0, 0}, {0.5f, 0.5f}});
  t.set("inputNormal", Numbers{{-h, 0.6f}, {0, 0}, {0.5f, 0.8f}});
  t.set("adjustAmount", 0);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultN", 0, 0), -h, 1e-6);
  t.set("adjustAmount", 1);
  ASSERT_TRUE(t.run(8));
  const double seen = t.at("resultN", 0, 0) * h + t.at("resultN", 0, 2) * 0.5;
  EXPECT_GT(seen, 0);
  EXPECT_LT(seen, 0.02);
  EXPECT_NEAR(t.at("resultN", 1, 0), 0.6f, 1e-6) << "what is seen stays";
  t.set("surfaceNormalMix", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultN", 0, 2), 1, 1e-6);
  expectSameBitsAtAllWidths(t);
}

TEST(VectorPatterns, BumpsAddTheirSlopes) {
  TestContext t("PxrBumpMixer", 1);
  t.set("surfaceGradient1", Numbers{{0.3f}, {0}, {0}});
  t.set("amount1", 2);
  // a normal that leans as a slope of 0.5 along y does
  const float l = std::sqrt(1.25f);
  t.set("inputN3", Numbers{{0}, {-0.5f / l}, {1 / l}});
  t.set("amount3", 0.5f);
  ASSERT_TRUE(t.run(8));
  const double n[3] = {-0.6, -0.25, 1}, length = std::sqrt(n[0] * n[0] + n[1] * n[1] + 1);
  for (uint32_t k = 0; k < 3; ++k) EXPECT_NEAR(t.at("resultN", 0, k), n[k] / length, 1e-6) << k;
  EXPECT_NEAR(t.at("resultNG", 0, 0), 0.6, 1e-6);
  EXPECT_NEAR(t.at("resultNG", 0, 1), 0.25, 1e-6);
  t.set("disable", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultN", 0, 2), 1);
  TestContext w("PxrBumpMixer", 45);
  w.set("surfaceGradient2", Numbers{spread(45, -3, 3), spread(45, -2, 2, 11), spread(45, 0, 0.1f, 13)});
  w.set("inputN5", Numbers{spread(45, -1, 1), spread(45, -1, 1, 11), spread(45, 0.2f, 1, 13)});
  expectSameBitsAtAllWidths(w);
}

// A bump and its gradient through the mixer give the same normal.
TEST(VectorPatterns, GradientsOfBumpsBendAlike) {
  TestContext t("PxrNormalMap", 3);
  t.setBuiltin(Builtin::St, {{0.f}, {0.f}});
  t.setBuiltin(Builtin::StRadius, {{0.f}});
  t.set("inputRGB", Numbers{{0.5f, 0.7f, 0.2f}, {0.5f, 0.4f, 0.9f}, {1, 0.9f, 0.8f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_LT(t.at("resultN", 1, 2), 0.95f);
  TestContext mixer("PxrBumpMixer", 3);
  Numbers gradient(3);
  for (uint32_t k = 0; k < 3; ++k)
    for (uint32_t i = 0; i < 3; ++i) gradient[k].push_back(t.at("resultNG", i, k));
  mixer.set("surfaceGradient4", gradient);
  ASSERT_TRUE(mixer.run(8));
  for (uint32_t i = 0; i < 3; ++i)
    for (uint32_t k = 0; k < 3; ++k) EXPECT_NEAR(mixer.at("resultN", i, k), t.at("resultN", i, k), 1e-6) << i;
}

TEST(VectorPatterns, TangentsTurn) {
  TestContext t("PxrTangentField", 3);
  t.setBuiltin(Builtin::Tangent, {{1.f}, {0.f}, {0.f}});
  t.set("inputRotation", Numbers{{0, 0.25f, 0.5f}});
  t.set("rotationRange", 0.5f);
  t.set("rotationOffset", 0.125f);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * (0.125 + 0.125 * i);
    EXPECT_NEAR(t.at("resultX", i), std::cos(angle), 1e-6);
    EXPECT_NEAR(t.at("resultXYZ", i, 1), std::sin(angle), 1e-6);
    EXPECT_EQ(t.at("resultZ", i), 0);
  }
  t.set("rotationOffset", 0);
  t.set("inputVector", Numbers{{0.5f, 0, 1}, {1, 0.5f, 1}, {0, 0, 0}});
  ASSERT_TRUE(t.run(8));
  const double h = std::sqrt(0.5), x[3] = {0, -1, h}, y[3] = {1, 0, h};
  for (uint32_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(t.at("resultX", i), x[i], 1e-6) << i;
    EXPECT_NEAR(t.at("resultY", i), y[i], 1e-6) << i;
  }
  expectSameBitsAtAllWidths(t);
}

// The same physics in double, every nanometre.
TEST(VectorPatterns, BlackBodyByPlancksLaw) {
  const auto planck = [](double kelvin, double rgb[3]) {
    const auto lobe = [](double l, double mean, double below, double above) {
      const double t = (l - mean) * (l < mean ? below : above);
      return std::exp(-0.5 * t * t);
    };
    double x = 0, y = 0, z = 0;
    for (int nm = 360; nm <= 830; ++nm) {
      const double power = std::pow(560. / nm, 5) / std::expm1(1.4387769e7 / (nm * kelvin));
      x += power * (0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323) -
                    0.065 * lobe(nm, 501.1, 0.0490, 0.0382));
      y += power * (0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322));
      z += power * (1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725));
    }
    rgb[0] = std::fmax(0, 3.2404542 * x - 1.5371385 * y - 0.4985314 * z);
    rgb[1] = std::fmax(0, -0.9692660 * x + 1.8760108 * y + 0.0415560 * z);
    rgb[2] = std::fmax(0, 0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  };
  TestContext t("PxrBlackBody", 6);
  const std::vector<float> kelvin{1000, 2000, 3000, 5000, 6500, 10000};
  t.set("temperature", Numbers{kelvin});
  double rgb[3];
  const double white = planck(6500, rgb);
  for (const float physical : {0.f, 1.f}) {
    t.set("physicalIntensity", physical);
    t.set("exposure", 1 + physical);
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < 6; ++i) {
      const double l = planck(kelvin[i], rgb), scale = (physical > 0 ? 4 / white : 2 / l);
      const double tolerance = 0.005 * l * scale;  // what 10 nm instead of 1 cost
      for (uint32_t k = 0; k < 3; ++k)
        EXPECT_NEAR(t.at("resultRGB", i, k), rgb[k] * scale, tolerance) << kelvin[i] << " " << k;
    }
  }
  t.set("temperature", Numbers{{-5, 0, 1e30f, 499, 500, 40000}});
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 6; ++i) EXPECT_TRUE(std::isfinite(t.at("resultR", i))) << i;
  expectSameBitsAtAllWidths(t);
}

TEST(VectorPatterns, ThinFilmInterferes) {
  TestContext t("PxrThinFilm", 4);
  std::vector<uint32_t> outside(16, ~0u);
  t.c.entering = outside.data();
  std::vector<float> x, z;
  for (const double angle : {0., 0.5, 1., 1.5}) {
    x.push_back(float(std::sin(angle)));
    z.push_back(float(std::cos(angle)));
  }
  t.setVectors(t.c.wo, {x, {0, 0, 0, 0}, z});
  t.set("spread", 0);
  t.set("thickness", 0);  // black: the two reflections cancel
  ASSERT_TRUE(t.run(8));
  for (uint32_t k = 0; k < 3; ++k) EXPECT_NEAR(t.at("resultRGB", 2, k), 0, 1e-6);
  t.set("thickness", 600);
  t.set("eta", 1.33f);
  t.set("inputRGB", 0.5f);
  ASSERT_TRUE(t.run(8));
  // by the angle in the film, of the bands' shares as the node documents them
  const double green[6] = {-0.06584, 0.07104, 0.61547, 0.42414, -0.03791, -0.0069};
  for (uint32_t i = 0; i < 4; ++i) {
    const double inside = std::asin(x[i] / 1.33);
    double sum = 0;
    for (int b = 0; b < 6; ++b)
      sum += green[b] * std::pow(std::sin(2 * M_PI * 1.33 * 600 * std::cos(inside) / (425 + 50 * b)), 2);
    EXPECT_NEAR(t.at("resultG", i), 0.5 * std::fmax(0, sum), 1e-5) << i;
  }
  t.set("spread", 10);  // no order is left: half of all light
  ASSERT_TRUE(t.run(8));
  for (uint32_t k = 0; k < 3; ++k) EXPECT_NEAR(t.at("resultRGB", 1, k), 0.25, 1e-4);
  t.set("spread", 0.01f);
  expectSameBitsAtAllWidths(t);
}

TEST(VectorPatterns, VariationsKeepTheirRange) {
  constexpr uint32_t kObjects = 2000;
  TestContext t("PxrVary", kObjects);
  std::vector<float> id(kObjects);
  for (uint32_t i = 0; i < kObjects; ++i) id[i] = float(i);
  t.setBuiltin(Builtin::ObjectId, {id});
  t.set("inputRGB", Numbers{{0.2f}, {0.4f}, {0.6f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultG", 5), 0.4f, 1e-6) << "no amounts, no change";
  t.set("luminance", 0.5f);
  for (const int mode : {0, 1, 2}) {
    t.set("luminanceMode", float(mode));
    ASSERT_TRUE(t.run(8));
    double low = 9, high = 0, sum = 0;
    for (uint32_t i = 0; i < kObjects; ++i) {
      const double factor = t.at("resultB", i) / 0.6;
      EXPECT_NEAR(t.at("resultR", i) / 0.2, factor, 1e-5);
      low = std::fmin(low, factor), high = std::fmax(high, factor), sum += factor;
    }
    const double from = mode == 1 ? 1 : 0.5, to = mode == 2 ? 1 : 1.5;
    EXPECT_GE(low, from - 1e-6);
    EXPECT_LE(high, to + 1e-6);
    EXPECT_NEAR(sum / kObjects, (from + to) / 2, 4 * (to - from) / std::sqrt(12. * kObjects)) << mode;
  }
  t.set("probability", 0.25f);
  ASSERT_TRUE(t.run(8));
  int changed = 0;
  for (uint32_t i = 0; i < kObjects; ++i) changed += std::fabs(t.at("resultG", i) - 0.4f) > 1e-6f;
  EXPECT_NEAR(changed / double(kObjects), 0.25, 4 * std::sqrt(0.25 * 0.75 / kObjects));
  t.set("probability", 1);
  t.set("luminance", 0);
  t.set("hue", 1);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 50; ++i) {  // the hue alone: the largest and the smallest component stay
    const float r = t.at("resultR", i), g = t.at("resultG", i), b = t.at("resultB", i);
    EXPECT_NEAR(std::fmax(r, std::fmax(g, b)), 0.6f, 1e-5);
    EXPECT_NEAR(std::fmin(r, std::fmin(g, b)), 0.2f, 1e-5);
  }
  t.set("hue", 0);
  t.set("saturation", 0.9f);
  int vivid = 0;
  for (const float red : {0.2f, -0.2f}) {  // what is below zero already may stay there
    t.set("inputRGB", Numbers{{red}, {0.4f}, {0.05f}});
    ASSERT_TRUE(t.run(8));
    for (uint32_t i = 0; i < kObjects; ++i) {
      EXPECT_GE(t.at("resultR", i), std::fmin(red, 0.f)) << i;
      EXPECT_GE(t.at("resultB", i), 0) << i;
      vivid += t.at("resultB", i) == 0;
    }
  }
  EXPECT_GT(vivid, 100) << "the test asks for nothing";
  t.set("saturation", 0);
  t.set("hue", 1);
  t.set("inputRGB", Numbers{{0.2f}, {0.4f}, {0.6f}});
  // a primitive variable: equal values, equal colours
  t.set("varySource", 2);
  t.setText("varName", "leaf");
  std::vector<float> leaf(kObjects);
  for (uint32_t i = 0; i < kObjects; ++i) leaf[i] = float(i % 10);
  t.setPrimvar("leaf", {leaf});
  ASSERT_TRUE(t.run(8));
  EXPECT_EQ(t.at("resultR", 3), t.at("resultR", 1993));
  EXPECT_NE(t.at("resultR", 3), t.at("resultR", 4));
  TestContext w("PxrVary", 45);
  w.setBuiltin(Builtin::ObjectId, {spread(45, 0, 44)});
  for (const char* name : {"hue", "saturation", "luminance", "gamma"}) w.set(name, 0.7f);
  expectSameBitsAtAllWidths(w);
}

}  // namespace kinora::patternTest
