// Frames, paths, limits, colours and statistics pages as a user asks for them on the command line.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "run_program.h"

namespace kinora::cli {
namespace {

std::string contents(const Workplace& w, const std::string& name) {
  std::ifstream stream(w.path(name), std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::string frames(std::initializer_list<int> numbers) {
  std::string text;
  for (const int n : numbers) text += "FrameBegin " + std::to_string(n) + "\n" + rib() + "FrameEnd\n";
  return text;
}

TEST(Frames, EachGoesToItsOwnName) {
  Workplace w;
  w.write("scene.rib", frames({1, 2, 12}));
  const Result r = w.run({"scene.rib", "-o", "f.####.png", "--stats", "s.###.json", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(w.files(), (std::vector<std::string>{"f.0001.png", "f.0002.png", "f.0012.png", "s.001.json", "s.002.json",
                                                 "s.012.json", "scene.rib"}));
}

TEST(Frames, OneNameForSeveralIsRefused) {
  Workplace w;
  w.write("scene.rib", frames({1, 2}));
  const Result r = w.run({"scene.rib", "-o", "f.png", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 2) << r.err;
  EXPECT_NE(r.err.find("####"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("f.png"));
  EXPECT_EQ(w.run({"scene.rib", "-o", "f.png", "--frames", "2", "--progress", "none"}).exitCode, 0);
  EXPECT_TRUE(w.has("f.png"));
}

TEST(Frames, OnlyThoseAskedFor) {
  Workplace w;
  w.write("scene.rib", frames({1, 2, 3, 4, 7}));
  Result r = w.run({"scene.rib", "-o", "f.#.png", "--frames", "2-3,7", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(w.files(), (std::vector<std::string>{"f.2.png", "f.3.png", "f.7.png", "scene.rib"}));
  r = w.run({"scene.rib", "-o", "g.#.png", "--frames", "4-6", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 3) << r.err;
  EXPECT_NE(r.err.find("APP-FRAMES"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("5, 6"), std::string::npos) << r.err;
  EXPECT_TRUE(w.has("g.4.png"));
  for (const char* bad : {"3-1", "1,", "x", "1-2-3", "", "99999999999"})
    if (*bad) {
      EXPECT_EQ(w.run({"scene.rib", "--frames", bad}).exitCode, 2) << bad;
    }
}

TEST(Frames, WorldsOutsideFramesCountFromZero) {
  Workplace w;
  w.write("scene.rib", rib() + rib() + rib());
  EXPECT_EQ(w.run({"scene.rib", "-o", "f.#.png", "--frames", "1", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(w.files(), (std::vector<std::string>{"f.1.png", "scene.rib"}));
}

TEST(Paths, DirmapReplacesTheStartOfNames) {
  Workplace w;
  std::filesystem::create_directories(w.path("here/geo"));
  w.write("here/geo/ball.rib", "Sphere 1 -1 1 360\n");
  SceneParts parts;
  parts.geometry = "ReadArchive \"/studio/geo/ball.rib\"";
  parts.display = "Display \"/studio/out.exr\" \"openexr\" \"rgba\"";
  w.write("scene.rib", rib(parts));
  const Result r = w.run({"scene.rib", "--dirmap", "/studio=" + w.path("here"), "--strict", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("here/out.exr"));
  EXPECT_EQ(w.run({"scene.rib", "--dirmap", "studio"}).exitCode, 2);
  EXPECT_NE(w.run({"scene.rib", "--dirmap", "/stud=" + w.path("here"), "--progress", "none"}).exitCode, 0)
      << "half a folder's name is not a folder";
}

TEST(Paths, SearchPathOfTheSceneAndOfTheCommandLine) {
  Workplace w;
  std::filesystem::create_directories(w.path("a"));
  std::filesystem::create_directories(w.path("b"));
  w.write("a/ball.rib", "Sphere 1 -1 1 360\n");
  SceneParts parts;
  parts.geometry = "ReadArchive \"ball.rib\"";
  w.write("scene.rib", rib(parts));
  EXPECT_EQ(w.run({"scene.rib", "--search-path", "archive=b:a", "--strict", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(w.run({"scene.rib", "--search-path", "archive=b", "--strict", "--progress", "none"}).exitCode, 4);
  parts.options = "Option \"searchpath\" \"string archive\" [\"a:@\"]";
  w.write("scene.rib", rib(parts));
  EXPECT_EQ(w.run({"scene.rib", "--strict", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(w.run({"scene.rib", "--search-path", "nonsense=b"}).exitCode, 2);
}

TEST(Set, AnUnknownParameterIsAnErrorWithNearNames) {
  Workplace w;
  w.write("scene.rib", rib());
  Result r = w.run({"scene.rib", "--set", "integrator.maxIndirectBounce=2"});
  EXPECT_EQ(r.exitCode, 2) << r.err;
  EXPECT_NE(r.err.find("did you mean maxIndirectBounces?"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("out.exr"));
  for (const char* bad : {"light.intensityy=2", "hider.maxsample=2", "projection.fovv=2", "display.compresion=zip",
                          "lamp.x=1", "option.foo=3", "option.limits:rendertme=2", "option.Ri:Frame=2",
                          "option.searchpath:archive=a", "option.user:=1"})
    EXPECT_EQ(w.run({"scene.rib", "--set", bad}).exitCode, 2) << bad;
  for (const char* good : {"light.intensity=2", "hider.maxsamples=2", "projection.fov=60", "display.compression=zip",
                           "option.user:pass=beauty"})
    EXPECT_EQ(w.run({"scene.rib", "--set", good, "--progress", "none"}).exitCode, 0) << good;
}

TEST(Set, TellsOfOptionsThatTheSceneHasAskedBefore) {
  Workplace w;
  w.write("scene.rib", rib());
  Result r = w.run({"scene.rib", "--set", "option.limits:rendertme=2"});
  EXPECT_NE(r.err.find("did you mean limits:rendertime?"), std::string::npos) << r.err;
  r = w.run({"scene.rib", "--set", "option.user:pass=beauty", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_NE(r.err.find("CLI-SET-READ"), std::string::npos) << r.err;
}

// Inside objects and of old kinds too.
TEST(Set, ReachesAllLights) {
  Workplace w;
  const auto scene = [](const std::string& light) {
    return "Format 4 4 1\nDisplay \"out.exr\" \"openexr\" \"rgba\"\nHider \"raytrace\" \"int maxsamples\" [4]\n"
           "Projection \"orthographic\"\nWorldBegin\n" +
           light + "Bxdf \"PxrDiffuse\" \"d\"\nPolygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nWorldEnd\n";
  };
  for (const char* light :
       {"ObjectBegin \"lamp\"\nLight \"PxrDistantLight\" \"l\"\nObjectEnd\nObjectInstance \"lamp\"\n",
        "LightSource \"distantlight\" 1 \"intensity\" [2]\nIlluminate 1 1\n"}) {
    w.write("scene.rib", scene(light));
    EXPECT_EQ(w.run({"scene.rib", "--progress", "none"}).err.find("RENDER-BLACK"), std::string::npos) << light;
    const Result dark = w.run({"scene.rib", "--set", "light.intensity=0", "--progress", "none"});
    EXPECT_EQ(dark.exitCode, 0) << dark.err;
    EXPECT_NE(dark.err.find("RENDER-BLACK"), std::string::npos) << dark.err;
    EXPECT_EQ(w.run({"scene.rib", "--set", "light.intensityy=0"}).exitCode, 2) << light;
  }
}

TEST(Set, AValueOfAnotherTypeIsAnError) {
  Workplace w;
  w.write("scene.rib", rib());
  for (const char* bad :
       {"integrator.maxIndirectBounces=many", "integrator.maxIndirectBounces=", "integrator.maxIndirectBounces=2.5",
        "integrator.maxIndirectBounces=1,2", "integrator.maxIndirectBounces=99999999999",
        "integrator.clampLuminance=nan", "integrator.clampLuminance=1x", "hider.maxsamples=lots",
        "hider.maxsamples=4.5", "projection.fov=wide", "projection.fov=inf", "light.lightColor=1,2",
        "light.lightColor=red", "light.intensity=", "option.limits:rendertime=nan", "option.limits:rendertime=abc"}) {
    const Result r = w.run({"scene.rib", "--set", bad});
    EXPECT_EQ(r.exitCode, 2) << bad;
    EXPECT_NE(r.err.find("is not"), std::string::npos) << r.err;
    EXPECT_FALSE(w.has("out.exr")) << bad;
  }
  for (const char* good : {"light.lightColor=1,.5,0", "light.lightColor=.5", "hider.shutteropening=0,0,0,0,1,1,1,1",
                           "light.notes=123", "projection.fov=6e1", "option.trace:worldoffset=1,2,3",
                           "option.bucket:order=spiral", "option.limits:gridsize=64"}) {
    const Result r = w.run({"scene.rib", "--set", good, "--progress", "none"});
    EXPECT_EQ(r.exitCode, 0) << good << r.err;
    EXPECT_EQ(r.err.find("PARAM-TYPE"), std::string::npos) << r.err;
  }
}

TEST(BadValues, OfOptionsAreABadCommandLine) {
  Workplace w;
  w.write("scene.rib", rib());
  const std::vector<std::vector<std::string>> commands = {{"scene.rib", "--integrator", "PxrPathTraser"},
                                                          {"scene.rib", "--integrator", ""},
                                                          {"scene.rib", "--plugin-path", "nowhere"},
                                                          {"scene.rib", "--plugin-path", ".:scene.rib"},
                                                          {"scene.rib", "--plugin-path", ""},
                                                          {"scene.rib", "-o", ""},
                                                          {"scene.rib", "--stats", ""},
                                                          {"scene.rib", "--frames", ""},
                                                          {"scene.rib", "--res", "70000x10"},
                                                          {"scene.rib", "--res", "65536x65536"},
                                                          {"scene.rib", "--res", "0x10"},
                                                          {"scene.rib", "--res", "-1x10"},
                                                          {"scene.rib", "--res", "10x10x10"},
                                                          {"scene.rib", "--res", "99999999999x1"},
                                                          {"scene.rib", "--search-path", "texture="},
                                                          {"scene.rib", "--crop", "0.011", "0.012", "0", "1"},
                                                          {"plugins", "--plugin-path", "nowhere"},
                                                          {"diff", "", "scene.rib"},
                                                          {"diff", "a.exr", "b.exr", "--threshold", "nan"},
                                                          {"diff", "a.exr", "b.exr", "--threshold=-0.5"},
                                                          {"diff", "a.exr", "b.exr", "--rmse", "nan"},
                                                          {"diff", "a.exr", "b.exr", "--max=-1"}};
  for (const auto& command : commands) {
    const Result r = w.run(command);
    EXPECT_EQ(r.exitCode, 2) << command[0] << ' ' << command[1] << ' ' << command.back() << '\n' << r.err;
    EXPECT_NE(r.err.find("error"), std::string::npos) << command[1];
  }
  EXPECT_EQ(w.files(), (std::vector<std::string>{"scene.rib"})) << "nothing was written";
  EXPECT_NE(w.run(commands[0]).err.find("did you mean PxrPathTracer?"), std::string::npos);
}

TEST(Options, ProgramsOfASceneAreRunWhereAllowExecSaysSo) {
  Workplace w;
  w.write("disk.rib", "Disk 0 1 360\n");
  std::string scene = rib();
  const size_t end = scene.rfind("WorldEnd");
  ASSERT_NE(end, std::string::npos);
  scene.insert(end, "Procedural \"RunProgram\" [\"cat disk.rib\" \"\"] [-1 1 -1 1 0 0]\n");
  w.write("scene.rib", scene);
  const Result without = w.run({"scene.rib", "--spp", "1"}),
               with = w.run({"scene.rib", "--spp", "1", "--allow-exec"});
  EXPECT_EQ(with.exitCode, 0) << with.err;
  EXPECT_NE(without.err.find("ASSET-PROGRAM-REFUSED"), std::string::npos) << without.err;
  EXPECT_EQ(without.exitCode, 0) << without.err;
  EXPECT_EQ(without.err.find("GEOM-"), std::string::npos) << "it is told once\n" << without.err;
  EXPECT_EQ(w.run({"scene.rib", "--spp", "1", "--strict"}).exitCode, 4);
  EXPECT_EQ(with.err.find("ASSET-PROGRAM"), std::string::npos) << with.err;
}

// Lights of archives that are read later are known, and set, before the first ray; those of programs are no lights.
TEST(Options, LightsThatComeLateAreSetOrTheMistakeSaysWhere) {
  Workplace w;
  w.write("lamp.rib", "Light \"PxrSphereLight\" \"lamp\" \"float intensity\" [10]\nSphere .3 -.3 .3 360\n");
  const std::string head = "Display \"out.exr\" \"openexr\" \"rgba\"\nFormat 8 8 1\nTranslate 0 0 5\nWorldBegin\n";
  const auto run = [&](const std::string& request, bool isSet) {
    w.write("scene.rib", head + request + " [-1 1 -1 1 -1 1]\nWorldEnd\n");
    std::vector<std::string> line = {"scene.rib", "--spp", "1", "--progress", "none", "--allow-exec"};
    if (isSet) line.insert(line.end(), {"--set", "light.intensity=0"});
    return w.run(line);
  };
  const std::string archive = "Procedural \"DelayedReadArchive\" [\"lamp.rib\"]",
                    program = "Procedural \"RunProgram\" [\"cat lamp.rib\" \"\"]";
  EXPECT_EQ(run(archive, false).err.find("RENDER-BLACK"), std::string::npos);
  const Result dark = run(archive, true);
  EXPECT_EQ(dark.exitCode, 0) << dark.err;
  EXPECT_NE(dark.err.find("RENDER-BLACK"), std::string::npos) << dark.err;
  const Result refused = run(program, true);
  EXPECT_EQ(refused.exitCode, 2) << refused.err;
  EXPECT_NE(refused.err.find("immediatesubdivide"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find("error"), refused.err.rfind("error")) << "it is told once\n" << refused.err;
}

TEST(Later, CommandsOfTheContractSayThatTheyAreNotAvailableYet) {
  Workplace w;
  w.write("scene.rib", rib());
  const std::vector<std::vector<std::string>> commands = {{"denoise", "a.exr"}, {"view", "scene.rib"}};
  for (const auto& command : commands) {
    const Result r = w.run(command);
    EXPECT_EQ(r.exitCode, 2) << command[0] << ' ' << command[1];
    EXPECT_NE(r.err.find("is not available yet"), std::string::npos) << r.err;
  }
  EXPECT_NE(w.run({"scene.rib", "--chekpoint"}).err.find("not expected"), std::string::npos)
      << "what nobody knows is unknown";
}

TEST(Resolution, KeepsTheSceneShape) {
  Workplace w;
  SceneParts parts;
  parts.format = "Format 64 32 1\nFrameAspectRatio 2";
  w.write("scene.rib", rib(parts));
  const auto size = [&](const std::string& res) {
    const Result r = w.run({"scene.rib", "--res", res, "--progress", "none"});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    EXPECT_EQ(r.err.find("RENDER-FRAME-ASPECT") != std::string::npos, res != "32x16") << r.err;
    return w.run({"info", "out.exr"}).out;
  };
  EXPECT_NE(size("32x16").find("32 x 16"), std::string::npos);
  EXPECT_NE(size("40x40").find("40 x 20"), std::string::npos);
  EXPECT_NE(size("64x16").find("32 x 16"), std::string::npos);
}

TEST(Crop, WithoutAPixelRendersNothing) {
  Workplace w;
  for (const char* crop : {"CropWindow .511 .512 0 1", "CropWindow .5 .5 0 1", "CropWindow .6 .4 0 1"}) {
    SceneParts parts;
    parts.options = crop;
    w.write("scene.rib", rib(parts));
    const Result r = w.run({"scene.rib", "--progress", "none"});
    EXPECT_EQ(r.exitCode, 3) << crop << r.err;
    EXPECT_NE(r.err.find("RENDER-CROP"), std::string::npos) << r.err;
    EXPECT_FALSE(w.has("out.exr")) << crop;
  }
}

// A part remembers which scene it is of, its old lights among the rest.
TEST(Parts, OfOtherLightSourcesDoNotMerge) {
  Workplace w;
  const auto part = [&](const std::string& light, const char* samples, const char* name) {
    SceneParts parts;
    parts.light = light;
    w.write("scene.rib", rib(parts));
    EXPECT_EQ(w.run({"scene.rib", "--samples", samples, "-o", name, "--progress", "none"}).exitCode, 0);
  };
  const std::string light = "LightSource \"distantlight\" 1 \"intensity\" ";
  part(light + "1\n", "0:2", "a.exr");
  part(light + "1\n", "2:4", "b.exr");
  part(light + "2\n", "2:4", "brighter.exr");
  part(light + "1\nIlluminate 1 0\n", "2:4", "off.exr");
  EXPECT_EQ(w.run({"merge", "a.exr", "b.exr", "-o", "whole.exr"}).exitCode, 0);
  for (const char* other : {"brighter.exr", "off.exr"}) {
    const Result r = w.run({"merge", "a.exr", other, "-o", "mixed.exr"});
    EXPECT_NE(r.exitCode, 0) << other;
    EXPECT_NE(r.err.find("FILM-SHARD-SCENE"), std::string::npos) << r.err;
  }
}

TEST(Files, OfOtherSystems) {
  Workplace w;
  const std::string unix = rib();
  ASSERT_EQ(w.run({w.write("unix.rib", unix), "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  const auto same = [&](const std::string& text) {
    w.write("other.rib", text);
    const Result r = w.run({"other.rib", "-o", "b.exr", "--strict", "--progress", "none"});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    EXPECT_EQ(r.err.find("error"), std::string::npos) << r.err;
    EXPECT_EQ(w.run({"diff", "a.exr", "b.exr"}).exitCode, 0);
  };
  same("\xef\xbb\xbf" + unix);
  std::string mac = "# a comment\n" + unix;
  std::replace(mac.begin(), mac.end(), '\n', '\r');
  same(mac);
}

// A grid of polygons whose description, mesh and hierarchy take some hundred megabytes.
std::string largeScene() {
  constexpr int kSide = 450;
  std::string counts, indices, points;
  for (int y = 0; y <= kSide; ++y)
    for (int x = 0; x <= kSide; ++x) {
      char text[64];
      std::snprintf(text, sizeof text, "%.4g %.4g %.4g ", 4.0 * x / kSide - 2, 4.0 * y / kSide - 2,
                    0.01 * ((x * 7 + y * 13) % 17));
      points += text;
      if (x == kSide || y == kSide) continue;
      const int a = y * (kSide + 1) + x;
      counts += "4 ";
      indices += std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + kSide + 2) + " " +
                 std::to_string(a + kSide + 1) + " ";
    }
  SceneParts parts;
  const std::string mesh = "PointsPolygons [" + counts + "] [" + indices + "] \"vertex point P\" [" + points + "]\n";
  parts.geometry = mesh + "Translate 0 0 1\n" + mesh;
  return rib(parts);
}

TEST(Limits, MemoryLimitEndsWithTheLargestConsumersOrRenders) {
  Workplace w;
  w.write("scene.rib", largeScene());
  ASSERT_EQ(w.run({"scene.rib", "--spp", "1", "-t", "2", "--stats", "s.json", "--progress", "none"}).exitCode, 0);
  const auto stats = nlohmann::json::parse(contents(w, "s.json"));
  const uint64_t peak = stats["memory_bytes"]["resident_peak"];
  ASSERT_GT(peak, 100u << 20);
  std::filesystem::remove(w.path("out.exr"));
  const auto run = [&](double part, std::vector<std::string> more = {}) {
    std::vector<std::string> a{"scene.rib",
                               "--spp",
                               "1",
                               "-t",
                               "2",
                               "--progress",
                               "none",
                               "--memory-limit",
                               std::to_string(uint64_t(double(peak) * part))};
    a.insert(a.end(), more.begin(), more.end());
    return w.run(a);
  };
  const Result third = run(1.0 / 3);
  EXPECT_EQ(third.exitCode, 5) << third.err;
  EXPECT_EQ(third.signal, 0);
  for (const char* said : {"error MEMORY-LIMIT", "largest so far", "scene description"})
    EXPECT_NE(third.err.find(said), std::string::npos) << said << "\n" << third.err;
  EXPECT_FALSE(w.has("out.exr"));
  const Result under = run(1.05);
  EXPECT_EQ(under.exitCode, 0) << under.err;
  EXPECT_TRUE(w.has("out.exr"));
  // the film: 6000 x 6000 pixels need gigabytes, whatever the scene
  const Result film = run(1.05, {"--res", "6000x6000", "-o", "film.exr"});
  EXPECT_EQ(film.exitCode, 5) << film.err;
  EXPECT_NE(film.err.find("film would take"), std::string::npos) << film.err;
  for (const char* bad : {"lots", "-1", "0", "4Q", "1e30"})
    EXPECT_EQ(w.run({"scene.rib", "--memory-limit", bad}).exitCode, 2) << bad;
}

// A half of the limit is what archives that rays meet may hold together. Sixteen of 15 MB, of which each block of pixels
// sees one: most go, and are read again in the next pass; the picture is that of the same balls without their ballast.
// Misses: archives whose size in memory nobody can expect from that of their files.
TEST(Limits, ArchivesAreDroppedForAHalfOfTheMemoryLimit) {
  constexpr int kArchives = 16;
  constexpr uint32_t kFloats = 3750000;
  Workplace w;
  std::string placed;
  const std::string ball = "Sphere .2 -.2 .2 360";
  for (int k = 0; k < kArchives; ++k) {
    const std::string name = "ball" + std::to_string(k) + ".rib";
    placed += "AttributeBegin Translate " + std::to_string(k - .5 * (kArchives - 1)) +
              " 0 4 Procedural \"DelayedReadArchive\" [\"" + name + "\"] [-.2 .2 -.2 .2 -.2 .2] AttributeEnd\n";
    w.write(name, ball + "\n");
  }
  w.write("scene.rib",
          "Display \"out.exr\" \"openexr\" \"rgba\"\nFormat 256 16 1\nScreenWindow -8 8 -.5 .5\nProjection "
          "\"orthographic\"\nIntegrator \"PxrDirectLighting\" \"i\"\nWorldBegin\nAttributeBegin\nRotate -90 1 0 "
          "0\nLight \"PxrDistantLight\" \"sun\"\nAttributeEnd\n" +
              placed + "WorldEnd\n");
  const std::vector<std::string> command{"scene.rib", "--progress", "none", "--spp", "4", "-t", "2"};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), command.begin(), command.end());
    RunOptions options;
    options.environment = {"ASAN_OPTIONS=quarantine_size_mb=1"};  // what is freed counts no more, with sanitizers too
    return w.run(more, options);
  };
  const Result light = run({"-o", "light.exr"});
  ASSERT_EQ(light.exitCode, 0) << light.err;
  for (int k = 0; k < kArchives; ++k) {
    // an encoded array, whose zeros are a hole in the file
    std::string text = ball + " \"constant float[" + std::to_string(kFloats) + "] ballast\" \xcb";
    for (int byte = 3; byte >= 0; --byte) text += char(kFloats >> (8 * byte) & 255);
    const std::string name = "ball" + std::to_string(k) + ".rib";
    w.write(name, text);
    std::filesystem::resize_file(w.path(name), text.size() + 4 * uint64_t(kFloats));
  }
  const Result r = run({"--memory-limit", "256M", "--stats", "s.json"});
  ASSERT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(r.err.find("RENDER-PROCEDURAL"), std::string::npos) << r.err;
  EXPECT_TRUE(areSame(w, "light.exr", "out.exr"));
  const auto s = nlohmann::json::parse(contents(w, "s.json"))["procedurals"];
  const uint64_t budget = s["budget"], most = s["most_bytes"], largest = s["largest_bytes"];
  EXPECT_EQ(budget, uint64_t(128) << 20);
  EXPECT_EQ(s["read"], kArchives);
  EXPECT_GT(largest, 4 * uint64_t(kFloats));
  EXPECT_GT(kArchives * largest, budget * 3 / 2) << "they would not fit";
  EXPECT_LE(most, budget * 5 / 4);
  EXPECT_GT(s["dropped"], 0);
  EXPECT_GT(s["read_again"], 0);
}

// A float picture of one colour as an uncompressed TIFF (6.0, section 2): 12 bytes a pixel.
std::string largeMap(uint32_t width, uint32_t height) {
  std::string s;
  const auto put = [&s](uint32_t v, int bytes) {
    for (int i = 0; i < bytes; ++i) s += char(v >> (8 * i));
  };
  constexpr uint32_t kEntries = 10, kBits = 8 + 2 + 12 * kEntries + 4, kPixels = kBits + 6;
  s = "II*";
  s += char(0);
  put(8, 4);
  put(kEntries, 2);
  const uint32_t entries[kEntries][4] = {{256, 4, 1, width}, {257, 4, 1, height}, {258, 3, 3, kBits},
                                         {259, 3, 1, 1},     {262, 3, 1, 2},      {273, 4, 1, kPixels},
                                         {277, 3, 1, 3},     {278, 4, 1, height}, {279, 4, 1, width * height * 12},
                                         {339, 3, 1, 3}};
  for (const auto& [tag, type, count, value] : entries) put(tag, 2), put(type, 2), put(count, 4), put(value, 4);
  put(0, 4);
  for (int c = 0; c < 3; ++c) put(32, 2);
  const float one = 1;
  std::string pixel(reinterpret_cast<const char*>(&one), 4);
  s.reserve(s.size() + size_t(width) * height * 12);
  for (size_t i = 0; i < size_t(width) * height * 3; ++i) s += pixel;
  return s;
}

TEST(Limits, TheMapOfALightCountsAndIsNamed) {
  Workplace w;
  SceneParts parts;
  parts.light = "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"map.tif\"]";
  w.write("scene.rib", rib(parts));
  w.write("map.tif", largeMap(4000, 2000));  // 92 MB
  const std::vector<std::string> all{"scene.rib", "--progress", "none", "--spp", "1"};
  const auto run = [&](const std::string& limit) {
    auto a = all;
    a.insert(a.end(), {"--memory-limit", limit});
    return w.run(a);
  };
  const Result refused = run("100M");
  EXPECT_EQ(refused.exitCode, 5) << refused.err;
  EXPECT_NE(refused.err.find("error MEMORY-LIMIT: textures would take 92 MiB"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find("PLUGIN-CREATE"), std::string::npos) << refused.err;
  EXPECT_FALSE(w.has("out.exr"));
  const Result under = run("700M");
  EXPECT_EQ(under.exitCode, 0) << under.err;
  EXPECT_EQ(under.err.find("warning"), std::string::npos) << under.err;
}

TEST(Statistics, PageHoldsEverythingItself) {
  Workplace w;
  w.write("scene.rib", rib());
  const Result r = w.run({"scene.rib", "--spp", "8", "--stats", "s.html", "--progress", "none"});
  ASSERT_EQ(r.exitCode, 0) << r.err;
  const std::string page = contents(w, "s.html");
  size_t pictures = 0;
  for (size_t at = 0; (at = page.find("data:image/png;base64,", at)) != std::string::npos; ++at) ++pictures;
  EXPECT_EQ(pictures, 3u) << "the picture, its errors, its times";
  for (const char* part : {"Memory by owner", "Time by stage", "Rays", "Lane use", "Worst pixels", "</html>"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  for (const char* foreign : {"http", "<script", "<link", "url("})
    EXPECT_EQ(page.find(foreign), std::string::npos) << foreign;
  // measuring the error changes no pixel
  ASSERT_EQ(w.run({"scene.rib", "--spp", "8", "-o", "plain.exr", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(w.run({"diff", "out.exr", "plain.exr"}).exitCode, 0);
}

TEST(Colors, AMissingConfigurationIsOneMessageAndChangesNothing) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  RunOptions options;
  options.environment = {"OCIO=/no/such/config.ocio"};
  const Result r = w.run({"scene.rib", "-o", "b.exr", "--progress", "none"}, options);
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_NE(r.err.find("warning ASSET-COLOR-CONFIG"), std::string::npos) << r.err;
  EXPECT_EQ(w.run({"diff", "a.exr", "b.exr"}).exitCode, 0);
  EXPECT_EQ(w.run({"scene.rib", "-o", "b.exr", "--strict", "--progress", "none"}, options).exitCode, 4);
}

TEST(Colors, PicturesAreSeenThroughAView) {
  Workplace w;
  w.write("config.ocio",
          "ocio_profile_version: 2\nsearch_path: \"\"\nroles:\n  default: lin\n  scene_linear: lin\nfile_rules:\n"
          "  - !<Rule> {name: Default, colorspace: default}\ndisplays:\n  screen:\n    - !<View> {name: Dark, "
          "colorspace: dark}\n"
          "colorspaces:\n  - !<ColorSpace> {name: lin}\n  - !<ColorSpace>\n    name: dark\n    from_scene_reference: "
          "!<MatrixTransform> {matrix: [0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 1]}\n");
  w.write("scene.rib", rib());
  RunOptions options;
  options.environment = {"OCIO=" + w.path("config.ocio")};
  for (const char* extension : {".png", ".jpg", ".tif"}) {
    const std::string plain = std::string("plain") + extension, dark = std::string("dark") + extension;
    ASSERT_EQ(w.run({"scene.rib", "-o", plain, "--progress", "none"}, options).exitCode, 0);
    const Result r = w.run({"scene.rib", "-o", dark, "--set", "display.view=Dark", "--progress", "none"}, options);
    ASSERT_EQ(r.exitCode, 0) << r.err;
    EXPECT_EQ(r.err.find("warning"), std::string::npos) << r.err;
    EXPECT_EQ(w.run({"diff", plain, dark}).exitCode, 1) << extension;
  }
  const Result none =
      w.run({"scene.rib", "-o", "none.png", "--set", "display.view=Bright", "--progress", "none"}, options);
  EXPECT_EQ(none.exitCode, 0);
  EXPECT_NE(none.err.find("there are: screen/Dark"), std::string::npos) << none.err;
  EXPECT_EQ(w.run({"diff", "plain.png", "none.png"}).exitCode, 0);
}

TEST(Rib, ConvertsBothWaysAndExpands) {
  Workplace w;
  SceneParts parts;
  parts.geometry = "ReadArchive \"ball.rib\"";
  w.write("ball.rib", "Sphere 1 -1 1 360\n");
  w.write("scene.rib", rib(parts));
  const std::string ascii = w.run({"rib", "scene.rib"}).out;
  EXPECT_NE(ascii.find("ReadArchive \"ball.rib\""), std::string::npos) << ascii;
  EXPECT_EQ(w.run({"rib", "scene.rib", "--binary", "-o", "b.rib"}).exitCode, 0);
  EXPECT_EQ(w.run({"rib", "scene.rib", "--binary", "--gzip", "-o", "bz.rib"}).exitCode, 0);
  EXPECT_EQ(w.run({"rib", "scene.rib", "-o", "a.rib.gz"}).exitCode, 0);
  EXPECT_EQ(contents(w, "a.rib.gz").substr(0, 2), "\x1f\x8b");
  for (const char* file : {"b.rib", "bz.rib", "a.rib.gz"}) EXPECT_EQ(w.run({"rib", file}).out, ascii) << file;
  EXPECT_EQ(w.run({"rib", "scene.rib", "--expand", "-o", "whole.rib"}).exitCode, 0);
  EXPECT_EQ(w.run({"rib", "scene.rib", "--resolve", "-o", "resolved.rib"}).exitCode, 0);
  std::filesystem::remove(w.path("ball.rib"));
  EXPECT_EQ(w.run({"rib", "scene.rib", "--expand", "--strict", "-o", "x.rib"}).exitCode, 4);
  EXPECT_FALSE(w.has("x.rib"));
  for (const char* file : {"whole.rib", "resolved.rib"})
    EXPECT_EQ(w.run({file, "--strict", "-o", std::string(file) + ".exr", "--progress", "none"}).exitCode, 0) << file;
  EXPECT_EQ(w.run({"diff", "whole.rib.exr", "resolved.rib.exr"}).exitCode, 0);
  const Result missing = w.run({"rib", "missing.rib"});
  EXPECT_EQ(missing.exitCode, 3);
  EXPECT_EQ(missing.out, "") << "nothing was converted";
  EXPECT_EQ(w.run({"rib", "scene.rib", "--ascii", "--binary"}).exitCode, 2);
  EXPECT_EQ(w.run({"rib", "scene.rib", "-o", "no/folder/x.rib"}).exitCode, 6);
}

TEST(Options, ThatMayBeRepeatedLeaveTheFileBehindThem) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "-o", "b.exr", "--samples", "0:1", "--progress", "none"}).exitCode, 0);
  const std::vector<std::vector<std::string>> commands = {
      {"diff", "--channels", "R,G", "a.exr", "a.exr"},
      {"diff", "a.exr", "--channels", "R", "--channels", "G", "a.exr"},
      {"info", "--archive-path", ".", "scene.rib"},
      {"merge", "--plugin-path", ".", "b.exr", "-o", "c.exr"},
      {"plugins", "--plugin-path", ".", "PxrDiffuse"},
      {"rib", "--search-path", "archive=.", "scene.rib"},
      {"--search-path", "archive=.", "scene.rib", "-o", "d.exr", "--progress", "none"},
  };
  for (const auto& arguments : commands) {
    const Result r = w.run(arguments);
    EXPECT_EQ(r.exitCode, 0) << arguments[0] << " " << arguments[1] << ": " << r.err;
  }
  // what is named counts, and nothing else
  const Result r = w.run({"diff", "--channels", "R,nowhere", "a.exr", "a.exr"});
  EXPECT_NE(r.exitCode, 0) << r.out;
  EXPECT_NE((r.out + r.err).find("nowhere"), std::string::npos) << r.out << r.err;
}

}  // namespace
}  // namespace kinora::cli
