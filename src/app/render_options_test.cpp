// The command line of `render` as values, and that each wrong form is refused with one message and code 2. Misses:
// what the renderer does with the values.
#include "app/render_options.h"

#include <gtest/gtest.h>

#include "app/command_line.h"
#include "app/exit_codes.h"

namespace kinora::app {
namespace {

struct Parsed {
  std::optional<int> done;
  RenderOptions options;
  std::vector<std::string> messages;
};

Parsed parsed(std::vector<std::string> arguments) {
  Parsed p;
  Diagnostics diagnostics([&](const std::string& line, Severity) { p.messages.push_back(line); });
  p.done = parseRenderOptions(arguments, p.options, diagnostics);
  return p;
}

TEST(RenderOptions, ValuesArrive) {
  const Parsed p = parsed({"-o",
                           "a.exr",
                           "-t",
                           "-2",
                           "--spp",
                           "32",
                           "--res",
                           "640x360",
                           "--crop",
                           "0",
                           "0.5",
                           "0.25",
                           "1",
                           "--integrator",
                           "PxrDirectLighting",
                           "--set",
                           "integrator.maxIndirectBounces=4",
                           "--set",
                           "hider.x=a=b",
                           "--seed",
                           "9",
                           "--progress",
                           "json",
                           "--stats",
                           "s.json",
                           "--plugin-path",
                           "p",
                           "--search-path",
                           "texture=t1:t2",
                           "--search-path",
                           "archive=a1",
                           "--width",
                           "4",
                           "--group-size",
                           "512",
                           "--bucket-order",
                           "spiral",
                           "--strict",
                           "-q",
                           "-vv",
                           "x.rib",
                           "y.rib"});
  ASSERT_FALSE(p.done) << (p.messages.empty() ? "" : p.messages[0]);
  const render::Settings& s = p.options.settings;
  EXPECT_EQ(p.options.files, (std::vector<std::string>{"x.rib", "y.rib"}));
  EXPECT_EQ(s.output, "a.exr");
  EXPECT_EQ(s.threads, -2);
  EXPECT_EQ(s.samplesPerPixel, 32);
  EXPECT_EQ(s.resolution, (std::array<int, 2>{640, 360}));
  EXPECT_EQ(s.crop, (std::array<float, 4>{0, 0.5f, 0.25f, 1}));
  EXPECT_EQ(s.integrator, "PxrDirectLighting");
  ASSERT_EQ(s.sets.size(), 2u);
  EXPECT_EQ(s.sets[0], (std::pair<std::string, std::string>("integrator.maxIndirectBounces", "4")));
  EXPECT_EQ(s.sets[1], (std::pair<std::string, std::string>("hider.x", "a=b")));
  EXPECT_EQ(s.seed, 9u);
  EXPECT_EQ(p.options.progress, ProgressMode::Json);
  EXPECT_EQ(p.options.statsFile, "s.json");
  EXPECT_EQ(p.options.pluginPath, (std::vector<std::string>{"p"}));
  EXPECT_EQ(s.texturePath, (std::vector<std::string>{"t1", "t2"}));
  EXPECT_EQ(p.options.archivePath, (std::vector<std::string>{"a1"}));
  EXPECT_EQ(s.width, 4u);
  EXPECT_EQ(s.groupSize, 512u);
  EXPECT_EQ(s.bucketOrder, "spiral");
  EXPECT_TRUE(s.strict);
  EXPECT_EQ(p.options.quiet, 1);
  EXPECT_EQ(p.options.verbose, 2);
}

TEST(RenderOptions, AFileMayFollowWhatTakesValues) {
  for (const std::vector<std::string>& before : std::vector<std::vector<std::string>>{{"--set", "hider.jitter=0"},
                                                                                      {"--set=hider.jitter=0"},
                                                                                      {"--crop", "0", "1", "0", "1"},
                                                                                      {"--search-path", "texture=/"},
                                                                                      {"--dirmap", "/a=/b"},
                                                                                      {"--plugin-path", "/"}}) {
    std::vector<std::string> all = before;
    all.push_back("a.rib");
    const Parsed p = parsed(all);
    EXPECT_FALSE(p.done) << before[0] << (p.messages.empty() ? "" : p.messages[0]);
    EXPECT_EQ(p.options.files, std::vector<std::string>{"a.rib"}) << before[0];
  }
}

TEST(RenderOptions, RangesAndSamples) {
  const Parsed part = parsed({"--samples", "16:64", "-"});
  ASSERT_FALSE(part.done);
  EXPECT_EQ(part.options.settings.firstSample, 16);
  EXPECT_EQ(part.options.settings.lastSample, 64);
  EXPECT_EQ(part.options.files, (std::vector<std::string>{"-"}));
  const Parsed one = parsed({"a.rib", "--only-sample", "10,20,3"});
  ASSERT_TRUE(one.options.onlySample);
  EXPECT_EQ(*one.options.onlySample, (std::array<int, 3>{10, 20, 3}));
}

TEST(RenderOptions, AdaptiveSampling) {
  const Parsed p = parsed({"a.rib", "--pixel-variance", ".05", "--min-spp", "8", "--max-spp", "512"});
  ASSERT_FALSE(p.done);
  EXPECT_EQ(p.options.settings.pixelVariance, 0.05f);
  EXPECT_EQ(p.options.settings.leastSamples, 8);
  EXPECT_EQ(p.options.settings.mostSamples, 512);
  EXPECT_LT(parsed({"a.rib"}).options.settings.pixelVariance, 0.f) << "the scene decides";
  EXPECT_EQ(parsed({"a.rib", "--error", ".01", "--max-spp", "512"}).options.settings.pictureError, 0.01f);
}

TEST(RenderOptions, WrongFormsAreRefusedWithOneMessage) {
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"--no-such-option", "a.rib"},
      {"a.rib", "--error", ".01", "--spp", "16"},
      {"a.rib", "--error", ".01", "--pixel-variance", ".02"},
      {"a.rib", "--error", ".01", "--samples", "0:8"},
      {"a.rib", "--error", "nan"},
      {"a.rib", "--res", "640"},
      {"a.rib", "--res", "640x360x2"},
      {"a.rib", "--res", "0x360"},
      {"a.rib", "--res", "-4x360"},
      {"a.rib", "--res", "99999999999x2"},
      {"a.rib", "--crop", "0", "1", "0"},
      {"a.rib", "--crop", "0.5", "0.5", "0", "1"},
      {"a.rib", "--crop", "nan", "1", "0", "1"},
      {"a.rib", "--crop", "0", "1.5", "0", "1"},
      {"a.rib", "--spp", "0"},
      {"a.rib", "--spp", "many"},
      {"a.rib", "--spp"},
      {"a.rib", "--pixel-variance", "-1"},
      {"a.rib", "--pixel-variance", "nan"},
      {"a.rib", "--min-spp", "0"},
      {"a.rib", "--min-spp", "8", "--max-spp", "4"},
      {"a.rib", "--spp", "8", "--max-spp", "16"},
      {"a.rib", "--spp", "8", "--pixel-variance", ".1"},
      {"a.rib", "--samples", "0:4", "--pixel-variance", ".1"},
      {"a.rib", "--width", "5"},
      {"a.rib", "--group-size", "0"},
      {"a.rib", "--seed", "-1"},
      {"a.rib", "--samples", "4"},
      {"a.rib", "--samples", "4:4"},
      {"a.rib", "--samples", "-1:4"},
      {"a.rib", "--samples", "0:4", "-o", "part.png"},
      {"a.rib", "--only-sample", "1,2"},
      {"a.rib", "--only-sample", "1,2,3", "--check"},
      {"a.rib", "--progress", "loud"},
      {"a.rib", "--stats", "s.pdf"},
      {"a.rib", "--stats", "/dev/full"},
      {"a.rib", "-o", "picture"},
      {"a.rib", "-o", "picture.gif"},
      {"a.rib", "--set", "maxBounces=3"},
      {"a.rib", "--set", "integrator.=3"},
      {"a.rib", "--set", "integrator.x"},
      {"a.rib", "--search-path", "texture"},
      {"a.rib", "--search-path", "sound=here"},
      {"-", "-"},
  };
  for (const auto& arguments : wrong) {
    std::string line;
    for (const std::string& a : arguments) line += a + " ";
    const Parsed p = parsed(arguments);
    ASSERT_TRUE(p.done) << line;
    EXPECT_EQ(*p.done, kBadCommandLine) << line;
    ASSERT_EQ(p.messages.size(), 1u) << line;
    EXPECT_NE(p.messages[0].find("error APP-OPTION: "), std::string::npos) << p.messages[0];
  }
}

TEST(CommandLine, SplitIntsTakesWholeTextsOnly) {
  std::vector<int> v;
  EXPECT_TRUE(splitInts("1,-2,3", ',', v));
  EXPECT_EQ(v, (std::vector<int>{1, -2, 3}));
  for (const char* bad : {"", ",", "1,", ",1", "1 ,2", "1;2", "0x10", "99999999999"})
    EXPECT_FALSE(splitInts(bad, ',', v)) << bad;
}

TEST(CommandLine, NearNamesAreSuggestedFarOnesAreNot) {
  EXPECT_EQ(didYouMean("pxrsurfce", {"PxrDiffuse", "PxrSurface"}), "did you mean PxrSurface?");
  EXPECT_EQ(didYouMean("Teapot", {"PxrDiffuse", "PxrSurface"}), "");
}

}  // namespace
}  // namespace kinora::app
