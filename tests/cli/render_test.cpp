// `kinora render` as a user meets it: where pictures go, progress in each form, statistics, parts and their merging,
// replay, interruption. Misses: what is in the pictures.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "run_program.h"

namespace kinora::cli {
namespace {

std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

bool isIdentical(const Workplace& w, const std::string& a, const std::string& b) {
  return w.run({"diff", a, b}).exitCode == 0;
}

TEST(Render, PictureGoesWhereTheSceneOrTheOptionSays) {
  Workplace w;
  w.write("scene.rib", rib());
  Result r = w.run({"scene.rib"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("out.exr"));
  EXPECT_NE(r.err.find("kinora: wrote "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("/out.exr"), std::string::npos) << r.err;
  for (const char* name : {"other.png", "other.exr", "other.tif", "other.jpg"}) {
    r = w.run({"render", "scene.rib", "-o", name, "--progress", "none"});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    EXPECT_TRUE(w.has(name));
    EXPECT_EQ(w.run({"info", name}).exitCode, 0);
  }
}

TEST(Render, StandardInputAndSeveralFilesAreOneStream) {
  Workplace w;
  RunOptions input;
  input.input = rib();
  EXPECT_EQ(w.run({"-", "-o", "piped.exr", "--progress", "none"}, input).exitCode, 0);
  const std::string whole = rib();
  const size_t half = whole.find("WorldBegin");
  w.write("head.rib", whole.substr(0, half));
  w.write("tail.rib", whole.substr(half));
  EXPECT_EQ(w.run({"head.rib", "tail.rib", "-o", "two.exr", "--progress", "none"}).exitCode, 0);
  EXPECT_TRUE(isIdentical(w, "piped.exr", "two.exr"));
}

// Displays that name cameras show what those see, each frame of them its own.
TEST(Render, DisplaysShowTheirOwnCameras) {
  Workplace w;
  const auto scene = [](const std::string& displays, double x) {
    SceneParts parts;
    parts.display = displays;
    parts.camera = "Projection \"perspective\" \"fov\" [40]\n";
    for (const auto& [name, shift] : {std::pair{"left", "0.3"}, {"right", "-0.3"}})
      parts.camera +=
          std::string("TransformBegin Translate ") + shift + " 0 4 Camera \"" + name + "\" TransformEnd\n";
    parts.camera += "Translate " + std::to_string(x) + " 0 4";
    return rib(parts);
  };
  const auto show = [](const char* file, const char* camera) {
    return std::string("Display \"") + file + "\" \"openexr\" \"rgba\"" +
           (*camera ? std::string(" \"string camera\" [\"") + camera + "\"]" : "") + "\n";
  };
  w.write("alone.rib", scene(show("l.exr", ""), 0.3));
  w.write("other.rib", scene(show("r.exr", ""), -0.3));
  w.write("middle.rib", scene(show("m.exr", ""), 0));
  for (const char* file : {"alone.rib", "other.rib", "middle.rib"}) EXPECT_EQ(w.run({file}).exitCode, 0);
  w.write("all.rib", scene(show("l2.exr", "left") + show("+r2.exr", "right") + show("+m2.exr", ""), 0));
  const Result r = w.run({"all.rib"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(isIdentical(w, "l.exr", "l2.exr"));
  EXPECT_TRUE(isIdentical(w, "r.exr", "r2.exr"));
  EXPECT_TRUE(isIdentical(w, "m.exr", "m2.exr"));
  EXPECT_FALSE(isIdentical(w, "l.exr", "r.exr"));
  // -o is for the primary display; the other cameras' keep their names
  EXPECT_EQ(w.run({"all.rib", "-o", "named.exr", "--stats", "s.json"}).exitCode, 0);
  EXPECT_TRUE(isIdentical(w, "l.exr", "named.exr"));
  // parts go beside each picture and merge to it
  for (const char* part : {"0:2", "2:4"}) EXPECT_EQ(w.run({"all.rib", "--samples", part}).exitCode, 0);
  EXPECT_EQ(w.run({"merge", "r2.samples-0-2.exr", "r2.samples-2-4.exr", "-o", "merged.exr"}).exitCode, 0);
  EXPECT_TRUE(isIdentical(w, "r.exr", "merged.exr"));
  const Result part = w.run({"all.rib", "--samples", "0:2", "-o", "part.exr"});
  EXPECT_EQ(part.exitCode, 0) << part.err;
  EXPECT_NE(part.err.find("DISPLAY-CAMERA"), std::string::npos) << part.err;
  w.write("wrong.rib", scene(show("l.exr", "middle"), 0.3));
  const Result wrong = w.run({"wrong.rib"});
  EXPECT_EQ(wrong.exitCode, 0);
  EXPECT_NE(wrong.err.find("DISPLAY-CAMERA"), std::string::npos) << wrong.err;
}

// Words that stand for choices and for none of them.
TEST(Render, WordsThatAreNoChoiceAreTold) {
  Workplace w;
  for (const auto& [word, isOne] : {std::pair{"Nn", true}, {"identifier:id", true}, {"VLen", false}}) {
    SceneParts parts;
    parts.material = std::string("Pattern \"PxrVariable\" \"v\" \"string variable\" [\"") + word +
                     "\"]\nBxdf \"PxrDiffuse\" \"m\" \"reference color diffuseColor\" [\"v:resultRGB\"]";
    w.write("scene.rib", rib(parts));
    const Result r = w.run({"scene.rib", "--check"});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    EXPECT_EQ(r.err.find("PARAM-CHOICE") == std::string::npos, isOne) << r.err;
  }
}

TEST(Render, ResolutionAndCropOverrideTheScene) {
  Workplace w;
  w.write("scene.rib", rib());
  EXPECT_EQ(w.run({"scene.rib", "--res", "20x10", "--progress", "none"}).exitCode, 0);
  EXPECT_NE(w.run({"info", "out.exr"}).out.find("20 x 10"), std::string::npos) << w.run({"info", "out.exr"}).out;
  EXPECT_EQ(w.run({"scene.rib", "--crop", "0", "0.5", "0", "0.5", "-o", "crop.exr", "--progress", "none"}).exitCode,
            0);
  EXPECT_NE(w.run({"info", "crop.exr"}).out.find("16 x 12"), std::string::npos) << w.run({"info", "crop.exr"}).out;
}

TEST(Render, SetChangesAParameter) {
  Workplace w;
  SceneParts parts;
  parts.geometry = "Sphere 1 -1 1 360 Polygon \"vertex point P\" [-9 -1 -9  9 -1 -9  9 -1 9  -9 -1 9]";
  w.write("scene.rib", rib(parts));
  EXPECT_EQ(w.run({"scene.rib", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(
      w.run({"scene.rib", "-o", "b.exr", "--set", "integrator.maxIndirectBounces=0", "--progress", "none"}).exitCode,
      0);
  EXPECT_EQ(w.run({"diff", "a.exr", "b.exr"}).exitCode, 1);
}

TEST(Render, SameBitsForAnyThreadsWidthGroupAndOrder) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "-o", "a.exr", "-t", "1", "--progress", "none"}).exitCode, 0);
  const std::vector<std::vector<std::string>> ways{
      {"-t", "2"}, {"--width", "1"}, {"--width", "4"}, {"--group-size", "256"}, {"--bucket-order", "spiral"}};
  for (const auto& way : ways) {
    std::vector<std::string> arguments{"scene.rib", "-o", "b.exr", "--progress", "none"};
    arguments.insert(arguments.end(), way.begin(), way.end());
    ASSERT_EQ(w.run(arguments).exitCode, 0) << way[0] << " " << way[1];
    EXPECT_TRUE(isIdentical(w, "a.exr", "b.exr")) << way[0] << " " << way[1];
  }
}

TEST(Render, CheckReadsAndWritesNothing) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r = w.run({"scene.rib", "--check"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_FALSE(r.out.empty());
  EXPECT_EQ(w.files(), (std::vector<std::string>{"scene.rib"}));
}

TEST(Render, ProgressOnAPipeIsALineAPercent) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r = w.run({"scene.rib"});
  const auto lines = linesOf(r.err);
  const auto isLine = [](const std::string& l) { return l.find(" % ") != std::string::npos; };
  EXPECT_GE(std::count_if(lines.begin(), lines.end(), isLine), 1) << r.err;
  EXPECT_LE(std::count_if(lines.begin(), lines.end(), isLine), 101);
  EXPECT_NE(r.err.find("100 % "), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find('\r'), std::string::npos);
}

TEST(Render, ProgressAsJsonIsAloneOnStandardOutput) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r = w.run({"scene.rib", "--progress", "json"});
  ASSERT_EQ(r.exitCode, 0) << r.err;
  const auto lines = linesOf(r.out);
  ASSERT_FALSE(lines.empty());
  for (const std::string& line : lines) EXPECT_TRUE(nlohmann::json::accept(line)) << line;
  EXPECT_EQ(nlohmann::json::parse(lines.back())["fraction"], 1.0);
}

TEST(Render, ProgressBarAndSilence) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result bar = w.run({"scene.rib", "--progress", "bar"});
  EXPECT_NE(bar.err.find("[##############################]"), std::string::npos) << bar.err;
  EXPECT_EQ(w.run({"scene.rib", "--progress", "none", "-q"}).err, "");
  EXPECT_EQ(w.run({"scene.rib", "-q"}).err, "");
}

TEST(Render, StatisticsAsJsonAndText) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "--stats", "s.json", "--progress", "none"}).exitCode, 0);
  std::ifstream stream(w.path("s.json"));
  const auto j = nlohmann::json::parse(stream);
  EXPECT_EQ(j["outcome"], "complete");
  // 32 x 24 pixels of 4 samples; camera packets are whole blocks, so that more may be traced
  EXPECT_GE(j["film"]["samples"].get<int>(), 32 * 24 * 4);
  EXPECT_GE(j["rays"]["camera"].get<int>(), 32 * 24 * 4);
  EXPECT_GT(j["rays"]["shadow"].get<int>(), 0);
  EXPECT_GT(j["memory_bytes"]["sum"].get<int64_t>(), 0);
  EXPECT_EQ(j["world"]["lights"], 1);
  const double use = j["lane_use"]["first_hit"]["share"];
  EXPECT_GT(use, 0);
  EXPECT_LE(use, 1);
  ASSERT_EQ(w.run({"scene.rib", "--stats", "s.txt", "--progress", "none"}).exitCode, 0);
  EXPECT_TRUE(w.has("s.txt"));
}

TEST(Render, PartsMergeToTheWholeBitForBit) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "-o", "whole.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:1", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--samples", "1:4", "-o", "b.exr", "--progress", "none"}).exitCode, 0);
  const Result merged = w.run({"merge", "b.exr", "a.exr", "-o", "merged.exr"});
  ASSERT_EQ(merged.exitCode, 0) << merged.err;
  EXPECT_TRUE(isIdentical(w, "whole.exr", "merged.exr"));
  EXPECT_FALSE(isIdentical(w, "whole.exr", "a.exr"));
}

TEST(Render, MergeRefusesPartsOfDifferentFrames) {
  Workplace w;
  w.write("scene.rib", rib());
  SceneParts other;
  other.geometry = "Sphere 0.5 -0.5 0.5 360";
  w.write("other.rib", rib(other));
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:2", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"other.rib", "--samples", "2:4", "-o", "b.exr", "--progress", "none"}).exitCode, 0);
  const Result r = w.run({"merge", "a.exr", "b.exr", "-o", "merged.exr"});
  EXPECT_EQ(r.exitCode, 3) << r.err;
  EXPECT_FALSE(w.has("merged.exr"));
}

TEST(Render, OnlySamplePrintsTheEventsOfOnePath) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r = w.run({"scene.rib", "--only-sample", "16,12,1"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_GE(linesOf(r.out).size(), 2u) << r.out;
  EXPECT_FALSE(w.has("out.exr"));
  EXPECT_EQ(w.run({"scene.rib", "--only-sample", "99,99,0"}).exitCode, 2);
}

TEST(Render, SigtermEndsSoonWithAReadablePictureAndCodeSeven) {
  Workplace w;
  w.write("scene.rib", rib());
  RunOptions options;
  options.timeoutSeconds = 60;
  options.terminateWhen = [](const std::string& out) { return !out.empty(); };
  const Result r = w.run({"scene.rib", "--spp", "65536", "--progress", "json"}, options);
  EXPECT_FALSE(r.isTimedOut);
  EXPECT_EQ(r.signal, 0);
  EXPECT_EQ(r.exitCode, 7) << r.err;
  for (const std::string& name : w.files()) EXPECT_TRUE(name == "scene.rib" || name == "out.exr") << name;
  if (w.has("out.exr")) {
    EXPECT_EQ(w.run({"info", "out.exr"}).exitCode, 0);
  }
}

// The scenes that documentation promises to work: that of the README as it stands there, and the gallery.
TEST(Render, SceneOfTheReadmeRendersWithoutAWord) {
  std::ifstream stream(KINORA_SOURCE_DIR "/README.md");
  std::stringstream text;
  text << stream.rdbuf();
  const std::string readme = text.str(), opening = "```rib\n";
  const size_t begin = readme.find(opening);
  ASSERT_NE(begin, std::string::npos);
  const size_t end = readme.find("```", begin + opening.size());
  Workplace w;
  w.write("ball.rib", readme.substr(begin + opening.size(), end - begin - opening.size()));
  const Result r = w.run({"ball.rib", "--spp", "1", "--res", "64x36", "--progress", "none", "-q", "--strict"});
  EXPECT_EQ(r.exitCode, 0);
  EXPECT_EQ(r.err, "");
  EXPECT_TRUE(w.has("ball.exr"));
  EXPECT_TRUE(w.has("ball.png"));
}

TEST(Render, GalleryRendersWithoutAWord) {
  std::set<std::string> scenes;
  for (const auto& e : std::filesystem::directory_iterator(KINORA_SOURCE_DIR "/scenes"))
    if (e.path().extension() == ".rib") scenes.insert(e.path().stem());
  EXPECT_GE(scenes.size(), 6u);
  for (const std::string& scene : scenes) {
    Workplace w;
    const Result r = w.run({KINORA_SOURCE_DIR "/scenes/" + scene + ".rib", "--spp", "1", "--res", "64x36",
                            "--progress", "none", "-q", "--strict"});
    EXPECT_EQ(r.exitCode, 0) << scene;
    EXPECT_EQ(r.err, "") << scene;
    EXPECT_TRUE(w.has(scene + ".exr")) << scene;
    EXPECT_TRUE(w.has(scene + ".png")) << scene;
  }
}

TEST(Commands, HelpAndVersionWorkEverywhere) {
  Workplace w;
  EXPECT_EQ(w.run({"--help"}).exitCode, 0);
  EXPECT_EQ(w.run({"--version"}).exitCode, 0);
  for (const char* command : {"render", "plugins", "info", "diff", "merge", "rib", "explain"}) {
    const Result help = w.run({command, "--help"});
    EXPECT_EQ(help.exitCode, 0) << command;
    EXPECT_NE(help.out.find("Usage"), std::string::npos) << command;
    EXPECT_EQ(help.err, "") << command;
    EXPECT_NE(w.run({command, "--version"}).out.find("kinora "), std::string::npos) << command;
  }
}

TEST(Commands, PluginsPrintsTheManual) {
  Workplace w;
  const Result page = w.run({"plugins", "pxrdiffuse", "--markdown"});
  EXPECT_EQ(page.exitCode, 0);
  EXPECT_TRUE(page.out.starts_with("# PxrDiffuse\n")) << page.out;
  EXPECT_NE(page.out.find("| `diffuseColor` | color | 0.5 |"), std::string::npos) << page.out;
  const Result index = w.run({"plugins", "--markdown"});
  EXPECT_NE(index.out.find("[PxrDiffuse](plugins/PxrDiffuse.md)"), std::string::npos) << index.out;
}

TEST(Commands, InfoTellsAboutScenesAndPictures) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result scene = w.run({"info", "scene.rib"});
  EXPECT_EQ(scene.exitCode, 0);
  for (const char* part : {"32 x 24", "1 quadrics", "1 PxrDiffuse", "1 PxrRectLight"})
    EXPECT_NE(scene.out.find(part), std::string::npos) << part << "\n" << scene.out;
  EXPECT_EQ(w.run({"info", "missing.exr"}).exitCode, 3);
}

TEST(Commands, InfoTellsAboutArchivesAndClassicShaders) {
  Workplace w;
  w.write("part.rib",
          "AttributeBegin\nLightSource \"pointlight\" 1\nSurface \"plastic\"\nDisplacement \"dented\"\n"
          "Sphere 1 -1 1 360\nSphere 2 -2 2 360\nAttributeEnd\n");
  const Result archive = w.run({"info", "part.rib"});
  EXPECT_EQ(archive.exitCode, 0) << archive.err;
  for (const char* part : {"archive", "2 quadrics", "1 plastic", "1 dented", "1 pointlight"})
    EXPECT_NE(archive.out.find(part), std::string::npos) << part << "\n" << archive.out;
  EXPECT_EQ(archive.err.find("RIB-NO-WORLD"), std::string::npos) << archive.err;
  w.write("bad.rib", "");
  EXPECT_EQ(w.run({"info", "bad.rib"}).exitCode, 3);
}

// Exporters write the two times that the shutter opens and closes between, as older renderers had them.
TEST(Commands, AShutterOpeningOfTwoNumbersIsItsTimes) {
  Workplace w;
  const auto scene = [&](const std::string& name, const std::string& hider, const std::string& camera) {
    w.write(name, "Display \"" + name + ".exr\" \"openexr\" \"rgba\"\nFormat 24 24 1\nShutter 0 1\n" +
                      "Hider \"raytrace\" \"int maxsamples\" [16] \"int minsamples\" [16] " + hider +
                      "\nProjection \"perspective\"\nTranslate 0 0 5\n" + camera +
                      "WorldBegin\nBxdf \"PxrConstant\" \"c\"\nMotionBegin [0 1]\nTranslate -2 0 0\n"
                      "Translate 2 0 0\nMotionEnd\nSphere 1 -1 1 360\nWorldEnd\n");
    return w.run({"render", name});
  };
  const Result by = scene("hider.rib", "\"float[2] shutteropening\" [.25 .5]", "");
  EXPECT_EQ(by.exitCode, 0) << by.err;
  EXPECT_EQ(by.err.find("RENDER-SHUTTER"), std::string::npos) << by.err;
  scene("camera.rib", "", "Camera \"main\" \"float shutterOpenTime\" [.25] \"float shutterCloseTime\" [.5]\n");
  scene("none.rib", "", "");
  EXPECT_EQ(w.run({"diff", "hider.rib.exr", "camera.rib.exr"}).exitCode, 0);
  EXPECT_EQ(w.run({"diff", "hider.rib.exr", "none.rib.exr"}).exitCode, 1);
}

TEST(Commands, ExplainKnowsEveryCodeItLists) {
  Workplace w;
  const auto codes = linesOf(w.run({"explain"}).out);
  ASSERT_GT(codes.size(), 20u);
  EXPECT_EQ(w.run({"explain", codes.front()}).exitCode, 0);
  EXPECT_EQ(w.run({"explain", codes.back()}).exitCode, 0);
}

}  // namespace
}  // namespace kinora::cli
