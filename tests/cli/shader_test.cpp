// `kinora shader compile` and `info` as a user runs them: what they print, the files they write, the exit codes.
// Misses: what is in the .oso beyond its first lines, which src/language/program tests.
#include <gtest/gtest.h>

#include "run_program.h"

namespace kinora::cli {
namespace {

constexpr const char* kSource =
    "#include \"inc.h\"\n"
    "shader s [[ string help = \"h\" ]] (float a = X [[ string label = \"A\" ]], string n[2] = {\"a\", \"b\"}, "
    "vector p = {1, 2, 3},\n"
    "         float r = a, output color o = 0) { o = r; }\n";

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Shader, Compile) {
  Workplace w;
  w.write("s.osl", kSource);
  w.write("inc.h", "#define X 1\n");
  Result r = w.run({"shader", "compile", "s.osl"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(r.out, "Compiled s.osl -> s.oso\n");
  r = w.run({"shader", "compile", "-q", "--Wall", "-O2", "-o", "other.oso", "-MD", "-MTtarget", "s.osl"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(r.out + r.err, "");
  r = w.run({"shader", "compile", "-q", "-MM", "-MFrule.d", "-MT", "target", "s.osl"});
  EXPECT_EQ(r.out, "");
  EXPECT_TRUE(w.has("rule.d"));
  r = w.run({"shader", "compile", "-MM", "s.osl"});
  EXPECT_EQ(r.out, "s.oso: s.osl inc.h\n");
  r = w.run({"shader", "compile", "-E", "-DY=7", "s.osl"});
  EXPECT_TRUE(has(r.out, "float a = 1")) << r.out;
}

TEST(Shader, CompileRefuses) {
  Workplace w;
  w.write("e.osl", "shader e() {\n  float x = y;\n}\n");
  Result r = w.run({"shader", "compile", "e.osl"});
  EXPECT_EQ(r.exitCode, 1);
  EXPECT_EQ(r.out, "FAILED e.osl\n");
  EXPECT_TRUE(has(r.err, "e.osl:2: error: 'y' is not declared\n  2:13 |   float x = y;\n       |             ^\n"))
      << r.err;
  w.write("w.osl", "shader w() {\n  int x = 1.5;\n}\n");
  EXPECT_EQ(w.run({"shader", "compile", "w.osl"}).exitCode, 0);
  EXPECT_EQ(w.run({"shader", "compile", "-Werror", "w.osl"}).exitCode, 1);
  EXPECT_EQ(w.run({"shader", "compile", "missing.osl"}).exitCode, 1);
  EXPECT_EQ(w.run({"shader", "compile", "-o", "no/such/folder/x.oso", "w.osl"}).exitCode, 6);
  EXPECT_EQ(w.run({"shader", "compile", "-fancy", "w.osl"}).exitCode, 2);
  EXPECT_EQ(w.run({"shader", "compile"}).exitCode, 2);
  EXPECT_EQ(w.run({"shader", "nothing"}).exitCode, 2);
}

TEST(Shader, Info) {
  Workplace w;
  w.write("s.osl", kSource);
  w.write("inc.h", "#define X 1\n");
  ASSERT_EQ(w.run({"shader", "compile", "-q", "s.osl"}).exitCode, 0);
  const std::string plain =
      "shader \"s\"\nfloat a  1\nstring[2] n \"a\" \"b\" \nvector p  [ 1 2 3 ]\nfloat r nodefault\noutput color o  [ "
      "0 0 0 ]\n";
  EXPECT_EQ(w.run({"shader", "info", "s.osl"}).out, plain);
  EXPECT_EQ(w.run({"shader", "info", "s.oso"}).out, plain);
  EXPECT_EQ(w.run({"shader", "info", "s"}).out, plain);
  const Result verbose = w.run({"shader", "info", "-v", "s"});
  EXPECT_TRUE(has(verbose.out,
                  "shader \"s\"\n\t\tmetadata: string help = \"h\"\n    \"a\" \"float\"\n\t\tDefault value: "
                  "1\n\t\tmetadata: string label = \"A\"\n"))
      << verbose.out;
  EXPECT_TRUE(has(verbose.out, "    \"o\" \"output color\"\n\t\tDefault value: [ 0 0 0 ]\n")) << verbose.out;
  EXPECT_EQ(w.run({"shader", "info", "--param", "p", "s"}).out, "vector p  [ 1 2 3 ]\n");
  EXPECT_EQ(w.run({"shader", "info", "--param", "none", "s"}).exitCode, 1);
  EXPECT_TRUE(has(w.run({"shader", "info", "--ir", "s"}).out, "assign o r"));
  EXPECT_TRUE(has(w.run({"shader", "info", "--count", "s"}).out, "parameters 4\noutputs 1\n"));
  EXPECT_EQ(w.run({"shader", "info", "missing"}).exitCode, 1);
}

}  // namespace
}  // namespace kinora::cli
