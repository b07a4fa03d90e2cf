// Proves: a frame that was stopped at a checkpoint, by a signal or by a limit, and gone on with has the bits of one that
// was not, whatever its integrator and its way of sampling; what cannot be gone on from is told and begun anew. Misses:
// power cuts, other machines.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "run_program.h"

namespace kinora::cli {
namespace {

using Arguments = std::vector<std::string>;

const char* const kCheckpoint = "out.exr.checkpoint";

Arguments with(Arguments a, const Arguments& more) {
  a.insert(a.end(), more.begin(), more.end());
  if (std::find(a.begin(), a.end(), "--progress") == a.end()) a.insert(a.end(), {"--progress", "none"});
  return a;
}

struct Way {
  const char* name;
  Arguments arguments;
};
const std::vector<Way>& ways() {
  static const std::vector<Way> all{
      {"paths", {"--spp", "24"}},
      {"guided", {"--spp", "24", "--set", "integrator.risPathGuiding=1", "--set", "integrator.learnLights=1"}},
      {"vcm", {"--spp", "24", "--integrator", "PxrVCM"}},
      {"by pixel", {"--pixel-variance", "0.03", "--max-spp", "64", "--min-spp", "4"}},
      {"by picture", {"--error", "0.04", "--max-spp", "96", "--min-spp", "4"}},
  };
  return all;
}

TEST(Checkpoint, AStoppedFrameHasTheBitsOfAWholeOne) {
  for (const Way& way : ways()) {
    Workplace w;
    SceneParts parts;
    parts.options = "PixelFilter \"catmull-rom\" 4 4";
    w.write("scene.rib", rib(parts));
    const Arguments scene = with({"scene.rib"}, way.arguments);
    ASSERT_EQ(w.run(with(scene, {"-o", "whole.exr"})).exitCode, 0) << way.name;
    // stops after the third pass, and again after two more
    for (const char* at : {"2i,3i", "1i,2i"}) {
      const Result r = w.run(with(scene, {"--recover", "--checkpoint", at}));
      EXPECT_EQ(r.exitCode, 7) << way.name << r.err;
      EXPECT_TRUE(w.has("out.exr")) << way.name;
      ASSERT_TRUE(w.has(kCheckpoint)) << way.name;
    }
    const Result r = w.run(with(scene, {"--recover", "--checkpoint", "1i"}));
    EXPECT_EQ(r.exitCode, 0) << way.name << r.err;
    EXPECT_NE(r.err.find("RENDER-RECOVERED"), std::string::npos) << way.name << r.err;
    EXPECT_EQ(r.err.find("warning"), std::string::npos) << way.name << r.err;
    EXPECT_TRUE(areSame(w, "whole.exr", "out.exr")) << way.name;
    EXPECT_FALSE(w.has(kCheckpoint)) << "the frame is complete: " << way.name;
  }
}

// Some buckets of the pass that a signal stops are ahead of others, in the sums and in what decides adaptively.
TEST(Checkpoint, ASignalKeepsThePassesThatAreComplete) {
  int count = 0;
  for (const Way& way : {ways()[0], ways()[2], ways()[4]}) {
    Workplace w;
    w.write("scene.rib", rib());
    const Arguments scene = with({"scene.rib", "--res", "160x120"}, way.arguments);
    RunOptions options;
    options.timeoutSeconds = 60;
    options.terminateWhen = [](const std::string& out) {
      const size_t at = out.rfind("\"samples_done\":");
      return at != std::string::npos && std::atoi(out.c_str() + at + 15) >= 4;
    };
    Arguments first{"scene.rib", "--res", "160x120", "--checkpoint", "1h", "--progress", "json"};
    first.insert(first.end(), way.arguments.begin(), way.arguments.end());
    const Result stopped = w.run(first, options);
    // a fast machine may be done before the signal
    if (stopped.exitCode == 0) continue;
    ++count;
    ASSERT_EQ(stopped.exitCode, 7) << way.name << stopped.err;
    ASSERT_TRUE(w.has(kCheckpoint)) << way.name;
    ASSERT_EQ(w.run(with(scene, {"--recover"})).exitCode, 0) << way.name;
    ASSERT_EQ(w.run(with(scene, {"-o", "whole.exr"})).exitCode, 0) << way.name;
    EXPECT_TRUE(areSame(w, "whole.exr", "out.exr")) << way.name;
  }
  EXPECT_GT(count, 0);
}

TEST(Checkpoint, PartsOfAFrameHaveThem) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "--spp", "40", "-o", "whole.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:7", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  const Arguments part = with({"scene.rib"}, {"--samples", "7:40", "-o", "b.exr"});
  EXPECT_EQ(w.run(with(part, {"--checkpoint", "1i,2i"})).exitCode, 7);
  ASSERT_TRUE(w.has("b.exr.checkpoint"));
  ASSERT_EQ(w.run(with(part, {"--recover"})).exitCode, 0);
  EXPECT_FALSE(w.has("b.exr.checkpoint"));
  ASSERT_EQ(w.run({"merge", "a.exr", "b.exr", "-o", "merged.exr"}).exitCode, 0);
  EXPECT_TRUE(areSame(w, "whole.exr", "merged.exr"));
}

// One is a part of the frame too.
TEST(Checkpoint, MergesToThePictureSoFar) {
  Workplace w;
  w.write("scene.rib", rib());
  EXPECT_EQ(w.run({"scene.rib", "--spp", "64", "--checkpoint", "1i,3i", "--progress", "none"}).exitCode, 7);
  ASSERT_EQ(w.run({"merge", kCheckpoint, "-o", "merged.exr"}).exitCode, 0);
  EXPECT_TRUE(areSame(w, "out.exr", "merged.exr"));
}

TEST(Checkpoint, WhatItCannotGoOnFromIsToldAndBegunAnew) {
  Workplace w;
  w.write("scene.rib", rib());
  const Arguments scene{"scene.rib", "--spp", "16"};
  ASSERT_EQ(w.run(with(scene, {"-o", "whole.exr"})).exitCode, 0);
  const auto goesOn = [&](const char* what, const Arguments& arguments, const char* picture) {
    const Result r = w.run(with(arguments, {"--recover"}));
    EXPECT_EQ(r.exitCode, 0) << what << r.err;
    EXPECT_NE(r.err.find("warning RENDER-RECOVER:"), std::string::npos) << what << r.err;
    EXPECT_TRUE(!picture || areSame(w, picture, "out.exr")) << what;
  };
  const auto stop = [&](const Arguments& arguments) {
    EXPECT_EQ(w.run(with(arguments, {"--checkpoint", "1i,3i"})).exitCode, 7);
    ASSERT_TRUE(w.has(kCheckpoint));
  };
  stop({"scene.rib", "--spp", "16", "--seed", "2"});
  goesOn("another seed", scene, "whole.exr");
  stop({"scene.rib", "--spp", "16", "--set", "integrator.maxIndirectBounces=1"});
  goesOn("another scene", scene, "whole.exr");
  stop({"scene.rib", "--spp", "16", "--res", "40x30"});
  goesOn("another picture", scene, "whole.exr");
  stop(scene);
  goesOn("fewer samples", {"scene.rib", "--spp", "2"}, nullptr);
  stop(scene);
  goesOn("adaptive now", {"scene.rib", "--error", "0.5"}, nullptr);
  stop({"scene.rib", "--error", "0.0001", "--max-spp", "64"});
  goesOn("another error", {"scene.rib", "--error", "0.5", "--max-spp", "64"}, nullptr);
  stop(scene);
  goesOn("a part", {"scene.rib", "--spp", "16", "--set", "hider.sampleoffset=3"}, nullptr);
  // broken files: cut off anywhere, and of something else
  stop(scene);
  const uintmax_t size = std::filesystem::file_size(w.path(kCheckpoint));
  std::ifstream in(w.path(kCheckpoint), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  for (const double share : {0., 0.01, 0.3, 0.9}) {
    std::ofstream(w.path(kCheckpoint), std::ios::binary) << whole.substr(0, size_t(double(size) * share));
    goesOn("cut off", scene, "whole.exr");
  }
  std::filesystem::copy_file(w.path("whole.exr"), w.path(kCheckpoint));
  goesOn("a picture", scene, "whole.exr");
  ASSERT_EQ(w.run(with({"scene.rib"}, {"--samples", "0:4", "-o", "part.exr"})).exitCode, 0);
  std::filesystem::copy_file(w.path("part.exr"), w.path(kCheckpoint));
  goesOn("a part without its progress", scene, "whole.exr");
  // none: a job that starts for the first time says the same
  const Result r = w.run(with(scene, {"--recover"}));
  EXPECT_EQ(r.exitCode, 0);
  EXPECT_EQ(r.err.find("RENDER-RECOVER"), std::string::npos) << r.err;
}

// What the scene asks for, and what it runs.
TEST(Checkpoint, OptionsOfTheScene) {
  Workplace w;
  SceneParts parts;
  parts.samples = "Hider \"raytrace\" \"int maxsamples\" [32]";
  parts.options =
      "Option \"checkpoint\" \"string interval\" [\"-1\"] \"string exitat\" [\"3i\"] \"int keepfiles\" [1] \"string "
      "command\" [\"echo x >> written\"]";
  w.write("scene.rib", rib(parts));
  Result r = w.run({"scene.rib", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 7) << r.err;
  EXPECT_NE(r.err.find("warning RENDER-CHECKPOINT-COMMAND"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("written"));
  EXPECT_TRUE(w.has(kCheckpoint));
  // the command line's interval has no end
  r = w.run({"scene.rib", "--recover", "--checkpoint", "1i", "--allow-exec", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has(kCheckpoint)) << "keepfiles";
  std::ifstream in(w.path("written"));
  EXPECT_GE(std::count(std::istreambuf_iterator<char>(in), {}, 'x'), 2);
  parts.options = "Option \"checkpoint\" \"string interval\" [\"often\"]";
  w.write("scene.rib", rib(parts));
  r = w.run({"scene.rib", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0);
  EXPECT_NE(r.err.find("warning RENDER-CHECKPOINT:"), std::string::npos) << r.err;
  for (const char* never : {"", "0", "0s"}) {
    parts.options = std::string("Option \"checkpoint\" \"string interval\" [\"") + never + "\"]";
    w.write("scene.rib", rib(parts));
    r = w.run({"scene.rib", "--progress", "none", "-o", "never.exr"});
    EXPECT_EQ(r.exitCode, 0);
    EXPECT_EQ(r.err.find("RENDER-CHECKPOINT"), std::string::npos) << never << r.err;
  }
}

TEST(Checkpoint, TimesThatAreNoneAreRefused) {
  Workplace w;
  w.write("scene.rib", rib());
  for (const char* text : {"0s", "0", "1h,0", "soon", "1i,", ",1i", "1.5i", "5w", "1h,2h,3h", "nan", "-3s", "1e99"})
    EXPECT_EQ(w.run({"scene.rib", "--checkpoint", text, "--progress", "none"}).exitCode, 2) << text;
  for (const char* text : {"30s", "5m", "0.5h", "1h,2h", "16i", "90"})
    EXPECT_EQ(w.run({"scene.rib", "--checkpoint", text, "--check"}).exitCode, 0) << text;
}

}  // namespace
}  // namespace kinora::cli
