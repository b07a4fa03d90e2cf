// Which function a call means. Every function prints its number, so that the intermediate form tells.
#include <gtest/gtest.h>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

// The numbers that are printed, in the order of calls.
std::string chosen(const std::string& functions, const std::string& calls) {
  const Compiled c = compiled(functions + "\nshader t(output float result = 0) {\n" + calls + "\n}\n");
  EXPECT_TRUE(c.result.ok()) << c.errors;
  std::string out;
  for (size_t at = c.ir.find("printf \""); at != std::string::npos; at = c.ir.find("printf \"", at + 1))
    out += c.ir.substr(at + 8, c.ir.find('"', at + 8) - at - 8) + " ";
  return out;
}

std::string numbered(const std::vector<std::string>& heads) {
  std::string s = "struct A { float a; }; struct B { float b; };\n";
  for (size_t i = 0; i < heads.size(); ++i) {
    const std::string& h = heads[i];
    const std::string type = h.substr(0, h.find(' '));
    const std::string value = type == "void"               ? ""
                              : type == "string"           ? "return \"\";"
                              : type == "A" || type == "B" ? "return {1};"
                              : type == "closure"          ? "return emission();"
                                                           : "return 1;";
    s += h + " { printf(\"" + std::to_string(i + 1) + "\"); " + value + " }\n";
  }
  return s;
}

TEST(Overloads, ByArguments) {
  const std::string f = numbered({"void f(int x)", "void f(float x)", "void f(color x)", "void f(point x)",
                                  "void f(string x)", "void f(matrix x)"});
  EXPECT_EQ(chosen(f, "f(1); f(1.0); f(color(1)); f(P); f(\"\"); f(matrix(1));"), "1 2 3 4 5 6 ");
  EXPECT_EQ(chosen(f, "f(N); f(I);"), "4 4 ") << "normals and vectors are nearer to points than to colors";
  const std::string g = numbered({"void g(float x)", "void g(color x)"});
  EXPECT_EQ(chosen(g, "g(1); g(P);"), "1 2 ");
}

TEST(Overloads, SumsOverArguments) {
  const std::string f = numbered({"int f(float a, float b)", "int f(int a, float b)", "int f(int a, int b)"});
  EXPECT_EQ(chosen(f, "f(1, 1); f(1, 1.0); f(1.0, 1); f(1.0, 1.0);"), "3 2 1 1 ");
  const std::string e = numbered({"int e(int a, float b, color s)", "int e(float a, int b, vector v)"});
  EXPECT_EQ(chosen(e, "e(1, 1, color(0)); e(1, 1, vector(0)); e(1, 1, point(0));"), "1 2 2 ");
}

TEST(Overloads, ByResultWhereArgumentsDoNotDecide) {
  const std::string f = numbered({"int f()", "float f()", "color f()"});
  EXPECT_EQ(chosen(f, "(color) f(); (float) f(); (int) f(); color c = f(); float x; x = f(); c = f() * 2.0;"),
            "3 2 1 3 2 3 ");
  EXPECT_EQ(chosen(f + "void take(color c) { }\n color give() { return f(); }",
                   "take(color(f())); give(); int i = 1 ? f() : 2;"),
            "3 3 1 ");
}

TEST(Overloads, ByRankAtLast) {
  const std::vector<std::string> all = {"float",  "int",    "color",         "vector", "point", "normal",
                                        "matrix", "string", "closure color", "A",      "void"};
  for (size_t best = 0; best + 1 < all.size(); ++best) {
    std::vector<std::string> heads;
    for (size_t i = all.size(); i-- > best;) heads.push_back(all[i] + " f()");
    EXPECT_EQ(chosen(numbered(heads), "f();"), std::to_string(heads.size()) + " ") << all[best];
  }
  const Compiled c = compiled("float f() { return 1; } int f() { return 1; } shader t() { f(); }");
  EXPECT_TRUE(c.says("ambiguous call to 'f ()'")) << c.warnings;
}

TEST(Overloads, Lists) {
  const std::string f = numbered({"void f(A a, float b)", "void f(B b, int c)"});
  EXPECT_EQ(chosen(f, "f({1}, 1); f({1}, 1.0);"), "2 1 ");
  EXPECT_EQ(chosen(numbered({"void f(float a[], int n)", "void f(A a, float n)"}), "f({1, 2, 3}, 3); f({1}, 1.5);"),
            "1 2 ");
}

TEST(Overloads, Arrays) {
  const std::string f = numbered({"void f(float a[])", "void f(float a[3])", "void f(color a[])"});
  EXPECT_EQ(chosen(f, "float a[3]; float b[4]; color c[2]; f(a); f(b); f(c);"), "2 1 3 ");
}

TEST(Overloads, TheNearestScopeHidesTheSameSignature) {
  const std::string f = "void f(float x) { printf(\"1\"); }\n";
  EXPECT_EQ(
      chosen(f, "void f(float x) { printf(\"2\"); } f(1.0); { void f(int x) { printf(\"3\"); } f(1); f(1.0); }"),
      "2 3 2 ");
  EXPECT_EQ(
      chosen("float sin(float x) { printf(\"1\"); return x; }\n", "float a = sin(1.0); color c = sin(color(1));"),
      "1 ");
}

TEST(Overloads, TheLibrarysResultsFollowTheContext) {
  const Compiled c = compiled(
      "shader t() { color a = noise(P); float b = noise(P); vector d = noise(\"cell\", u, v); point e; e = "
      "cellnoise(u);\n"
      "normal n = 2 * snoise(P, time); color x = texture(\"a\", u, v); float y = texture(\"a\", u, v); "
      "printf(\"%f\", noise(u)); }");
  ASSERT_TRUE(c.result.ok()) << c.errors;
  for (const char* s : {"noise ___1_a P", "noise ___2_b P", "noise ___3_d \"cell\" u v", "cellnoise ___4_e u"})
    EXPECT_TRUE(c.has(s)) << s << "\n" << c.ir;
  std::map<std::string, Base> bases;
  for (const Symbol& s : c.result.shader->symbols) bases[s.name] = s.type.base;
  EXPECT_EQ(bases["$tmp0"], Base::Normal) << "the expected type reaches the operands";
  EXPECT_TRUE(c.says("ambiguous call to 'noise (float)'"));
}

TEST(Overloads, OperatorsOfStructs) {
  const std::string s =
      "struct V { float x; float y; };\n"
      "V __operator__add__(V a, V b) { printf(\"1\"); return V(a.x + b.x, a.y + b.y); }\n"
      "V __operator__mul__(V a, float b) { printf(\"2\"); return V(a.x * b, a.y * b); }\n"
      "V __operator__neg__(V a) { printf(\"3\"); return V(-a.x, -a.y); }\n"
      "int __operator__eq__(V a, V b) { printf(\"4\"); return a.x == b.x; }\n"
      "V __operator__sub__(V a, V b) { printf(\"5\"); return a + -b; }\n";
  EXPECT_EQ(
      chosen(
          s,
          "V a = {1, 2}; V b = a + a; b = a * 2; b = -a; int i = a == b; b += a; b = a - b; result = 1.0 + 2.0 * u;"),
      "1 2 3 4 1 5 3 1 ");
  EXPECT_FALSE(compiled(s + "shader t() { V a = {1, 2}; V b = a / a; }").result.ok());
}

}  // namespace
}  // namespace kinora::language
