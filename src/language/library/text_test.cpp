// Proves text.h, string_hash.h, regex.h and dictionary.h: formats against the C library's output where the rules
// agree and against written-out strings where they differ, conversions at their limits, the hash against published
// values, expressions that would take forever, dictionaries that are none.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "language/library/dictionary.h"
#include "language/library/noise_name.h"
#include "language/library/regex.h"
#include "language/library/string_hash.h"
#include "language/library/text.h"

namespace kinora::language {
namespace {
using Kind = FormatArgument::Kind;
std::string text(std::string_view format, std::vector<FormatArgument> arguments) {
  return formatText(parseFormat(format), arguments.data());
}
std::string ofInt(std::string_view format, int32_t v) { return text(format, {formatInts(&v)}); }
std::string ofFloat(std::string_view format, float v) { return text(format, {formatFloats(&v)}); }
std::string ofString(std::string_view format, std::string_view v) { return text(format, {formatStrings(&v)}); }
}  // namespace

TEST(LanguageText, NumbersAsTheCLibraryPrintsThem) {
  char expected[512];
  for (const char* f :
       {"%f",       "%g",  "%e",  "%.3f",    "%.0f",    "%#.0f", "%.9g",  "%#g",       "%#.3g",       "%10.4f",
        "%-10.4f|", "%+g", "% g", "%010.3f", "%+08.2e", "%#.0e", "%.12g", "%-+12.1f|", "%g and more", "%.0g"})
    for (float v : {0.f, -0.f, 1.f, -1.5f, 0.1f, 123456.f, 1234567.f, 1e-5f, 1e20f, 3.14159265f, 1e-40f, 0.5f,
                    99999.95f, 100.f, 2.5f, 3.4028235e38f}) {
      std::snprintf(expected, sizeof expected, f, double(v));
      EXPECT_EQ(ofFloat(f, v), expected) << f;
    }
  for (const char* f : {"%d", "%i", "%5d", "%-5d|", "%05d", "%+d", "% d", "%-05d|", "%o", "%x", "%X", "%8x", "%08X",
                        "%#o", "%#012x", "[%d]"})
    for (int v : {0, 1, -1, 42, 123456, std::numeric_limits<int>::min(), std::numeric_limits<int>::max()}) {
      if (v == 0 && std::string_view(f).find("#0") != std::string_view::npos) continue;  // C omits the prefix of 0
      std::snprintf(expected, sizeof expected, f, v);
      EXPECT_EQ(ofInt(f, v), expected) << f;
    }
  EXPECT_EQ(ofInt("%#x", 0), "0x0");
  EXPECT_EQ(ofFloat("%08f", INFINITY), "     inf");
  EXPECT_EQ(ofFloat("%f", -INFINITY), "-inf");
  EXPECT_EQ(ofFloat("%g", std::fabs(NAN)), "nan");
  for (char letter : std::string("cmnpv")) EXPECT_EQ(ofFloat(std::string("%") + letter, 0.25f), "0.250000");
}

TEST(LanguageText, WhereTheRulesDifferFromC) {
  EXPECT_EQ(ofString("%s", "abc"), "abc");
  EXPECT_EQ(ofString("%6s|", "abc"), "abc   |");
  EXPECT_EQ(ofString("%-6s|", "abc"), "abc   |");
  EXPECT_EQ(ofString("%.2s|", "abc"), "ab|");
  EXPECT_EQ(ofString("%05s", "abc"),
            "MIS-FORMAT: format \"{:05s}\" threw \"format specifier requires numeric argument\"");
  EXPECT_EQ(ofInt("%.3d", 5), "MIS-FORMAT: format \"{:.3d}\" threw \"precision not allowed for this argument type\"");
  EXPECT_EQ(ofInt("%+x", 5), "MIS-FORMAT: format \"{:+x}\" threw \"format specifier requires signed argument\"");
  EXPECT_EQ(ofInt("%ld", 5), "MIS-FORMAT: format \"{:ld}\" threw \"invalid format specifier\"");
  const float triple[3] = {1, 2.5f, -3};
  EXPECT_EQ(text("c = %g!", {formatFloats(triple, 3)}), "c = 1 2.5 -3!");
  const int32_t ints[2] = {1, -1};
  EXPECT_EQ(text("%x", {formatInts(ints, 2)}), "1 ffffffff");
  const std::string_view strings[2] = {"a", "b"};
  EXPECT_EQ(text("%2s|%%|%d%%", {formatStrings(strings, 2), formatInts(ints)}), "a  b |%|1%");
  EXPECT_EQ(text("no conversion %", {}), "no conversion %");
  EXPECT_EQ(ofString("%s", std::string(3000, 'x')).size(), 1024u);
  EXPECT_EQ(ofFloat("%2000f", 1).size(), 1024u);
  EXPECT_EQ(ofFloat("%.2000f", 1.f / 3).size(), 1024u);
  EXPECT_EQ(ofFloat("%999999999999f", 1).size(), 1024u);
}

TEST(LanguageText, FormatsAreChecked) {
  const auto check = [](std::string_view f, std::vector<Kind> k) { return checkFormat(parseFormat(f), k); };
  EXPECT_EQ(check("%d %f %s %%", {Kind::Int, Kind::Float, Kind::String}), "");
  EXPECT_EQ(check("%x%X%o%i", {Kind::Int, Kind::Int, Kind::Int, Kind::Int}), "");
  EXPECT_NE(check("%d", {Kind::Float}), "");
  EXPECT_NE(check("%f", {Kind::Int}), "");
  EXPECT_NE(check("%s", {Kind::Float}), "");
  EXPECT_NE(check("%g", {Kind::String}), "");
  EXPECT_NE(check("%u", {Kind::Int}), "");
  EXPECT_NE(check("%d %d", {Kind::Int}), "");
  EXPECT_NE(check("%d", {Kind::Int, Kind::Int}), "");
  EXPECT_NE(check("%5.2d", {Kind::Float}).find("%5.2d"), std::string::npos);
}

TEST(LanguageText, NumbersFromStrings) {
  EXPECT_EQ(stoi("  -42abc"), -42);
  EXPECT_EQ(stoi("+7"), 7);
  EXPECT_EQ(stoi("abc"), 0);
  EXPECT_EQ(stoi(""), 0);
  EXPECT_EQ(stoi("-"), 0);
  EXPECT_EQ(stoi("99999999999999999999"), std::numeric_limits<int>::max());
  EXPECT_EQ(stoi("-99999999999999999999"), std::numeric_limits<int>::min());
  EXPECT_EQ(stoi("0x10"), 0);
  EXPECT_EQ(stof(" 3.5e2x"), 350.f);
  EXPECT_EQ(stof("0x1.8p1"), 3.f);
  EXPECT_EQ(stof("-inf"), -INFINITY);
  EXPECT_TRUE(std::isnan(stof("nan")));
  EXPECT_EQ(stof("abc"), 0.f);
  EXPECT_EQ(stof(""), 0.f);
}

TEST(LanguageText, Pieces) {
  EXPECT_EQ(substr("hello", 1, 3), "ell");
  EXPECT_EQ(substr("hello", -3, 100), "llo");
  EXPECT_EQ(substr("hello", -100, 2), "he");
  EXPECT_EQ(substr("hello", 9, 2), "");
  EXPECT_EQ(substr("hello", 2, -5), "");
  EXPECT_EQ(substr("hello", std::numeric_limits<int>::min(), std::numeric_limits<int>::max()), "hello");
  EXPECT_EQ(getchar("az", 1), 'z');
  EXPECT_EQ(getchar("az", 2), 0);
  EXPECT_EQ(getchar("az", -1), 0);
  EXPECT_TRUE(startswith("abc", "ab"));
  EXPECT_TRUE(startswith("abc", ""));
  EXPECT_FALSE(startswith("a", "ab"));
  EXPECT_TRUE(endswith("abc", "bc"));
  EXPECT_TRUE(endswith("abc", ""));
  EXPECT_FALSE(endswith("c", "bc"));
  using Pieces = std::vector<std::string_view>;
  EXPECT_EQ(split("a b  c", "", 10), (Pieces{"a", "b", "c"}));
  EXPECT_EQ(split("  a b  c ", "", 2), (Pieces{"a", "b  c "}));
  EXPECT_EQ(split(" a ", "", 5), (Pieces{"a"}));
  EXPECT_EQ(split("a,,b,", ",", 10), (Pieces{"a", "", "b", ""}));
  EXPECT_EQ(split("a,b,c", ",", 2), (Pieces{"a", "b,c"}));
  EXPECT_EQ(split("a::b", "::", 9), (Pieces{"a", "b"}));
  EXPECT_EQ(split("", ",", 9), Pieces{});
  EXPECT_EQ(split("a", ",", 0), Pieces{});
  EXPECT_EQ(split("   ", "", 3), Pieces{});
}

TEST(LanguageText, HashesArePublishedOnes) {
  EXPECT_EQ(hashString(""), 0);
  EXPECT_EQ(hashString("Hello World!"), -16050688);
  EXPECT_EQ(farmHash64("hello world"), 0x588fb7478bd6b01bu);
  // by OpenImageIO 2.4's copy of the published sources; each length takes another path
  const std::pair<int, uint64_t> known[] = {
      {1, 0xb3454265b6df75e3u},   {3, 0x20a33e5d43d096deu},  {5, 0x56e72dd021fd3d8eu},  {8, 0x1de76afc5d6454deu},
      {13, 0x6941b27c60633f7au},  {16, 0x3f608b9cdec06e60u}, {17, 0x821fa7dbb1a8d6e3u}, {29, 0xb414a6374ae767c9u},
      {32, 0x82925828879d04f2u},  {33, 0xdf0f3d0a21bcc10eu}, {50, 0xe61039b7ac495260u}, {64, 0x3401a054e9e14fe5u},
      {65, 0xace1b18c1893ce8u},   {80, 0x83336084a13047eau}, {96, 0x657db8974728526eu}, {97, 0x7d0747f2f5c94f4du},
      {150, 0x77f4f1d241f371d8u}, {256, 0x63d6a7f39718e6eu}, {257, 0xe15b9344024e16u},  {300, 0x6250df16710c3548u},
      {700, 0x1481269617693f98u}};
  for (const auto& [length, hash] : known) {
    std::string s;
    for (int i = 0; i < length; ++i) s += char('a' + (i * i * 7 + i / 3) % 26);
    EXPECT_EQ(farmHash64(s), hash) << length;
  }
}

TEST(LanguageText, RegularExpressions) {
  std::string why;
  std::vector<int32_t> r(6, -7);
  EXPECT_TRUE(matchRegex("foobar.baz", "bar(.)(b.?)", false, r.data(), 6, why));
  EXPECT_EQ(r, (std::vector<int32_t>{3, 9, 6, 7, 7, 9}));
  EXPECT_FALSE(matchRegex("foobar.baz", "bar", true, r.data(), 6, why));
  EXPECT_EQ(r, std::vector<int32_t>(6, 3));  // filled with the pattern's length
  EXPECT_TRUE(matchRegex("abab", "(ab)+", true, r.data(), 6, why));
  EXPECT_EQ(r, (std::vector<int32_t>{0, 4, 2, 4, 5, 5}));
  EXPECT_TRUE(matchRegex("xaaay", "a+?", false, r.data(), 2, why));
  EXPECT_EQ(r[1], 2);  // not greedy
  EXPECT_TRUE(matchRegex("abcd", "ab|abcd", false, r.data(), 2, why));
  EXPECT_EQ(r[1], 2);  // the first alternative, not the longest
  EXPECT_TRUE(matchRegex(std::string(5000, 'x') + "abcd", "ab|abcd", false, r.data(), 2, why));
  EXPECT_EQ(r[0], 5000);  // found, wherever it ends
  EXPECT_TRUE(matchRegex("line9", "^[a-z]+\\d$", false, nullptr, 0, why));
  EXPECT_TRUE(matchRegex("abcabc", "(abc)\\1", true, r.data(), 4, why));
  EXPECT_EQ(r[3], 3);
  EXPECT_TRUE(why.empty());
  // not expressions, and what would take forever
  EXPECT_FALSE(matchRegex("a", "(", false, r.data(), 2, why));
  EXPECT_NE(why, "");
  EXPECT_FALSE(matchRegex("a", "a{99999}{99999}", false, r.data(), 2, why));
  EXPECT_NE(why, "");
  for (const char* large : {"(a?){9000}", "((a?){100}){100}", "(a|b)*(a?){3000}c", "(a{99}){99}"}) {
    EXPECT_FALSE(matchRegex("b", large, false, r.data(), 2, why)) << large;
    EXPECT_NE(why, "") << large;
  }
  EXPECT_TRUE(matchRegex("0a1b2c3d-0a1b", "[0-9a-f]{8}-[0-9a-f]{4}", true, r.data(), 2, why));
  EXPECT_EQ(why, "");
  EXPECT_FALSE(matchRegex(std::string(16000, 'a'), "(a|b)*(a|b)*(a?){1000}c", true, r.data(), 2, why));
  EXPECT_NE(why, "");
  EXPECT_FALSE(matchRegex("a", std::string(5000, 'a'), false, r.data(), 2, why));
  EXPECT_NE(why, "");
  EXPECT_FALSE(matchRegex(std::string(40, 'a'), "(a*)*b", true, r.data(), 2, why));
  EXPECT_EQ(why, "");
  EXPECT_FALSE(matchRegex(std::string(40, 'a'), "((a|a)*)*\\1b", true, r.data(), 2, why));
  EXPECT_NE(why, "");
  EXPECT_FALSE(matchRegex(std::string(3000, 'a'), "a*a*a*a*a*b", true, r.data(), 2, why));
  EXPECT_EQ(why, "");
  EXPECT_FALSE(matchRegex(std::string(16, 'a'), "(a|a)*b", true, r.data(), 2, why));
  EXPECT_FALSE(matchRegex(std::string(100000, 'a'), "a*", true, r.data(), 2, why));
  EXPECT_NE(why, "");
  EXPECT_FALSE(matchRegex(std::string(kLongestRegexSubject, 'a'), "(a|b)*c", false, r.data(), 2, why));
  EXPECT_NE(why, "");  // a search would start as often as there are characters
  EXPECT_TRUE(matchRegex(std::string(kLongestRegexSubject, 'a'), "(a|b)*", true, r.data(), 2, why));
  EXPECT_EQ(r[1], int32_t(kLongestRegexSubject));
}

TEST(LanguageText, NamesOfNoises) {
  EXPECT_EQ(noiseKind("snoise", false, true), NoiseKind::Perlin);
  EXPECT_EQ(noiseKind("noise", true, true), NoiseKind::UnsignedPerlin);
  EXPECT_EQ(noiseKind("usimplex", false, true), NoiseKind::UnsignedSimplex);
  EXPECT_EQ(noiseKind("usimplex", true, true), NoiseKind::Unknown);
  EXPECT_EQ(noiseKind("simplexnoise", false, true), NoiseKind::Unknown);
  EXPECT_EQ(noiseKind("simplexnoise", false, false), NoiseKind::Simplex);
  EXPECT_EQ(noiseKind("null", false, true), NoiseKind::Unknown);
  EXPECT_EQ(noiseKind("unull", true, false), NoiseKind::UnsignedNull);
  EXPECT_EQ(unknownNoise("x", true, "a.osl", 7), "periodic noise type \"x\" is unknown, called from (a.osl:7)");
}

TEST(LanguageText, Dictionaries) {
  std::vector<std::string> reports;
  Dictionary d([&](const std::string& s) { reports.push_back(s); });
  const char* xml =
      "<list><item name='a' size='3' at='1, 2.5 3'>first</item><item name='b'>second<sub k='7'/></item></list>";
  const int first = d.find(xml, "//item");
  ASSERT_GT(first, 0);
  EXPECT_EQ(d.find(xml, "//item"), first);
  const int second = d.next(first);
  ASSERT_GT(second, first);
  EXPECT_EQ(d.next(second), 0);
  std::string s;
  EXPECT_TRUE(d.value(first, "", s));
  EXPECT_EQ(s, "first");
  EXPECT_TRUE(d.value(second, "name", s));
  EXPECT_EQ(s, "b");
  EXPECT_FALSE(d.value(second, "size", s));
  int32_t i = 0;
  EXPECT_TRUE(d.value(first, "size", &i, 1));
  EXPECT_EQ(i, 3);
  float p[3] = {};
  EXPECT_TRUE(d.value(first, "at", p, 3));
  EXPECT_EQ(p[1], 2.5f);
  EXPECT_EQ(p[2], 3.f);
  EXPECT_FALSE(d.value(first, "name", p, 1));  // no number
  EXPECT_FALSE(d.value(first, "size", p, 3));  // too few
  EXPECT_EQ(p[0], 1.f);
  EXPECT_TRUE(d.value(d.find(second, "sub"), "k", &i, 1));
  EXPECT_EQ(i, 7);
  EXPECT_EQ(d.find(first, "sub"), 0);
  EXPECT_EQ(d.find(xml, "//nothing"), 0);
  EXPECT_TRUE(reports.empty());
  EXPECT_EQ(d.find("<a><b></a>", "//a"), -1);
  EXPECT_EQ(d.find("<a><b></a>", "//b"), -1);
  EXPECT_EQ(reports.size(), 1u);  // once a dictionary
  EXPECT_EQ(d.find("no/such/file.xml", "//a"), -1);
  EXPECT_EQ(d.find(xml, "///[["), 0);
  EXPECT_EQ(d.find(xml, "///[["), 0);
  EXPECT_EQ(reports.size(), 3u);
  for (int bad : {0, -1, 12345, std::numeric_limits<int>::max()}) {
    EXPECT_EQ(d.next(bad), 0);
    EXPECT_EQ(d.find(bad, "x"), 0);
    EXPECT_FALSE(d.value(bad, "", s));
  }
  const std::string file = testing::TempDir() + "kinora_dictionary.xml";
  std::ofstream(file) << "<a v='5'/>";
  EXPECT_TRUE(d.value(d.find(file, "/a"), "v", &i, 1));
  EXPECT_EQ(i, 5);
  std::remove(file.c_str());
}
}  // namespace kinora::language
