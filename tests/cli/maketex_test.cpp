// `kinora maketex`: flags in both spellings, what is written, and each way to fail with its exit code. Misses: the
// mip levels' values (texture_levels_test.cpp).
#include <gtest/gtest.h>

#include "run_program.h"

namespace kinora::cli {
namespace {

Result picture(Workplace& w) {
  w.write("scene.rib", rib());
  return w.run({"scene.rib", "-o", "in.png", "--progress", "none"});
}

TEST(Maketex, MakesATextureBesideItsSource) {
  Workplace w;
  ASSERT_EQ(picture(w).exitCode, 0);
  Result r = w.run({"maketex", "in.png"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("in.tx"));
  r = w.run({"info", "in.tx"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
}

TEST(Maketex, TakesTxmakesSpelling) {
  Workplace w;
  ASSERT_EQ(picture(w).exitCode, 0);
  Result r = w.run({"maketex", "-mode", "clamp", "-resize", "up-", "-byte", "-newer", "-verbose", "-t:1", "in.png",
                    "out.tex.tif"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_NE(r.out.find("wrote out.tex.tif"), std::string::npos) << r.out;
  r = w.run({"maketex", "-newer", "-verbose", "in.png", "out.tex.tif"});
  EXPECT_NE(r.out.find("up to date"), std::string::npos) << r.out;
  r = w.run(
      {"maketex", "--smode", "black", "--tmode", "periodic", "--half", "--format", "openexr", "in.png", "out.exr"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("out.exr"));
  // its own endings are no format's
  for (const char* name : {"out.tex", "out.env"}) {
    r = w.run({"maketex", "-mode", "periodic", "in.png", name});
    EXPECT_EQ(r.exitCode, 0) << r.err;
    r = w.run({"diff", name, "in.png", "--max", "0.01"});
    EXPECT_EQ(r.exitCode, 0) << r.out << r.err;
  }
}

// Flags of txmake that change nothing here are named, and take their value with them.
TEST(Maketex, TellsOfWhatItIgnores) {
  Workplace w;
  ASSERT_EQ(picture(w).exitCode, 0);
  Result r = w.run({"maketex", "-mipfilter", "lanczos", "-filter", "cubic", "-pattern", "diagonal", "-blur", "1",
                    "-compression", "lzw", "in.png", "out.tx"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(r.err, "");
  EXPECT_TRUE(w.has("out.tx"));
  r = w.run({"maketex", "-filter", "cubic", "-pattern", "all", "-blur", "2", "-ch", "0,1", "in.png", "more.tx"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_TRUE(w.has("more.tx"));
  for (const char* flag : {"--pattern all: levels", "--blur: the filter", "--ch: all channels"})
    EXPECT_NE(r.err.find(flag), std::string::npos) << r.err;
  r = w.run({"maketex", "-compression", "foo", "in.png", "none.tx"});
  EXPECT_EQ(r.exitCode, 2) << r.err;
  EXPECT_NE(r.err.find("foo"), std::string::npos) << r.err;
  EXPECT_FALSE(w.has("none.tx"));
}

TEST(Maketex, SaysWhatIsWrong) {
  Workplace w;
  ASSERT_EQ(picture(w).exitCode, 0);
  Result r = w.run({"maketex", "none.png"});
  EXPECT_EQ(r.exitCode, 3) << r.err;
  EXPECT_NE(r.err.find("none.png"), std::string::npos) << r.err;
  w.write("broken.png", "this is no picture");
  EXPECT_EQ(w.run({"maketex", "broken.png"}).exitCode, 3);
  EXPECT_FALSE(w.has("broken.tx"));
  EXPECT_EQ(w.run({"maketex", "in.png", "in.png"}).exitCode, 2) << "would overwrite its source";
  EXPECT_EQ(w.run({"maketex", "-mode", "sideways", "in.png"}).exitCode, 2);
  EXPECT_EQ(w.run({"maketex", "-byte", "-float", "in.png"}).exitCode, 2);
  EXPECT_EQ(w.run({"maketex", "in.png", "nowhere/out.tx"}).exitCode, 6);
  EXPECT_EQ(w.run({"maketex"}).exitCode, 2);
}

}  // namespace
}  // namespace kinora::cli
