// Proves: shaders of the shading language stand in scenes as pattern nodes. Their parameters, connections, primvars
// and derivatives mean what those of C++ patterns mean; materials that differ in numbers share a program; what is
// broken is told with its place and seen.
#include "fixture.h"
#include "shade/no_effect.h"

namespace kinora::tests {
namespace {

TEST_F(Shaders, AConstantIsTheConstant) {
  write("plain.osl", "shader plain(color c = color(.25, .5, .75), output color result = 0) { result = c; }");
  const auto plain = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [.25 .5 .75]\n");
  EXPECT_EQ(filmOf(std::string("Pattern \"plain\" \"n\"\n") + kShow), plain);
  EXPECT_EQ(filmOf(std::string("Pattern \"PxrOSL\" \"n\" \"string shader\" [\"plain\"]\n") + kShow), plain);
  EXPECT_EQ(filmOf(std::string("Pattern \"plain.osl\" \"n\"\n") + kShow), plain);
  EXPECT_EQ(filmOf(std::string("Pattern \"plain\" \"n\" \"color c\" [1 0 0]\n") + kShow),
            filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [1 0 0]\n"));
}

TEST_F(Shaders, TextureCoordinatesPrimvarsAndDefaults) {
  write("show.osl", R"(shader show(float s = 0 [[int lockgeom = 0]], float t = 0 [[int lockgeom = 0]],
    color tint = color(0, 0, .5) [[int lockgeom = 0]], float locked = 3, output color result = 0)
    { result = color(s, t, tint[2] * locked); })");
  const std::string network = std::string("Pattern \"show\" \"n\"\n") + kShow;
  SceneRender render(requestOf(network));
  ASSERT_TRUE(render.ok());
  const image::Image picture = render.channel("Ci");
  for (int y : {0, 7, 15})
    for (int x : {0, 5, 15}) {
      EXPECT_NEAR(picture.at(x, y)[0], (x + 0.5) / 16, 0.5 / 16 + 1e-5);
      EXPECT_NEAR(picture.at(x, y)[1], 1 - (y + 0.5) / 16, 0.5 / 16 + 1e-5);
      EXPECT_FLOAT_EQ(picture.at(x, y)[2], 1.5f);
    }
  // a primvar of the parameter's name replaces it, but not one that is locked
  SceneRender replaced(requestOf(network, "\"constant color tint\" [0 0 .25] \"constant float locked\" [9]"));
  ASSERT_TRUE(replaced.ok());
  EXPECT_FLOAT_EQ(middleOf(replaced)[2], 0.75f);
}

// Whether or not the materials of the scene say the same of a parameter, an object's primvar stands before it.
TEST_F(Shaders, PrimvarsReplaceWhatMaterialsSayDifferently) {
  using Rgb = std::array<float, 3>;
  write("own.osl", R"(shader own(float k = 0 [[int lockgeom = 0]], int n = 0 [[int lockgeom = 0]],
    float made = 3 * k [[int lockgeom = 0]], output color result = 0) { result = color(k, n, made); })");
  const auto own = [](const std::string& parameters) { return "Pattern \"own\" \"n\" " + parameters + "\n" + kShow; };
  SceneRender differ(halvesOf(own("\"float k\" [.5] \"int n\" [2]"),
                              "\"constant float k\" [.25] \"constant int n\" [7]",
                              own("\"float k\" [.125] \"int n\" [3]"), "\"constant float made\" [9]"));
  ASSERT_TRUE(differ.ok());
  EXPECT_EQ(at(differ, 3), (Rgb{.25f, 7, .75f}));
  EXPECT_EQ(at(differ, 12), (Rgb{.125f, 3, 9}));
  const std::string same = own("\"float k\" [.5] \"int n\" [2]");
  SceneRender alike(halvesOf(same, "\"constant int n\" [7]", same, "\"constant float made\" [9]"));
  ASSERT_TRUE(alike.ok());
  EXPECT_EQ(at(alike, 3), (Rgb{.5f, 7, 1.5f}));
  EXPECT_EQ(at(alike, 12), (Rgb{.5f, 2, 9}));
  // what materials give stands before the code of a default
  SceneRender given(halvesOf(own("\"float made\" [4]"), "", own("\"float made\" [5]"), "\"constant float k\" [1]"));
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(at(given, 3), (Rgb{0, 0, 4}));
  EXPECT_EQ(at(given, 12), (Rgb{1, 0, 5}));
}

TEST_F(Shaders, PrimvarsReplaceStringsAndArrays) {
  using Rgb = std::array<float, 3>;
  write("many.osl", R"(shader many(string name = "a" [[int lockgeom = 0]], float two[2] = {1, 2} [[int lockgeom = 0]],
    string names[2] = {"x", "y"} [[int lockgeom = 0]], int whole[4] = {1, 2, 3, 4} [[int lockgeom = 0]],
    output color result = 0)
    { result = color((name == "b") + 2 * (names[0] == "x") + 4 * (names[1] == "q"), two[0] + 10 * two[1],
                     whole[0] + 10 * whole[3]); })");
  const auto many = [](const std::string& parameters) {
    return "Pattern \"many\" \"n\" " + parameters + "\n" + kShow;
  };
  SceneRender alike(halvesOf(many(""),
                             "\"constant string name\" [\"b\"] \"constant float[2] two\" [3 4] \"constant string[2] "
                             "names\" [\"p\" \"q\"] \"constant int[4] whole\" [5 6 7 8]",
                             many(""), ""));
  ASSERT_TRUE(alike.ok());
  EXPECT_EQ(at(alike, 3), (Rgb{5, 43, 85}));
  EXPECT_EQ(at(alike, 12), (Rgb{2, 21, 41}));
  // what materials say, and primvars of another length, which are none
  SceneRender differ(halvesOf(many("\"string name\" [\"b\"] \"string[2] names\" [\"x\" \"q\"]"),
                              "\"constant float[3] two\" [3 4 5] \"uniform string names\" [\"q\"]",
                              many("\"string name\" [\"c\"] \"float[2] two\" [6 7] \"int[4] whole\" [2 0 0 3]"),
                              "\"uniform string name\" [\"b\"]"));
  ASSERT_TRUE(differ.ok());
  EXPECT_EQ(at(differ, 3), (Rgb{7, 21, 41}));
  EXPECT_EQ(at(differ, 12), (Rgb{3, 76, 32}));
  // values that vary over the surface
  SceneRender varies(requestOf(many(""), "\"vertex float[2] two\" [0 1  0 1  2 1  2 1]"));
  ASSERT_TRUE(varies.ok());
  EXPECT_NEAR(at(varies, 4)[1], 10 + 2 * 4.5 / 16, 1.0 / 16 + 1e-4);
  EXPECT_NEAR(at(varies, 12)[1], 10 + 2 * 12.5 / 16, 1.0 / 16 + 1e-4);
}

// Render space begins elsewhere where the camera is far from the origin. Points that a scene says lie in the world.
TEST_F(Shaders, PointsOfMaterialsLieInTheWorld) {
  using Rgb = std::array<float, 3>;
  write("where.osl", R"(shader where(point p = 0, point own = 0 [[int lockgeom = 0]], output color result = 0)
    { result = color(p[0], own[0] > 1000 ? own[0] - 5000 : own[0], own[1]); })");
  const auto where = [](const std::string& parameters) {
    return "Pattern \"where\" \"n\" " + parameters + "\n" + kShow;
  };
  RenderRequest r = halvesOf(where("\"point p\" [1 2 3] \"point own\" [4 5 6]"), "\"constant point own\" [.5 0 0]",
                             where("\"point p\" [2 3 4] \"point own\" [5 6 7]"), "");
  r.rib.insert(r.rib.find("WorldBegin"), "Translate -5000 0 0\n");
  r.rib.insert(r.rib.find("AttributeBegin"), "Translate 5000 0 0\n");
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(at(render, 3), (Rgb{1, .5f, 0}));
  EXPECT_EQ(at(render, 12), (Rgb{2, 5, 6}));
}

TEST_F(Shaders, DerivativesAreThoseOfThePicture) {
  // one step is one pixel: a sixteenth of s and t
  write("steps.osl",
        R"(shader steps(float s = 0 [[int lockgeom = 0]], float t = 0 [[int lockgeom = 0]], output color result = 0)
    { result = color(filterwidth(s), filterwidth(t), sqrt(area(P))) * 8; })");
  SceneRender render(requestOf(std::string("Pattern \"steps\" \"n\"\n") + kShow));
  ASSERT_TRUE(render.ok());
  const auto c = middleOf(render);
  EXPECT_NEAR(c[0], 0.5, 1e-4);
  EXPECT_NEAR(c[1], 0.5, 1e-4);
  EXPECT_NEAR(c[2], 1.0, 1e-4);  // the square is 2 wide
}

TEST_F(Shaders, NetworksOfShadersAndPatternsFeedEachOther) {
  write("twice.osl",
        "shader twice(color a = 0, output color result = 0, output float sum = 0) { result = 2 * a; sum = a[0] + "
        "a[1] + a[2]; }");
  write("lift.osl", "shader lift(color a = 0, float by = 0, output color result = 0) { result = a + by; }");
  const std::string gain =
      "Pattern \"PxrExposure\" \"e\" \"reference color inputRGB\" [\"n1:result\"] \"float stops\" [1]\n";
  const auto expected = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [1.25 .75 1]\n");
  // shader -> C++ -> shader (n1 also feeds it directly): .125 .0 .0625 -> x2 x2 -> + sum ...
  EXPECT_EQ(filmOf("Pattern \"twice\" \"n1\" \"color a\" [.125 0 .0625]\n" + gain +
                   "Pattern \"lift\" \"n\" \"reference color a\" [\"e:resultRGB\"] \"float by\" [.75]\n" + kShow),
            expected);
  // shader -> shader, a float of one output to a parameter of the other
  EXPECT_EQ(filmOf(std::string("Pattern \"twice\" \"n1\" \"color a\" [.5 .25 0]\n") +
                   "Pattern \"lift\" \"n\" \"color a\" [.5 0 .25] \"reference float by\" [\"n1:sum\"]\n" + kShow),
            expected);
}

TEST_F(Shaders, ShadersThatDifferInNumbersShareAProgram) {
  write("plain.osl", "shader plain(color c = 0, float k = 1, output color result = 0) { result = c * k; }");
  RenderRequest r = requestOf("AttributeBegin\nPattern \"plain\" \"n\" \"color c\" [.5 0 0] \"float k\" [2]\n" +
                              std::string(kShow) +
                              "Polygon \"P\" [-1 -1 0  -1 1 0  0 1 0  0 -1 0]\nAttributeEnd\n"
                              "Translate 0 0 .5\nPattern \"plain\" \"n\" \"color c\" [0 .25 0] \"float k\" [3]\n" +
                              kShow);
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const image::Image picture = render.channel("Ci");
  EXPECT_FLOAT_EQ(picture.at(3, 8)[0], 1);
  EXPECT_FLOAT_EQ(picture.at(3, 8)[1], 0);
  EXPECT_FLOAT_EQ(picture.at(12, 8)[0], 0);
  EXPECT_FLOAT_EQ(picture.at(12, 8)[1], 0.75f);
}

TEST_F(Shaders, WhatIsBrokenIsToldWithItsPlaceAndSeen) {
  write("broken.osl", "shader broken(output color result = 0)\n{\n  result = undefined;\n}\n");
  SceneRender render(requestOf(std::string("Pattern \"broken\" \"n\"\n") + kShow));
  ASSERT_TRUE(render.ok());
  ASSERT_EQ(render.messages().size(), 1u);
  EXPECT_NE(render.messages()[0].find("SHADER-COMPILE"), std::string::npos) << render.messages()[0];
  EXPECT_NE(render.messages()[0].find("broken.osl:3"), std::string::npos) << render.messages()[0];
  EXPECT_EQ(middleOf(render), (std::array<float, 3>{1, 0, 1}));
  // a shader that is not there is a missing pattern
  SceneRender missing(requestOf(std::string("Pattern \"nowhere\" \"n\"\n") + kShow));
  ASSERT_TRUE(missing.ok());
  bool told = false;
  for (const std::string& m : missing.messages())
    told |= m.find("PLUGIN-MISSING") != std::string::npos && m.find("nowhere") != std::string::npos;
  EXPECT_TRUE(told);
  // an output that is not there, a parameter that is not there
  write("plain.osl", "shader plain(output color result = 0) { result = 1; }");
  SceneRender wrong(
      requestOf("Pattern \"plain\" \"n\" \"float x\" [1]\nBxdf \"PxrConstant\" \"m\" \"reference color emitColor\" "
                "[\"n:colour\"]\n"));
  ASSERT_TRUE(wrong.ok());
  ASSERT_EQ(wrong.messages().size(), 2u);
  EXPECT_NE(wrong.messages()[0].find("PARAM-UNKNOWN"), std::string::npos);
  EXPECT_NE(wrong.messages()[1].find("PARAM-CONNECTION"), std::string::npos);
}

TEST_F(Shaders, ParametersWithoutEffectAreTold) {
  const auto said = [&](const std::string& network) {
    SceneRender render(requestOf(network));
    for (const std::string& m : render.messages())
      if (m.find("PARAM-NO-EFFECT") != std::string::npos) return m;
    return std::string();
  };
  EXPECT_NE(said("Bxdf \"PxrSurface\" \"m\" \"int presenceCached\" [0] \"color userColor\" [1 0 0]\n")
                .find("'presenceCached', 'userColor'"),
            std::string::npos);
  EXPECT_EQ(said("Bxdf \"PxrSurface\" \"m\" \"int presenceCached\" [1] \"color userColor\" [0 0 0]\n"), "");
  // materials that others are made of, which become one before they are shaded
  EXPECT_NE(said("Bxdf \"LamaConductor\" \"c\" \"float tailMix\" [.5]\nBxdf \"LamaDiffuse\" \"d\"\n"
                 "Bxdf \"LamaLayer\" \"l\" \"reference struct materialTop\" [\"c:bxdf_out\"] "
                 "\"reference struct materialBase\" [\"d:bxdf_out\"]\n")
                .find("LamaConductor 'c': parameters without effect in this version: 'tailMix'"),
            std::string::npos);
  EXPECT_NE(said("Bxdf \"LamaLayer\" \"l\" \"float topThickness\" [1]\n").find("'topThickness'"), std::string::npos);
  EXPECT_NE(said("Pattern \"PxrHairColor\" \"n\" \"int colorSpace\" [1]\nBxdf \"PxrConstant\" \"m\" \"reference "
                 "color emitColor\" [\"n:resultDiff\"]\n")
                .find("'colorSpace'"),
            std::string::npos);
}

TEST_F(Shaders, RampsThatCannotBeAreTold) {
  const auto said = [&](const std::string& ramp) {
    SceneRender render(requestOf("Pattern \"PxrRamp\" \"n\" " + ramp +
                                 "\nBxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:resultRGB\"]\n"));
    return render.messages().empty() ? std::string() : render.messages()[0];
  };
  const std::string two = "\"color[2] colorRamp_Colors\" [0 0 0  1 1 1]";
  EXPECT_EQ(said("\"float[2] colorRamp_Knots\" [0 1] " + two), "");
  EXPECT_EQ(said("\"float[2] colorRamp_Knots\" [.5 .5] " + two), "") << "a step";
  EXPECT_NE(said("\"float[3] colorRamp_Knots\" [0 .5 1] " + two).find("3 knots and 2 colours"), std::string::npos);
  EXPECT_NE(said("\"float[2] colorRamp_Knots\" [1 0] " + two).find("PATTERN-RAMP"), std::string::npos);
  EXPECT_NE(said("\"float[2] positions\" [.7 .2] \"color[2] colors\" [0 0 0  1 1 1]").find("do not ascend"),
            std::string::npos);
}

TEST(NoEffect, EachParameterIsToldOnce) {
  Registry registry;
  Diagnostics diagnostics([](const std::string&, Severity) {});
  const auto networkOf = [](const char* parameter) {
    auto node = std::make_shared<scene::Node>();
    node->kind = "Bxdf";
    node->plugin = "LamaConductor";
    scene::Parameter p;
    p.name = parameter;
    p.floats = {0.5f};
    node->params.set(p);
    scene::Network n;
    n.terminal = node;
    return n;
  };
  shade::NoEffect report;
  for (int object = 0; object < 3; ++object)
    for (const char* parameter : {"tailMix", "tailLength", "roughness"})
      report.tell(networkOf(parameter), Kind::Bxdf, registry, diagnostics);
  EXPECT_EQ(diagnostics.count("PARAM-NO-EFFECT"), 2u);
}

TEST_F(Shaders, WritingThePointChangesNothingForOthers) {
  write("shift.osl",
        "displacement shift(output color result = 0) { result = color(P[0], 0, 0); P += N * 5; if (u > .5) P = 0; N "
        "= -N; }");
  write("read.osl", "shader read(color a = 0, output color result = 0) { result = color(P) * .25 + N + a * 0; }");
  const std::string reader = "Pattern \"read\" \"n\" ";
  EXPECT_EQ(filmOf("Pattern \"shift\" \"n1\"\n" + reader + "\"reference color a\" [\"n1:result\"]\n" + kShow),
            filmOf(reader + "\n" + kShow));
}

TEST_F(Shaders, ShadersSpeak) {
  write("speak.osl", "shader speak(output color result = 0) { if (u < 0.1) warning(\"u is %g\", 1.5); result = 1; }");
  SceneRender render(requestOf(std::string("Pattern \"speak\" \"n\"\n") + kShow));
  ASSERT_TRUE(render.ok());
  ASSERT_FALSE(render.messages().empty());
  EXPECT_NE(render.messages()[0].find("SHADER-WARNING"), std::string::npos) << render.messages()[0];
  EXPECT_NE(render.messages()[0].find("u is 1.5"), std::string::npos) << render.messages()[0];
}

}  // namespace
}  // namespace kinora::tests
