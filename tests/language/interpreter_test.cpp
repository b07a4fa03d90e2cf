// The oracle itself: programs whose values follow by hand or from the reference, derivatives against differences.
#include <gtest/gtest.h>

#include <cmath>

#include "language/front/compile.h"
#include "language/interpreter.h"

namespace kinora::oracle {
namespace {

Cells numbers(std::initializer_list<double> list) {
  Cells c;
  for (const double v : list) c.numbers.push_back({double(float(v)), 0, 0});
  return c;
}

struct Ran {
  double f = 0;
  Dual dual;
  std::vector<Dual> c;
  std::string printed;
};

Ran ran(const std::string& code, double u = 0.3, double v = 0.7, const std::string& before = {}) {
  const language::CompileResult r =
      language::compile(before + "\nshader t(output float f = 0, output color c = 0) {\n" + code + "\n}\n", "t.osl");
  EXPECT_TRUE(r.ok()) << (r.messages.empty() ? "" : r.messages[0].str());
  if (!r.ok()) return {};
  Interpreter i(*r.shader);
  Cells du = numbers({u}), dv = numbers({v}), p = numbers({u, v, u * v});
  du.numbers[0].dx = 1;
  dv.numbers[0].dy = 1;
  p.numbers[0].dx = 1, p.numbers[1].dy = 1, p.numbers[2].dx = v, p.numbers[2].dy = u;
  i.given = {{"u", du}, {"v", dv}, {"P", p}, {"N", numbers({0, 0, 1})}};
  EXPECT_EQ(i.run(), "") << code;
  return {i.of("f").numbers[0].v, i.of("f").numbers[0], i.of("c").numbers, i.printed()};
}

TEST(Interpreter, Values) {
  EXPECT_EQ(ran("f = 7 / 2 + 7 % 4 * (1 << 3) + (6 ^ 3) + ~0;").f, 3 + 24 + 5 - 1);
  EXPECT_EQ(ran("f = 1.0 / (u - u) + 5 / (int)(u);").f, 0);
  EXPECT_EQ(ran("for (int i = 0; i < 5; ++i) { if (i == 1) continue; if (i == 4) break; f += i; }").f, 5);
  EXPECT_EQ(ran("int n = 0; do { f += 2; n++; } while (n < 3); while (f > 3) f -= 1;").f, 3);
  EXPECT_EQ(ran("f = g(4) + g(-4);", 0, 0, "float g(float x) { if (x > 0) return x; return x * -2; }").f, 12);
  EXPECT_EQ(ran("h(c[1]); f = c.g;", 0, 0, "void h(output float x) { x += 3; }").f, 3);
  EXPECT_EQ(ran("float a[3] = {1, 2, 3}; a[1] *= 5; f = a[0] + a[1] + a[arraylength(a) - 1] + a[99];").f,
            1 + 10 + 3 + 3);
  EXPECT_EQ(ran("S s[2] = {{1, color(2)}, {3, color(4)}}; S k = s[1]; k.c[2] = 9; s[0] = k; f = s[0].a + s[0].c.b + "
                "s[1].c.b;",
                0, 0, "struct S { float a; color c; };")
                .f,
            3 + 9 + 4);
  EXPECT_EQ(ran("f = mod(-16, 7) * 100 + mod(-16.0, 7.0) * 10 + fmod(-16, 7);").f, -2 * 100 + 50 - 2);
  EXPECT_EQ(ran("matrix m = matrix(2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 1, 1, 1, 1); point p = transform(m, point(1, "
                "2, 3)); f = p[0] * 100 + p[1] * 10 + p[2];")
                .f,
            300 + 70 + 13);
  EXPECT_EQ(ran("matrix m = matrix(2, 1, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 1, 1, 1, 1); matrix e = m / m; f = e == 1 ? "
                "determinant(m) : -1;")
                .f,
            24);
  EXPECT_EQ(ran("string s = concat(\"ab\", \"cde\"); f = strlen(s) + getchar(s, 1) + stoi(\" -12x\") + (substr(s, "
                "-2) == \"de\") * 1000;")
                .f,
            5 + 98 - 12 + 1000);
  EXPECT_EQ(ran("printf(\"%d %g %s|%.1f\", 3, 0.5, \"x\", color(1, 2, 3));").printed, "3 0.5 x|1.0 2.0 3.0");
  EXPECT_EQ(ran("f = u > 0 && v < 1 || exp(u) > 100 ? 3 : 4;").f, 3);
}

TEST(Interpreter, Library) {
  EXPECT_NEAR(ran("f = pow(2, 10) + sqrt(16) + exp(0) + log(1) + sin(0) + atan2(0, 1);").f, 1024 + 4 + 1, 1e-3);
  EXPECT_EQ(ran("f = sqrt(-1) + inversesqrt(0) + pow(0, 3) + acos(2);").f, 0);
  EXPECT_EQ(ran("f = smoothstep(0, 1, 0.5) + linearstep(0, 4, 1) + step(1, 1) + clamp(5, 0, 2) + mix(0, 10, 0.3) + "
                "select(1, 2, 1);")
                .f,
            double(0.5f + 0.25f + 1 + 2 + 3 + 2));
  EXPECT_NEAR(ran("vector r = rotate(vector(1, 0, 0), M_PI_2, vector(0, 0, 5)); f = r[1];").f, 1, 1e-6);
  EXPECT_NEAR(ran("vector r = reflect(vector(1, -1, 0), vector(0, 1, 0)); f = r[0] * 10 + r[1];").f, 11, 1e-6);
  EXPECT_NEAR(
      ran("f = length(normalize(vector(3, 4, 0))) + distance(point(0), point(3, 4, 0)) + dot(P, vector(0));").f, 6,
      1e-6);
}

// Noise vanishes on the lattice; the cell noise of a cell is one value; hash of floats is of their bits.
TEST(Interpreter, Noise) {
  EXPECT_EQ(ran("f = snoise(3.0) + snoise(1.0, 2.0) + snoise(point(1, 2, 3)) + snoise(point(1, 2, 3), 4);").f, 0);
  EXPECT_EQ(ran("f = noise(point(5, 6, 7));").f, 0.5);
  EXPECT_EQ(ran("f = cellnoise(1.2) == cellnoise(1.9) && cellnoise(1.2) != cellnoise(2.1);").f, 1);
  EXPECT_EQ(ran("f = hashnoise(1.2) == hashnoise(1.2) && hashnoise(1.2) != hashnoise(1.25);").f, 1);
  const Ran r = ran("c = snoise(P * 3); f = snoise(P * 3);");
  EXPECT_EQ(r.c[0].v, r.f) << "the first component is the float noise";
}

TEST(Interpreter, DerivativesAreThoseOfDifferences) {
  for (const char* code :
       {"f = u * v / (u + 2);", "f = sin(u * 3) * exp(v);", "f = pow(u + 1, v * 2);", "f = sqrt(u * u + v * v);",
        "f = snoise(P * 2);", "f = noise(u * 5);", "f = snoise(u * 3, v * 3);", "f = snoise(P, u);",
        "f = smoothstep(0, 1, u * v);", "f = mix(u, v, u * v);", "vector n = normalize(P + vector(1)); f = n[1];",
        "f = mod(u * 7, 2) + fmod(v * 9, 2);", "float a[2] = {u, v}; f = a[0] * a[1];",
        "f = spline(\"catmull-rom\", u, 0, 1, v, 2, 5);", "f = log(u + v) + atan(u * v) + acos(u);",
        "f = refract(normalize(P), vector(0, 0, 1), 0.7)[0];"}) {
    constexpr double h = 1.0 / 512;
    const Ran at = ran(code);
    EXPECT_NEAR(at.dual.dx, (ran(code, 0.3 + h).f - ran(code, 0.3 - h).f) / (2 * h),
                5e-3 * (1 + std::fabs(at.dual.dx)))
        << code;
    EXPECT_NEAR(at.dual.dy, (ran(code, 0.3, 0.7 + h).f - ran(code, 0.3, 0.7 - h).f) / (2 * h),
                5e-3 * (1 + std::fabs(at.dual.dy)))
        << code;
  }
  EXPECT_EQ(ran("f = Dx(floor(u) + u) + Dy(v * 2) * 10;").f, 21);
  EXPECT_EQ(ran("f = filterwidth(u * 3);").f, 3);
}

TEST(Interpreter, GivesUpWhereItKnowsNothing) {
  const language::CompileResult r =
      language::compile("shader t(output float f = 0) { f = trace(P, N); while (1) f += 1; }", "t.osl");
  Interpreter i(*r.shader);
  EXPECT_EQ(i.run(), "operation trace is not interpreted");
  const language::CompileResult endless =
      language::compile("shader t(output float f = 0) { while (1) f += 1; }", "t.osl");
  Interpreter e(*endless.shader);
  e.instructionLimit = 1000;
  EXPECT_EQ(e.run(), "too many instructions");
  const language::CompileResult empty =
      language::compile("shader t(output float f = 0) { do { } while (1); }", "t.osl");
  Interpreter n(*empty.shader);
  n.instructionLimit = 1000;
  EXPECT_EQ(n.run(), "too many instructions");
}

}  // namespace
}  // namespace kinora::oracle
