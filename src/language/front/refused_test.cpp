// Programs that must be refused, one file a family in tests/language/refused: "==== what", the messages as "//!
// LINE:COLUMN text", the source. Each message is compared whole, and nothing else may be said: a second message would
// be a cascade. Misses: limits on sizes, which are made by code in limits_test.cpp.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

struct Case {
  std::string file, name, messages, source;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const auto& e :
       std::filesystem::directory_iterator(std::string(KINORA_SOURCE_DIR) + "/tests/language/refused")) {
    std::ifstream in(e.path());
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("==== "))
        all.push_back({e.path().filename().string(), line.substr(5), {}, {}});
      else if (all.empty())
        ADD_FAILURE() << e.path() << " does not begin with a case";
      else if (line.starts_with("//! "))
        all.back().messages += line.substr(4) + "\n";
      else
        all.back().source += line + "\n";
    }
  }
  return all;
}

TEST(Refused, EachProgramForItsReasonAtItsPlace) {
  const std::vector<Case> all = cases();
  ASSERT_GE(all.size(), 140u);
  for (const Case& c : all) {
    const Compiled r = compiled(c.source);
    EXPECT_FALSE(r.result.ok()) << c.file << ": " << c.name;
    EXPECT_FALSE(c.messages.empty()) << c.file << ": " << c.name;
    EXPECT_EQ(r.errors, c.messages) << c.file << ": " << c.name;
  }
}

TEST(Refused, AMessageShowsTheLineWithACaret) {
  const Compiled r = compiled("shader t() {\n  float x = yy + 1;\n}\n");
  ASSERT_EQ(r.result.messages.size(), 1u);
  EXPECT_EQ(r.result.messages[0].str(),
            "t.osl:2: error: 'yy' is not declared\n"
            "  2:13 |   float x = yy + 1;\n"
            "       |             ^");
}

TEST(Refused, ALongLineIsShownInPart) {
  const Compiled r = compiled("shader t() { float a = 1" + std::string(500, ' ') + "+ yy; }\n");
  ASSERT_EQ(r.result.messages.size(), 1u);
  const std::string s = r.result.messages[0].str();
  EXPECT_LT(s.size(), 500u);
  const size_t caret = s.rfind('^') - s.rfind('\n'), line = s.rfind('\n') - s.rfind('\n', s.rfind('\n') - 1);
  EXPECT_LT(caret, line) << "the caret stands below the line";
  EXPECT_EQ(s[s.rfind('\n', s.rfind('\n') - 1) + caret], 'y') << s;
}

TEST(Refused, MessagesNameTheFileTheyAreIn) {
  const Compiled r = compiled("#include \"b.h\"\nshader t() { f(); }\n", {{"b.h", "void f() { nothing(); }\n"}});
  ASSERT_EQ(r.result.messages.size(), 1u);
  EXPECT_EQ(r.result.messages[0].pos.str(), "b.h:1");
}

TEST(Refused, ControlCharactersDoNotReachTheTerminal) {
  const Compiled r = compiled("shader t() { float x = \"\x1b[31m\" + 1; }\n");
  ASSERT_EQ(r.result.messages.size(), 1u);
  EXPECT_EQ(r.result.messages[0].str().find('\x1b'), std::string::npos);
}

TEST(Refused, WarningsAreErrorsWhenAsked) {
  CompileOptions options;
  EXPECT_TRUE(compiled("shader t() { int i = 1.5; }").result.ok());
  EXPECT_EQ(compiled("shader t() { int i = 1.5; }").warnings, "1:22 assignment may lose precision: int = float\n");
  options.warningsAreErrors = true;
  EXPECT_EQ(compiled("shader t() { int i = 1.5; }", {}, options).errors,
            "1:22 assignment may lose precision: int = float\n");
  options = {};
  options.withWarnings = false;
  EXPECT_EQ(compiled("shader t() { int i = 1.5; }", {}, options).warnings, "");
}

TEST(Refused, WhatIsHardlyMeantIsAWarning) {
  EXPECT_EQ(compiled("shader t() {\n  color c = (1, 2, 3);\n}").warnings,
            "2:14 a comma in parentheses gives the last value alone; color(...) or {...} is meant?\n");
  EXPECT_EQ(compiled("shader t() {\n  color c = 2 * (1, 2, 3);\n}").warnings,
            "2:18 a comma in parentheses gives the last value alone; color(...) or {...} is meant?\n");
  EXPECT_EQ(compiled("point abs(point p) { return p; }\nshader t() { }").warnings,
            "1:7 function 'abs' takes the place of the library's\n");
  EXPECT_EQ(compiled("float hypot(float a, float b) { return a; }\nshader t() { }").warnings,
            "1:7 function 'hypot' takes the place of the library's\n");
  EXPECT_EQ(compiled("string concat(string a, string b) { return a; }\nshader t() { }").warnings,
            "1:8 function 'concat' takes the place of the library's\n");
  // other arguments, or the body of another function: nothing is replaced
  EXPECT_EQ(compiled("int abs(string s) { return 1; }\nvoid f() { float sin(float x) { return x; } }\nshader t() { }")
                .warnings,
            "");
}

TEST(Refused, AfterFiftyErrorsItStops) {
  std::string source = "shader t() {\n";
  for (int i = 0; i < 200; ++i) source += "  string s" + std::to_string(i) + " = 1;\n";
  const Compiled r = compiled(source + "}\n");
  EXPECT_EQ(r.result.messages.size(), 51u);
  EXPECT_EQ(r.result.messages.back().text, "too many errors; stopped");
}

}  // namespace
}  // namespace kinora::language
