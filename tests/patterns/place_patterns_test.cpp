// Proves patterns over texture coordinates, space and direction against values worked out by hand, and equal bits at
// every width.
#include <cmath>

#include "plugins/pattern/test_context.h"

namespace kinora::patternTest {

TEST(PlacePatterns, CheckerAndItsFilter) {
  TestContext t("PxrChecker", 4);
  t.setManifold("manifold", {{0.5f, 1.5f, -0.5f, 1.5f}, {0.5f, 0.5f, 0.5f, -0.5f}}, {{0.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 0), 1);
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 0);
  EXPECT_FLOAT_EQ(t.at("resultR", 2), 0);
  EXPECT_FLOAT_EQ(t.at("resultR", 3), 1);
  // a window centred a quarter of its half width from an edge sees 5/8 of one colour
  t.setManifold("manifold", {{0.95f, 1.05f, 0.95f, 0.95f}, {0.5f, 0.5f, 0.5f, 0.5f}}, {{0.2f, 0.2f, 40.f, 1.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultR", 0), 0.625f, 1e-4f);
  EXPECT_NEAR(t.at("resultR", 1), 0.375f, 1e-4f);
  EXPECT_NEAR(t.at("resultR", 2), 0.5f, 0.02f);
  EXPECT_NEAR(t.at("resultR", 3), 0.5f, 1e-4f);  // two whole cells
  TestContext w("PxrChecker", 45);
  w.setManifold("manifold", {spread(45, -9, 9), spread(45, -9, 9, 11), spread(45, -9, 9, 13)},
                {spread(45, 0, 2, 17)});
  w.set("dimensions", 3);
  expectSameBitsAtAllWidths(w);
}

TEST(PlacePatterns, RampCurves) {
  TestContext t("PxrRamp", 5);
  t.setManifold("manifold", {{-1.f, 0.f, 0.25f, 0.5f, 3.f}, {0.f, 0.f, 0.f, 0.f, 0.f}}, {{0.f}});
  t.setList("colorRamp_Knots", {0, 0, 0.5f, 1, 1});
  t.setList("colorRamp_Colors", {0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 4, 0, 0, 4, 0});
  t.setText("colorRamp_Interpolation", "linear");
  ASSERT_TRUE(t.run(8));
  const float linear[] = {0, 0, 1, 2, 4};
  for (uint32_t i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(t.at("resultG", i), linear[i]) << i;
  t.setText("colorRamp_Interpolation", "constant");
  ASSERT_TRUE(t.run(8));
  const float constant[] = {0, 0, 0, 2, 2};
  for (uint32_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(t.at("resultG", i), constant[i]) << i;
  t.setText("colorRamp_Interpolation", "catmull-rom");  // goes through its knots; half way: (-0 + 9 0 + 9 2 - 4) / 16
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultG", 1), 0, 1e-6f);
  EXPECT_NEAR(t.at("resultG", 2), 14.f / 16, 1e-6f);
  EXPECT_NEAR(t.at("resultG", 3), 2, 1e-6f);
  EXPECT_NEAR(t.at("resultG", 4), 4, 1e-6f);
  t.setText("colorRamp_Interpolation", "bspline");  // at a knot: (a + 4 b + c) / 6
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultG", 3), (0 + 8 + 4) / 6.f, 1e-5f);
  t.setText("colorRamp_Interpolation", "linear");
  t.set("reverse", 1);
  t.set("tile", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultG", 2), 3);
  t.setList("colorRamp_Colors", {});  // no colours: black, no crash
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultG", 2), 0);
}

TEST(PlacePatterns, RampTypesAndWidths) {
  TestContext t("PxrRamp", 45);
  t.setManifold("manifold", {spread(45, -1, 2), spread(45, -1, 2, 11)}, {{0.f}});
  t.setBuiltin(Builtin::ObjectId, {spread(45, 0, 44, 7)});
  for (int type = 0; type < 8; ++type) {
    t.set("rampType", float(type));
    expectSameBitsAtAllWidths(t);
    if (type == 6) continue;  // splineMap is one number for all
    bool varies = false;
    for (uint32_t i = 1; i < 45; ++i) varies |= t.at("resultR", i) != t.at("resultR", 0);
    EXPECT_TRUE(varies) << type;
  }
  t.set("rampType", 0.f);
  t.setText("colorRamp_Interpolation", "linear");
  t.set("splineMap", 0.f);  // said as every scene says it: the manifold counts
  ASSERT_TRUE(t.run(8));
  bool isFlat = true;
  for (uint32_t i = 1; i < 45; ++i) isFlat &= t.at("resultR", i) == t.at("resultR", 0);
  EXPECT_FALSE(isFlat);
  t.connect("splineMap", Numbers{spread(45, 0, 1, 13)});  // overrides it
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 45; ++i) EXPECT_NEAR(t.at("resultR", i), spread(45, 0, 1, 13)[i], 1e-6f);
  t.connect("splineMap", Numbers{{0.f}});  // so does what is 0 everywhere
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 0; i < 45; ++i) EXPECT_NEAR(t.at("resultR", i), 0, 1e-6f);
}

TEST(PlacePatterns, Manifold3D) {
  TestContext t("PxrManifold3D", 2);
  t.setBuiltin(Builtin::Po, {{1.f, 2.f}, {3.f, 4.f}, {5.f, 6.f}});
  t.setBuiltin(Builtin::PoRadius, {{0.5f, 0.5f}});
  t.set("scale", -2);
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultY", 1), -8);
  EXPECT_FLOAT_EQ(t.outManifold("result").radius.data[0][0], 1);
  EXPECT_EQ(t.outManifold("result").dimensions, 3u);
  t.set("use", 1);
  t.setPrimvar("__Pref", {{7.f, 8.f}, {0.f, 0.f}, {0.f, 0.f}}, 0.25f);
  t.matrices["render>object"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1};
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultX", 1), -36);
  expectSameBitsAtAllWidths(t);
}

// Up to 16 points are seen from where there is nothing around them.
void seeFromOutside(TestContext& t) {
  static const uint32_t entering[16] = {~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u,
                                        ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u, ~0u};
  static const float ior[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  t.c.entering = entering;
  t.c.outerIor = ior;
}

TEST(PlacePatterns, FacingRatio) {
  TestContext t("PxrFacingRatio", 3);
  // normal along z; seen from above, at 60 degrees, and with a bent normal
  t.setVectors(t.c.wo, {{0.f, 0.8660254f, 0.f}, {0.f, 0.f, 0.f}, {1.f, 0.5f, 1.f}});
  seeFromOutside(t);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF", 0), 1, 1e-6f);
  EXPECT_NEAR(t.at("resultF", 1), 0.5f, 1e-6f);
  t.set("invert", 1);
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF", 1), 0.5f, 1e-6f);
  EXPECT_NEAR(t.at("resultF", 0), 0, 1e-6f);
  t.set("mode", 2);  // head on: ((1.5 - 1) / (1.5 + 1))^2, one minus it, inverted back
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF", 0), 0.04f, 1e-5f);
  t.set("invert", 0.f);
  t.set("mode", 0.f);
  t.set("use", 1);
  t.set("direction", Numbers{{0.f}, {3.f}, {4.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_NEAR(t.at("resultF", 0), 0.8f, 1e-6f);
  expectSameBitsAtAllWidths(t);
}

TEST(PlacePatterns, Voronoise) {
  constexpr uint32_t n = 5003;
  TestContext t("PxrVoronoise", n);
  t.setBuiltin(Builtin::Po, {spread(n, -40, 40, 7), spread(n, -40, 40, 11), spread(n, -40, 40, 13)});
  t.setBuiltin(Builtin::PoRadius, {{0.f}});
  t.set("jitter", 1);
  double smoothDeviation = 0;
  for (float smoothness : {1.f, 0.f}) {
    t.set("smoothness", smoothness);
    t.set("octaves", 1);
    ASSERT_TRUE(t.run(8));
    double sum = 0, squares = 0;
    for (uint32_t i = 0; i < n; ++i) {
      const double v = t.at("resultF", i);
      ASSERT_TRUE(v >= 0 && v <= 1);
      sum += v, squares += v * v;
    }
    const double deviation = std::sqrt(squares / n - sum / n * sum / n);
    EXPECT_NEAR(sum / n, 0.5, 0.02) << smoothness;
    if (smoothness == 1) smoothDeviation = deviation;
    // flat cells keep the deviation of uniform values, smooth noise averages it away
    if (smoothness == 0) {
      EXPECT_NEAR(deviation, std::sqrt(1 / 12.0), 0.03);
    }
  }
  EXPECT_LT(smoothDeviation, 0.2);
  t.setBuiltin(Builtin::PoRadius, {{5.f}});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultF", 3), 0.5f);
  TestContext w("PxrVoronoise", 45);
  w.setBuiltin(Builtin::Po, {spread(45, -40, 40, 7), spread(45, -40, 40, 11), spread(45, -40, 40, 13)});
  w.setBuiltin(Builtin::PoRadius, {spread(45, 0, 1, 17)});
  w.set("jitter", 0.8f);
  w.set("smoothness", 0.3f);
  w.set("turbulent", 1);
  expectSameBitsAtAllWidths(w);
}

// Flat cells are those of the nearest points: values jump between cells, and are nowhere the mean of no cell.
TEST(PlacePatterns, VoronoiseHasNoHoles) {
  constexpr uint32_t n = 60000;
  TestContext t("PxrVoronoise", n);
  std::vector<float> x(n), y(n), z(n);
  for (uint32_t i = 0; i < n; ++i) {
    x[i] = 40 * std::fmod(float(i) * 0.75487766f, 1.f) - 20;
    y[i] = 40 * std::fmod(float(i) * 0.56984029f, 1.f) - 20;
    z[i] = 40 * std::fmod(float(i) * 0.36902809f, 1.f) - 20;
  }
  t.setBuiltin(Builtin::Po, {x, y, z});
  t.setBuiltin(Builtin::PoRadius, {{0.f}});
  t.set("jitter", 1);
  t.set("octaves", 1);
  t.set("smoothness", 0.f);
  ASSERT_TRUE(t.run(8));
  uint32_t middles = 0;
  for (uint32_t i = 0; i < n; ++i) middles += t.at("resultF", i) == 0.5f;
  EXPECT_EQ(middles, 0u);
  // smooth noise goes on smoothly: along a line its steps are small everywhere
  for (uint32_t i = 0; i < n; ++i) x[i] = float(i) * 0.001f, y[i] = 0.37f, z[i] = -3.21f;
  t.setBuiltin(Builtin::Po, {x, y, z});
  t.set("smoothness", 1);
  ASSERT_TRUE(t.run(8));
  for (uint32_t i = 1; i < n; ++i)
    ASSERT_NEAR(t.at("resultF", i), t.at("resultF", i - 1), 0.01f) << "at x = " << x[i];
}

// Where normals differ from point to point, those that have none are the surface's as it is, also where the viewer
// hardly sees it, as where none has one.
TEST(PlacePatterns, PointsWithoutABumpHaveTheSurfacesNormal) {
  const float grazing = 0.002f, other = std::sqrt(1 - grazing * grazing);
  for (const auto& [pattern, input] : {std::pair{"PxrBump", "inputN"},
                                       {"PxrAdjustNormal", "inputNormal"},
                                       {"PxrNormalMap", "bumpOverlay"},
                                       {"PxrBumpMixer", "inputN2"}}) {
    TestContext t(pattern, 2);
    seeFromOutside(t);
    t.setVectors(t.c.wo, {{other, other}, {0, 0}, {grazing, grazing}});
    t.set(input, Numbers{{0, 0.6f}, {0, 0}, {0, 0.8f}});
    if (std::string(pattern) == "PxrNormalMap") t.set("disable", 1);
    ASSERT_TRUE(t.run(8)) << pattern;
    EXPECT_EQ(t.at("resultN", 0, 0), 0) << pattern;
    EXPECT_EQ(t.at("resultN", 0, 2), 1) << pattern;
    EXPECT_NEAR(t.at("resultN", 1, 0), 0.6f, 1e-5f) << pattern;
  }
}

// The renderer's gradient of what feeds a bump tilts its normal.
TEST(PlacePatterns, BumpOfAGradient) {
  TestContext t("PxrBump", 9);
  seeFromOutside(t);
  t.set("scale", 2);
  t.set("inputBump", 3);  // a number has no slope
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultN", 4, 2), 1);
  t.connect("inputBump", {{3.f}}, {{0.25f}, {-0.5f}, {7.f}});  // what rises along the normal bends nothing
  for (const int reverse : {0, 1}) {
    t.set("reverse", float(reverse));
    ASSERT_TRUE(t.run(8));
    const double l = std::sqrt(0.25 + 1 + 1), sign = reverse ? -1 : 1;
    EXPECT_NEAR(t.at("resultN", 4, 0), sign * -0.5 / l, 1e-6);
    EXPECT_NEAR(t.at("resultN", 4, 1), sign / l, 1e-6);
    EXPECT_NEAR(t.at("resultN", 4, 2), 1 / l, 1e-6);
  }
  t.connect("inputBump", {spread(9, 0, 1)}, {spread(9, -1, 1), spread(9, 0, 1, 5), {std::vector<float>(9, 0.f)}});
  expectSameBitsAtAllWidths(t);
  t.setText("filename", "heights.tx");  // an image counts before
  t.onTexture = [](int, float, float, float, const TextureOptions&, float v[4]) { v[0] = v[1] = v[2] = 0; };
  t.setBuiltin(Builtin::St, {spread(9, 0, 1), spread(9, 0, 1, 5)});
  t.setBuiltin(Builtin::StRadius, {std::vector<float>(9, 0.01f)});
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultN", 4, 2), 1);
}

TEST(PlacePatterns, NormalsFromImages) {
  TestContext m("PxrNormalMap", 9);
  seeFromOutside(m);
  m.setBuiltin(Builtin::St, {spread(9, 0, 1), spread(9, 0, 1, 5)});
  m.setBuiltin(Builtin::StRadius, {std::vector<float>(9, 0.01f)});
  ASSERT_TRUE(m.run(8));
  EXPECT_NEAR(m.at("resultN", 0, 2), 1, 1e-5f);  // no image, neutral input
  m.set("orientation", 0.f);
  m.set("inputRGB", Numbers{{0.8f}, {0.5f}, {0.9f}});  // 0.6 along the tangent, 0.8 up
  ASSERT_TRUE(m.run(8));
  EXPECT_NEAR(m.at("resultN", 4, 0), 0.6f, 1e-5f);
  EXPECT_NEAR(m.at("resultN", 4, 2), 0.8f, 1e-5f);
  m.set("flipX", 1);
  ASSERT_TRUE(m.run(8));
  EXPECT_NEAR(m.at("resultN", 4, 0), -0.6f, 1e-5f);
  m.setText("filename", "map.tx");
  m.onTexture = [](int, float, float, float, const TextureOptions&, float v[4]) {
    v[0] = 0.5f, v[1] = 0.8f, v[2] = 0.9f;
  };
  ASSERT_TRUE(m.run(8));
  EXPECT_NEAR(m.at("resultN", 4, 1), 0.6f, 1e-5f);
  expectSameBitsAtAllWidths(m);
  m.set("disable", 1);
  ASSERT_TRUE(m.run(8));
  EXPECT_NEAR(m.at("resultN", 4, 2), 1, 1e-5f);

  TestContext b("PxrBump", 9);
  seeFromOutside(b);
  b.setBuiltin(Builtin::St, {spread(9, 0, 1), spread(9, 0, 1, 5)});
  b.setBuiltin(Builtin::StRadius, {std::vector<float>(9, 0.01f)});
  static const float radius[16] = {.02f, .02f, .02f, .02f, .02f, .02f, .02f, .02f,
                                   .02f, .02f, .02f, .02f, .02f, .02f, .02f, .02f};
  b.c.radius = radius;  // one unit of st is two render units long
  b.setGradient("", 0, {{0.5f}, {0.f}, {0.f}});
  b.setGradient("", 1, {{0.f}, {0.5f}, {0.f}});
  b.setText("filename", "heights.tx");
  b.onTexture = [](int, float s, float t, float, const TextureOptions&, float v[4]) { v[0] = 1.5f * s + t; };
  ASSERT_TRUE(b.run(8));
  // slopes 0.75 along s and, t counting down in images, -0.5 up
  const float length = std::sqrt(0.75f * 0.75f + 0.5f * 0.5f + 1);
  EXPECT_NEAR(b.at("resultN", 3, 0), -0.75f / length, 2e-3f);
  EXPECT_NEAR(b.at("resultN", 3, 1), 0.5f / length, 2e-3f);
  EXPECT_NEAR(b.at("resultN", 3, 2), 1 / length, 2e-3f);
  expectSameBitsAtAllWidths(b);
}

TEST(PlacePatterns, Variables) {
  TestContext t("PxrVariable", 3);
  t.setVectors(t.c.P, {{1.f, 2.f, 3.f}, {4.f, 5.f, 6.f}, {7.f, 8.f, 9.f}});
  t.setBuiltin(Builtin::St, {{0.1f, 0.2f, 0.3f}, {0.4f, 0.5f, 0.6f}});
  t.setText("variable", "P");
  t.setText("coordsys", "world");
  t.matrices["render>world"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 100, 0, 0, 1};
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 102);
  EXPECT_FLOAT_EQ(t.at("resultB", 2), 9);
  t.setText("variable", "");
  t.setText("name", "st");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultG", 1), 0.5f);
  EXPECT_FLOAT_EQ(t.at("resultB", 1), 0);
  t.setText("name", "t");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 0.5f);
  t.setBuiltin(Builtin::U, {{0.7f, 0.8f, 0.9f}});
  t.setBuiltin(Builtin::V, {{0.25f}});
  t.setText("name", "uv");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 0.8f);
  EXPECT_FLOAT_EQ(t.at("resultG", 1), 0.25f);
  EXPECT_FLOAT_EQ(t.at("resultB", 1), 0);
  t.setText("name", "nothing");
  ASSERT_TRUE(t.run(8));
  EXPECT_FLOAT_EQ(t.at("resultR", 1), 0);
}

}  // namespace kinora::patternTest
