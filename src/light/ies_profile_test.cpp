// Files of the four editions of LM-63, made here: candelas and angles as written, symmetries unfolded against the
// file's own values, tilts skipped, free line breaks; broken and hostile files end in one message with its line, every
// cut and many mutations of a good one in no crash. Misses: files whose horizontal angles stop short of a symmetry.
#include "light/ies_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace kinora::light {
namespace {

struct File {
  std::string head = "IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] none\n[MORE] TILT is not here\n", tilt = "TILT=NONE\n";
  std::string counts;  // else made from the angles
  int type = 1;
  double multiplier = 2, ballast = 0.5;
  std::vector<double> vertical = {0, 45, 90}, horizontal = {0, 90, 180};
  std::string tail;

  static double value(size_t column, size_t row) { return 100 + 10.0 * double(column) + double(row) / 2; }
  std::string text() const {
    const auto list = [](const std::vector<double>& x) {
      std::string s;
      for (double v : x) s += std::to_string(v) + " ";
      return s + "\n";
    };
    std::string s = head + tilt + "1 -1 " + std::to_string(multiplier) + " ";
    s += counts.empty() ? std::to_string(vertical.size()) + " " + std::to_string(horizontal.size()) : counts;
    s += " " + std::to_string(type) + " 2 .5 .6 0\n" + std::to_string(ballast) + " 1 60.5\n" + list(vertical) +
         list(horizontal);
    for (size_t c = 0; c < horizontal.size(); ++c) {
      std::vector<double> column;
      for (size_t r = 0; r < vertical.size(); ++r) column.push_back(value(c, r));
      s += list(column);
    }
    return s + tail;
  }
};

// Which of the file's columns stands at each angle.
void expectColumns(const File& f, const std::vector<std::pair<float, size_t>>& expected) {
  IesProfile p;
  const IesError e = readIes(f.text(), p);
  ASSERT_EQ(e.line, 0u) << e.what;
  ASSERT_EQ(p.horizontal.size(), expected.size());
  ASSERT_EQ(p.candela.size(), expected.size() * f.vertical.size());
  for (size_t c = 0; c < expected.size(); ++c) {
    EXPECT_EQ(p.horizontal[c], expected[c].first);
    for (size_t r = 0; r < f.vertical.size(); ++r)
      EXPECT_FLOAT_EQ(p.candela[c * f.vertical.size() + r],
                      float(File::value(expected[c].second, r) * f.multiplier * f.ballast));
  }
}

TEST(IesProfile, EditionsDifferInTheirHeadsOnly) {
  for (const char* head : {"", "an old file\nof 1986\n", "IESNA91\n[TEST]x\n", "IESNA:LM-63-1995\r\n[TEST] x\r\n",
                           "IESNA:LM-63-2002\n[_OWN] x\n"}) {
    File f;
    f.head = head;
    f.tail = "\nafter the values anything\n";
    expectColumns(f, {{0.f, 0}, {90.f, 1}, {180.f, 2}, {270.f, 1}, {360.f, 0}});
  }
  File tilted;
  tilted.tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n1 .9 .8\n";
  tilted.multiplier = 3;
  expectColumns(tilted, {{0.f, 0}, {90.f, 1}, {180.f, 2}, {270.f, 1}, {360.f, 0}});
  tilted.tilt = "TILT= OTHER.TLT \r\n";
  expectColumns(tilted, {{0.f, 0}, {90.f, 1}, {180.f, 2}, {270.f, 1}, {360.f, 0}});
}

TEST(IesProfile, SymmetriesAreUnfolded) {
  File f;
  f.horizontal = {0};
  expectColumns(f, {{0.f, 0}});
  f.horizontal = {0, 30, 90};
  expectColumns(
      f, {{0.f, 0}, {30.f, 1}, {90.f, 2}, {150.f, 1}, {180.f, 0}, {210.f, 1}, {270.f, 2}, {330.f, 1}, {360.f, 0}});
  f.horizontal = {0, 100, 360};
  expectColumns(f, {{0.f, 0}, {100.f, 1}, {360.f, 2}});
  f.horizontal = {0, 120, 240};  // the way back left out
  expectColumns(f, {{0.f, 0}, {120.f, 1}, {240.f, 2}, {360.f, 0}});
  f.horizontal = {90, 120, 180, 270};
  expectColumns(f, {{0.f, 2}, {60.f, 1}, {90.f, 0}, {120.f, 1}, {180.f, 2}, {270.f, 3}, {360.f, 2}});
  f.type = 2;
  f.vertical = {-90, 0, 90};
  f.horizontal = {0, 30, 90};
  expectColumns(f, {{-90.f, 2}, {-30.f, 1}, {0.f, 0}, {30.f, 1}, {90.f, 2}});
  f.type = 3;
  f.horizontal = {-80, 0, 10};
  expectColumns(f, {{-80.f, 0}, {0.f, 1}, {10.f, 2}});
}

// Found by fuzzing: the way around had a gap where neither 0 nor 180 was said.
TEST(IesProfile, HalvesWithoutTheirMiddleGoAllAround) {
  File f;
  f.horizontal = {90, 160, 220, 270};
  IesProfile p;
  ASSERT_EQ(readIes(f.text(), p).line, 0u);
  EXPECT_EQ(p.horizontal, (std::vector<float>{0, 20, 90, 160, 180, 220, 270, 320, 360}));
  const double scale = f.multiplier * f.ballast;
  for (size_t r = 0; r < 3; ++r) {
    const double at180 = (File::value(1, r) * 2 + File::value(2, r)) / 3 * scale;
    for (const size_t c : {0u, 4u, 8u}) EXPECT_FLOAT_EQ(p.candela[c * 3 + r], float(at180)) << c;
    EXPECT_FLOAT_EQ(p.candela[1 * 3 + r], float(File::value(1, r) * scale));
    EXPECT_FLOAT_EQ(p.candela[7 * 3 + r], float(File::value(2, r) * scale));
  }
}

TEST(IesProfile, NumbersMayBeBrokenAnyhow) {
  File f;
  std::string text = f.text();
  const size_t data = text.find("TILT=NONE\n") + 10;
  for (size_t i = data; i < text.size(); ++i)
    if (text[i] == ' ') text[i] = i % 3 ? ',' : '\n';
  text.insert(data, "  \r\n\t ");
  IesProfile a, b;
  ASSERT_EQ(readIes(text, a).line, 0u);
  ASSERT_EQ(readIes(f.text(), b).line, 0u);
  EXPECT_EQ(a.candela, b.candela);
}

TEST(IesProfile, BrokenFilesAreOneMessageWithALine) {
  const auto expect = [](const std::string& text, uint32_t line, const char* what) {
    IesProfile p;
    const IesError e = readIes(text, p);
    EXPECT_EQ(e.line, line) << e.what;
    EXPECT_NE(e.what.find(what), std::string::npos) << e.what;
  };
  const auto file = [](auto&& change) {
    File f;
    change(f);
    return f.text();
  };
  expect("", 1, "TILT=");
  expect(
      "\x7f"
      "ELF\n\n\n",
      4, "TILT=");
  expect("TILT=NONE", 2, "ends");
  expect(file([](File& f) { f.counts = "2000000000 2000000000"; }), 6, "whole number");
  expect(file([](File& f) { f.counts = "1000000 1000000"; }), 7, "cannot hold");
  expect(file([](File& f) { f.counts = "900 900"; }), 7, "cannot hold");
  expect(file([](File& f) { f.counts = "-3 3"; }), 6, "whole number");
  expect(file([](File& f) { f.counts = "2.5 3"; }), 6, "whole number");
  expect(file([](File& f) { f.counts = "nan 3"; }), 6, "no number");
  expect(file([](File& f) { f.counts = "1 3"; }), 6, "whole number");
  expect(file([](File& f) { f.type = 4; }), 6, "photometric type");
  expect(file([](File& f) { f.multiplier = -1; }), 7, "not positive");
  expect(file([](File& f) { f.vertical = {0, 90, 45}; }), 8, "larger than the one before");
  expect(file([](File& f) { f.vertical = {0, 90, 270}; }), 8, "within 0 and 180");
  expect(file([](File& f) { f.vertical = {0, 90, 1e9}; }), 8, "beyond 360");
  expect(file([](File& f) { f.horizontal = {0, 45, 77}; }), 9, "0 to 77");
  expect(file([](File& f) { f.horizontal = {10, 45, 90}; }), 9, "10 to 90");
  expect(file([](File& f) { f.tilt = "TILT=INCLUDE\n1\n-1\n"; }), 7, "count of tilts");
  std::string cut = file([](File&) {});
  cut.resize(cut.rfind(' ') - 4);
  cut.resize(cut.rfind(' '));
  expect(cut, 12, "ends where a candela value");
  expect(file([](File&) {}).replace(file([](File&) {}).find("110.5"), 5, "-10.5"), 11, "negative");
  expect(std::string(kMostIesBytes + 1, ' '), 1, "16 MiB");
}

TEST(IesProfile, CutsAndMutationsNeverCrash) {
  const std::string good = File().text();
  IesProfile p;
  for (size_t n = 0; n < good.size(); ++n) readIes(std::string_view(good).substr(0, n), p);
  std::mt19937 random(1);
  const char odd[] = "0123456789-+.eE, \n\r\t\0TILT=nainf";
  int errors = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 4; ++k) text[random() % text.size()] = odd[random() % sizeof odd];
    errors += readIes(text, p).line != 0;
    if (errors == i + 1) continue;
    for (float c : p.candela) ASSERT_TRUE(std::isfinite(c));
  }
  EXPECT_GT(errors, 1000);
  EXPECT_LT(errors, 19000);
}

}  // namespace
}  // namespace kinora::light
