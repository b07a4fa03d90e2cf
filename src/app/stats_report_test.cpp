// The statistics report: every figure of render/ reaches the JSON, ratios are of the right pairs, an empty frame
// divides nothing by zero, and the file is written whole or not at all. Misses: whether the figures themselves are
// true.
#include "app/stats_html.h"
#include "app/stats_report.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace kinora::app {
namespace {

using render::StageTime;
using render::Statistics;

Statistics example() {
  Statistics s;
  s.loadSeconds = 0.5;
  s.buildSeconds = 0.25;
  s.renderSeconds = 2;
  s.firstPixelSeconds = 0.75;
  s.firstGroupSeconds = 0.25;
  s.primitives = 3;
  s.triangles = 1200;
  s.lights = 2;
  s.memory = {{"film", 1000}, {"geometry", 5000}};
  s.stageNanoseconds[size_t(StageTime::TraceCamera)] = 4000;
  s.stageNanoseconds[size_t(StageTime::Closures)] = 6000;
  s.cameraRays = 100;
  s.indirectRays = 60;
  s.shadowRays = 40;
  s.samples = 100;
  s.lanesAt[0] = {75, 100, 5};
  s.lanesAt[1] = {30, 48, 3};
  s.lanesAt[2] = {10, 16, 1};
  s.lanesQueries = {3, 8, 1};
  s.shadingPoints = 90;
  s.shadingGroups = 9;
  s.nonFiniteSamples = 1;
  s.shadersCompiled = 2;
  s.shaderPrograms = 2;
  s.shaders = {{"wood", 3, 32, 1000, 2000, 2, 40, 10, {60, 80}},
               {"brick + rust", 1, 16, 500, 6000, 1, 20, 0, {10, 20}}};
  s.textureLookups = 17;
  s.textureTilesAgain = 5;
  s.largestTextures.push_back({"wall.tx", 4096, 3});
  return s;
}

std::string fileText(const std::string& name) {
  std::ifstream stream(name);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(StatsReport, ShadersByTheirTime) {
  const auto j = nlohmann::json::parse(statsAsJson(example(), {"a.rib", 7, "complete", 9000}));
  EXPECT_EQ(j["shaders"]["points"], 1500);
  EXPECT_EQ(j["shaders"]["files_compiled"], 2);
  EXPECT_EQ(j["shaders"]["lane_use"]["share"], 0.7);
  EXPECT_EQ(j["shaders"]["slowest"][0]["name"], "brick + rust");
  EXPECT_EQ(j["shaders"]["slowest"][1]["instructions_per_run"], 20);
  EXPECT_EQ(j["shaders"]["slowest"][1]["nanoseconds_per_point"], 2);
  for (const std::string& text : {statsAsText(example(), {}), statsAsHtml(example(), {})}) {
    EXPECT_NE(text.find("brick + rust"), std::string::npos);
    EXPECT_NE(text.find("1500"), std::string::npos);
  }
  render::Statistics none = example();
  none.shaders.clear();
  EXPECT_FALSE(nlohmann::json::parse(statsAsJson(none, {})).contains("shaders"));
}

TEST(StatsReport, JsonHoldsTheFiguresAndTheirRatios) {
  const auto j = nlohmann::json::parse(statsAsJson(example(), {"a.rib", 7, "complete", 9000}));
  EXPECT_EQ(j["scene"], "a.rib");
  EXPECT_EQ(j["frame"], 7);
  EXPECT_EQ(j["outcome"], "complete");
  EXPECT_EQ(j["seconds"]["render"], 2.0);
  EXPECT_EQ(j["seconds"]["first_pixel"], 0.75);
  EXPECT_EQ(j["seconds"]["first_group"], 0.25);
  EXPECT_EQ(j["world"]["triangles"], 1200);
  EXPECT_EQ(j["memory_bytes"]["by_owner"]["geometry"], 5000);
  EXPECT_EQ(j["memory_bytes"]["sum"], 6000);
  EXPECT_EQ(j["memory_bytes"]["resident_peak"], 9000);
  EXPECT_EQ(j["rays"]["all"], 200);
  EXPECT_EQ(j["rays"]["per_sample"], 2.0);
  EXPECT_EQ(j["rays"]["per_second"], 100.0);
  EXPECT_EQ(j["rays"]["nanoseconds_per_ray"], 50.0);
  const auto& trace = j["stages"][render::nameOf(StageTime::TraceCamera)];
  EXPECT_DOUBLE_EQ(trace["seconds"], 4e-6);
  EXPECT_DOUBLE_EQ(trace["share"], 0.4);
  EXPECT_DOUBLE_EQ(trace["nanoseconds_per_ray"], 20);
  EXPECT_DOUBLE_EQ(trace["nanoseconds_per_own_ray"], 40);
  EXPECT_EQ(j["stages"].size(), size_t(StageTime::Count));
  EXPECT_DOUBLE_EQ(j["lane_use"]["first_hit"]["share"], 0.75);
  EXPECT_DOUBLE_EQ(j["lane_use"]["deeper"]["share"], 0.625);
  EXPECT_DOUBLE_EQ(j["lane_use"]["queries"]["share"], 0.375);
  ASSERT_EQ(j["lane_use"]["by_depth"].size(), 3u);
  EXPECT_DOUBLE_EQ(j["lane_use"]["by_depth"][1]["points_per_group"], 10);
  EXPECT_DOUBLE_EQ(j["shading"]["points_per_group"], 10);
  EXPECT_EQ(j["film"]["non_finite"], 1);
  EXPECT_EQ(j["textures"]["lookups"], 17);
  EXPECT_EQ(j["textures"]["tiles_read_again"], 5);
  EXPECT_EQ(j["textures"]["largest"][0]["file"], "wall.tx");
  EXPECT_EQ(j["textures"]["largest"][0]["tiles_read_again"], 3);
}

TEST(StatsReport, AFrameWithoutRaysGivesNumbersEverywhere) {
  const std::string text = statsAsJson(Statistics(), {"", 0, "failed", 0});
  EXPECT_EQ(text.find("null"), std::string::npos) << text;  // JSON's word for NaN
  const auto j = nlohmann::json::parse(text);
  EXPECT_EQ(j["rays"]["nanoseconds_per_ray"], 0.0);
  EXPECT_FALSE(j["seconds"].contains("first_pixel"));
  EXPECT_FALSE(j["seconds"].contains("first_group"));
  const std::string lines = statsAsText(Statistics(), {"", 0, "failed", 0});
  EXPECT_EQ(lines.find("nan"), std::string::npos) << lines;
}

TEST(StatsReport, TextNamesLargestOwnerFirst) {
  const std::string text = statsAsText(example(), {"a.rib", 7, "complete", 0});
  const std::string memory = text.substr(text.find("\nMemory\n"));
  EXPECT_NE(memory.find("geometry"), std::string::npos) << text;
  EXPECT_LT(memory.find("  geometry "), memory.find("  film ")) << text;
  EXPECT_NE(text.find("camera 100, indirect 60, shadow 40"), std::string::npos) << text;
}

TEST(StatsReport, NamesWithBrokenUtf8DoNotStopTheReport) {
  const auto j = nlohmann::json::parse(statsAsJson(example(), {"bad\xff.rib", 1, "complete", 0}));
  EXPECT_EQ(j["frame"], 1);
}

TEST(StatsReport, FileIsWrittenWholeOrNotAtAll) {
  const std::string folder = testing::TempDir() + "kinora_stats_" + std::to_string(getpid());
  std::filesystem::create_directories(folder);
  std::vector<std::string> messages;
  Diagnostics diagnostics([&](const std::string& line, Severity) { messages.push_back(line); });
  EXPECT_TRUE(writeStats(folder + "/s.json", example(), {"a.rib", 1, "complete", 0}, diagnostics));
  EXPECT_EQ(nlohmann::json::parse(fileText(folder + "/s.json"))["frame"], 1);
  EXPECT_TRUE(writeStats(folder + "/s.txt", example(), {"a.rib", 1, "complete", 0}, diagnostics));
  EXPECT_NE(fileText(folder + "/s.txt").find("Lane use"), std::string::npos);
  EXPECT_TRUE(messages.empty());
  EXPECT_FALSE(writeStats(folder + "/missing/s.json", example(), {"a.rib", 1, "complete", 0}, diagnostics));
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("missing/s.json"), std::string::npos) << messages[0];
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2) << "a temporary was left behind";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace kinora::app
