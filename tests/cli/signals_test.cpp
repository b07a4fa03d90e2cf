// Signals and time limits: what is on the disk afterwards is whole, and what was done is not lost. Misses: power
// cuts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <regex>

#include "run_program.h"

namespace kinora::cli {
namespace {

bool isReadable(const Workplace& w, const std::string& file) { return w.run({"diff", file, file}).exitCode == 0; }

// KINORA_SIGNAL_MOMENTS asks for more moments than a test run has time for.
int moments() {
  const char* asked = std::getenv("KINORA_SIGNAL_MOMENTS");
  return asked ? std::max(1, std::atoi(asked)) : 8;
}

TEST(Signals, SigtermAtAnyMomentLeavesAWholePictureOrNone) {
  SceneParts parts;
  parts.display =
      "Display \"out.exr\" \"openexr\" \"rgba\"\nDisplay \"+out.png\" \"png\" \"rgba\"\nDisplay \"+out.tif\" "
      "\"tiff\" "
      "\"rgba\"";
  std::mt19937 random(20);
  std::uniform_real_distribution<double> moment(0.0, 0.5);
  const int runs = moments();
  int pictures = 0, interrupted = 0;
  for (int i = 0; i < runs; ++i) {
    Workplace w;
    w.write("scene.rib", rib(parts));
    RunOptions options;
    options.timeoutSeconds = 60;
    options.signalAfterSeconds = moment(random);
    options.fromFirstOutput = i % 5 != 0;  // the others: while the scene is read and built
    // snapshots all the time: most signals come while a file is being written
    const Result r = w.run(
        {"scene.rib", "--spp", "65536", "--res", "96x72", "--snapshot", "0.001", "--progress", "json"}, options);
    EXPECT_FALSE(r.isTimedOut) << options.signalAfterSeconds;
    // before main() there is no handler yet
    EXPECT_TRUE(r.exitCode == 7 || r.signal == SIGTERM) << r.exitCode << " " << r.err;
    interrupted += r.exitCode == 7;
    for (const std::string& name : w.files()) {
      if (name == "scene.rib") continue;
      EXPECT_TRUE(name == "out.exr" || name == "out.png" || name == "out.tif") << name;
      EXPECT_TRUE(isReadable(w, name)) << name << " after " << options.signalAfterSeconds << " s";
      ++pictures;
    }
  }
  EXPECT_GT(pictures, runs / 2) << "the moments were too early to show anything";
  EXPECT_GT(interrupted, runs / 2) << "most signals come after main() has begun";
  std::printf("%d moments: %d ended with code 7, %d whole pictures, no other file\n", runs, interrupted, pictures);
}

TEST(Signals, APartInterruptedHoldsTheSamplesThatAreComplete) {
  Workplace w;
  w.write("scene.rib", rib());
  RunOptions options;
  options.timeoutSeconds = 60;
  options.terminateWhen = [](const std::string& out) {
    const size_t at = out.rfind("\"samples_done\":");
    return at != std::string::npos && std::atoi(out.c_str() + at + 15) >= 8;
  };
  const Result r =
      w.run({"scene.rib", "--res", "300x200", "--samples", "0:65536", "-o", "a.exr", "--progress", "json"}, options);
  ASSERT_EQ(r.exitCode, 7) << r.err;
  std::smatch match;
  ASSERT_TRUE(std::regex_search(r.err, match, std::regex("samples 0:([0-9]+)\\)"))) << r.err;
  const int done = std::stoi(match[1]);
  ASSERT_GE(done, 8);
  // the rest of a frame of `done` + 4 samples
  const std::string end = std::to_string(done + 4);
  ASSERT_EQ(w.run({"scene.rib", "--res", "300x200", "--samples", std::to_string(done) + ":" + end, "-o", "b.exr",
                   "--progress", "none"})
                .exitCode,
            0);
  ASSERT_EQ(w.run({"scene.rib", "--res", "300x200", "--spp", end, "-o", "whole.exr", "--progress", "none"}).exitCode,
            0);
  const Result merged = w.run({"merge", "a.exr", "b.exr", "-o", "merged.exr"});
  ASSERT_EQ(merged.exitCode, 0) << merged.err;
  EXPECT_EQ(w.run({"diff", "whole.exr", "merged.exr"}).exitCode, 0)
      << "interrupted and continued is not the same picture";
}

TEST(Signals, APartWithoutASampleIsNotWritten) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r =
      w.run({"scene.rib", "--samples", "0:65536", "-o", "part.exr", "--max-time", "0", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 7) << r.err;
  EXPECT_FALSE(w.has("part.exr"));
}

TEST(Signals, MaxTimeEndsAsSigtermDoes) {
  Workplace w;
  w.write("scene.rib", rib());
  RunOptions options;
  options.timeoutSeconds = 60;
  const Result r = w.run({"scene.rib", "--spp", "65536", "--max-time", "1s", "--progress", "none"}, options);
  EXPECT_FALSE(r.isTimedOut);
  EXPECT_EQ(r.exitCode, 7) << r.err;
  EXPECT_TRUE(isReadable(w, "out.exr"));
  EXPECT_NE(r.err.find("interrupted"), std::string::npos) << r.err;
  EXPECT_EQ(w.run({"scene.rib", "--max-time", "soon"}).exitCode, 2);
}

// A scene's own limit is one for each frame: those behind it are rendered.
TEST(Signals, RenderTimeOfTheSceneEndsAFrame) {
  Workplace w;
  std::string text;
  for (const char* frame : {"1", "2"}) {
    SceneParts parts;
    parts.options = std::string("FrameBegin ") + frame + "\nOption \"limits\" \"float rendertime\" [0.01]";
    parts.display = std::string("Display \"out") + frame + ".exr\" \"openexr\" \"rgba\"";
    parts.samples = "Hider \"raytrace\" \"int maxsamples\" [65536]";
    text += rib(parts) + "FrameEnd\n";
  }
  w.write("scene.rib", text);
  RunOptions options;
  options.timeoutSeconds = 60;
  const Result r = w.run({"scene.rib", "--progress", "none"}, options);
  EXPECT_FALSE(r.isTimedOut);
  EXPECT_EQ(r.exitCode, 7) << r.err;
  EXPECT_TRUE(isReadable(w, "out1.exr"));
  EXPECT_TRUE(isReadable(w, "out2.exr"));
  EXPECT_NE(r.err.find("interrupted"), std::string::npos) << r.err;
}

TEST(Signals, Sigusr1WritesThePictureAndGoesOn) {
  Workplace w;
  w.write("scene.rib", rib());
  RunOptions options;
  options.timeoutSeconds = 60;
  options.signal = SIGUSR1;
  options.terminateWhen = [](const std::string& out) { return out.find("\"samples_done\":2,") != std::string::npos; };
  // no other snapshot: the picture can only come from the signal, which the time limit then outlives
  const Result r =
      w.run({"scene.rib", "--spp", "65536", "--snapshot", "0", "--max-time", "2", "--progress", "json"}, options);
  EXPECT_EQ(r.signal, 0);
  EXPECT_EQ(r.exitCode, 7) << r.err;
  EXPECT_TRUE(w.has("out.exr"));
}

TEST(Signals, AFullDiskDuringASnapshotLosesNothing) {
  Workplace w;
  SceneParts parts;
  parts.display = "Display \"out.exr\" \"openexr\" \"rgba\" \"string compression\" [\"none\"]";
  w.write("scene.rib", rib(parts));
  RunOptions options;
  options.fileSizeLimit = 2000;
  const Result r = w.run({"scene.rib", "--spp", "64", "--snapshot", "0.001", "--progress", "none"}, options);
  EXPECT_EQ(r.exitCode, 6) << r.err;  // the disk is still full at the end
  EXPECT_NE(r.err.find("warning DISPLAY-SNAPSHOT"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("error DISPLAY-WRITE"), std::string::npos) << r.err;
  EXPECT_EQ(w.files(), std::vector<std::string>{"scene.rib"});
}

}  // namespace
}  // namespace kinora::cli
