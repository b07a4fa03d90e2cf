// Programs in the language itself, through the front end: what they give, at every width, block and number of points
// with the same bits, optimised or not; derivatives against finite differences of the same program. Values expected
// are computed here by C++ that shares no code with the kernels, within the stated tolerance of the language's own
// approximations.
#include <functional>

#include "language/vm/test_runner.h"

namespace kinora::language {
namespace {
using namespace testing;

struct Case {
  const char* name;
  const char* body;  // of shader test(output float r = 0)
  double (*expected)(double u, double v);
  double tolerance;
};
std::string shaderWith(const std::string& body, const std::string& parameters = "output float r = 0") {
  return "shader test(" + parameters + ") {\n" + body + "\n}\n";
}

const Case kCases[] = {
    {"sin", "r = sin(3*u);", [](double u, double) { return std::sin(3 * u); }, 1e-5},
    {"pow", "r = pow(u + 0.5, v * 3);", [](double u, double v) { return std::pow(u + 0.5, v * 3); }, 1e-4},
    {"exp log", "r = log(exp(u) + v);", [](double u, double v) { return std::log(std::exp(u) + v); }, 1e-4},
    {"int arithmetic",
     "int i = int(u * 20); int j = int(v * 7) - 3; r = i / j + i % j * 10 + (i << 2) - (i & 5) + (i ^ j);",
     [](double u, double v) {
       const int i = int(float(u) * 20), j = int(float(v) * 7) - 3;
       return double((j ? i / j : 0) + (j ? i % j : 0) * 10 + (i << 2) - (i & 5) + (i ^ j));
     },
     0},
    {"division by zero", "float z = u > 2 ? 1 : 0; r = u / z + 3;", [](double, double) { return 3.0; }, 0},
    {"ternary", "r = u > v ? u * 2 : v * 3;", [](double u, double v) { return u > v ? u * 2 : v * 3; }, 1e-6},
    {"while", "float x = u + 0.1; int n = 0; while (x < 10) { x *= 1.5 + v; n++; if (n > 20) break; } r = n;",
     [](double u, double v) {
       float x = float(u) + 0.1f;
       int n = 0;
       while (x < 10) {
         x *= 1.5f + float(v);
         if (++n > 20) break;
       }
       return double(n);
     },
     0},
    {"do while", "int n = 0; do { n += 2; if (n > u * 10) continue; r += 1; } while (n < v * 30);",
     [](double u, double v) {
       int n = 0, r = 0;
       do {
         n += 2;
         if (n > float(u) * 10) continue;
         ++r;
       } while (n < float(v) * 30);
       return double(r);
     },
     0},
    {"nested loops",
     "for (int i = 0; i < 5; i++) { for (int j = 0; j < 5; j++) { if (j > u * 5) break; if (i > v * 5) continue; r "
     "+= i * j; } }",
     [](double u, double v) {
       int r = 0;
       for (int i = 0; i < 5; i++)
         for (int j = 0; j < 5; j++) {
           if (j > float(u) * 5) break;
           if (i > float(v) * 5) continue;
           r += i * j;
         }
       return double(r);
     },
     0},
    {"function with early returns",
     "float f(float x, float y) { if (x > 0.7) return 1; for (int i = 0; i < 4; i++) { if (i * 0.3 > y) return i; } "
     "return 9; }\n r = f(u, v) * 2;",
     [](double u, double v) {
       const auto f = [](float x, float y) {
         if (x > 0.7f) return 1;
         for (int i = 0; i < 4; i++)
           if (i * 0.3f > y) return i;
         return 9;
       };
       return 2.0 * f(float(u), float(v));
     },
     0},
    {"exit", "r = 1; if (u > 0.5) { r = 5; exit(); } r += v > 0.5 ? 1 : 2;",
     [](double u, double v) { return u > 0.5   ? 5.0
                                     : v > 0.5 ? 2.0
                                               : 3.0; }, 0},
    {"arrays",
     "float a[4] = {1, 2, 3, 4}; int i = int(u * 4); a[i] = v; r = a[0] + 10 * a[1] + 100 * a[2] + 1000 * a[3] + "
     "a[(i + 1) % 4];",
     [](double u, double v) {
       float a[4] = {1, 2, 3, 4};
       const int i = int(float(u) * 4);
       a[i] = float(v);
       return double(a[0] + 10 * a[1] + 100 * a[2] + 1000 * a[3] + a[(i + 1) % 4]);
     },
     1e-3},
    {"components",
     "color c = color(u, v, 0.5); int k = int(u * 3); c[k] = 7; r = c[0] + 10 * c[1] + 100 * c[2] + c[(k + 1) % 3];",
     [](double u, double v) {
       float c[3] = {float(u), float(v), 0.5f};
       const int k = int(float(u) * 3);
       c[k] = 7;
       return double(c[0] + 10 * c[1] + 100 * c[2] + c[(k + 1) % 3]);
     },
     1e-4},
    {"geometry", "r = dot(normalize(vector(u + 1, v, 2)), cross(vector(1, v, 0), vector(0, 1, u))) + length(P);",
     [](double u, double v) {
       const double l = std::sqrt((u + 1) * (u + 1) + v * v + 4);
       const double cx = v * u, cy = -u, cz = 1;
       const double x = 3 * u - 1, y = 2 * v, z = u * v;
       return ((u + 1) * cx + v * cy + 2 * cz) / l + std::sqrt(x * x + y * y + z * z);
     },
     1e-5},
    {"matrix",
     "matrix m = matrix(1,0,0,0, 0,2,0,0, 0,0,4,0, u,v,1,1); point p = transform(m, P); point q = transform(1 / m, "
     "p); r = p[0] + 3 * p[1] + distance(q, P) + determinant(m) + m[3][1];",
     [](double u, double v) { return (3 * u - 1 + u) + 3 * (4 * v + v) + 8 + v; }, 1e-4},
    {"smoothstep mix clamp",
     "r = mix(smoothstep(0.2, 0.8, u), clamp(v * 2, 0.3, 0.9), 0.25) + step(0.5, u) + max(u, v) - min(u, v);",
     [](double u, double v) {
       const double t = std::clamp((u - 0.2) / 0.6, 0.0, 1.0), s = t * t * (3 - 2 * t);
       return s * 0.75 + std::clamp(v * 2, 0.3, 0.9) * 0.25 + (u < 0.5 ? 0 : 1) + std::max(u, v) - std::min(u, v);
     },
     1e-5},
    {"string selection", "string s = u > 0.5 ? \"long name\" : \"x\"; r = strlen(s) + (s == \"x\") * 100;",
     [](double u, double) { return u > 0.5 ? 9.0 : 101.0; }, 0},
    {"spline", "r = spline(\"linear\", u, 0, 0, v, 1, 1);",
     [](double u, double v) {
       u = std::clamp(u, 0.0, 1.0);
       return u < 0.5 ? 2 * u * v : v + (2 * u - 1) * (1 - v);
     },
     1e-5},
    {"struct",
     "struct S { float a; vector b; }; S s; s.a = u; s.b = vector(v, 2, 3); S t = s; t.b[1] += u; r = t.a + t.b[0] + "
     "t.b[1];",
     [](double u, double v) { return u + v + 2 + u; }, 1e-5},
    {"messages",
     "float x = 5; r = getmessage(\"b\", x) * 100; setmessage(\"a\", u); if (v > 0.5) setmessage(\"a\", v); r += "
     "getmessage(\"a\", x) * 10 + x; setmessage(\"b\", v); r += getmessage(\"b\", x) * 1000;",
     [](double u, double) { return 10 + u; }, 1e-5},
    {"conditional message", "float x = 5; if (v > 0.5) setmessage(\"a\", u); r = getmessage(\"a\", x) * 10 + x;",
     [](double u, double v) { return v > 0.5 ? 10 + u : 5; }, 1e-5},
    {"formats",
     "string s = format(\"%d|%g|%s\", 3, 0.5, u > 0.5 ? \"aa\" : \"b\"); r = strlen(s) + 100 * stoi(substr(s, 0, 1)) "
     "+ stof(\"0.25\") + startswith(s, \"3|\") * 10;",
     [](double u, double) { return (u > 0.5 ? 8 : 7) + 300 + 0.25 + 10; }, 0},
    {"split and regex",
     "string parts[4]; int n = split(\"a,bb,ccc\", parts, \",\"); int at[2]; r = n * 100 + strlen(parts[2]) * 10 + "
     "regex_search(parts[1], at, \"b+\") + at[1];",
     [](double, double) { return 300 + 30 + 1 + 2.0; }, 0},
    {"unset locals are zero", "float x; if (u > 2) x = 1; r = x;", [](double, double) { return 0.0; }, 0},
    {"spaces that nobody knows", "point p = transform(\"nowhere\", P); r = p[0] - P[0];",
     [](double, double) { return 0.0; }, 0},
    {"unsupported", "r = 3; int at[1]; r += pointcloud_search(\"x\", P, 1, 1, \"index\", at);",
     [](double, double) { return 3.0; }, 0},
    {"printed noise bounds", "r = noise(P * 4) >= 0 && noise(\"perlin\", P * 4) <= 1;",
     [](double, double) { return 1.0; }, 0},
};

TEST(LanguagePrograms, GiveWhatTheirTextSays) {
  for (const Case& c : kCases) {
    const Answer a = runEverywhere(groupOf(shaderWith(c.body), {"r"}));
    if (a.values.empty()) continue;
    for (uint32_t i = 0; i < 300; ++i) {
      const double expected = c.expected(Points::uOf(i), Points::vOf(i));
      if (!(std::abs(a.of("r", i) - expected) <= c.tolerance * std::max(1.0, std::abs(expected)))) {
        ADD_FAILURE() << c.name << ": point " << i << " gives " << a.of("r", i) << " instead of " << expected;
        break;
      }
    }
  }
}

// r is smooth in u and v away from a few points
const char* const kSmooth[] = {
    "r = u * v + u / (v + 1) - 3 * u;",
    "r = sin(u * 3) * cos(v * 2) + exp(u * v);",
    "r = pow(u + 0.5, 1.5 + v);",
    "r = sqrt(u + 1) + log(v + 2) + 1 / (u + 0.5);",
    "r = asin(u * 0.9) + atan(v * 3) + acos(v * 0.5);",
    "r = tanh(u) + sinh(v) + cosh(u);",
    "r = length(P) + distance(P, point(1, 2, 3));",
    "vector n = normalize(vector(P)); r = n[0] * 2 + n[1] + dot(n, vector(u, v, 1));",
    "r = noise(P * 1.7);",
    "r = noise(\"simplex\", P * 1.3);",
    "color c = noise(u * 3, v * 2); r = c[0] + c[1] * 2 - c[2];",
    "r = noise(P, u * 4);",
    "r = spline(\"catmull-rom\", u * 0.5 + 0.2, 0, 0.3, v, 1, 0.4);",
    "float f(float x) { return x * x; } r = f(u) + f(v + f(u));",
    "float a[3]; a[0] = u; a[1] = u * v; a[2] = v; for (int i = 0; i < 3; i++) r += a[i] * a[i];",
    "float x = u; for (int i = 0; i < 3; i++) x = x * x + v; r = x;",
    "if (u > 0.5) r = u * u; else r = u * v;",
    "r = mix(u * u, v * v, u * v) + smoothstep(-1, 3, u + v);",
    "point p = transform(matrix(1,2,0,0, 0,1,0,0, 0,0,1,0, 3,4,5,1), P); r = p[0] * p[1];",
    "r = mod(u * 0.9, 5) + fmod(v, 7);",
    "color c = transformc(\"rgb\", \"XYZ\", color(u, v, 0.3)); r = luminance(c) + c[1];",
    "r = reflect(vector(u, v, 1), normalize(vector(1, 2, 3)))[0] + refract(normalize(vector(u, v, -2)), vector(0, 0, "
    "1), 0.7)[1];",
};

TEST(LanguagePrograms, DerivativesAgreeWithDifferences) {
  constexpr float h = 1.f / 512;
  for (const char* body : kSmooth) {
    const auto group = groupOf(shaderWith(std::string(body) + "\n dx = Dx(r); dy = Dy(r);",
                                          "output float r = 0, output float dx = 0, output float dy = 0"),
                               {"r", "dx", "dy"});
    const Answer a = runEverywhere(group);
    std::string error;
    const auto program = compileGroup(group, {}, error);
    if (!program) continue;
    const Answer right = runOn(*program, group, Points(300, h, 0)), left = runOn(*program, group, Points(300, -h, 0));
    const Answer up = runOn(*program, group, Points(300, 0, h)), down = runOn(*program, group, Points(300, 0, -h));
    int bad = 0;
    for (uint32_t i = 0; i < 300; ++i) {
      const float dx = (right.of("r", i) - left.of("r", i)) / (2 * h) * Points::kStep,
                  dy = (up.of("r", i) - down.of("r", i)) / (2 * h) * Points::kStep;
      const float scale = Points::kStep * (0.02f * (1 + std::abs(dx) / Points::kStep));
      if (std::abs(dx - a.of("dx", i)) > scale || std::abs(dy - a.of("dy", i)) > scale) ++bad;
    }
    // a kink may lie between the two points of a difference
    EXPECT_LE(bad, 24) << body;
  }
}

TEST(LanguagePrograms, UnusedDerivativesAreNotCarried) {
  const auto plain = groupOf(shaderWith("r = noise(P * 3) * u;"), {"r"});
  const auto dual = groupOf(shaderWith("r = Dx(noise(P * 3) * u);"), {"r"});
  std::string error;
  EXPECT_LT(compileGroup(plain, {}, error)->slotCount(), compileGroup(dual, {}, error)->slotCount());
}

TEST(LanguagePrograms, MessagesComeInTheOrderOfPoints) {
  const Answer a = runEverywhere(
      groupOf(shaderWith("if (u < 0.1) printf(\"a %g\\n\", u); if (v < 0.05) printf(\"b %d\\n\", 3);"), {"r"}));
  std::vector<std::string> expected;
  for (uint32_t i = 0; i < 300; ++i) {
    char line[64];
    std::snprintf(line, sizeof line, "a %g\n", double(Points::uOf(i)));
    if (Points::uOf(i) < 0.1f) expected.push_back(line);
    if (Points::vOf(i) < 0.05f) expected.push_back("b 3\n");
  }
  EXPECT_EQ(a.messages, expected);
}

TEST(LanguagePrograms, BadIndicesAreClampedAndToldOnce) {
  const Answer a = runEverywhere(groupOf(shaderWith("float a[3] = {1, 2, 3}; r = a[int(u * 10) - 2];"), {"r"}));
  ASSERT_EQ(a.messages.size(), 1u);
  EXPECT_EQ(a.messages[0],
            "Index [-2] out of range a[0..2]: test.osl:2 (group unnamed_group, layer 0 layer, shader test)");
  for (uint32_t i = 0; i < 300; ++i)
    EXPECT_EQ(a.of("r", i), float(std::clamp(int(Points::uOf(i) * 10) - 2, 0, 2) + 1));
}

TEST(LanguagePrograms, EndlessLoopsStopWithAMessage) {
  for (const char* body :
       {"while (1) r += 1;", "while (u > -1) r += 1;", "int i = 0; for (;;) { i++; if (u > 2) break; } r = i;"}) {
    const auto group = groupOf(shaderWith(body), {"r"});
    MachineOptions options;
    options.iterationLimit = 1000;
    std::string error;
    const auto program = compileGroup(group, options, error);
    ASSERT_TRUE(program) << error;
    const Answer a = runOn(*program, group, Points(64));
    ASSERT_EQ(a.messages.size(), 1u) << body;
    EXPECT_NE(a.messages[0].find("1000 turns"), std::string::npos);
  }
}

// Each of these loops stays within its own limit.
TEST(LanguagePrograms, EndlessLoopsInLoopsStopWithAMessage) {
  const auto group = groupOf(shaderWith("for (;;) { int i = 0; while (i < 900) i++; r += i; }"), {"r"});
  MachineOptions options;
  options.iterationLimit = 1000;
  std::string error;
  const auto program = compileGroup(group, options, error);
  ASSERT_TRUE(program) << error;
  const Answer a = runOn(*program, group, Points(64));
  ASSERT_FALSE(a.messages.empty());
  EXPECT_NE(a.messages[0].find("loops inside each other were stopped after 16000 turns"), std::string::npos)
      << a.messages[0];
  const auto deep = groupOf(shaderWith("do do do do r += 1; while (1); while (1); while (1); while (1);"), {"r"});
  const auto endless = compileGroup(deep, options, error);
  ASSERT_TRUE(endless) << error;
  EXPECT_FALSE(runOn(*endless, deep, Points(8)).messages.empty());
}

}  // namespace
}  // namespace kinora::language
