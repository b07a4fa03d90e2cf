// Proves: parameters of shaders come from the scene with their declared types - arrays, structs, strings, integers -,
// parts of them are fed one by one, and what does not fit is one message and the default.
#include "fixture.h"

namespace kinora::tests {
namespace {

class ShaderParameters : public Shaders {
 protected:
  using Rgb = std::array<float, 3>;
  Rgb shown(const std::string& network) {
    SceneRender render(requestOf(network + kShow));
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    return middleOf(render);
  }
  // One message, of this code and with these words; what is shown.
  Rgb complained(const std::string& network, const std::string& code, const std::vector<std::string>& words) {
    SceneRender render(requestOf(network + kShow));
    EXPECT_EQ(render.messages().size(), 1u);
    for (const std::string& m : render.messages()) {
      EXPECT_NE(m.find(code + ":"), std::string::npos) << m;
      for (const std::string& w : words) EXPECT_NE(m.find(w), std::string::npos) << w << " in " << m;
    }
    return middleOf(render);
  }
};

TEST_F(ShaderParameters, ArraysOfAllKinds) {
  write("lists.osl", R"(shader lists(float f[3] = {1, 2, 3}, int i[2] = {4, 5}, string s[2] = {"a", "b"},
    color c[2] = {color(1), color(2)}, float open[] = {7}, matrix m = 1, int big = 0, output color result = 0) {
    result = color(f[2] + i[1], c[1][2], arraylength(open) + open[arraylength(open) - 1]);
    if (s[1] == "second") result += color(10, 0, 0);
    if (m[3][1] == 6) result += color(0, 10, 0);
    if (big == 123456789) result += color(0, 0, 10); })");
  EXPECT_EQ(shown("Pattern \"lists\" \"n\"\n"), (Rgb{8, 2, 8}));
  EXPECT_EQ(
      shown("Pattern \"lists\" \"n\" \"float[3] f\" [0 0 .5] \"int[2] i\" [0 1] \"string[2] s\" [\"x\" \"second\"] "
            "\"color[2] c\" [0 0 0 0 0 .25] \"float[4] open\" [0 0 0 .5] \"matrix m\" [1 0 0 0 0 1 0 0 0 0 1 0 0 6 0 "
            "1] "
            "\"int big\" [123456789]\n"),
      (Rgb{11.5f, 10.25f, 14.5f}));
  // numbers for triples
  EXPECT_EQ(shown("Pattern \"lists\" \"n\" \"float[2] c\" [.5 .75]\n"), (Rgb{8, .75f, 8}));
}

TEST_F(ShaderParameters, StructsByTheirMembers) {
  write("made.osl",
        "struct Layer { color tint; float k[2]; };\nshader made(output Layer layer = {0, {0, 0}}) { layer.tint = "
        "color(.5, .25, 0); layer.k[1] = 2; }");
  write(
      "taken.osl",
      "struct Layer { color tint; float k[2]; };\nshader taken(Layer layer = {color(1, 0, 0), {1, 1}}, output color "
      "result = 0) { result = layer.tint * layer.k[1]; }");
  EXPECT_EQ(shown("Pattern \"taken\" \"n\"\n"), (Rgb{1, 0, 0}));
  EXPECT_EQ(shown("Pattern \"taken\" \"n\" \"color layer.tint\" [0 1 0] \"float[2] layer.k\" [0 .5]\n"),
            (Rgb{0, .5f, 0}));
  EXPECT_EQ(shown("Pattern \"made\" \"a\"\nPattern \"taken\" \"n\" \"reference struct layer\" [\"a:layer\"]\n"),
            (Rgb{1, .5f, 0}));
  EXPECT_EQ(shown("Pattern \"made\" \"a\"\nPattern \"taken\" \"n\" \"reference color layer.tint\" [\"a:layer.tint\"] "
                  "\"float[2] layer.k\" [0 1]\n"),
            (Rgb{.5f, .25f, 0}));
  complained("Pattern \"taken\" \"n\" \"float layer\" [1]\n", "PARAM-TYPE",
             {"taken.layer of 'n'", "struct", "layer.member"});
}

TEST_F(ShaderParameters, PartsFedOneByOne) {
  write("give.osl",
        "shader give(output color c = 0, output float x = 0, output float list[3] = {0, 0, 0}) { c = color(.125, "
        ".25, .5); x = "
        "2; list[2] = .75; }");
  write("take.osl",
        "shader take(color c = color(1, 1, 1), color many[2] = {color(4), color(8)}, float one = 0, output color "
        "result = 0) { "
        "result = c + many[0] + many[1] + one; }");
  const std::string give = "Pattern \"give\" \"g\"\n";
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\"\n"), (Rgb{13, 13, 13}));
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\" \"reference float c[1]\" [\"g:x\"]\n"), (Rgb{13, 14, 13}));
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\" \"reference color many[1]\" [\"g:c\"]\n"),
            (Rgb{5.125f, 5.25f, 5.5f}));
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\" \"reference color[2] many\" [\"\" \"g:x\"]\n"), (Rgb{7, 7, 7}));
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\" \"reference float one\" [\"g:c[2]\"]\n"),
            (Rgb{13.5f, 13.5f, 13.5f}));
  EXPECT_EQ(shown(give + "Pattern \"take\" \"n\" \"reference float one\" [\"g:list[2]\"]\n"),
            (Rgb{13.75f, 13.75f, 13.75f}));
  complained(give + "Pattern \"take\" \"n\" \"reference color many[2]\" [\"g:c\"]\n", "PARAM-TYPE",
             {"take.many[2]", "no part 2"});
  // a component goes to a plug-in too
  EXPECT_EQ(
      shown(give +
            "Pattern \"PxrExposure\" \"e\" \"color inputRGB\" [1 1 1] \"reference float stops\" [\"g:c[2]\"]\n" +
            "Pattern \"take\" \"n\" \"color c\" [0 0 0] \"color[2] many\" [0 0 0 0 0 0] \"reference float one\" "
            "[\"e:resultRGB\"]\n")[0],
      std::sqrt(2.f));
}

TEST_F(ShaderParameters, WhatDoesNotFitIsToldWithItsPlaceAndHasItsDefault) {
  write("typed.osl",
        R"(shader typed(float f = .25, color c = .25, int i = 0, string s = "", float three[3] = {0, 0, 0},
    output color result = 0) { result = f + c + i + three[0]; })");
  const Rgb standard{.5f, .5f, .5f};
  const std::string n = "Pattern \"typed\" \"n\" ";
  EXPECT_EQ(complained(n + "\"color f\" [1 1 1]\n", "PARAM-TYPE", {"typed.f of 'n'", "is a float", "a color"}),
            standard);
  EXPECT_EQ(complained(n + "\"string f\" [\"1\"]\n", "PARAM-TYPE", {"typed.f"}), standard);
  EXPECT_EQ(complained(n + "\"float i\" [1]\n", "PARAM-TYPE", {"typed.i", "is a int", "a float"}), standard);
  EXPECT_EQ(complained(n + "\"float s\" [1]\n", "PARAM-TYPE", {"typed.s", "is a string"}), standard);
  EXPECT_EQ(complained(n + "\"float[2] three\" [1 1]\n", "PARAM-TYPE", {"typed.three", "float[3]", "float[2]"}),
            standard);
  EXPECT_EQ(complained(n + "\"matrix c\" [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1]\n", "PARAM-TYPE", {"typed.c"}), standard);
  // connections
  write("gives.osl",
        "shader gives(output string text = \"\", output float x = 0, output float many[2] = {0, 0}, output matrix m "
        "= 1, output "
        "color c = 0) { text = \"t\"; x = 1; many[0] = 1; c = 1; }");
  const auto connected = [&](const std::string& parameter, const std::string& output) {
    return complained("Pattern \"gives\" \"g\"\n" + n + "\"reference " + parameter + "\" [\"g:" + output + "\"]\n",
                      "PARAM-CONNECTION", {"cannot feed", "typed."});
  };
  EXPECT_EQ(connected("float f", "text"), standard);
  EXPECT_EQ(connected("float f", "many"), standard);
  EXPECT_EQ(connected("color c", "m"), standard);
  EXPECT_EQ(connected("float f", "c"), standard);
  EXPECT_EQ(connected("int i", "x"), standard);
  EXPECT_EQ(connected("string s", "x"), standard);
  complained("Pattern \"gives\" \"g\"\n" + n + "\"reference float f\" [\"g:nothing\"]\n", "PARAM-CONNECTION",
             {"has no output 'nothing'"});
  SceneRender missing(requestOf("Pattern \"PxrOSL\" \"n\" \"string shader\" [\"missing\"]\n" + std::string(kShow)));
  EXPECT_EQ(told(missing, "PLUGIN-MISSING"), 1u);
  EXPECT_NE(missing.messages()[0].find("no shader 'missing' (node 'n')"), std::string::npos) << missing.messages()[0];
}

TEST_F(ShaderParameters, CirclesAreOpened) {
  write("add.osl", "shader add(color a = .25, color b = 0, output color result = 0) { result = a + b; }");
  const std::string circle =
      "Pattern \"add\" \"first\" \"reference color b\" [\"n:result\"]\n"
      "Pattern \"add\" \"n\" \"reference color b\" [\"first:result\"]\n";
  EXPECT_EQ(complained(circle, "RIB-CYCLE", {"reads it in turn"}), (Rgb{.5f, .5f, .5f}));
  // through a plug-in
  EXPECT_EQ(complained("Pattern \"PxrExposure\" \"first\" \"reference color inputRGB\" [\"n:result\"]\n"
                       "Pattern \"add\" \"n\" \"reference color b\" [\"first:resultRGB\"]\n",
                       "RIB-CYCLE", {"reads it in turn"}),
            (Rgb{.25f, .25f, .25f}));
}

TEST_F(ShaderParameters, WhatIsConnectedKnowsIt) {
  write("know.osl",
        "shader know(color a = 0, color b = 0, color c = 0, output color result = 0, output color unused = 0) { "
        "result = "
        "color(isconnected(a), isconnected(b), isconnected(c) + 4 * isconnected(result) + 16 * isconnected(unused)) "
        "+ 0 * (a + b "
        "+ c); }");
  write("zero.osl", "shader zero(output color result = 0) { result = 0; }");
  EXPECT_EQ(
      shown("Pattern \"zero\" \"z\"\nPattern \"PxrExposure\" \"e\"\n"
            "Pattern \"know\" \"n\" \"reference color a\" [\"z:result\"] \"reference color b\" [\"e:resultRGB\"]\n"),
      (Rgb{1, 1, 8}));
}

}  // namespace
}  // namespace kinora::tests
