// Source that is made to hurt: what explodes, nests or never ends is refused with one message, quickly and without
// overflowing the stack; large source that is honest compiles.
#include <gtest/gtest.h>

#include <ctime>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

std::string repeated(const std::string& s, size_t n) {
  std::string out;
  for (size_t i = 0; i < n; ++i) out += s;
  return out;
}

void expectRefused(const std::string& source, const std::string& message,
                   const std::map<std::string, std::string>& files = {}) {
  const Compiled c = compiled(source, files);
  EXPECT_FALSE(c.result.ok());
  EXPECT_TRUE(c.says(message)) << "missing: " << message << "\nin: " << c.errors.substr(0, 1000);
  size_t errors = 0;
  for (const CompileMessage& m : c.result.messages) errors += m.severity == Severity::Error;
  EXPECT_EQ(errors, 1u) << message;
}

TEST(Limits, ParenthesesInsideEachOther) {
  expectRefused("shader t() { float x = " + std::string(100000, '(') + "1" + std::string(100000, ')') + "; }",
                "nested too deeply");
  expectRefused("shader t() { float x = " + std::string(100000, '-') + "1; }", "nested too deeply");
  expectRefused("shader t() { float x = " + repeated("1 ? 2 : ", 100000) + "1; }", "nested too deeply");
  expectRefused("shader t() { float x; " + repeated("x = ", 100000) + "1; }", "nested too deeply");
  EXPECT_TRUE(
      compiled("shader t() { float x = " + std::string(60, '(') + "1" + std::string(60, ')') + "; }").result.ok());
}

TEST(Limits, StatementsInsideEachOther) {
  expectRefused("shader t() { " + std::string(100000, '{') + std::string(100000, '}') + " }", "nested too deeply");
  expectRefused("shader t() { " + repeated("if (1) ", 100000) + "; }", "nested too deeply");
  expectRefused("shader t() { if (1) ; " + repeated("else if (1) ; ", 100000) + "}", "nested too deeply");
  expectRefused("shader t() { float a[1] = " + std::string(100000, '{') + std::string(100000, '}') + "; }",
                "nested too deeply");
}

TEST(Limits, ALongChainIsATree) {
  EXPECT_TRUE(compiled("shader t() { float x = u" + repeated(" + u", 500) + "; }").result.ok());
  expectRefused("shader t() { float x = u" + repeated(" + u", 100000) + "; }", "nested too deeply");
  expectRefused("shader t() { float a[2]; float x = a" + repeated("[0]", 100000) + "; }", "nested too deeply");
  // which costs no more than its length
  const Compiled c = compiled("shader t() { float a[2]; float x = a" + repeated("[0]", 900) + "; }");
  EXPECT_TRUE(c.says("has no elements")) << c.errors;
}

TEST(Limits, MacrosThatExplode) {
  std::string source = "#define A0 1 + 1\n";
  for (int i = 1; i < 60; ++i)
    source += "#define A" + std::to_string(i) + " A" + std::to_string(i - 1) + " + A" + std::to_string(i - 1) + "\n";
  expectRefused(source + "shader t() { float x = A59; }", "macros expand to more");
  std::string nested = "#define F(x) x x\nshader t() { " + repeated("F(", 100) + "1" + repeated(")", 100) + " }";
  const Compiled c = compiled(nested);
  EXPECT_FALSE(c.result.ok());
  expectRefused("#define F(x) x\nshader t() { float a = " + repeated("F(", 1000) + "1" + repeated(")", 1000) + "; }",
                "nested too deeply");
  EXPECT_TRUE(compiled("#define X X + 1\nshader t() { float X = 1; }").says("expected"));  // not expanded for ever
}

TEST(Limits, IncludesThatIncludeThemselves) {
  expectRefused("#include \"a.h\"\nshader t() { }", "does \"a.h\" include itself?", {{"a.h", "#include \"a.h\"\n"}});
  // each of eleven files includes the next ten times
  std::map<std::string, std::string> files;
  for (int i = 0; i < 10; ++i)
    files["f" + std::to_string(i)] = repeated("#include \"f" + std::to_string(i + 1) + "\"\n", 10);
  files["f10"] = "\n";
  expectRefused("#include \"f0\"\nshader t() { }", "includes", files);
  EXPECT_TRUE(
      compiled("#include \"a.h\"\n#include \"a.h\"\nshader t() { f(); }", {{"a.h", "#pragma once\nvoid f() { }\n"}})
          .result.ok());
}

TEST(Limits, ConditionsOfThePreprocessor) {
  expectRefused("#if " + std::string(100000, '(') + "1\n#endif\nshader t() { }", "nested too deeply");
  expectRefused(repeated("#if 1\n", 100000) + "shader t() { }", "nested too deeply");
}

TEST(Limits, FunctionsThatInlineToTooMuch) {
  std::string source = "float f0(float x) { return x * x + 1; }\n";
  for (int i = 1; i < 40; ++i)
    source += "float f" + std::to_string(i) + "(float x) { return f" + std::to_string(i - 1) + "(x) + f" +
              std::to_string(i - 1) + "(x + 1); }\n";
  expectRefused(source + "shader t(output float r = 0) { r = f39(u); }", "too large");
  // a chain of calls nests as deep as it is long
  std::string chain = "float g0(float x) { return x; }\n";
  for (int i = 1; i < 5000; ++i)
    chain += "float g" + std::to_string(i) + "(float x) { return 1 + g" + std::to_string(i - 1) + "(x); }\n";
  expectRefused(chain + "shader t(output float r = 0) { r = g4999(u); }", "nested too deeply");
}

TEST(Limits, StructsOfStructs) {
  std::string source = "struct S0 { float a; float b; };\n";
  for (int i = 1; i < 40; ++i)
    source += "struct S" + std::to_string(i) + " { S" + std::to_string(i - 1) + " a; S" + std::to_string(i - 1) +
              " b; };\n";
  const Compiled c = compiled(source + "shader t() { S39 x; }");
  EXPECT_FALSE(c.result.ok());
  EXPECT_TRUE(c.says("holds too many values")) << c.errors.substr(0, 500);
}

TEST(Limits, CallsAndListsInsideEachOtherAreCheckedOnce) {
  const Compiled c =
      compiled("struct S { float a; };\nfloat f(S s) { return s.a; }\nshader t(output float r = 0) { r = " +
               repeated("f({", 40) + "1" + repeated("})", 40) + "; }");
  EXPECT_TRUE(c.result.ok()) << c.errors;
}

TEST(Limits, AHundredThousandLines) {
  std::string source = "shader t(output float r = 0) {\n";
  for (int i = 0; i < 100000; ++i) source += "  r = r * 0.5 + u;\n";
  const std::clock_t begin = std::clock();
  const Compiled c = compiled(source + "}\n");
  EXPECT_TRUE(c.result.ok()) << c.errors;
  EXPECT_LT(double(std::clock() - begin) / CLOCKS_PER_SEC, 20.0);
  ASSERT_TRUE(c.result.shader);
  EXPECT_EQ(c.result.shader->main.code.size(), 200000u);
}

TEST(Limits, WildBytes) {
  uint32_t state = 1;
  for (int i = 0; i < 300; ++i) {
    std::string source = i % 2 ? "shader t() { " : "";
    for (int n = 0; n < 400; ++n) {
      state = state * 1664525u + 1013904223u;
      source += i % 3 ? char(32 + (state >> 16) % 95) : char(state >> 20);
    }
    EXPECT_FALSE(compiled(source).errors.empty());
  }
}

}  // namespace
}  // namespace kinora::language
