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
  expectEnd(w.run({"scene.rib", "--integrator", "PxrNowhere", "--progress", "none", "--strict"}), 4, {"PxrNowhere"});
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
