// What a user can do wrong, seen from outside: the exit code of the contract, one clear message that names the file
// (and line), and no half file. Misses: mistakes inside geometry and transforms, which the rooms that read them test.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>

#include "run_program.h"

namespace kinora::cli {
namespace {

// The program ended by itself, with this code, and printed each text on standard error.
void expectEnd(const Result& r, int code, std::initializer_list<const char*> said) {
  EXPECT_FALSE(r.isTimedOut);
  EXPECT_EQ(r.signal, 0);
  EXPECT_EQ(r.exitCode, code) << r.err;
  for (const char* text : said)
    EXPECT_NE(r.err.find(text), std::string::npos) << "missing: " << text << "\nin: " << r.err;
}

size_t occurrences(const std::string& text, const std::string& of) {
  size_t n = 0;
  for (size_t at = 0; (at = text.find(of, at)) != std::string::npos; at += of.size()) ++n;
  return n;
}

std::string gzipped(const std::string& text) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(compressBound(uLong(text.size())) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  z.avail_in = uInt(text.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = uInt(out.size());
  deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

TEST(BadInput, EmptyFile) {
  Workplace w;
  expectEnd(w.run({w.write("empty.rib", "")}), 3, {"empty.rib: error RIB-EMPTY"});
}

TEST(BadInput, DirectoryMissingFileAndNoPermission) {
  Workplace w;
  mkdir(w.path("folder.rib").c_str(), 0755);
  expectEnd(w.run({"folder.rib"}), 3, {"error RIB-DIRECTORY", "folder.rib"});
  expectEnd(w.run({"missing.rib"}), 3, {"error RIB-OPEN", "missing.rib"});
}

TEST(BadInput, NoWorldIsNothingToRender) {
  Workplace w;
  expectEnd(w.run({w.write("archive.rib", "Sphere 1 -1 1 360\n")}), 3, {"RIB-NO-WORLD"});
}

TEST(BadInput, NotARibFile) {
  Workplace w;
  std::string bytes;
  for (int i = 0; i < 4096; ++i) bytes += char((i * 7919 + 13) & 255);
  const Result r = w.run({w.write("noise.rib", bytes)});
  expectEnd(r, 3, {"noise.rib", "error"});
}

TEST(BadInput, TruncatedGzipIsNeverComplete) {
  Workplace w;
  SceneParts parts;
  for (int i = 0; i < 400; ++i)
    parts.geometry +=
        "\nTransformBegin Translate " + std::to_string(i * 37 % 101) + " 0 0 Sphere 1 -1 1 360 TransformEnd";
  const std::string whole = gzipped(rib(parts));
  expectEnd(w.run({w.write("cut.rib", whole.substr(0, whole.size() / 2)), "--progress", "none"}), 3,
            {"cut.rib", "RIB-TRUNCATED"});
}

TEST(BadInput, AsciiCutInsideTheWorldIsNeverComplete) {
  Workplace w;
  const std::string whole = rib();
  const size_t at = whole.find("Sphere") + 6;
  const Result r = w.run({w.write("cut.rib", whole.substr(0, at)), "--progress", "none"});
  expectEnd(r, 3, {"cut.rib:", "error"});
}

TEST(BadInput, UnknownRequestIsNamedOnceAndTheRestIsRendered) {
  Workplace w;
  SceneParts parts;
  for (int i = 0; i < 50; ++i) parts.geometry += "\nFrobnicate 1 2 \"three\"";
  const Result r = w.run({w.write("scene.rib", rib(parts)), "--progress", "none"});
  expectEnd(r, 0, {"scene.rib:", "RIB-UNKNOWN-REQUEST", "Frobnicate"});
  EXPECT_LE(occurrences(r.err, "Frobnicate"), 2u) << r.err;
  EXPECT_TRUE(w.has("out.exr"));
}

TEST(BadInput, NoLightsGivesAPictureAndAWarning) {
  Workplace w;
  SceneParts parts;
  parts.light = "";
  expectEnd(w.run({w.write("dark.rib", rib(parts)), "--progress", "none"}), 0, {"warning", "light"});
  EXPECT_TRUE(w.has("out.exr"));
}

// An empty world is no complete frame; others of the file are rendered.
TEST(BadInput, AnEmptyWorldIsTold) {
  Workplace w;
  w.write("empty.rib", "Display \"empty.exr\" \"openexr\" \"rgba\"\nWorldBegin\nWorldEnd\n");
  expectEnd(w.run({"empty.rib", "--progress", "none"}), 3, {"empty.rib:2: error RENDER-EMPTY", "empty picture"});
  EXPECT_TRUE(w.has("empty.exr"));
  w.write("two.rib",
          "FrameBegin 1\nDisplay \"one.exr\" \"openexr\" \"rgba\"\nWorldBegin\nWorldEnd\nFrameEnd\nFrameBegin 2\n" +
              rib() + "FrameEnd\n");
  expectEnd(w.run({"two.rib", "--progress", "none"}), 3, {"RENDER-EMPTY"});
  EXPECT_TRUE(w.has("out.exr"));
  // a light alone is a scene
  w.write("light.rib",
          "Display \"light.exr\" \"openexr\" \"rgba\"\nWorldBegin\nLight \"PxrDomeLight\" \"sky\"\nWorldEnd\n");
  expectEnd(w.run({"light.rib", "--progress", "none"}), 0, {});
}

// Messages stand where what they are about is said.
TEST(BadInput, MessagesNameTheirLine) {
  Workplace w;
  SceneParts parts;
  parts.options = "DisplayChannel \"color foo\" \"string source\" [\"nosuch\"]";
  parts.display = "Display \"out.exr\" \"openexr\" \"rgba\"\nDisplay \"+foo.exr\" \"openexr\" \"foo\"";
  expectEnd(w.run({w.write("scene.rib", rib(parts)), "--progress", "none"}), 0,
            {"scene.rib:1: warning DISPLAY-SOURCE"});
  parts.options = "";
  parts.display = "Display \"out.exr\" \"openexr\" \"Ci,nosuch\"";
  expectEnd(w.run({w.write("scene.rib", rib(parts)), "--progress", "none"}), 0,
            {"scene.rib:4: warning DISPLAY-SOURCE"});
}

TEST(BadInput, ABlackPictureIsNeverSilent) {
  SceneParts parts;
  parts.camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 -9";
  for (const bool isSeen : {false, true}) {
    if (isSeen) {
      parts = {};
      parts.material = "Bxdf \"PxrBlack\" \"none\"";
    }
    Workplace w;
    const Result r = w.run({w.write("scene.rib", rib(parts)), "--progress", "none"});
    expectEnd(r, 0, {"scene.rib:", "warning RENDER-BLACK", isSeen ? "no light reaches" : "sees nothing"});
  }
  // without alpha nobody knows which
  parts = {};
  parts.camera = "Projection \"perspective\" \"fov\" [40]\nTranslate 0 0 -9";
  parts.display = "Display \"out.exr\" \"openexr\" \"rgb\"";
  Workplace unknown;
  expectEnd(unknown.run({unknown.write("scene.rib", rib(parts)), "--progress", "none"}), 0,
            {"RENDER-BLACK", "the camera sees nothing, or no light reaches what it sees"});
  // matte objects are there, and leave the picture empty
  parts = {};
  parts.material += "\nMatte 1";
  Workplace matte;
  expectEnd(matte.run({matte.write("scene.rib", rib(parts)), "--progress", "none"}), 0, {"RENDER-BLACK", "matte"});
  // lights that are not rendered are named
  parts = {};
  parts.light = "Light \"StudioLight\" \"key\"\nLightSource \"causticlight\" 1";
  Workplace w;
  expectEnd(w.run({w.write("scene.rib", rib(parts)), "--progress", "none"}), 0,
            {"RENDER-BLACK", "not rendered: 'StudioLight', 'causticlight'"});
}

TEST(BadInput, NoCameraIsTheDefaultOne) {
  Workplace w;
  SceneParts parts;
  parts.camera = "";
  const Result r = w.run({w.write("scene.rib", rib(parts)), "--progress", "none"});
  expectEnd(r, 0, {});
  EXPECT_TRUE(w.has("out.exr"));
}

TEST(BadInput, FormatBeyondReasonIsRefusedAtOnce) {
  Workplace w;
  SceneParts parts;
  parts.format = "Format 1000000000 1000000000 1";
  RunOptions options;
  options.timeoutSeconds = 20;
  const Result r = w.run({w.write("vast.rib", rib(parts)), "--progress", "none"}, options);
  EXPECT_FALSE(r.isTimedOut);
  EXPECT_EQ(r.signal, 0);
  EXPECT_TRUE(r.exitCode == 3 || r.exitCode == 5) << r.exitCode << r.err;
  EXPECT_NE(r.err.find("1000000000"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("out.exr"));
  const Result byOption = w.run({w.write("scene.rib", rib()), "--res", "1000000000x1000000000"}, options);
  EXPECT_TRUE(byOption.exitCode == 2 || byOption.exitCode == 3 || byOption.exitCode == 5) << byOption.exitCode;
}

TEST(BadInput, OutputThatCannotBeMadeIsRefusedBeforeRendering) {
  Workplace w;
  w.write("scene.rib", rib());
  RunOptions quick;
  quick.timeoutSeconds = 20;
  expectEnd(w.run({"scene.rib", "--spp", "65536", "-o", "missing/out.exr"}, quick), 6, {"missing/out.exr"});
  mkdir(w.path("taken.exr").c_str(), 0755);
  expectEnd(w.run({"scene.rib", "--spp", "65536", "-o", "taken.exr"}, quick), 6, {"taken.exr"});
  mkfifo(w.path("pipe.exr").c_str(), 0644);
  expectEnd(w.run({"scene.rib", "--spp", "65536", "-o", "pipe.exr"}, quick), 6, {"pipe.exr"});
  SceneParts parts;
  parts.display = "Display \"missing/out.exr\" \"openexr\" \"rgba\"";
  expectEnd(w.run({w.write("display.rib", rib(parts)), "--spp", "65536"}, quick), 6, {"missing/out.exr"});
}

TEST(BadInput, FullDiskLeavesNoHalfPicture) {
  Workplace w;
  SceneParts parts;
  parts.format = "Format 256 192 1";
  RunOptions small;
  small.fileSizeLimit = 4096;  // the picture needs more
  const Result r = w.run({w.write("scene.rib", rib(parts)), "--spp", "1", "--progress", "none"}, small);
  expectEnd(r, 6, {"out.exr"});
  EXPECT_EQ(w.files(), (std::vector<std::string>{"scene.rib"}));
}

TEST(BadInput, FullDiskBehindStandardOutput) {
  Workplace w;
  const std::string command = std::string(KINORA_PROGRAM) + " plugins > /dev/full 2> " + w.path("err");
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 6);
}

TEST(BadInput, PictureThatExistsSurvivesAFailure) {
  Workplace w;
  w.write("scene.rib", rib());
  w.write("out.exr", "precious");
  RunOptions small;
  small.fileSizeLimit = 100;
  expectEnd(w.run({"scene.rib", "--progress", "none"}, small), 6, {});
  std::string kept(8, ' ');
  std::FILE* f = std::fopen(w.path("out.exr").c_str(), "rb");
  ASSERT_NE(f, nullptr);
  EXPECT_EQ(std::fread(kept.data(), 1, 8, f), 8u);
  std::fclose(f);
  EXPECT_EQ(kept, "precious");
}

// A missing asset: a warning, a visible fallback and code 0; with --strict an error and code 4, and no picture.
void expectAsset(const SceneParts& parts, const char* name) {
  Workplace w;
  w.write("scene.rib", rib(parts));
  expectEnd(w.run({"scene.rib", "--progress", "none"}), 0, {"scene.rib:", name});
  EXPECT_TRUE(w.has("out.exr"));
  Workplace strict;
  strict.write("scene.rib", rib(parts));
  expectEnd(strict.run({"scene.rib", "--progress", "none", "--strict"}), 4, {name});
  EXPECT_FALSE(strict.has("out.exr"));
}

// A thing that is wrong in a scene: one warning or error with file and line, a picture all the same, code 0.
struct Flaw {
  const char *code, *said;
  uint32_t count;  // messages of that code, with those that only the summary counts
};
void expectFlaw(const SceneParts& parts, const Flaw& flaw) {
  Workplace w;
  RunOptions options;
  options.timeoutSeconds = 60;
  const Result r = w.run({w.write("scene.rib", rib(parts)), "--progress", "none"}, options);
  expectEnd(r, 0, {"scene.rib:", flaw.code, flaw.said});
  EXPECT_EQ(occurrences(r.err, std::string(flaw.code) + ":"), 1u) << r.err;
  EXPECT_EQ(occurrences(r.err, "more of " + std::string(flaw.code)), flaw.count > 1 ? 1u : 0u) << r.err;
  EXPECT_TRUE(w.has("out.exr"));
}

TEST(BadInput, InstancesThatMultiplyEndSoon) {
  SceneParts parts;
  parts.geometry = "ObjectBegin \"o0\" Sphere 1 -1 1 360 ObjectEnd\n";
  for (int i = 1; i < 60; ++i) {
    const std::string before = "ObjectInstance \"o" + std::to_string(i - 1) + "\" ";
    parts.geometry += "ObjectBegin \"o" + std::to_string(i) + "\" " + before + before + "ObjectEnd\n";
  }
  parts.geometry += "ObjectInstance \"o59\"\nSphere 1 -1 1 360";
  expectFlaw(parts, {"RENDER-INSTANCES", "left out", 2});
}
TEST(BadInput, MotionTimesThatAreNotSorted) {
  SceneParts parts;
  parts.geometry = "MotionBegin [1 0]\nSphere 1 -1 1 360\nSphere 1 -1 1 360\nMotionEnd";
  expectFlaw(parts, {"RIB-MOTION", "does not move", 1});
}
TEST(BadInput, MotionOfUnequalCounts) {
  SceneParts parts;
  parts.geometry =
      "MotionBegin [0 1]\nPoints \"P\" [0 0 0] \"constantwidth\" [1]\nPoints \"P\" [0 0 0 1 1 1] "
      "\"constantwidth\" [1]\nMotionEnd";
  expectFlaw(parts, {"RIB-MOTION", "does not match the first", 1});
}
TEST(BadInput, WidthsNegativeAndNan) {
  for (const char* width : {"-0.1", "nan", "0"}) {
    SceneParts parts;
    parts.geometry += "\nCurves \"linear\" [2] \"nonperiodic\" \"P\" [-1 0 0 1 0 0] \"constant float width\" [" +
                      std::string(width) + "]";
    expectFlaw(parts, {"GEOM-ZERO-AREA", "left out", 1});
  }
}
TEST(BadInput, CurvesWithoutLength) {
  SceneParts parts;
  parts.geometry += "\nCurves \"linear\" [2] \"nonperiodic\" \"P\" [1 0 0 1 0 0] \"constantwidth\" [0.1]";
  expectFlaw(parts, {"GEOM-CURVE-LENGTH", "left out", 1});
}
TEST(BadInput, SizesOfTheCameraThatAreNone) {
  SceneParts parts;
  for (const char* fov : {"-40", "0", "180"}) {
    parts.camera = "Projection \"perspective\" \"fov\" [" + std::string(fov) + "]\nTranslate 0 0 4";
    expectFlaw(parts, {"PROJECTION-FOV", "PxrPerspective: fov", 1});
  }
  parts = {};
  parts.options = "PixelFilter \"gaussian\" -2 nan";
  expectFlaw(parts, {"RIB-NUMBER", "PixelFilter", 1});
  parts.options = "CropWindow 0.5 0.5 0 nan";
  expectFlaw(parts, {"RIB-NUMBER", "CropWindow", 1});
}
TEST(BadInput, SamplesNegativeAndCountless) {
  SceneParts parts;
  parts.format = "Format 2 2 1";
  for (const char* count : {"-4", "2147483647"}) {
    parts.samples = "Hider \"raytrace\" \"int maxsamples\" [" + std::string(count) + "]";
    expectFlaw(parts, {"RENDER-SAMPLES", count, 1});
  }
}
TEST(BadInput, NamesThatNothingHas) {
  SceneParts parts;
  parts.geometry = "Attribute \"lighting\" \"string excludesubset\" [\"nobody\"]\n" + parts.geometry;
  expectFlaw(parts, {"LIGHT-LINK", "nobody", 1});
  parts = {};
  parts.geometry = "Attribute \"trace\" \"string reflectsubset\" [\"nobody\"]\n" + parts.geometry;
  expectFlaw(parts, {"RENDER-TRACE-SET", "nobody", 1});
}
TEST(BadInput, DeepNesting) {
  const auto times = [](const char* text, int n) {
    std::string all;
    for (int i = 0; i < n; ++i) all += text;
    return all;
  };
  SceneParts parts;
  parts.geometry = times("AttributeBegin ", 200000) + "Sphere 1 -1 1 360 " + times("AttributeEnd ", 200000);
  expectFlaw(parts, {"RIB-DEPTH", "AttributeBegin", 1});
  parts.geometry = times("IfBegin \"1\" ", 200000) + "Sphere 1 -1 1 360 " + times("IfEnd ", 200000);
  expectFlaw(parts, {"RIB-DEPTH", "IfBegin", 1});
  parts.geometry = "IfBegin \"" + times("(", 200000) + "1" + times(")", 200000) + "\"\nIfEnd\nSphere 1 -1 1 360";
  expectFlaw(parts, {"RIB-CONDITION", "nested too deeply", 1});
}

// The program's memory is held to half a gigabyte: what is in the pipe is not kept.
TEST(BadInput, AGigabyteOfBracketsThroughAPipe) {
#ifdef KINORA_SANITIZED
  GTEST_SKIP() << "the sanitizer maps terabytes of its own";
#endif
  Workplace w;
  const std::string command = "cd " + w.path("") +
                              " && (ulimit -v 4000000; head -c 1073741824 /dev/zero | tr '\\0' '[' | " +
                              std::string(KINORA_PROGRAM) + " - --memory-limit 512M --progress none) 2> err";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_EQ(w.files(), std::vector<std::string>{"err"});
}

// Headers of a picture far larger than its file.
TEST(BadInput, TexturesThatPromiseTooMuch) {
  for (const bool isLight : {false, true}) {
    Workplace w;
    w.write("vast.ppm", "P6\n100000 100000\n255\nabc");
    SceneParts parts;
    if (isLight)
      parts.light = "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"vast.ppm\"]";
    else
      parts.material =
          "Pattern \"PxrTexture\" \"t\" \"string filename\" [\"vast.ppm\"]\n"
          "Bxdf \"PxrDiffuse\" \"matt\" \"reference color diffuseColor\" [\"t:resultRGB\"]";
    w.write("scene.rib", rib(parts));
    const Result r = w.run({"scene.rib", "--progress", "none", "--memory-limit", "1G"});
    expectEnd(r, 0, {"scene.rib:", "ASSET-TEXTURE-READ", "100000 x 100000", isLight ? "'sky'" : "'t'"});
    EXPECT_TRUE(w.has("out.exr"));
    expectEnd(w.run({"scene.rib", "--progress", "none", "--strict"}), 4, {"ASSET-TEXTURE-READ"});
  }
}

TEST(BadInput, UdimSetsWithHoles) {
  Workplace w;
  for (const char* tile : {"1001", "1003"})
    w.write(std::string("skin.") + tile + ".ppm", "P6\n2 2\n255\n" + std::string(12, 'x'));
  SceneParts parts;
  parts.material =
      "Pattern \"PxrTexture\" \"t\" \"string filename\" [\"skin.<UDIM>.ppm\"]\n"
      "Bxdf \"PxrDiffuse\" \"matt\" \"reference color diffuseColor\" [\"t:resultRGB\"]";
  parts.geometry = "Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"varying float[2] st\" [0 0 3 0 3 1 0 1]";
  w.write("scene.rib", rib(parts));
  const Result r = w.run({"scene.rib", "--progress", "none"});
  expectEnd(r, 0, {"scene.rib:", "warning ASSET-TEXTURE-TILE", "none for 1002)"});
  EXPECT_EQ(occurrences(r.err, "ASSET-TEXTURE-TILE"), 1u) << r.err;
  EXPECT_EQ(w.run({"scene.rib", "--progress", "none", "--strict"}).exitCode, 4);
}

TEST(BadInput, ABrokenColourConfiguration) {
  Workplace w;
  w.write("scene.rib", rib());
  w.write("config.ocio", "ocio_profile_version: 2\nroles: {default: [\n");
  RunOptions options;
  options.environment = {"OCIO=" + w.path("config.ocio")};
  const Result r = w.run({"scene.rib", "--progress", "none"}, options);
  expectEnd(r, 0, {"warning ASSET-COLOR-CONFIG", "config.ocio"});
  EXPECT_TRUE(w.has("out.exr"));
  expectEnd(w.run({"scene.rib", "--strict", "--progress", "none"}, options), 4, {"ASSET-COLOR-CONFIG"});
}

TEST(BadInput, FormatsThatCannotHoldTheChannels) {
  for (const char* format : {"png", "jpeg"}) {
    Workplace w;
    SceneParts parts;
    parts.display = std::string("Display \"out.") + format + "\" \"" + format + "\" \"Ci,a,z,Nn\"";
    w.write("scene.rib", "DisplayChannel \"normal Nn\"\n" + rib(parts));
    // snapshots all the time: each of them makes the same file
    const Result r = w.run({"scene.rib", "--spp", "64", "--snapshot", "0.001", "--progress", "none"});
    expectEnd(r, 0, {"scene.rib:", "warning DISPLAY-CHANNELS", "Z, Nn"});
    EXPECT_EQ(occurrences(r.err, "DISPLAY-CHANNELS"), 1u) << r.err;
    EXPECT_TRUE(w.has(std::string("out.") + format));
  }
}

TEST(BadInput, MissingArchive) {
  SceneParts parts;
  parts.geometry += "\nReadArchive \"nowhere.rib\"";
  expectAsset(parts, "nowhere.rib");
}
TEST(BadInput, MissingTexture) {
  SceneParts parts;
  parts.material =
      "Pattern \"PxrTexture\" \"t\" \"string filename\" [\"nowhere.tex\"]\n"
      "Bxdf \"PxrDiffuse\" \"matt\" \"reference color diffuseColor\" [\"t:resultRGB\"]";
  expectAsset(parts, "nowhere.tex");
}
TEST(BadInput, UnknownBxdf) {
  SceneParts parts;
  parts.material = "Bxdf \"PxrNowhere\" \"matt\"";
  expectAsset(parts, "PxrNowhere");
}
TEST(BadInput, UnknownPattern) {
  SceneParts parts;
  parts.material =
      "Pattern \"PxrNowhere\" \"t\"\nBxdf \"PxrDiffuse\" \"matt\" \"reference color diffuseColor\" [\"t:resultRGB\"]";
  expectAsset(parts, "PxrNowhere");
}
TEST(BadInput, UnknownLight) {
  SceneParts parts;
  parts.light += "\nLight \"PxrNowhere\" \"other\"";
  expectAsset(parts, "PxrNowhere");
}

TEST(BadInput, UnknownIntegratorOfTheCommandLine) {
  Workplace w;
  w.write("scene.rib", rib());
  expectEnd(w.run({"scene.rib", "--integrator", "PxrNowhere", "--progress", "none", "--strict"}), 2, {"PxrNowhere"});
}

TEST(BadInput, SeveralFramesNeedANumberedOutput) {
  Workplace w;
  const std::string frames = "FrameBegin 3\n" + rib() + "FrameEnd\nFrameBegin 4\n" + rib() + "FrameEnd\n";
  w.write("frames.rib", frames);
  expectEnd(w.run({"frames.rib", "-o", "one.exr", "--progress", "none"}), 2, {"####"});
  EXPECT_EQ(w.files(), (std::vector<std::string>{"frames.rib"}));
  expectEnd(w.run({"frames.rib", "-o", "f.####.exr", "--progress", "none"}), 0, {});
  EXPECT_TRUE(w.has("f.0003.exr"));
  EXPECT_TRUE(w.has("f.0004.exr"));
}

TEST(BadInput, UnknownParameterIsNamed) {
  Workplace w;
  w.write("scene.rib", rib());
  expectEnd(w.run({"scene.rib", "--set", "integrator.noSuchParameter=4", "--progress", "none"}), 2,
            {"noSuchParameter"});
}

TEST(BadInput, WrongOptionsAreCodeTwo) {
  Workplace w;
  w.write("scene.rib", rib());
  expectEnd(w.run({}), 2, {"kinora [render]"});
  expectEnd(w.run({"--no-such-option", "scene.rib"}), 2, {"--no-such-option"});
  expectEnd(w.run({"scene.rib", "--res", "640"}), 2, {"--res", "640"});
  expectEnd(w.run({"scene.rib", "--bucket-order", "sideways", "--progress", "none"}), 2, {"sideways"});
  expectEnd(w.run({"scene.rib", "--set", "teapot.size=4", "--progress", "none"}), 2, {"teapot"});
  expectEnd(w.run({"plugins", "PxrDifuse"}), 2, {"did you mean PxrDiffuse?"});
  expectEnd(w.run({"explain", "NO-SUCH-CODE"}), 2, {"NO-SUCH-CODE"});
  expectEnd(w.run({"merge"}), 2, {"PART"});
  EXPECT_FALSE(w.has("out.exr"));
}

}  // namespace
}  // namespace kinora::cli
