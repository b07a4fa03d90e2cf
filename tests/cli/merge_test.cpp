// Proves: parts of a frame merge to the pictures of the whole, bit for bit, whatever filters and displays the scene
// has; parts and other inputs are never written over, nor one frame by the next. Misses: parts of other machines.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "run_program.h"

namespace kinora::cli {
namespace {

std::string bytesOf(const Workplace& w, const std::string& name) {
  std::ifstream in(w.path(name), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

const char* const kFilters =
    "SampleFilter \"PxrGradeSampleFilter\" \"grade\" \"color gain\" [0.5 1 2]\n"
    "DisplayFilter \"PxrBackgroundDisplayFilter\" \"back\" \"color backgroundColor\" [0.25 0.5 1]\n"
    "DisplayFilter \"PxrBackgroundDisplayFilter\" \"far\" \"string aov\" [\"albedo\"] \"color backgroundColor\" [1 0 "
    "1]\n"
    "DisplayFilter \"PxrDisplayFilterCombiner\" \"both\" \"reference displayfilter[2] filter\" [\"back\" \"far\"]\n";

// Every kind of display, of all that they can be told.
std::string displays(const std::string& stem) {
  return "Display \"" + stem + ".exr\" \"openexr\" \"Ci,a,albedo,z,Nn,own\" \"string exrpixeltype\" [\"float\"]\n" +
         "Display \"+" + stem + ".png\" \"png\" \"rgba\" \"float[2] exposure\" [1.5 2.2] \"float dither\" [0.5]\n" +
         "Display \"+" + stem + "16.png\" \"png\" \"rgba\" \"int[4] quantize\" [0 1023 0 1023]\n" + "Display \"+" +
         stem + ".tif\" \"tiff\" \"rgba\"\nDisplay \"+" + stem + "f.tif\" \"tiff\" \"rgbaz\"\nDisplay \"+" + stem +
         ".jpg\" \"jpeg\" \"rgb\"\nDisplay \"+" + stem + ".tga\" \"targa\" \"rgba\"\nDisplay \"+" + stem +
         ".bmp\" \"file\" \"rgba\"\nDisplay \"+unseen\" \"null\" \"Ci,a,P\"\n"
         "DisplayChannel \"color own\" \"string source\" [\"Ci\"] \"string filter\" [\"sinc\"] "
         "\"float[2] filterwidth\" [4 4]\nPixelFilter \"catmull-rom\" 4 4\n";
}

TEST(Merge, EveryFilterAndKindOfDisplay) {
  Workplace w;
  SceneParts parts;
  parts.options = kFilters;
  parts.display = displays("whole");
  w.write("scene.rib", rib(parts));
  ASSERT_EQ(w.run({"scene.rib", "--progress", "none"}).exitCode, 0);
  parts.options = "";
  parts.display =
      "Display \"plain.exr\" \"openexr\" \"Ci,a,albedo,z,Nn\" \"string exrpixeltype\" [\"float\"]\nPixelFilter "
      "\"catmull-rom\" 4 4";
  w.write("plain.rib", rib(parts));
  ASSERT_EQ(w.run({"plain.rib", "--progress", "none"}).exitCode, 0);
  EXPECT_NE(w.run({"diff", "plain.exr", "whole.exr", "--channels", "R"}).exitCode, 0) << "the filters do nothing";

  parts.options = kFilters;
  parts.display = displays("merged");
  w.write("scene.rib", rib(parts));
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:1", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--samples", "1:4", "--progress", "none"}).exitCode, 0);
  EXPECT_TRUE(w.has("merged.samples-0-1.exr")) << "a part has a name of its own, beside the picture's";
  EXPECT_FALSE(w.has("merged.exr"));
  const Result r = w.run({"merge", "merged.samples-1-4.exr", "merged.samples-0-1.exr"});
  ASSERT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(r.err.empty()) << r.err;
  for (const char* ending : {".exr", ".png", "16.png", ".tif", "f.tif", ".jpg", ".tga", ".bmp"})
    EXPECT_TRUE(areSame(w, std::string("whole") + ending, std::string("merged") + ending)) << ending;
  // also the first of two steps, and with -o
  ASSERT_EQ(w.run({"merge", "merged.samples-1-4.exr", "--keep-samples", "-o", "kept.exr"}).exitCode, 0);
  ASSERT_EQ(w.run({"merge", "kept.exr", "merged.samples-0-1.exr", "-o", "again.exr"}).exitCode, 0);
  EXPECT_TRUE(areSame(w, "whole.exr", "again.exr"));
}

// Machines that each take every third sample make the whole frame together, also where light paths are stored or paths
// learn from those before; the part of one of them is the picture of its samples.
TEST(Merge, StridedPartsAreTheWholeFrame) {
  for (const char* integrator :
       {"", "Integrator \"PxrVCM\" \"i\"", "Integrator \"PxrPathTracer\" \"i\" \"int risPathGuiding\" [1]"}) {
    SCOPED_TRACE(integrator);
    Workplace w;
    SceneParts parts;
    parts.display = "Display \"f.exr\" \"openexr\" \"rgba\" \"string exrpixeltype\" [\"float\"]";
    parts.camera = integrator + ("\n" + parts.camera);
    parts.samples = "Hider \"raytrace\" \"int maxsamples\" [10]";
    w.write("whole.rib", rib(parts));
    ASSERT_EQ(w.run({"whole.rib", "-o", "whole.exr", "--progress", "none"}).exitCode, 0);
    std::vector<std::string> merge{"merge", "-o", "merged.exr"};
    for (int k = 0; k < 3; ++k) {
      const std::string offset = std::to_string(k);
      parts.samples =
          "Hider \"raytrace\" \"int maxsamples\" [3] \"int sampleoffset\" [" + offset + "] \"int samplestride\" [3]";
      w.write("part.rib", rib(parts));
      const Result r = w.run({"part.rib", "--samples", "0:10", "--progress", "none"});
      ASSERT_EQ(r.exitCode, 0) << r.err;
      merge.push_back("f.samples-" + offset + "-10-every-3.exr");
      ASSERT_TRUE(w.has(merge.back()));
    }
    const Result r = w.run(merge);
    ASSERT_EQ(r.exitCode, 0) << r.err;
    EXPECT_TRUE(areSame(w, "whole.exr", "merged.exr"));
    // samples 2, 5, 8
    ASSERT_EQ(w.run({"part.rib", "-o", "alone.exr", "--progress", "none"}).exitCode, 0);
    const Result one = w.run({"merge", merge.back(), "-o", "third.exr"});
    ASSERT_EQ(one.exitCode, 0);
    EXPECT_NE(one.out.find("1 part, samples"), std::string::npos) << one.out;
    EXPECT_TRUE(areSame(w, "alone.exr", "third.exr"));
    EXPECT_EQ(w.run({"diff", "whole.exr", "third.exr"}).exitCode, 1) << "the third of the samples is the whole frame";
  }
}

// -o means the picture that it means for a whole frame: that of the first display with colour, or one of its own.
TEST(Merge, OutputIsThatOfTheWholeFrame) {
  for (const char* display : {"Display \"z.exr\" \"openexr\" \"z\"", "Display \"n\" \"null\" \"rgba\"",
                              "Display \"n\" \"null\" \"rgba\"\nDisplay \"+z.exr\" \"openexr\" \"Ci,z\"",
                              "Display \"z.exr\" \"openexr\" \"z\"\nDisplay \"+c.png\" \"png\" \"rgba\"", ""}) {
    SCOPED_TRACE(display);
    Workplace w;
    SceneParts parts;
    parts.options = kFilters;
    parts.display = display;
    w.write("scene.rib", rib(parts));
    ASSERT_EQ(w.run({"scene.rib", "-o", "whole.exr", "--progress", "none"}).exitCode, 0);
    const std::vector<std::string> before = w.files();
    ASSERT_EQ(w.run({"scene.rib", "--samples", "0:3", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
    ASSERT_EQ(w.run({"scene.rib", "--samples", "3:4", "-o", "b.exr", "--progress", "none"}).exitCode, 0);
    const Result r = w.run({"merge", "a.exr", "b.exr", "-o", "merged.exr"});
    ASSERT_EQ(r.exitCode, 0) << r.err;
    EXPECT_TRUE(areSame(w, "whole.exr", "merged.exr"));
    EXPECT_EQ(w.files().size(), before.size() + 3) << "two parts, one picture; the others were there";
  }
}

// tests/identity goes through all kinds of difference; here is what a person sees of one.
TEST(Merge, APartOfAnotherSceneIsRefusedByItsObject) {
  Workplace w;
  SceneParts parts;
  parts.geometry = "Attribute \"identifier\" \"string name\" [\"ball\"]\nSphere 1 -1 1 360";
  w.write("scene.rib", rib(parts));
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:2", "-o", "a.exr", "--progress", "none"}).exitCode, 0);
  parts.options = "# said otherwise\n\nOption \"statistics\" \"int endofframe\" [1]";
  parts.display = "Display \"another.exr\" \"openexr\" \"rgba\"";
  w.write("scene.rib", rib(parts));
  ASSERT_EQ(w.run({"scene.rib", "--samples", "2:4", "-o", "same.exr", "--progress", "none"}).exitCode, 0);
  parts.geometry = "Sides 1\n" + parts.geometry;
  w.write("other.rib", rib(parts));
  ASSERT_EQ(w.run({"other.rib", "--samples", "2:4", "-o", "other.exr", "--progress", "none"}).exitCode, 0);
  EXPECT_EQ(w.run({"merge", "a.exr", "same.exr", "-o", "merged.exr"}).exitCode, 0);
  const Result r = w.run({"merge", "a.exr", "other.exr", "-o", "mixed.exr"});
  EXPECT_EQ(r.exitCode, 3) << r.err;
  EXPECT_NE(r.err.find("error FILM-SHARD-SCENE: \"other.exr\": it is of another scene than the parts before it: "
                       "object \"ball\" (scene.rib:"),
            std::string::npos)
      << r.err;
  EXPECT_NE(r.err.find(", other.rib:"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find(") differs in sides"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("mixed.exr"));
}

TEST(Merge, NoPartIsWrittenOver) {
  Workplace w;
  w.write("scene.rib", rib());
  ASSERT_EQ(w.run({"scene.rib", "--samples", "0:2", "-o", "out.exr", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--samples", "2:4", "-o", "b.exr", "--progress", "none"}).exitCode, 0);
  const std::string before = bytesOf(w, "out.exr") + bytesOf(w, "b.exr");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"merge", "out.exr", "b.exr"},
                                                    {"merge", "out.exr", "b.exr", "-o", "b.exr"},
                                                    {"merge", "out.exr", "b.exr", "-o", "./out.exr"},
                                                    {"merge", "out.exr", "b.exr", "--keep-samples", "-o", "b.exr"}}) {
    const Result r = w.run(arguments);
    EXPECT_EQ(r.exitCode, 2) << r.out;
    EXPECT_NE(r.err.find("FILM-MERGE-OVERWRITE"), std::string::npos) << r.err;
  }
  EXPECT_EQ(bytesOf(w, "out.exr") + bytesOf(w, "b.exr"), before);
  EXPECT_EQ(w.run({"merge", "out.exr", "b.exr", "-o", "c.exr"}).exitCode, 0);
}

TEST(Inputs, NoCommandWritesOverOne) {
  Workplace w;
  SceneParts parts;
  parts.display = "Display \"scene.exr\" \"openexr\" \"rgba\"";
  w.write("scene.png", rib());
  w.write("scene.exr", rib(parts));
  w.write("stats.txt", rib());
  w.write("in.rib", rib());
  w.write("s.osl", "shader s(output color c = 0) { c = u; }\n");
  w.write("inc.h", "#define K 1\n");
  w.write("t.osl", "#include \"inc.h\"\nshader t(output color c = 0) { c = K; }\n");
  ASSERT_EQ(w.run({"in.rib", "-o", "a.png", "--progress", "none"}).exitCode, 0);
  ASSERT_EQ(w.run({"in.rib", "-o", "b.png", "--seed", "1", "--progress", "none"}).exitCode, 0);
  const std::vector<std::vector<std::string>> commands = {
      {"scene.png", "-o", "scene.png"},
      {"scene.exr"},
      {"stats.txt", "--stats", "./stats.txt"},
      {"in.rib", "scene.png", "-o", "scene.png"},
      {"rib", "in.rib", "-o", "in.rib"},
      {"rib", "in.rib", "--binary", "-o", "./in.rib"},
      {"diff", "a.png", "b.png", "-o", "a.png"},
      {"diff", "a.png", "b.png", "-o", "b.png"},
      {"maketex", "a.png", "a.png"},
      {"shader", "compile", "-o", "s.osl", "s.osl"},
      {"shader", "compile", "-E", "-o", "s.osl", "s.osl"},
      {"shader", "compile", "-MD", "-MF", "s.osl", "s.osl"},
      {"shader", "compile", "-o", "inc.h", "t.osl"},
  };
  std::string before;
  for (const char* f : {"scene.png", "scene.exr", "stats.txt", "in.rib", "s.osl", "inc.h", "a.png", "b.png"})
    before += bytesOf(w, f);
  for (const auto& arguments : commands) {
    std::string shown;
    for (const std::string& a : arguments) shown += a + " ";
    const Result r = w.run(arguments);
    EXPECT_EQ(r.exitCode, 2) << shown << r.err;
    EXPECT_NE(r.err.find("written over"), std::string::npos) << shown << r.err;
  }
  std::string after;
  for (const char* f : {"scene.png", "scene.exr", "stats.txt", "in.rib", "s.osl", "inc.h", "a.png", "b.png"})
    after += bytesOf(w, f);
  EXPECT_EQ(after, before);
}

TEST(Frames, OneNameOfTheScenesForSeveralKeepsTheFirst) {
  Workplace w;
  SceneParts bright;
  bright.options = "Exposure 2 1";
  const auto frame = [](int n, const std::string& world) {
    return "FrameBegin " + std::to_string(n) + "\n" + world + "FrameEnd\n";
  };
  SceneParts other;
  other.display = "Display \"other.exr\" \"openexr\" \"rgba\"";
  w.write("one.rib", rib());
  ASSERT_EQ(w.run({"one.rib", "--progress", "none"}).exitCode, 0);
  const std::string first = bytesOf(w, "out.exr");
  w.write("scene.rib", frame(1, rib()) + frame(2, rib(bright)) + frame(3, rib(other)));
  const Result r = w.run({"scene.rib", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 3) << r.err;
  EXPECT_NE(r.err.find("APP-SAME-FILE"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("frame 2 would be written"), std::string::npos) << r.err;
  EXPECT_TRUE(w.has("other.exr")) << "the third goes on";
  ASSERT_EQ(w.run({"scene.rib", "--frames", "2", "--progress", "none"}).exitCode, 0) << "alone it may";
  EXPECT_NE(bytesOf(w, "out.exr"), first);
  ASSERT_EQ(w.run({"scene.rib", "--frames", "1", "-o", "again.exr", "--progress", "none"}).exitCode, 0);
  // a number in the name
  bright.display = "Display \"n.###.exr\" \"openexr\" \"rgba\"";
  w.write("scene.rib", frame(1, rib(bright)) + frame(2, rib(bright)));
  EXPECT_EQ(w.run({"scene.rib", "--progress", "none"}).exitCode, 0);
  EXPECT_TRUE(w.has("n.001.exr") && w.has("n.002.exr"));
  // and two displays of one frame
  bright.display = "Display \"d.exr\" \"openexr\" \"rgba\"\nDisplay \"+d.exr\" \"openexr\" \"z\"";
  w.write("scene.rib", rib(bright));
  const Result two = w.run({"scene.rib", "--progress", "none"});
  EXPECT_EQ(two.exitCode, 3) << two.err;
  EXPECT_NE(two.err.find("DISPLAY-SAME-FILE"), std::string::npos) << two.err;
  EXPECT_FALSE(w.has("d.exr"));
}

// Files of renderers that need shadow maps: passes and picture bear one number, and only the last is a picture.
TEST(Frames, ShadowPassesAreLeftOutForThePicture) {
  Workplace w;
  w.write("one.rib", rib());
  ASSERT_EQ(w.run({"one.rib", "-o", "one.exr", "--progress", "none"}).exitCode, 0);
  const auto frame = [](int n, const std::string& display) {
    SceneParts parts;
    parts.options = "Exposure 2 1";  // another picture than the last frame's
    parts.display = display;
    return "FrameBegin " + std::to_string(n) + "\n" + rib(parts) + "FrameEnd\n";
  };
  const std::string key = "Display \"key.z\" \"shadow\" \"z\"", fill = "Display \"fill.z\" \"zfile\" \"z\"";
  w.write("scene.rib", frame(1, key) + frame(1, fill) + "FrameBegin 1\n" + rib() + "FrameEnd\n");
  for (const char* output : {"name.####.exr", "name.exr"}) {  // one name for all: there is one picture
    const Result r = w.run({"scene.rib", "-o", output, "--progress", "none"});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    EXPECT_NE(r.err.find("APP-SHADOW-PASS"), std::string::npos) << r.err;
    EXPECT_FALSE(w.has("key.z.exr") || w.has("fill.z.exr"));
  }
  EXPECT_EQ(w.run({"diff", "name.0001.exr", "one.exr"}).exitCode, 0);
  EXPECT_EQ(w.run({"diff", "name.exr", "one.exr"}).exitCode, 0);
  ASSERT_EQ(w.run({"scene.rib", "--progress", "none"}).exitCode, 0) << "as the scene says";
  EXPECT_EQ(w.run({"diff", "out.exr", "one.exr"}).exitCode, 0);
  // behind the picture they are left out too, and a display of another driver makes a frame of its own
  w.write("behind.rib", "FrameBegin 1\n" + rib() + "FrameEnd\n" + frame(1, key) +
                            frame(2, "Display \"depth.exr\" \"openexr\" \"z\""));
  Result r = w.run({"behind.rib", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("depth.exr") && !w.has("key.z.exr"));
  // nothing else, or nothing else asked for: the first is a picture then
  w.write("passes.rib", frame(1, key) + frame(2, fill));
  r = w.run({"passes.rib", "-o", "pass.exr", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("pass.exr") && w.has("key.z.exr") && !w.has("fill.z.exr"));
  r = w.run({"passes.rib", "--frames", "2", "--progress", "none"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("fill.z.exr"));
  EXPECT_EQ(r.err.find("APP-SHADOW-PASS"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace kinora::cli
