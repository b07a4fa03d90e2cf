// Progress in its forms: what a line says, how often one is written, that each JSON line parses. Misses: how a real
// terminal shows the bar.
#include "app/progress_reporter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

namespace kinora::app {
namespace {

render::Progress at(double fraction) {
  render::Progress p;
  p.fraction = fraction;
  p.seconds = 10 * fraction;
  p.secondsLeft = fraction > 0 ? 10 * (1 - fraction) : -1;
  p.memoryBytes = 512000000;
  p.samplesDone = int(64 * fraction);
  p.samplesWanted = 64;
  return p;
}

// What a reporter writes for `steps` equal steps from 0 to 1.
std::string written(ProgressMode mode, int steps) {
  std::FILE* file = std::tmpfile();
  {
    ProgressReporter reporter(mode, file, "frame 3");
    for (int i = 0; i <= steps; ++i) reporter(at(double(i) / steps));
  }
  std::rewind(file);
  std::string text;
  for (int c; (c = std::fgetc(file)) != EOF;) text += char(c);
  std::fclose(file);
  return text;
}

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Progress, ClockAndBytesAreShort) {
  EXPECT_EQ(asClock(-1), "?");
  EXPECT_EQ(asClock(7.4), "0:07");
  EXPECT_EQ(asClock(3599.7), "1:00:00");
  EXPECT_EQ(asClock(3723), "1:02:03");
  EXPECT_EQ(asClock(1e300), "?");
  EXPECT_EQ(asBytes(999), "999 B");
  EXPECT_EQ(asBytes(1400), "1.4 kB");
  EXPECT_EQ(asBytes(999999), "1.0 MB");
  EXPECT_EQ(asBytes(512000000), "512 MB");
}

TEST(Progress, LineHoldsPercentSamplesTimesAndMemory) {
  EXPECT_EQ(progressLine(at(0.5), ""), " 50 %  32/64 samples  0:05 so far  0:05 left  512 MB");
  EXPECT_EQ(progressLine(at(0), "frame 3"), "frame 3    0 %  0/64 samples  0:00 so far  ? left  512 MB");
}

TEST(Progress, LinesComeOnceAPercent) {
  const auto lines = linesOf(written(ProgressMode::Lines, 1000));
  EXPECT_EQ(lines.size(), 101u);
  EXPECT_NE(lines.back().find("100 %"), std::string::npos);
}

TEST(Progress, AutoOnAFileIsLines) { EXPECT_EQ(written(ProgressMode::Auto, 200), written(ProgressMode::Lines, 200)); }

TEST(Progress, EachJsonLineIsAnObject) {
  const auto lines = linesOf(written(ProgressMode::Json, 200));
  ASSERT_EQ(lines.size(), 101u);
  double last = -1;
  for (const std::string& line : lines) {
    const auto j = nlohmann::json::parse(line);
    EXPECT_GT(j["fraction"].get<double>(), last);
    last = j["fraction"];
    EXPECT_EQ(j["samples_wanted"], 64);
    EXPECT_EQ(j["frame"], "frame 3");
  }
  EXPECT_EQ(last, 1.0);
  EXPECT_TRUE(nlohmann::json::parse(lines.front())["seconds_left"].is_null());
}

TEST(Progress, BarEndsItsLineAndShowsTheEnd) {
  const std::string text = written(ProgressMode::Bar, 1000);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
  EXPECT_NE(text.find("[##############################] frame 3  100 %"), std::string::npos);
  // ten seconds at no more than ten drawings a second
  EXPECT_LE(std::count(text.begin(), text.end(), '\r'), 102);
}

TEST(Progress, NoneIsSilent) { EXPECT_EQ(written(ProgressMode::None, 50), ""); }

TEST(Progress, FractionsOutsideAreClamped) {
  EXPECT_EQ(progressLine(at(1.5), "").substr(0, 5), "100 %");
  EXPECT_EQ(nlohmann::json::parse(progressJson(at(-1), ""))["fraction"], 0.0);
}

}  // namespace
}  // namespace kinora::app
