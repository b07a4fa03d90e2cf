// What the intermediate form of a source looks like where that matters to those behind it; every form is also checked
// by invalid(). Misses: what the values are, which the programs of tests/language compare.
#include <gtest/gtest.h>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

void expectCode(const std::string& code, std::initializer_list<const char*> lines, const std::string& before = {}) {
  const Compiled c = statements(code, before);
  ASSERT_TRUE(c.result.ok()) << c.errors;
  size_t at = c.ir.find("main\n");
  for (const char* line : lines) {
    const size_t next = c.ir.find(line, at);
    EXPECT_NE(next, std::string::npos) << "missing, or not in this order: " << line << "\n" << c.ir;
    if (next == std::string::npos) return;
    at = next;
  }
}

const Symbol& symbolOf(const Compiled& c, const std::string& name) {
  static const Symbol kNothing;
  if (!c.result.ok()) return ADD_FAILURE() << c.errors, kNothing;
  const SymbolId id = c.result.shader->find(name);
  return id == kNone ? (ADD_FAILURE() << name << " is missing", kNothing) : c.result.shader->symbols[size_t(id)];
}

TEST(Lower, LiteralsAndTheirArithmeticAreConstants) {
  expectCode("f = -1.5;", {"assign f -1.5"});
  expectCode("c = -color(1, 2.5, -3);", {"assign c color{-1, -2.5, 3}"});
  expectCode("f = 2 * 3.5 - 1.0 / 4;", {"assign f 6.75"});
  expectCode("int i = 7 / 2 + (9 % 4) * (1 << 3);", {"assign ___1_i 11"});
  expectCode("f = 1.0 / 0;", {"assign f 0"});
  expectCode("int i = 0xffffffff; int j = -2147483648;", {"assign ___1_i -1", "assign ___2_j -2147483648"});
  expectCode("string s = \"a\\tb\" \"c\";", {"assign ___1_s \"a\\tbc\""});
}

TEST(Lower, ConstantsAreShared) {
  const Compiled c = statements("f = u * 2.0 + 2.0; f = f * 2.0 + 3.0; c = color(2.0); c = c * color(2.0);");
  size_t constants = 0;
  for (const Symbol& s : c.result.shader->symbols) constants += s.kind == SymbolKind::Constant;
  EXPECT_EQ(constants, 3u) << c.ir;
}

TEST(Lower, ParametersComeFirstWithTheirDefaults) {
  const Compiled c = compiled(
      "struct S { float a; color c; int k[2]; };\n"
      "shader t(float a = 1 [[ string label = \"A\", float range[2] = {0, 1} ]], color b = 0.5, point p = point(1, "
      "2, 3), matrix m = 2, int n = -3,\n"
      "  string s = \"x\", float r[3] = {1, 2}, float open[] = {4, 5}, S st = {1, {2, 3, 4}, {5, 6}}, float computed "
      "= a * 2,\n"
      "  float st_u = u [[ int lockgeom = 0 ]], output color result = b, closure color cl = 0) { }");
  ASSERT_TRUE(c.result.ok()) << c.errors;
  const std::vector<std::string> names = {"a",  "b",    "p",    "m",    "n",        "s",    "r",      "open",
                                          "st", "st.a", "st.c", "st.k", "computed", "st_u", "result", "cl"};
  for (size_t i = 0; i < names.size(); ++i) EXPECT_EQ(c.result.shader->symbols[i].name, names[i]);
  EXPECT_EQ(symbolOf(c, "a").values.floats, std::vector<float>{1});
  EXPECT_EQ(symbolOf(c, "a").metadata.size(), 2u);
  EXPECT_EQ(symbolOf(c, "a").metadata[1].values.floats, (std::vector<float>{0, 1}));
  EXPECT_EQ(symbolOf(c, "b").values.floats, (std::vector<float>{0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(symbolOf(c, "m").values.floats[5], 2);
  EXPECT_EQ(symbolOf(c, "n").values.ints, std::vector<int32_t>{-3});
  EXPECT_EQ(symbolOf(c, "r").values.floats, (std::vector<float>{1, 2, 0}));
  EXPECT_EQ(symbolOf(c, "open").type.arrayLength, -1);
  EXPECT_EQ(symbolOf(c, "open").values.floats, (std::vector<float>{4, 5}));
  EXPECT_EQ(symbolOf(c, "st.c").values.floats, (std::vector<float>{2, 3, 4}));
  EXPECT_EQ(symbolOf(c, "st.k").values.ints, (std::vector<int32_t>{5, 6}));
  EXPECT_EQ(symbolOf(c, "st.k").field, 2);
  EXPECT_TRUE(symbolOf(c, "computed").hasInitCode);
  EXPECT_FALSE(symbolOf(c, "computed").values.empty());
  EXPECT_FALSE(symbolOf(c, "st_u").lockGeometry);
  EXPECT_TRUE(symbolOf(c, "computed").lockGeometry);
  EXPECT_EQ(symbolOf(c, "result").kind, SymbolKind::OutputParam);
  ASSERT_EQ(c.result.shader->initialisers.size(), 3u);
  EXPECT_EQ(c.result.shader->symbols[size_t(c.result.shader->initialisers[0].parameter)].name, "computed");
}

TEST(Lower, KindsAndMetadataOfShaders) {
  EXPECT_EQ(compiled("shader t() { }").result.shader->kind, ShaderKind::Shader);
  EXPECT_EQ(compiled("surface t() { }").result.shader->kind, ShaderKind::Surface);
  EXPECT_EQ(compiled("displacement t() { P += N; }").result.shader->kind, ShaderKind::Displacement);
  EXPECT_EQ(compiled("volume t [[ string help = \"x\" ]] () { }").result.shader->metadata.size(), 1u);
}

TEST(Lower, GlobalsByShaderKind) {
  EXPECT_EQ(compiled("displacement t() { P += N; N = normalize(calculatenormal(P)); }").warnings, "");
  EXPECT_TRUE(compiled("surface t() { P = P + N; }").says("should not write 'P'"));
  EXPECT_TRUE(compiled("volume t() { vector x = N; }").says("have no 'N'"));
  EXPECT_TRUE(compiled("displacement t() { Ci = 0; }").says("have no 'Ci'"));
  EXPECT_EQ(compiled("shader t() { vector x = N + I + dPdu; P = P + N; N = -N; }").warnings, "");
  EXPECT_TRUE(compiled("shader t() { u = 3; }").says("should not write 'u'"));
  EXPECT_TRUE(compiled("surface t() { u = 3; }").says("should not write 'u'"));
}

TEST(Lower, ShortCircuits) {
  expectCode("if (u > 0 && v > 0) f = 1;", {"gt $tmp0 u 0", "gt $tmp2 v 0", "and $tmp1 $tmp0 $tmp2", "if $tmp1"});
  expectCode("if (u > 0 && noise(P) > 0.5) f = 1;", {"neq $tmp1 $tmp0 0", "if $tmp1", "  noise", "if $tmp1"});
  expectCode("if (u > 0 || exp(v) > 0.5) f = 1;", {"if $tmp1", "else", "  exp", "if $tmp1"});
  expectCode("string s = \"a\"; if (s) f = 1; if (c) f = 2;", {"neq $tmp0 ___1_s \"\"", "neq $tmp1 c 0", "if $tmp1"});
}

TEST(Lower, Ternaries) { expectCode("f = u > 0.5 ? v : exp(v);", {"if $tmp0", "assign f v", "else", "exp f v"}); }

TEST(Lower, Loops) {
  expectCode("for (int i = 0; i < 3; ++i) { if (i == 1) continue; f += i; }",
             {"for $tmp0", "init", "assign ___1_i 0", "condition", "lt $tmp0 ___1_i 3", "body", "eq", "if",
              "continue", "add f f", "step", "add ___1_i ___1_i 1"});
  expectCode("while (f < 3) { f += 1; break; }", {"while", "condition", "lt", "body", "add f f 1", "break"});
  expectCode("do { f += 1; } while (f < 3);", {"dowhile", "condition", "lt", "body", "add f f 1"});
  expectCode("for (;;) break;", {"for 1", "body", "break"});
}

TEST(Lower, ElementsAndComponents) {
  expectCode("float a[3] = {1, 2, 3}; a[1] = u; f = a[2];",
             {"arraycopy ___1_a float[3]{1, 2, 3}", "aassign ___1_a 1 u", "aref $tmp0 ___1_a 2", "assign f $tmp0"});
  expectCode("c[1] = u; c.b += 2; f = c.r;", {"compassign c 1 u", "compref $tmp0 c 2", "add $tmp1 $tmp0 2",
                                              "compassign c 2 $tmp1", "compref $tmp2 c 0"});
  expectCode("matrix m = 1; m[1][2] = u; f = m[3][0];",
             {"assign ___1_m", "mxcompassign ___1_m 1 2 u", "mxcompref $tmp0 ___1_m 3 0"});
  expectCode("color k[2]; k[1].g = u; k[0][2] *= 2;",
             {"aref $tmp0 ___1_k 1", "compassign $tmp0 1 u", "aassign ___1_k 1 $tmp0", "aref $tmp1 ___1_k 0",
              "compref $tmp2 $tmp1 2"});
  expectCode("f = (P + N)[1] + point(1, 2, 3).z;",
             {"add $tmp0 P N", "compref $tmp1 $tmp0 1", "compref $tmp2 point{1, 2, 3} 2"});
  expectCode("float a[3]; float b[5]; int n = arraylength(a); b = a;",
             {"assign ___3_n 3", "arraycopy ___2_b ___1_a"});
}

TEST(Lower, StructsAreTheirFields) {
  const std::string s = "struct In { float x; color c; }; struct Out { In in; float k; };\n";
  expectCode("Out o = {{1, c}, 2}; Out q = o; q.in.x = u; f = q.k;",
             {"assign ___1_o.in.x 1", "assign ___1_o.in.c c", "assign ___1_o.k 2", "assign ___2_q.in.x ___1_o.in.x",
              "assign ___2_q.k ___1_o.k", "assign ___2_q.in.x u", "assign f ___2_q.k"},
             s);
  expectCode("In a[4]; a[2].x = u; In b = a[1]; a[3] = b;",
             {"aassign ___1_a.x 2 u", "aref $tmp0.x ___1_a.x 1", "aref $tmp0.c ___1_a.c 1",
              "aassign ___1_a.x 3 ___2_b.x", "aassign ___1_a.c 3 ___2_b.c"},
             s);
  expectCode("In a = In(u, c); a = u > 0 ? a : In(1, color(2));",
             {"if", "assign $tmp", "else", "assign ___1_a.x $tmp"}, s);
}

TEST(Lower, FunctionsAreInlinedByReference) {
  expectCode("g(c, f);", {"mul f f 2", "compref", "add f f"},
             "void g(color k, output float r) { r *= 2; r += k[0]; }");
  expectCode("g(c[1]);", {"compref $tmp1 c 1", "assign $tmp0 $tmp1", "add $tmp0 $tmp0 1", "compassign c 1 $tmp0"},
             "void g(output float r) { r += 1; }");
  // an argument that the function writes for itself is a copy
  expectCode("g(f);", {"assign $tmp0 f", "add $tmp0 $tmp0 1"}, "void g(float r) { r += 1; }");
  expectCode("int i = 3; f = g(i);", {"assign ___1_i 3", "assign $tmp0 ___1_i", "mul"},
             "float g(float r) { return r * r; }");
  expectCode("float a[3]; g(a); int n = 0; n = h(a);", {"aassign ___1_a 1 2", "assign $tmp0 3", "assign ___2_n"},
             "void g(output float a[]) { a[1] = 2; } int h(float a[]) { return arraylength(a); }");
}

TEST(Lower, OnlyAReturnThatLeavesEarlyMakesABlock) {
  expectCode("f = g(u);", {"mul", "assign f"}, "float g(float x) { return x * x; }");
  EXPECT_FALSE(statements("f = g(u);", "float g(float x) { return x * x; }").has("functioncall"));
  EXPECT_FALSE(statements("f = g(u);", "float g(float x) { if (x > 0) return x; else return -x; }").has("return"));
  expectCode("f = g(u);", {"functioncall \"g\"", "if", "assign", "return", "assign"},
             "float g(float x) { if (x > 0) return x; return -x; }");
  EXPECT_FALSE(statements("f = 1; return;").has("return"));
  expectCode("if (u > 0) return; f = 1;", {"if", "return", "assign f 1"});
}

TEST(Lower, NestedFunctionsSeeWhatIsAroundThem) {
  expectCode("float k = 2; float g(float x) { return x * k; } f = g(u);",
             {"assign ___1_k 2", "mul $tmp0 u ___1_k", "assign f $tmp0"});
}

TEST(Lower, IncrementsAndAssignmentsAreValues) {
  expectCode("int i = 1; f = i++; f = ++i; f = i = 5;",
             {"assign $tmp0 ___1_i", "add ___1_i $tmp0 1", "assign f $tmp0", "add ___1_i ___1_i 1", "assign f ___1_i",
              "assign ___1_i 5", "assign f ___1_i"});
  expectCode("f = (u, v);", {"assign f v"});
}

TEST(Lower, Closures) {
  const Compiled c = compiled(
      "surface t(float k = 1) { closure color d = diffuse(N); Ci = k * d + emission() * 2 * color(1, 0, 0); Ci += "
      "mix(d, d, 0.5); closure color none; Ci = 0; }");
  ASSERT_TRUE(c.result.ok()) << c.errors;
  for (const char* s : {"closure ___1_d \"diffuse\" N", "mul $tmp0 ___1_d k", "closure $tmp1 \"emission\"",
                        "assign ___", "assign Ci 0"})
    EXPECT_TRUE(c.has(s)) << s << c.ir;
  // a closure of somebody's own header
  const Compiled own = compiled(
      "closure color glow(color c, float k) [[int builtin = 1]];\nsurface t() { Ci = glow(color(1), 2, \"label\", "
      "\"x\"); }");
  ASSERT_TRUE(own.result.ok()) << own.errors;
  EXPECT_TRUE(own.has("\"glow\" color{1, 1, 1} 2 \"label\" \"x\"")) << own.ir;
}

TEST(Lower, TheLibrary) {
  expectCode("vector w = faceforward(N, I);", {"faceforward ___1_w N I Ng"});
  expectCode(
      "point q = rotate(P, u, point(0), point(0, 0, 1));",
      {"sub $tmp0 point{0, 0, 1} point{0, 0, 0}", "sub $tmp1 P", "rotate $tmp2 $tmp1 u $tmp0", "add ___1_q $tmp2"});
  expectCode("string s = substr(\"hello\", 2);", {"strlen $tmp0 \"hello\"", "substr ___1_s \"hello\" 2 $tmp0"});
  expectCode(
      "vector w = transform(\"object\", I); normal n = transform(\"world\", \"object\", N); point q = "
      "transform(matrix(1), P);",
      {"transformv ___1_w \"object\" I", "transformn ___2_n", "transform ___3_q matrix"});
  expectCode("f = mod(u, 2); int i = mod(7, 3); c = fmod(c, 2);",
             {"floormod f u 2", "floormod ___1_i 7 3", "fmod c c 2"});
  expectCode("float s; float k; sincos(u, s, k); f = clamp(u, 0, 1);", {"sincos u ___1_s ___2_k", "clamp f u 0 1"});
  expectCode("matrix m; int ok = getmatrix(\"object\", m); ok = getattribute(\"a\", c);",
             {"getmatrix ___2_ok \"object\" ___1_m", "getattribute ___2_ok \"a\" c"});
  expectCode("string r[4]; int n = split(\"a b\", r); n = regex_match(\"a\", \"b\");",
             {"split ___2_n \"a b\" ___1_r", "regex_match ___2_n \"a\" \"b\""});
  expectCode("int ok = getattribute(\"a\", c[1]);",
             {"compref $tmp1 c 1", "assign $tmp0 $tmp1", "getattribute ___1_ok \"a\" $tmp0", "compassign c 1 $tmp0"});
  expectCode(
      "f = hypot(3, u); f = distance(P, point(0), point(1)); f = aastep(0.5, u); float kr; float kt; fresnel(I, N, "
      "1.5, kr, kt);",
      {"sqrt", "filterwidth", "dot"});
  expectCode(
      "f = spline(\"linear\", u, 0, 1, 2, 3); color k[4]; c = spline(\"bspline\", u, k); c = spline(\"bspline\", u, "
      "4, k);",
      {"spline f \"linear\" u 0 1 2 3", "spline c \"bspline\" u ___1_k", "spline c \"bspline\" u 4 ___1_k"});
}

TEST(Lower, TheLibraryDoesNotSeeTheShadersNames) {
  const Compiled c = compiled(
      "displacement t(float sqrt = 1, float N = 2, float clamp = 3) { bump(0.5); float x = distance(P, point(0), "
      "point(1)); }");
  ASSERT_TRUE(c.result.ok()) << c.errors;
  EXPECT_EQ(c.result.shader->find("N"), 1) << "the parameter";
  EXPECT_TRUE(c.has("normalize")) << c.ir;
}

TEST(Lower, HeadersOfOtherSystems) {
  const Compiled c = compiled(
      "#include \"color4.h\"\n#include \"vector2.h\"\n#include <vector4.h>\n#include \"color2.h\"\n"
      "shader t(color4 a = {color(1), 1}, vector2 st = {u, v}, output color4 r = {0, 0}) {\n"
      "  color4 b = a * 2 + color4(color(0.5), 1); r = mix(b, -a, 0.5); float d = dot(st, st / 2.0); vector4 q = "
      "vector4(1, 2, 3, 4) - 1; if (a == b) r = a;\n}");
  EXPECT_TRUE(c.result.ok()) << c.errors;
}

TEST(Lower, PositionsAreThoseOfTheSource) {
  const Compiled c =
      compiled("#define TWICE(x) (x + x)\nshader t(output float f = 0) {\n  f = TWICE(u);\n  f = hypot(u, v);\n}\n");
  ASSERT_TRUE(c.result.ok());
  for (const Instruction& i : c.result.shader->main.code) {
    EXPECT_TRUE(i.pos.str() == "t.osl:3" || i.pos.str() == "t.osl:4") << i.pos.str();
  }
}

TEST(Lower, WordsForOperators) { expectCode("int a = u > 0 and not (v > 1) or u == v;", {"and", "or"}); }

}  // namespace
}  // namespace kinora::language
