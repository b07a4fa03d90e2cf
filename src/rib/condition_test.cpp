// The expressions of IfBegin and "$name" in strings.
#include "rib/condition.h"

#include <gtest/gtest.h>

namespace kinora::rib {
namespace {

std::optional<std::string> lookup(std::string_view n) {
  if (n == "user:pass") return "beauty";
  if (n == "Frame") return "12";
  if (n == "empty") return "";
  if (n == "tenth") return plainText(.1f);
  if (n == "third") return plainText(.3f);
  if (n == "colour") return plainText(1.f) + " " + plainText(.1f) + " " + plainText(3.f);
  if (n == "id") return plainText(1234567891);
  return std::nullopt;
}

TEST(Condition, Grammar) {
  const std::pair<const char*, bool> kCases[] = {{"1", true},
                                                 {"0", false},
                                                 {"$user:pass == 'beauty'", true},
                                                 {"${user:pass} != 'beauty'", false},
                                                 {"$Frame > 3 && $Frame <= 12", true},
                                                 {"$Frame < 3 || !defined(nothing)", true},
                                                 {"defined(user:pass)", true},
                                                 {"defined($Frame)", true},
                                                 {"defined('Frame')", true},
                                                 {"!defined(Frame)", false},
                                                 {"1 + 2 * 3 == 7", true},
                                                 {"(1 + 2) * 3 == 9", true},
                                                 {"2 ^ 3 ^ 2 == 512", true},
                                                 {"-2 + 3 == 1", true},
                                                 {"7 / 2 == 3.5", true},
                                                 {"'abc' < 'abd'", true},
                                                 {"10 > 9", true},
                                                 {"'beauty.01' =~ 'beauty\\.[0-9]+'", true},
                                                 {"'x' =~ '^y'", false},
                                                 {"concat('a', 'b', $Frame) == 'ab12'", true},
                                                 {"'pass $user:pass' == 'pass beauty'", true},
                                                 {"$empty == ''", true},
                                                 {"[1 0 0] == [1 0 0]", true},
                                                 // floats meet literals, whole numbers are exact
                                                 {"$tenth == .1 && $third <= .3 && $third >= .3", true},
                                                 {"$tenth + 0.2 == $third", true},
                                                 {"$third < .30001 && $third > .29999", true},
                                                 {"$id == 1234567891", true},
                                                 {"$id == 1234567890", false},
                                                 {"$colour == [1.0 .1 3.0]", true},
                                                 {"$colour == [1, 0.1, 3]", true},
                                                 {"$colour == [1 .1]", false},
                                                 {"$colour != [1 .1 3.1] && $colour < [1 .2 0]", true},
                                                 {"1 == 1 == 1", true},
                                                 {"!1 || 1", true},
                                                 {"0.002 > 1e-3", true},
                                                 {"1e+1 == 10 && 2e-1*5 == 1", true},
                                                 // sides that do not count
                                                 {"!defined(nothing) || $nothing == 1", true},
                                                 {"defined(nothing) && $nothing == 1", false},
                                                 {"defined(nothing) && ($nothing + 1 > 2 || 1 / 0)", false},
                                                 {"1 || 'a' + 1", true}};
  for (const auto& [text, expected] : kCases) {
    std::string problem;
    EXPECT_EQ(evaluateCondition(text, lookup, problem), expected) << text;
    EXPECT_EQ(problem, "") << text;
  }
}

TEST(Condition, MistakesAreFalseWithAReason) {
  const std::string deep(100000, '('), minus(100000, '-'), power = [] {
    std::string s = "1";
    for (int i = 0; i < 5000; ++i) s += "^1";
    return s;
  }();
  for (const std::string& text :
       {std::string(""), std::string("1 +"), std::string("(1"), std::string("$nothing == 1"), std::string("'open"),
        std::string("1 1"), std::string("'a' + 1"), std::string("1 / 0"), std::string("1 && $nothing"),
        std::string("0 || 1 / 0"), std::string("0 && (1"), std::string("'a' =~ '('"), deep, minus, power}) {
    std::string problem;
    EXPECT_FALSE(evaluateCondition(text, lookup, problem)) << text.substr(0, 40);
    EXPECT_NE(problem, "") << text.substr(0, 40);
  }
}

TEST(Condition, PatternsCannotStopTheReader) {
  std::string problem;
  evaluateCondition("'" + std::string(2000, 'a') + "' =~ '(a+)+(a+)+(a+)+b'", lookup, problem);
}

TEST(Substitution, NamesInStrings) {
  EXPECT_EQ(substitute("a/${user:pass}/x", '$', false, lookup), "a/beauty/x");
  EXPECT_EQ(substitute("a/$Frame.tif", '$', true, lookup), "a/12.tif");
  EXPECT_EQ(substitute("a/$Frame.tif", '$', false, lookup), "a/$Frame.tif");
  EXPECT_EQ(substitute("${none}$none$ ${", '$', true, lookup), "${none}$none$ ${");
  EXPECT_EQ(substitute("%Frame", '%', true, lookup), "12");
  EXPECT_EQ(substitute("a_${tenth}_${id}", '$', true, lookup), "a_0.1_1234567891");
}

TEST(Substitution, NumbersReadBackAsTheSame) {
  EXPECT_EQ(plainText(100000.f), "100000");
  EXPECT_EQ(plainText(1e-5f), "0.00001");
  EXPECT_EQ(plainText(16777216.f), "16777216");
  EXPECT_EQ(plainText(0.f), "0");
  for (const float v : {1.f / 3, -1e-30f, 3.4e38f, 123456.79f, 9.9999e-6f, 1e9f, 999999936.f})
    EXPECT_EQ(std::stof(plainText(v)), v) << plainText(v);
}

}  // namespace
}  // namespace kinora::rib
