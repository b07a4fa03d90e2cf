// Each kind of message is shown once, with its count and the next places at the end; -v shows more, -q less.
#include "base/diagnostics.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

struct Printed {
  std::vector<std::string> lines;
  Diagnostics d{[this](const std::string& line, Severity) { lines.push_back(line); }};
  FileName file{"a.rib"};
  void say(Severity s, const char* code, uint32_t line) { d.report({s, code, {file, line}, "wrong", "", ""}); }
};

TEST(Diagnostics, EachKindIsShownOnceAndCounted) {
  Printed p;
  for (uint32_t i = 1; i <= 7; ++i) {
    p.say(Severity::Warning, "X-ONE", i);
    p.say(Severity::Error, "X-TWO", 9);
  }
  EXPECT_EQ(p.lines, (std::vector<std::string>{"a.rib:1: warning X-ONE: wrong", "a.rib:9: error X-TWO: wrong"}));
  p.lines.clear();
  p.d.summary();
  EXPECT_EQ(p.lines, (std::vector<std::string>{
                         "kinora: 6 more of X-ONE, at a.rib:2, a.rib:3, a.rib:4 ... (kinora explain X-ONE)",
                         "kinora: 6 more of X-TWO, at a.rib:9 ... (kinora explain X-TWO)"}));
  EXPECT_EQ(p.d.count("X-ONE"), 7u);
  EXPECT_EQ(p.d.errors(), 7u);
  p.lines.clear();
  p.d.summary();
  EXPECT_TRUE(p.lines.empty()) << "counts are given once";
}

TEST(Diagnostics, EachNameIsGivenOnce) {
  Printed p;
  const auto say = [&](const char* what, uint32_t line) {
    p.d.report({Severity::Warning, "X-ONE", {p.file, line}, what, "", ""});
  };
  say("no pattern 'Apple' (node 'a')", 1);
  for (uint32_t i = 2; i < 40; ++i) say(i % 2 ? "no pattern 'Pear' (node 'b')" : "no pattern 'Apple' (node 'c')", i);
  say("the wood's apples and the tree's 'Quince'", 50);
  p.lines.clear();
  p.d.summary();
  ASSERT_EQ(p.lines.size(), 1u);
  EXPECT_EQ(
      p.lines[0],
      "kinora: 39 more of X-ONE: 'Apple' at a.rib:2, 'Pear' at a.rib:3, 'Quince' at a.rib:50 ... (kinora explain "
      "X-ONE)");
}

TEST(Diagnostics, QuietAndVerbose) {
  Printed p;
  p.d.setShown(3);
  p.d.setQuiet(2);
  for (uint32_t i = 1; i <= 5; ++i) {
    p.say(Severity::Info, "X-INFO", i);
    p.say(Severity::Warning, "X-WARN", i);
    p.say(Severity::Error, "X-BAD", i);
  }
  EXPECT_EQ(p.lines.size(), 3u);
  p.d.summary();
  ASSERT_EQ(p.lines.size(), 4u);
  EXPECT_NE(p.lines[3].find("2 more of X-BAD"), std::string::npos) << p.lines[3];
}

TEST(Diagnostics, WhatIsDoneOnceMoreIsNotSaidAgain) {
  Printed p;
  p.say(Severity::Warning, "X-ONE", 1);
  p.d.setRepeating(true);
  p.say(Severity::Warning, "X-ONE", 1);
  p.say(Severity::Warning, "X-ONE", 2);  // elsewhere
  p.d.setRepeating(false);
  EXPECT_EQ(p.d.count("X-ONE"), 2u);
  p.say(Severity::Warning, "X-ONE", 1);
  EXPECT_EQ(p.d.count("X-ONE"), 3u);
}

// A million parameters say where they stand, and most stand in one file.
TEST(SourcePos, TakesEightBytesAndSharesNames) {
  static_assert(sizeof(SourcePos) == 8);
  const FileName a("a.rib"), again("a.rib"), b("b.rib");
  EXPECT_EQ(a, again);
  EXPECT_NE(a, b);
  EXPECT_EQ(&*a, &*again);
  EXPECT_EQ((SourcePos{b, 3}.str()), "b.rib:3");
  EXPECT_FALSE(SourcePos{}.file);
  EXPECT_EQ(SourcePos{}.str(), "");
  // no name is a name too: what has no file says so by having none
  EXPECT_TRUE(FileName(""));
}

}  // namespace
}  // namespace kinora
