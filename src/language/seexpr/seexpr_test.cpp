// Expressions in SeExpr's language, translated and run on the group machine at every width, against what C++ says of
// the same formulas; and what is refused, with its place. Misses: what PxrSeExpr's variables are at a surface, which
// tests/shaders shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>

#include "language/seexpr/translate.h"
#include "language/vm/test_runner.h"

namespace kinora::language {
namespace {
using namespace testing;

constexpr uint32_t kPoints = 300;

Answer answerOf(const std::string& expression, const std::vector<seexpr::Input>& inputs = {}) {
  const seexpr::Translation t = seexpr::translate(expression, inputs, "e");
  EXPECT_EQ(t.problem, "") << expression;
  if (!t.problem.empty()) return {};
  return runEverywhere(groupOf(t.source, {"resultF", "resultRGB"}));
}

using Vector = std::array<double, 3>;
// P at a point: x, y and z of the expressions below.
Vector placeOf(uint32_t i) {
  const double u = Points::uOf(i), v = Points::vOf(i);
  return {3 * u - 1, 2 * v, u * v};
}

struct Case {
  const char* expression;
  std::function<double(double x, double y, double z)> expected;
  double tolerance = 2e-5;
};

double linearstep(double x, double a, double b) {
  if (a == b) return x < a ? 0 : 1;
  return a < b ? std::clamp((x - a) / (b - a), 0., 1.) : 1 - std::clamp((x - b) / (a - b), 0., 1.);
}
double smoothstep(double x, double a, double b) {
  const double t = linearstep(x, a, b);
  return t * t * (3 - 2 * t);
}

const Case kCases[] = {
    {"$x = P[0]; $y = P[1]; $x + $y*2", [](double x, double y, double) { return x + 2 * y; }},
    {"# a comment\nx = P[0]; # another\nx *= 3; x -= 1; x", [](double x, double, double) { return 3 * x - 1; }},
    {"-P[1]^2", [](double, double y, double) { return -y * y; }},
    {"2^3^0.7", [](double, double, double) { return std::pow(2, std::pow(3, .7)); }},
    {"10 - 4 - 3", [](double, double, double) { return 3; }},
    {"1 + 2 * 3 % 4", [](double, double, double) { return 1 + 6 % 4; }},
    {"(P[0] - 9) % 2 + (P[0] + 4) % (0 - 3)",
     [](double x, double, double) {
       return x - 9 - 2 * std::floor((x - 9) / 2) + x + 4 + 3 * std::floor((x + 4) / -3);
     },
     1e-4},
    {"(P[1]*5) % 1", [](double, double y, double) { return std::fmod(y * 5, 1); }, 1e-4},
    {"P[0] < .5 && P[1] > .3 || P[2] > .9", [](double x, double y, double z) { return (x < .5 && y > .3) || z > .9; },
     0},
    {"!(P[0] < 0) + ~.25", [](double x, double, double) { return (x < 0 ? 0 : 1) + .75; }},
    {"P[0] > 0 ? P[1] > 1 ? 1 : 2 : 3", [](double x, double y, double) { return x > 0 ? y > 1 ? 1 : 2 : 3; }, 0},
    {"a = 1; if (P[0] > .5) { a = 2; if (P[1] > 1) { a += 10; } } else if (P[0] > 0) { a = 3; } a",
     [](double x, double y, double) { return x > .5  ? y > 1 ? 12 : 2
                                             : x > 0 ? 3
                                                     : 1; }, 0},
    {"if (P[0] > .5) { $c::a = [1,2,3]; } else { $c::a = P[1]; } $c::a[2]",
     [](double x, double y, double) { return x > .5 ? 3 : y; }},
    {"c = P; P = P * 10; c[0] + P[1]", [](double x, double y, double) { return x + 10 * y; }, 1e-4},
    {"a = P[0]; b = a; a = 5; b", [](double x, double, double) { return x; }},
    {"[1, 2, 3] -> length() -> max(P[0])", [](double x, double, double) { return std::max(std::sqrt(14.), x); }},
    {"P[0] + 1 -> clamp(0, 1)", [](double x, double, double) { return std::clamp(x + 1, 0., 1.); }},
    {"dot(P, [1, 2, 3]) + cross([1,0,0], P)[2]", [](double x, double y, double z) { return x + 2 * y + 3 * z + y; }},
    {"dist(P, [0,0,1]) * norm(P)[1]",
     [](double x, double y, double z) {
       return std::hypot(std::hypot(x, y), z - 1) * y / std::hypot(std::hypot(x, y), z);
     }},
    {"angle(P, [1,0,0])", [](double x, double y, double z) { return std::acos(x / std::hypot(std::hypot(x, y), z)); },
     1e-3},
    {"rotate(P, [0,0,2], PI/2)[0]", [](double, double y, double) { return -y; }},
    {"boxstep((P[1]*5)%1,0.4)", [](double, double y, double) { return std::fmod(float(y) * 5, 1) < .4 ? 0 : 1; }, 0},
    {"linearstep(P[0], .2, .8) + linearstep(P[0], .8, .2)", [](double, double, double) { return 1; }},
    {"smoothstep(P[0], 1.5, -.5)", [](double x, double, double) { return smoothstep(x, 1.5, -.5); }},
    {"gaussstep(P[0], 0, 1)",
     [](double x, double, double) { return x <= 0   ? 0
                                           : x >= 1 ? 1
                                                    : std::pow(2, -8 * (1 - x) * (1 - x)); }},
    {"remap(P[0], .5, .2, .4, 1)", [](double x, double, double) { return smoothstep(std::fabs(x - .5), .6, .2); }},
    {"compress(P[0], 2, 4) + expand(P[0], -1, 3) + fit(P[0], -1, 1, 5, 9) + invert(P[0])",
     [](double x, double, double) { return 2 * x + 2 + (x + 1) / 4 + 5 + 2 * (x + 1) + 1 - x; }},
    {"gamma(P[1], 2.5) + bias(P[1], .3)",
     [](double, double y, double) { return std::pow(y, .4) + std::pow(y, std::log(.3) / std::log(.5)); }, 1e-4},
    {"contrast(P[1] / 2, .8)",
     [](double, double y, double) {
       const double e = std::log(.2) / std::log(.5);
       return y < 1 ? .5 * std::pow(y, e) : 1 - .5 * std::pow(2 - y, e);
     },
     1e-4},
    {"mix(P, [1,1,1], .25)[1]", [](double, double y, double) { return y * .75 + .25; }},
    {"sin(P)[2] + cosd(P[0]*90) + atan2d(P[1], 1)",
     [](double x, double y, double z) {
       return std::sin(z) + std::cos(x * M_PI / 2) + std::atan2(y, 1) * 180 / M_PI;
     },
     1e-3},
    {"floor(P[0]*3) + ceil(P[1]) + round(P[2]) + abs(P[0])",
     [](double x, double y, double z) {
       return std::floor(float(x) * 3) + std::ceil(y) + std::round(z) + std::fabs(x);
     },
     1e-4},
    {"choose(P[1]/2, 10, 20, 30)", [](double, double y, double) { return y < 2. / 3   ? 10
                                                                         : y < 4. / 3 ? 20
                                                                                      : 30; },
     0},
    {"choose(P[1]/2, 10, [1,20,3])[1]", [](double, double y, double) { return y < 1 ? 10 : 20; }, 0},
    {"wchoose(P[1]/2, 10, 1, 20, 3)", [](double, double y, double) { return y < .5 ? 10 : 20; }, 0},
    {"cycle(P[0]*6, 3, 5)",
     [](double x, double, double) {
       const double i = std::floor(float(x) * 6);
       return 3 + i - 3 * std::floor(i / 3);
     },
     0},
    {"spline(P[1]/2, 0, 0, 1, 2, 2)",
     [](double, double y, double) {  // the middle knots of a Catmull-Rom spline
       const double k[5] = {0, 0, 1, 2, 2}, x = std::clamp(y / 2, 0., 1.) * 2;
       const int i = std::min(int(x), 1);
       const double t = x - i, a = k[i], b = k[i + 1], c = k[i + 2], d = k[i + 3];
       return .5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t * t * t);
     },
     1e-4},
    {"curve(P[1]/2, 1,4,1, 0,0,1, .5,2,0)",  // out of order: 0, .5, 1
     [](double, double y, double) { return y < 1   ? 2 * y
                                           : y < 2 ? 2
                                                   : 4; }, 1e-4},
    {"curve(P[1]/2, 0,0,4, .5,1,4, 1,1,4)",  // never above 1
     [](double, double y, double) {
       if (y >= 1) return 1.;
       const double t = y, m0 = 2, h = .5, s = 1 - t;
       return m0 * h * t * s * s + t * t * (3 - 2 * t);
     },
     1e-4},
    {"hsi([.2,.4,.6], 120, 1, 1)[0]", [](double, double, double) { return .6; }, 1e-4},
    {"saturate([.2,.4,.6], 0)[2]", [](double, double, double) { return .2126 * .2 + .7152 * .4 + .0722 * .6; }},
    {"hsltorgb(rgbtohsl([.2,.4,.6]))[1]", [](double, double, double) { return .4; }, 1e-4},
};

TEST(SeExpr, ExpressionsMeanWhatTheyMeanInC) {
  for (const Case& c : kCases) {
    const Answer a = answerOf(c.expression);
    if (a.values.empty()) continue;
    int wrong = 0;
    for (uint32_t i = 0; i < kPoints; ++i) {
      const Vector p = placeOf(i);
      const double expected = c.expected(p[0], p[1], p[2]);
      wrong += !(std::fabs(a.of("resultF", i) - expected) <= c.tolerance * (1 + std::fabs(expected)));
    }
    // rounding may put a point or two to the other side of a step
    EXPECT_LE(wrong, c.tolerance == 0 || c.tolerance >= 1e-4 ? 3 : 0) << c.expression;
  }
}

TEST(SeExpr, VectorsAreColours) {
  const Answer a = answerOf("P * [1, 2, 3] + .5");
  for (uint32_t i = 0; i < kPoints; ++i)
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(a.of("resultRGB." + std::to_string(k), i), placeOf(i)[size_t(k)] * (k + 1) + .5, 1e-5);
  const Answer number = answerOf("P[1]");
  EXPECT_EQ(number.of("resultRGB.2", 7), number.of("resultF", 7)) << "a number stands in all channels";
}

TEST(SeExpr, InputsMayHaveNamesOfFunctions) {
  const seexpr::Translation t =
      seexpr::translate("$c1*$mix + $c2*(1-$mix)", {{"mix"}, {"c1", true}, {"c2", true}, {"unused"}}, "e");
  EXPECT_EQ(t.problem, "");
  EXPECT_EQ(t.inputs, (std::vector<std::string>{"c1", "c2", "mix"}));
  const auto shader = shaderOf(t.source);
  for (const std::string& name : t.inputs) EXPECT_NE(shader->find(seexpr::parameterOf(name)), kNone) << name;
}

// Means and bounds of noises; sums of one octave are the noise itself.
TEST(SeExpr, Noises) {
  for (const char* expression :
       {"noise(P*3)", "noise(P[0],P[1])", "noise(P[0],P[1],P[2])", "noise(P[0],P[1],P[2],.5)", "cellnoise(P*9)",
        "fbm(P*4)", "hash(P[0], 7)", "rand()", "rand(0, 1, P)", "pnoise(P*5,[2,2,2])", "cnoise(P*3)[1]",
        "ccellnoise(P*9)[2]", "cfbm(P*4,3)[1]", "cvoronoi(P*4)[0]", "fbm4(P*4, .5)", "cturbulence(P)[0]*.5"}) {
    const Answer a = answerOf(expression);
    if (a.values.empty()) continue;
    double sum = 0, low = 9, high = -9;
    for (uint32_t i = 0; i < kPoints; ++i) {
      const double x = a.of("resultF", i);
      sum += x, low = std::fmin(low, x), high = std::fmax(high, x);
    }
    EXPECT_GE(low, -.1) << expression;
    EXPECT_LE(high, 1.1) << expression;
    EXPECT_GT(high - low, .1) << expression;
    EXPECT_NEAR(sum / kPoints, .5, .25) << expression;
  }
  for (const auto& [one, other] :
       {std::pair("fbm(P*3, 1)", "noise(P*3)"), std::pair("vfbm(P*3, 1)[2]", "vnoise(P*3)[2]"),
        std::pair("turbulence(P*3, 1)", ".5*abs(snoise(P*3))+.5"),
        std::pair("fbm(P*3, 2, 3, .25)", ".5*(snoise(P*3) + .25*snoise(P*9)) + .5"),
        std::pair("fbm4(P*3, .2, 1)", ".5*snoise4(P*3, .2)+.5"),
        std::pair("voronoi(P*5, 3)", "voronoi(P*5, 2) - voronoi(P*5, 1)"),
        std::pair("voronoi(P*5)", "dist(P*5, pvoronoi(P*5))")}) {
    const Answer a = answerOf(one), b = answerOf(other);
    if (a.values.empty() || b.values.empty()) continue;
    for (uint32_t i = 0; i < kPoints; i += 7) EXPECT_NEAR(a.of("resultF", i), b.of("resultF", i), 1e-5) << one;
  }
  // without jitter the points stand in the middle of unit cells
  const Answer a = answerOf("voronoi(P*2, 1, 0)");
  for (uint32_t i = 0; i < kPoints; ++i) {
    double square = 0;
    for (const double x : placeOf(i)) square += std::pow(2 * x - std::floor(2 * x) - .5, 2);
    EXPECT_NEAR(a.of("resultF", i), std::sqrt(square), 1e-4);
  }
}

TEST(SeExpr, WhatIsWrongIsToldWithItsPlace) {
  const struct {
    const char *expression, *says;
  } cases[] = {
      {"", "the result is missing"},
      {"a = 1;", "the result is missing"},
      {"1 +", "the end comes where a value is expected"},
      {"1 + + * 2", "'*' stands where a value is expected"},
      {"a = 1;\nb + 2", "2:1: there is no variable 'b'"},
      {"nosuch(1)", "there is no function 'nosuch'"},
      {"fbm(P, 1, 2, 3, 4)", "fbm() takes 1 to 4 arguments and gets 5"},
      {"sin()", "sin() takes 1 arguments and gets 0"},
      {"fbm(P, [1,2,3])", "argument 2 of fbm() is a number, not a vector"},
      {"[1,2]", "a vector has three components; this one has 2"},
      {"[P,1,2]", "a component of a vector is a number"},
      {"P[3]", "a vector has the components 0, 1 and 2"},
      {"if (P[0] > 1) { a = 1; } a", "there is no variable 'a'"},
      {"if (P[0] > 1) { a = 1; ", "'}' is missing"},
      {"\"text\"", "the result is a string"},
      {"1 + \"text\"", "a string stands where a number is expected"},
      {"\"open", "a string that never ends"},
      {"1 @ 2", "'@' means nothing here"},
      {"1e999", "no number that fits"},
      {"1 2", "'2' behind the result"},
      {"curve(P[0], 1, 2)", "takes 4 to 769 arguments and gets 3"},
      {"wchoose(P[0], 1, 2, 3, 4, 5)", "a value and a weight each time"},
      {"def FLOAT f(FLOAT x) { f(x) } f(1)", "functions of one's own"},
      {"x = x + 1; x", "there is no variable 'x'"},
      {"P[0] -> 3", "the name of a function is missing"},
      {"a ? 1", "':' is missing"},
  };
  for (const auto& c : cases) {
    const seexpr::Translation t = seexpr::translate(c.expression, {}, "e");
    EXPECT_NE(t.problem.find(c.says), std::string::npos) << c.expression << ": " << t.problem;
    EXPECT_EQ(t.source, "") << c.expression;
  }
}

TEST(SeExpr, LargeAndDeepOnesAreRefused) {
  const auto repeated = [](const std::string& s, int n) {
    std::string r;
    for (int i = 0; i < n; ++i) r += s;
    return r;
  };
  for (const std::string& expression :
       {repeated("(", 100000), repeated("(", 20000) + "1" + repeated(")", 20000), repeated("-", 60000) + "1",
        "1" + repeated("+1", 30000), "1" + repeated("^1", 20000), "P" + repeated("[0]", 20000),
        "1" + repeated("->sin()", 9000), "1" + repeated("->sin()", 151), repeated("a=1;", 15000) + "a",
        repeated("if(1){", 9000), "1?" + repeated("1?", 30000), "hash(" + repeated("1,", 30000) + "1)",
        "if(1){}" + repeated("else if(1){}", 5000) + "1", repeated("\n", 70000), repeated("[", 3000),
        "choose(" + repeated("1,", 3000) + "1)"}) {
    const seexpr::Translation t = seexpr::translate(expression, {}, "e");
    EXPECT_NE(t.problem, "") << expression.substr(0, 40);
    EXPECT_LT(t.problem.size(), 1000u);
  }
  EXPECT_EQ(seexpr::translate("1" + repeated("+1", 500), {}, "e").problem, "");
  EXPECT_EQ(seexpr::translate("1" + repeated("->sin()", 150), {}, "e").problem, "");
}

// Whatever text: an expression, or a message; and what is translated compiles.
TEST(SeExpr, RandomTextIsTranslatedOrRefused) {
  const std::vector<std::string> words = {
      "P",   "$a", "1",  "2.5", "(",  ")", "[",  "]",     ",",     "+",   "-",     "*",
      "/",   "^",  "?",  ":",   "->", "=", ";",  "if",    "else",  "{",   "}",     "sin",
      "fbm", "<",  "==", "&&",  "!",  "~", "%=", "noise", "curve", "mix", "\"s\"", "#\n"};
  uint32_t state = 12345, compiled = 0;
  const auto random = [&](uint32_t n) { return (state = state * 1664525u + 1013904223u) / 65536 % n; };
  for (int round = 0; round < 20000; ++round) {
    std::string text = round % 2 ? "a = P; " : "";
    for (uint32_t n = 1 + random(12); n > 0; --n) text += words[random(uint32_t(words.size()))] + " ";
    const seexpr::Translation t = seexpr::translate(text, {}, "e");
    ASSERT_NE(t.problem.empty(), t.source.empty()) << text;
    if (t.source.empty() || ++compiled % 8) continue;
    const CompileResult result = compile(t.source, "e.osl");
    ASSERT_TRUE(result.ok()) << text << "\n" << result.messages[0].str();
  }
  EXPECT_GT(compiled, 100u);
}

}  // namespace
}  // namespace kinora::language
