// Proves: expressions (PxrSeExpr) and attributes (PxrAttribute) in scenes; their variables, connections both ways, and
// that broken expressions are told once and seen; elements of a plug-in's array are connected (PxrSwitch).
#include <cmath>
#include <memory>

#include "fixture.h"

namespace kinora::tests {
namespace {

constexpr const char* kShowRGB = "Bxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:resultRGB\"]\n";

std::string expression(const std::string& text, const std::string& more = "") {
  return "Pattern \"PxrSeExpr\" \"n\" \"string expression\" [\"" + text + "\"] " + more + "\n" + kShowRGB;
}

TEST_F(Shaders, ExpressionsKnowTheSurface) {
  SceneRender render(requestOf(expression("[s, t, objectId + (u - s) + (Nn[2] + 1) + (Cs[0] - Cs[1])]")));
  ASSERT_TRUE(render.ok());
  EXPECT_TRUE(render.messages().empty());
  const image::Image picture = render.channel("Ci");
  for (int y : {0, 7, 15})
    for (int x : {0, 5, 15}) {
      EXPECT_NEAR(picture.at(x, y)[0], (x + 0.5) / 16, 0.5 / 16 + 1e-5);
      EXPECT_NEAR(picture.at(x, y)[1], 1 - (y + 0.5) / 16, 0.5 / 16 + 1e-5);
    }
  // the square lies at z 1 and is 2 wide
  SceneRender place(requestOf(expression("[P[2], Pobj[2], P[0] - 2*s + 1]")));
  ASSERT_TRUE(place.ok());
  const auto c = middleOf(place);
  EXPECT_NEAR(c[0], 1, 1e-5);
  EXPECT_NEAR(c[1], 0, 1e-5);
  EXPECT_NEAR(c[2], 0, 1e-5);
}

TEST_F(Shaders, ExpressionsAreConnectedByName) {
  const auto expected = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [.25 .5 .75]\n");
  const std::string color =
      "Pattern \"PxrMix\" \"a\" \"color color1\" [.5 1 1.5] \"color color2\" [.5 1 1.5]\n"
      "Pattern \"PxrToFloat\" \"f\" \"reference color input\" [\"a:resultRGB\"]\n";
  EXPECT_EQ(filmOf(color + expression("$tint * $mix",
                                      "\"reference color tint\" [\"a:resultRGB\"] "
                                      "\"reference float mix\" [\"f:resultF\"]")),
            expected);
  EXPECT_EQ(filmOf(expression("colorInput2 / floatInput1",
                              "\"color colorInput2\" [1 2 3] \"float floatInput1\" [4] "
                              "\"float floatInput2\" [9] \"__instanceid\" [\"x\"]")),
            expected);
  // an expression feeds a pattern and an expression
  const std::string chain =
      "Pattern \"PxrSeExpr\" \"e\" \"string expression\" [\"[1,2,3]\"]\n"
      "Pattern \"PxrExposure\" \"half\" \"reference color inputRGB\" [\"e:resultRGB\"] \"float stops\" [-1]\n";
  EXPECT_EQ(filmOf(chain + expression("(x + y - y) * z",
                                      "\"reference color x\" [\"half:resultRGB\"] "
                                      "\"reference color y\" [\"e:resultRGB\"] "
                                      "\"float z\" [.5]")),
            expected);
}

TEST_F(Shaders, BrokenExpressionsAreToldAndSeen) {
  const std::string broken = "Pattern \"PxrSeExpr\" \"n\" \"string expression\" [\"a = 1;\\nb + a\"]\n";
  RenderRequest request = requestOf(broken + kShowRGB + "Sphere .1 -.1 .1 360\n" + broken + kShowRGB);
  SceneRender render(request);
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(told(render, "PATTERN-EXPRESSION"), 1u);
  EXPECT_NE(render.messages()[0].find("2:1: there is no variable 'b'"), std::string::npos) << render.messages()[0];
  EXPECT_EQ(middleOf(render), (std::array<float, 3>{1, 0, 1}));
  SceneRender none(requestOf(expression("")));
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(told(none, "PATTERN-EXPRESSION"), 1u);
}

TEST_F(Shaders, AttributesOfObjects) {
  const auto network = [](const std::string& type, const std::string& more) {
    return "Pattern \"PxrAttribute\" \"n\" \"string varname\" [\"user:dirt\"] \"string type\" [\"" + type + "\"] " +
           more + "\n" + kShowRGB;
  };
  const std::string has = "Attribute \"user\" \"color dirt\" [.25 .5 .75]\n";
  const auto expected = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [.25 .5 .75]\n");
  EXPECT_EQ(filmOf(has + network("color", "\"color defaultColor\" [9 9 9]")), expected);
  EXPECT_EQ(filmOf(network("color", "\"color defaultColor\" [.25 .5 .75]")), expected);
  const auto grey = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [3 3 3]\n");
  EXPECT_EQ(filmOf("Attribute \"user\" \"int dirt\" [3]\n" + network("int", "")), grey);
  EXPECT_EQ(filmOf("Attribute \"user\" \"float dirt\" [3]\n" + network("float", "\"float defaultFloat\" [1]")), grey);
  EXPECT_EQ(filmOf(network("float", "\"float defaultFloat\" [3]")), grey);
  EXPECT_EQ(filmOf(network("int", "\"int defaultInt\" [3]")), grey);
}

TEST_F(Shaders, ElementsOfArraysAreConnected) {
  const std::string colors =
      "Pattern \"PxrMix\" \"a\" \"color color1\" [9 9 9]\n"
      "Pattern \"PxrMix\" \"b\" \"color color1\" [.25 .5 .75]\n";
  const auto chosen = [&](const std::string& index) {
    return colors + "Pattern \"PxrSwitch\" \"n\" \"float index\" [" + index +
           "] \"reference color[2] inputsRGB\" [\"a:resultRGB\" \"b:resultRGB\"]\n" + kShowRGB;
  };
  const auto expected = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [.25 .5 .75]\n");
  EXPECT_EQ(filmOf(chosen("1")), expected);
  EXPECT_EQ(filmOf(chosen("3.2")), expected);
  EXPECT_NE(filmOf(chosen("0")), expected);
  EXPECT_EQ(filmOf("Pattern \"PxrSwitch\" \"n\" \"float index\" [1] \"color[2] inputsRGB\" [9 9 9 .25 .5 .75]\n" +
                   std::string(kShowRGB)),
            expected);
  // one by one, and with gaps: what is said counts there, else black
  const auto black = filmOf("Bxdf \"PxrConstant\" \"m\" \"color emitColor\" [0 0 0]\n");
  const auto some = [&](const std::string& index, const std::string& elements) {
    return filmOf(colors + "Pattern \"PxrSwitch\" \"n\" \"float index\" [" + index + "] " + elements + "\n" +
                  kShowRGB);
  };
  for (const char* elements : {"\"reference color[3] inputsRGB\" [\"a:resultRGB\" \"\" \"b:resultRGB\"]",
                               "\"reference color inputsRGB[0]\" [\"a:resultRGB\"] \"reference color inputsRGB[2]\" "
                               "[\"b:resultRGB\"]",
                               "\"reference color inputsRGB_2\" [\"b:resultRGB\"]"}) {
    EXPECT_EQ(some("2", elements), expected) << elements;
    EXPECT_EQ(some("1", elements), black) << elements;
  }
  EXPECT_EQ(some("1", "\"color[2] inputsRGB\" [9 9 9 .25 .5 .75] \"reference color inputsRGB[0]\" [\"a:resultRGB\"]"),
            expected);
  std::string many = colors + "Pattern \"PxrSwitch\" \"n\" \"reference color[17] inputsRGB\" [";
  for (int i = 0; i < 17; ++i) many += "\"b:resultRGB\" ";
  SceneRender render(requestOf(many + "]\n" + kShowRGB));
  ASSERT_TRUE(render.ok());
  EXPECT_EQ(told(render, "PARAM-TYPE"), 1u);
  EXPECT_FLOAT_EQ(middleOf(render)[1], 0.5f);
}

// A number that stands for no choice is told with the parameter's and the node's name, and is the default.
TEST_F(Shaders, NumbersThatAreNoChoiceAreToldAndTheDefault) {
  const auto blended = [](const std::string& operation) {
    return "Pattern \"PxrBlend\" \"n\" " + operation +
           " \"color topRGB\" [.25 .5 .75] \"color bottomRGB\" [.5 .5 .5]\n" + std::string(kShowRGB);
  };
  const auto expected = filmOf(blended(""));
  EXPECT_NE(filmOf(blended("\"int operation\" [18]")), expected);
  for (const char* wrong : {"\"int operation\" [99]", "\"int operation\" [-1]", "\"int operation\" [27]"}) {
    SceneRender render(requestOf(blended(wrong)));
    ASSERT_TRUE(render.ok()) << wrong;
    EXPECT_EQ(told(render, "PARAM-CHOICE"), 1u) << wrong;
    EXPECT_EQ(stateOf(render.film()), expected) << wrong;
    for (const std::string& m : render.messages()) {
      EXPECT_NE(m.find("PxrBlend.operation of 'n'"), std::string::npos) << m;
      EXPECT_NE(m.find(".rib:"), std::string::npos) << m;
    }
  }
}

TEST_F(Shaders, TeesShowInChannels) {
  const auto render = [&](const std::string& channel, const std::string& network) {
    RenderRequest r = requestOf(network);
    r.rib.insert(r.rib.find("WorldBegin"), "DisplayChannel \"" + channel + "\"\n");
    r.channels = "Ci,a,shown";
    return std::make_unique<SceneRender>(r);
  };
  const std::string color = "Pattern \"PxrMix\" \"a\" \"color color1\" [.25 .5 .75]\n";
  auto triple =
      render("color shown",
             color +
                 "Pattern \"PxrTee\" \"n\" \"reference color inputRGB\" [\"a:resultRGB\"] \"string aov\" "
                 "[\"shown\"]\n" +
                 "Pattern \"PxrExposure\" \"e\" \"reference color inputRGB\" [\"n:resultRGB\"] \"float stops\" [1]\n"
                 "Bxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"e:resultRGB\"]\n");
  ASSERT_TRUE(triple->ok());
  EXPECT_TRUE(triple->messages().empty()) << triple->messages()[0];
  EXPECT_FLOAT_EQ(triple->channel("shown").at(8, 8)[2], 0.75f);
  EXPECT_FLOAT_EQ(middleOf(*triple)[2], 1.5f);
  auto number = render("float shown",
                       "Pattern \"PxrTee\" \"n\" \"float inputF\" [.25] \"string aov\" [\"shown\"]\n"
                       "Bxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:resultF\"]\n");
  ASSERT_TRUE(number->ok());
  EXPECT_FLOAT_EQ(number->channel("shown").at(8, 8)[0], 0.25f);
  auto none = render("color shown", kShowRGB);
  EXPECT_EQ(told(*none, "DISPLAY-SOURCE"), 1u);
}

// Attribute and texture multiply, either counts alone; both ways to name the node; what is switched off is black.
TEST_F(Shaders, MattesOfObjectsShowInTheirChannels) {
  const auto shown = [&](const std::string& attribute, const std::string& network, size_t messages = 0) {
    RenderRequest r = requestOf(network);
    r.rib.insert(r.rib.find("WorldBegin"),
                 "DisplayChannel \"color MatteID0\"\nDisplayChannel \"color third\" "
                 "\"string source\" [\"color MatteID3\"]\n");
    r.rib.insert(r.rib.find("WorldBegin") + 10, "\n" + attribute);
    r.channels = "Ci,a,MatteID0,third";
    SceneRender render(r);
    EXPECT_TRUE(render.ok()) << network;
    EXPECT_EQ(render.messages().size(), messages) << (render.messages().empty() ? "" : render.messages()[0]);
    std::array<float, 6> c{};
    for (size_t k = 0; k < 3; ++k) {
      c[k] = render.channel("MatteID0").at(8, 8)[k];
      c[3 + k] = render.channel("third").at(8, 8)[k];
    }
    return c;
  };
  using Two = std::array<float, 6>;
  const std::string red = "Attribute \"user\" \"color MatteID0\" [1 .5 0]\n";
  const std::string surface = "Bxdf \"PxrSurface\" \"m\" \"reference int[1] utilityPattern\" [\"n:resultAOV\"]\n",
                    disney = "Bxdf \"PxrDisneyBsdf\" \"m\" \"reference int inputAOV\" [\"n:resultAOV\"]\n";
  for (const std::string& material : {surface, disney}) {
    EXPECT_EQ(shown(red, "Pattern \"PxrMatteID\" \"n\"\n" + material), (Two{1, .5f, 0, 0, 0, 0}));
    EXPECT_EQ(shown(red,
                    "Pattern \"PxrMatteID\" \"n\" \"color matteTexture0\" [.5 .5 1] \"color matteTexture3\" "
                    "[0 .25 1]\n" +
                        material),
              (Two{.5f, .25f, 0, 0, .25f, 1}));
  }
  const std::string black = "Pattern \"PxrMix\" \"a\" \"color color1\" [0 0 0]\nPattern \"PxrMatteID\" \"n\" ";
  EXPECT_EQ(shown(red, black + "\"reference color matteTexture0\" [\"a:resultRGB\"]\n" + surface), Two{})
      << "a texture that is connected counts where it is black";
  EXPECT_EQ(shown("", black + "\"color matteTexture0\" [.5 .5 1]\n" + surface), (Two{.5f, .5f, 1, 0, 0, 0}));
  EXPECT_EQ(shown(red, black + "\"int enable\" [0]\n" + surface), Two{});
  // two nodes, one named by the other or both by the material
  const std::string other = "Pattern \"PxrMatteID\" \"o\" \"color matteTexture3\" [.25 .5 1]\n";
  EXPECT_EQ(shown("", other + "Pattern \"PxrExposure\" \"n\"\nBxdf \"PxrSurface\" \"m\" \"reference int[2] "
                              "utilityPattern\" [\"n:resultRGB\" \"o:resultAOV\"]\n"),
            (Two{0, 0, 0, .25f, .5f, 1}));
  EXPECT_EQ(shown("", other + "Pattern \"PxrGeometricAOVs\" \"n\" \"reference int inputAOV\" [\"o:resultAOV\"]\n" +
                          surface),
            (Two{0, 0, 0, .25f, .5f, 1}));
  // a node that is not there: told, and so are the channels
  EXPECT_EQ(shown(red, "Bxdf \"PxrSurface\" \"m\" \"reference int[1] utilityPattern\" [\"n:nothing\"]\n", 2), Two{});
}

class ShaderSlopes : public Shaders {
 protected:
  // The normal that a bump makes of heights, over a square that is 2 wide. more: parameters of the bump.
  std::array<float, 3> bumpedNormal(const std::string& patterns, const std::string& heights,
                                    const std::string& more = "") {
    RenderRequest r =
        requestOf(patterns + "Pattern \"PxrBump\" \"n\" \"reference float inputBump\" [\"" + heights + "\"] " + more +
                  "\nBxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:resultN\"]\n");
    const size_t polygon = r.rib.find("Polygon");
    r.rib = r.rib.substr(0, polygon) + "Patch \"bilinear\" \"P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    return middleOf(render);
  }
  // That of heights which rise by so much a unit; the camera looks along z.
  static void expectAlong(const std::array<float, 3>& n, float dx, float dy, float tolerance) {
    const float l = std::sqrt(dx * dx + dy * dy + 1);
    EXPECT_NEAR(n[0], -dx / l, tolerance);
    EXPECT_NEAR(n[1], -dy / l, tolerance);
    EXPECT_NEAR(n[2], -1 / l, tolerance);
  }
};

// Heights of a shader have slopes: h rises by .9 along u and falls by .45 along v, over a square that is 2 wide.
TEST_F(ShaderSlopes, ABumpTakesTheSlopesOfAShader) {
  write("hills.osl", "shader hills(output float result = 0) { result = .9 * u - .45 * v; }");
  const auto normal = [&](const std::string& more) {
    return bumpedNormal("Pattern \"hills\" \"h\"\n", "h:result", more);
  };
  expectAlong(normal(""), .45f, -.225f, 1e-4f);
  expectAlong(normal("\"float scale\" [2] \"int invertT\" [0]"), .9f, -.45f, 1e-4f);
  expectAlong(normal("\"float scale\" [2] \"int reverse\" [1]"), -.9f, .45f, 1e-4f);
  expectAlong(normal("\"int disable\" [1]"), 0, 0, 1e-4f);
}

// Shaders and plug-ins in one network: heights have slopes wherever the plug-in stands. u rises by 1/2 a unit.
TEST_F(ShaderSlopes, ABumpTakesTheSlopesOfANetworkOfBoth) {
  write("half.osl", "shader half(float x = 0, output float result = 0) { result = x / 2; }");
  write("slope.osl", "shader slope(output float result = 0) { result = .9 * u - .45 * v; }");
  const std::string u = "Pattern \"PxrVariable\" \"x\" \"string variable\" [\"u\"]\n";
  expectAlong(bumpedNormal(u + "Pattern \"half\" \"h\" \"reference float x\" [\"x:resultR\"]\n", "h:result"), .25f, 0,
              1e-3f);
  expectAlong(bumpedNormal("Pattern \"slope\" \"s\"\nPattern \"PxrToFloat3\" \"x\" \"reference float input\" "
                           "[\"s:result\"]\n",
                           "x:resultRGB"),
              .45f, -.225f, 1e-3f);
}

}  // namespace
}  // namespace kinora::tests
