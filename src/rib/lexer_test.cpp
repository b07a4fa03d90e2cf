// The lexical rules of RIB, ASCII and each binary encoding, and what happens to bytes that break them. Proves values,
// not speed (speed_test.cpp) and not meaning (requests_test.cpp).
#include <unistd.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "rib/lexer.h"
#include "rib/test_support.h"

namespace kinora::rib {
namespace {

struct Lexed {
  std::vector<Request> requests;
  std::vector<Message> messages;
};

bool isKnown(std::string_view w) { return w == "A" || w == "B" || w == "Sphere"; }

Lexed lex(std::string text) {
  Lexed out;
  Diagnostics messages([](const std::string&, Severity) {});
  Lexer lexer(openText(std::move(text)), "t.rib", messages, &isKnown);
  Request r;
  while (lexer.readRequest(r)) {
    out.requests.push_back(r);
    out.requests.back().args.resize(r.count);
  }
  out.messages = messages.messages();
  return out;
}

std::string bytes(std::initializer_list<int> values) {
  std::string s;
  for (int v : values) s += char(v);
  return s;
}

TEST(Lexer, AsciiNumbers) {
  const auto r =
      lex("A 1 -2 +3 .5 1. 1e-3 -2.5E+2 2147483647 2147483648 1e999 -1e999 1e-999 nan -inf "
          "0.1000000000000000055511151231257827");
  ASSERT_EQ(r.requests.size(), 1u);
  const auto& a = r.requests[0].args;
  ASSERT_EQ(a.size(), 15u);
  const double expected[] = {1,        -2,        3, .5,  1,         1e-3, -250, 2147483647, 2147483648.0,
                             HUGE_VAL, -HUGE_VAL, 0, NAN, -HUGE_VAL, 0.1};
  for (size_t i = 0; i < 15; ++i) {
    ASSERT_EQ(a[i].exact.size(), 1u);
    if (std::isnan(expected[i]))
      EXPECT_TRUE(std::isnan(a[i].exact[0]));
    else
      EXPECT_EQ(a[i].exact[0], expected[i]) << i;
    EXPECT_EQ(a[i].isInteger, i < 3 || i == 7) << i;
  }
  EXPECT_TRUE(a[9].notFinite && a[12].notFinite && !a[0].notFinite && !a[8].notFinite);
}

TEST(Lexer, NumbersRoundAsTheLibraryDoes) {
  std::string text = "A [";
  std::vector<double> expected;
  uint64_t state = 7;
  for (int i = 0; i < 20000; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.*g", 1 + int(state >> 33) % 20,
                  std::ldexp(double(int64_t(state)), int(state % 200) - 160));
    expected.push_back(std::strtod(buffer, nullptr));
    text += std::string(buffer) + (i % 3 ? " " : "\n");
  }
  const auto r = lex(text + "]");
  ASSERT_EQ(r.requests.size(), 1u);
  ASSERT_EQ(r.requests[0].args[0].floats.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(r.requests[0].args[0].floats[i], float(expected[i])) << i;
}

TEST(Lexer, StringsEscapesAndComments) {
  const auto r = lex("A \"a\\n\\t\\\\\\\"\\101\\q\\\nb\" # comment \" [\n##structure\n\"two\nlines\"\"\"B'single'");
  ASSERT_EQ(r.requests.size(), 2u);
  ASSERT_EQ(r.requests[0].args.size(), 3u);
  EXPECT_EQ(r.requests[0].args[0].strings[0], "a\n\t\\\"Aqb");
  EXPECT_EQ(r.requests[0].args[1].strings[0], "two\nlines");
  EXPECT_EQ(r.requests[0].args[2].strings[0], "");
  EXPECT_EQ(r.requests[1].name, "B");
  EXPECT_EQ(r.requests[1].pos.line, 5u);
  EXPECT_EQ(r.requests[1].args[0].strings[0], "single");
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].code, "RIB-QUOTES");
}

TEST(Lexer, ArraysKeepIntegersUntilAFloatComes) {
  const auto r = lex("A[1 2 3][1 2 3.5 4][\"x\"\"y\"][]");
  const auto& a = r.requests[0].args;
  ASSERT_EQ(a.size(), 4u);
  EXPECT_EQ(a[0].ints, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(a[1].floats, (std::vector<float>{1, 2, 3.5f, 4}));
  EXPECT_EQ(a[2].strings.size(), 2u);
  EXPECT_EQ(a[3].size(), 0u);
}

TEST(Lexer, BinaryIntegersAndFixedPoint) {
  // 0200 + 4 d + w: w + 1 bytes, the lowest d of them behind the point
  const auto r = lex("A" + bytes({0200, 0xFE, 0201, 1,    0, 0202, 1,    0,    0,    0203, 0xFF,
                                  0xFF, 0xFF, 0xFE, 0205, 1, 0x80, 0213, 0xFF, 0xFF, 0x80, 0}));
  const auto& a = r.requests[0].args;
  ASSERT_EQ(a.size(), 6u);
  const double expected[] = {-2, 256, 65536, -2, 1.5, -0.5};
  for (int i = 0; i < 6; ++i) EXPECT_EQ(a[size_t(i)].exact[0], expected[i]) << i;
  EXPECT_TRUE(a[3].isInteger);
  EXPECT_FALSE(a[4].isInteger);
}

TEST(Lexer, BinaryStringsFloatsAndArrays) {
  const auto f = std::bit_cast<uint32_t>(1.5f);
  const auto d = std::bit_cast<uint64_t>(-0.1);
  std::string text =
      "A" + bytes({0220 + 3}) + "a\\n" + bytes({0240, 2}) + "xy" + bytes({0241, 0, 1}) + "z" + bytes({0244});
  for (int i = 3; i >= 0; --i) text += char(f >> (8 * i));
  text += char(0245);
  for (int i = 7; i >= 0; --i) text += char(d >> (8 * i));
  text += bytes({0310, 2});
  for (int k = 0; k < 2; ++k)
    for (int i = 3; i >= 0; --i) text += char(f >> (8 * i));
  const auto r = lex(text + "[1 " + bytes({0200, 7}) + "]");
  const auto& a = r.requests[0].args;
  ASSERT_EQ(a.size(), 7u);
  EXPECT_EQ(a[0].strings[0], "a\\n") << "encoded strings have no escapes";
  EXPECT_EQ(a[1].strings[0], "xy");
  EXPECT_EQ(a[2].strings[0], "z");
  EXPECT_EQ(a[3].exact[0], 1.5);
  EXPECT_EQ(a[4].exact[0], -0.1);
  EXPECT_TRUE(a[5].isArray);
  EXPECT_EQ(a[5].floats, (std::vector<float>{1.5f, 1.5f}));
  EXPECT_EQ(a[6].ints, (std::vector<int>{1, 7})) << "encoded numbers inside ASCII brackets";
  EXPECT_TRUE(r.messages.empty());
}

TEST(Lexer, BinaryDefinitions) {
  std::string text = bytes({0314, 5}) + "\"Sphere\"" + bytes({0315, 9, 0221}) + "k" + bytes({0316, 1, 0, 0222}) +
                     "kk" + bytes({0246, 5, 0317, 9, 0320, 1, 0, 0246, 5});
  const auto r = lex(text);
  ASSERT_EQ(r.requests.size(), 2u);
  EXPECT_EQ(r.requests[0].name, "Sphere");
  EXPECT_EQ(r.requests[0].args[0].strings[0], "k");
  EXPECT_EQ(r.requests[0].args[1].strings[0], "kk");
}

TEST(Lexer, EndOfStreamByte) {
  const auto r = lex("A 1\n\377B 2");
  ASSERT_EQ(r.requests.size(), 1u);
  EXPECT_EQ(r.requests[0].name, "A");
}

TEST(Lexer, AByteOrderMarkIsNoMistake) {
  const Lexed r =
      lex("\xef\xbb\xbf"
          "A 1\nB 2\n");
  EXPECT_TRUE(r.messages.empty());
  ASSERT_EQ(r.requests.size(), 2u);
  EXPECT_EQ(r.requests[1].pos.line, 2u);
  EXPECT_TRUE(lex("\xef\xbb\xbf").requests.empty());
  EXPECT_EQ(lex("A \xef\xbb\xbf 1").messages.size(), 1u) << "elsewhere it is";
}

// Lines of Unix, DOS and old Macintoshes: the same requests on the same lines.
TEST(Lexer, LinesEndWithLFCRLFOrCR) {
  const std::string text =
      "# comment\nA 1 # to its end\n\nB [1\n2\n\n3]\nUnknown\n\"a\nb\" A \"c\\\nd\"\n##x\nB\n\"open\nB 5\n";
  const auto withEnds = [&](const std::string& end) {
    std::string out;
    for (const char c : text) out += c == '\n' ? end : std::string(1, c);
    return out;
  };
  const Lexed unix = lex(text);
  ASSERT_EQ(unix.requests.size(), 6u);
  for (const char* end : {"\r\n", "\r"}) {
    const Lexed r = lex(withEnds(end));
    ASSERT_EQ(r.requests.size(), unix.requests.size());
    for (size_t i = 0; i < r.requests.size(); ++i) {
      EXPECT_EQ(r.requests[i].name, unix.requests[i].name);
      EXPECT_EQ(r.requests[i].pos.line, unix.requests[i].pos.line) << r.requests[i].name;
      EXPECT_EQ(r.requests[i].count, unix.requests[i].count);
    }
    EXPECT_EQ(r.requests[3].args[0].strings, (std::vector<std::string>{"cd"})) << "a backslash joins lines";
    ASSERT_EQ(r.messages.size(), unix.messages.size());
    for (size_t i = 0; i < r.messages.size(); ++i) {
      EXPECT_EQ(r.messages[i].code, unix.messages[i].code);
      EXPECT_EQ(r.messages[i].pos.line, unix.messages[i].pos.line);
    }
  }
}

// Line ends that fall on the end of what is read at a time are one, too.
TEST(Lexer, LineEndsAcrossBuffers) {
  for (int shift = 0; shift < 4; ++shift) {
    std::string text(size_t((1 << 18) - 2 + shift), ' ');
    text += "\r\nA 1\r\rB 2";
    const Lexed r = lex(text);
    ASSERT_EQ(r.requests.size(), 2u);
    EXPECT_EQ(r.requests[0].pos.line, 2u) << shift;
    EXPECT_EQ(r.requests[1].pos.line, 4u) << shift;
  }
}

TEST(Lexer, TokensAcrossBuffers) {
  // longer than the lexer's buffer, with tokens at every distance from its ends
  std::string text = "A [";
  for (int i = 0; i < 200000; ++i) text += std::to_string(i) + (i % 7 ? " " : "   ");
  text += "] \"" + std::string(600000, 'x') + "\" ";
  text += "0." + std::string(700, '0') + "1";
  const auto r = lex(text);
  for (const auto& m : r.messages) ADD_FAILURE() << m.str();
  ASSERT_EQ(r.requests[0].args.size(), 3u);
  const auto& v = r.requests[0].args[0].ints;
  ASSERT_EQ(v.size(), 200000u);
  for (int i = 0; i < 200000; ++i) ASSERT_EQ(v[size_t(i)], i);
  EXPECT_EQ(r.requests[0].args[1].strings[0].size(), 600000u);
  EXPECT_EQ(r.requests[0].args[2].exact[0], 0) << "1e-701 is 0";
  EXPECT_TRUE(r.messages.empty());
}

TEST(Lexer, NamesTheNumberThatGoesOnAlone) {
  const auto r = lex("A\n.5.5 7 8\nB");
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_NE(r.messages[0].what.find("'.5.5'"), std::string::npos) << r.messages[0].what;
}

struct BadCase {
  const char* name;
  std::string text;
  const char* code;
  uint32_t line;
};
class BadBytes : public testing::TestWithParam<BadCase> {};

TEST_P(BadBytes, GiveOneMessageAndReadingGoesOn) {
  const BadCase& c = GetParam();
  const auto r = lex(c.text);
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].code, c.code);
  EXPECT_EQ(r.messages[0].pos.line, c.line);
  EXPECT_FALSE(r.messages[0].done.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Lexer, BadBytes,
    testing::Values(
        BadCase{"Junk", "A 1\n@@ 2\nB", "RIB-SYNTAX", 2}, BadCase{"NumberWithTail", "A\n1.5xyz\nB", "RIB-SYNTAX", 2},
        BadCase{"ValuesFirst", "\n1 2 3\nA", "RIB-SYNTAX", 2}, BadCase{"Dashes", "A\n---------\nB", "RIB-SYNTAX", 2},
        BadCase{"OpenStringBeforeRequest", "A \"abc\nB 2\n", "RIB-STRING", 1},
        BadCase{"OpenStringAtEnd", "\nA \"abc\n", "RIB-STRING", 2},
        BadCase{"OpenArray", "A [1 2 3\nB 2", "RIB-BRACKET", 2},
        BadCase{"OpenArrayAtEnd", "A [1 2\n", "RIB-BRACKET", 2},
        BadCase{"StrayBracket", "A 1 ]\nB", "RIB-BRACKET", 1}, BadCase{"Nested", "A [1 [[ 2 ]\nB", "RIB-ARRAY", 1},
        BadCase{"Mixed", "A [1 \"x\" 2 \"y\"]\nB", "RIB-ARRAY", 1},
        BadCase{"MixedOther", "A [\"x\" 2]\nB", "RIB-ARRAY", 1},
        BadCase{"NoQuotes", "A file.tif\nB", "RIB-QUOTES", 1},
        BadCase{"CutString", "A " + bytes({0240, 200}) + "abc", "RIB-TRUNCATED", 1},
        BadCase{"CutFloat", "A " + bytes({0244, 1, 2}), "RIB-TRUNCATED", 1},
        BadCase{"CutInteger", "A " + bytes({0203, 1}), "RIB-TRUNCATED", 1},
        BadCase{"CutArray", "A " + bytes({0313, 0x7F, 0xFF, 0xFF, 0xFF, 1, 2, 3, 4}), "RIB-TRUNCATED", 1},
        BadCase{"CutHugeString", "A " + bytes({0243, 0xFF, 0xFF, 0xFF, 0xFF}) + "abc", "RIB-TRUNCATED", 1},
        BadCase{"CutDefinition", "A " + bytes({0314}), "RIB-TRUNCATED", 1},
        BadCase{"DefinitionWithoutString", "A " + bytes({0314, 1}) + " B", "RIB-BINARY", 1},
        BadCase{"DefinitionsNested", "A " + bytes({0315, 1, 0315, 1, 0221}) + "k", "RIB-BINARY", 1},
        BadCase{"UndefinedRequest", "A\n" + bytes({0246, 7}), "RIB-BINARY", 2},
        BadCase{"UndefinedToken", "A\n" + bytes({0317, 7}), "RIB-BINARY", 2},
        BadCase{"Reserved", "A\n" + bytes({0370}) + "\nB", "RIB-BINARY", 2}),
    [](const auto& info) { return info.param.name; });

TEST(Lexer, MissingQuotesAtTheStartOfALineAreARequest) {
  const auto r = lex("A 1\nfoo 2 3\nB");
  ASSERT_EQ(r.requests.size(), 3u);
  EXPECT_EQ(r.requests[1].name, "foo");
}

TEST(Lexer, AnOpenArrayEndsBeforeTheNextRequest) {
  const auto r = lex("A [1 2 3\nB 2");
  ASSERT_EQ(r.requests.size(), 2u);
  EXPECT_EQ(r.requests[0].args[0].ints.size(), 3u);
  EXPECT_EQ(r.requests[1].name, "B");
}

TEST(Lexer, AFloodOfBracketsOrScalarsIsBounded) {
  const auto brackets = lex("A " + std::string(3000000, '['));
  EXPECT_LE(brackets.messages.size(), 3u);
  std::string scalars = "A ";
  for (int i = 0; i < 300000; ++i) scalars += "1 ";
  const auto r = lex(scalars);
  EXPECT_EQ(r.requests[0].args.size(), 65536u);
  ASSERT_EQ(r.messages.size(), 1u);
  EXPECT_EQ(r.messages[0].code, "RIB-ARGUMENTS");
}

TEST(Lexer, RandomBytesNeverStopIt) {
  uint32_t state = 12345;
  for (int run = 0; run < 300; ++run) {
    std::string text = run % 2 ? "A [" : "";
    for (int i = 0; i < 2000; ++i) {
      state = state * 1664525u + 1013904223u;
      static const char kUsual[] = "AB []\"'#0123456789.-e\n ";
      text += run % 3 == 0            ? char(state >> 24)
              : (state >> 8) % 9 == 0 ? char(state >> 24)
                                      : kUsual[(state >> 24) % (sizeof kUsual - 1)];
    }
    lex(std::move(text));
  }
}

TEST(Files, GzipIsFoundByItsMagicAndTruncationIsReported) {
  const auto folder = std::filesystem::temp_directory_path() / ("kinora_rib_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string path = (folder / "scene.rib").string(),
                    text = "WorldBegin\nSphere 1 -1 1 360\nWorldEnd\n# " + std::string(5000, 'k');
  gzFile z = gzopen(path.c_str(), "wb0");
  gzwrite(z, text.data(), unsigned(text.size()));
  gzclose(z);
  const auto read = [&](const std::string& file) {
    Read out;
    Diagnostics messages([](const std::string&, Severity) {});
    RibReader reader(messages, {}, [&](scene::Scene&& s) { out.worlds.push_back(std::move(s)); });
    out.ok = reader.readFile(file);
    reader.finish();
    out.messages = messages.messages();
    return out;
  };
  Read r = read(path);
  EXPECT_TRUE(r.ok);
  EXPECT_EQ(r.world().primitives.size(), 1u);
  EXPECT_TRUE(r.messages.empty()) << r.all();

  std::filesystem::resize_file(path, 200);
  r = read(path);
  EXPECT_EQ(r.count("RIB-TRUNCATED"), 1u) << r.all();
  EXPECT_EQ(r.world().primitives.size(), 1u) << "what came before the cut is used";

  r = read(folder.string());
  EXPECT_FALSE(r.ok);
  EXPECT_EQ(r.count("RIB-DIRECTORY"), 1u) << r.all();
  r = read((folder / "none.rib").string());
  EXPECT_FALSE(r.ok);
  EXPECT_EQ(r.count("RIB-OPEN"), 1u) << r.all();
  std::fclose(std::fopen((folder / "empty.rib").c_str(), "w"));
  r = read((folder / "empty.rib").string());
  EXPECT_FALSE(r.ok);
  EXPECT_EQ(r.count("RIB-EMPTY"), 1u) << r.all();
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kinora::rib
