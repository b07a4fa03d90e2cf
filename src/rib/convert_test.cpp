// ASCII to binary and back gives the same text; archives expand where they are read. Misses: that binary RIB written
// by other programs is understood, which lexer_test.cpp proves.
#include "rib/convert.h"

#include <filesystem>
#include <fstream>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

struct Converted {
  std::string text;
  std::vector<std::string> messages;
};

Converted converted(const std::string& rib, bool binary) {
  Converted c;
  Diagnostics d([&](const std::string& line, Severity) { c.messages.push_back(line); });
  Converter converter(d, {.binary = binary}, [&](std::string_view part) { c.text += part; });
  EXPECT_TRUE(converter.text("text", rib));
  converter.finish();
  return c;
}

constexpr const char* kText = R"(version 3.04
Option "searchpath" "string archive" ["a\"b\\c:@"]
FrameBegin 1
Declare "x" "vertex float[2]"
Projection "perspective" "fov" [ 35.25 ]
Transform [1 0 0 0 0 0.1 0 0 0 0 1 0 0.3 2 -1e-9 1]
WorldBegin
AttributeBegin
Attribute "identifier" "string name" ["one"] "int id" [70000 -1 127 128 -128 -129 32768 8388608 -2147483648]
Frobnicate 1 2.0 "three" [nan -inf]
PointsPolygons [3 3] [0 1 2 2 1 0] "vertex point P" [0 0 0 1 0 0 0 1 0]
Sphere 1 -1 1 360 "constant float a" 1e30 "constant string a" ["" "line\nbreak"]
AttributeEnd
ReadArchive "nowhere.rib"
WorldEnd
FrameEnd
)";

TEST(Convert, BinaryAndBackIsTheSameText) {
  const Converted ascii = converted(kText, false), binary = converted(ascii.text, true);
  EXPECT_EQ(binary.messages, std::vector<std::string>()) << binary.messages[0];
  EXPECT_NE(binary.text.find('\246'), std::string::npos);
  const Converted back = converted(binary.text, false);
  EXPECT_EQ(back.messages, std::vector<std::string>());
  EXPECT_EQ(back.text, ascii.text);
  EXPECT_EQ(converted(ascii.text, false).text, ascii.text);
}

TEST(Convert, LongArraysKeepEachFloatAndTheirType) {
  std::string text = "Points \"P\" [";
  for (int i = 0; i < 30000; ++i) text += std::to_string(i * 0.37) + " ";
  text += "] \"constant int n\" [";
  for (int i = 0; i < 30000; ++i) text += std::to_string(i * 7919 % 100003 - 50000) + " ";
  text += "] \"constant float whole\" [1.0 2 3]\n";
  const Converted ascii = converted(text, false), binary = converted(text, true);
  EXPECT_LT(binary.text.size(), text.size());
  EXPECT_EQ(converted(binary.text, false).text, converted(ascii.text, false).text);
  EXPECT_NE(ascii.text.find("[1 2 3.0]"), std::string::npos);  // an array of floats stays one
  for (size_t at = 0, next = 0; at < ascii.text.size(); at = next + 1) {
    next = std::min(ascii.text.find('\n', at), ascii.text.size());
    EXPECT_LT(next - at, 130u);
  }
}

TEST(Convert, ArchivesStandWhereTheyWereRead) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "kinora_convert_test";
  fs::create_directories(folder / "sub");
  const auto write = [&](const char* name, const char* text) { std::ofstream(folder / name) << text; };
  write(
      "main.rib",
      "Option \"searchpath\" \"archive\" [\"sub\"]\nWorldBegin\nReadArchive \"part.rib\"\nReadArchive "
      "\"missing.rib\"\n"
      "Procedural \"DelayedReadArchive\" [\"leaf.rib\"] [0 1 0 1 0 1]\nArchiveBegin \"in\"\nArchiveEnd\nReadArchive "
      "\"in\"\nWorldEnd\n");
  write("sub/part.rib", "Color [1 0 0]\nReadArchive \"leaf.rib\"\nReadArchive \"part.rib\"\n");
  write("sub/leaf.rib", "Sphere 1 -1 1 360\n");
  std::string text;
  Diagnostics d([](const std::string&, Severity) {});
  Converter converter(d, {.expand = true}, [&](std::string_view part) { text += part; });
  EXPECT_TRUE(converter.file((folder / "main.rib").string()));
  converter.finish();
  EXPECT_EQ(
      text,
      "##RenderMan RIB-Structure 1.1\nOption \"searchpath\" \"archive\" [\"sub\"]\nWorldBegin\n  Color [1 0 0]\n"
      "  Sphere 1 -1 1 360\n  ReadArchive \"part.rib\"\n  ReadArchive \"missing.rib\"\n  AttributeBegin\n"
      "    Sphere 1 -1 1 360\n  AttributeEnd\n  ArchiveBegin \"in\"\n  ArchiveEnd\n  ReadArchive \"in\"\nWorldEnd\n");
  EXPECT_EQ(d.count("ASSET-MISSING-ARCHIVE"), 1u);
  EXPECT_EQ(d.count("RIB-RECURSION"), 1u);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace kinora::rib
