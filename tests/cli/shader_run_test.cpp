// `kinora shader run` as a user runs it: the points and their world, parameters, networks, outputs, messages and exit
// codes. Misses: what the language computes, which src/language and tests/language show.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "run_program.h"

namespace kinora::cli {
namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// The words behind "shader run -q".
Result quiet(const Workplace& w, std::vector<std::string> words) {
  std::vector<std::string> all = {"shader", "run", "-q"};
  all.insert(all.end(), words.begin(), words.end());
  return w.run(all);
}
std::string textOf(const Workplace& w, const std::string& name) {
  std::ifstream file(w.path(name));
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(ShaderRun, PointsInOrderAtAnyWidthAndThreads) {
  Workplace w;
  w.write("p.osl", "shader p() { printf(\"%g %g;\", u, v); if (u > 0.4) printf(\" right;\"); printf(\"\\n\"); }");
  const std::string expected = "0 0;\n0.5 0; right;\n1 0; right;\n0 1;\n0.5 1; right;\n1 1; right;\n";
  for (const char* width : {"1", "4", "8", "0"})
    for (const char* optimise : {"-O0", "-O2"})
      EXPECT_EQ(quiet(w, {"-g", "3", "2", "--width", width, optimise, "p"}).out, expected) << width << optimise;
  // more points than a slice holds
  const Result one = quiet(w, {"--res", "67", "71", "-t", "1", "p"}),
               four = quiet(w, {"-g", "67", "71", "-t", "4", "p"});
  EXPECT_EQ(one.exitCode, 0);
  EXPECT_EQ(std::count(one.out.begin(), one.out.end(), '\n'), 67 * 71);
  EXPECT_EQ(one.out, four.out);
  // not quiet: an empty line at the end
  EXPECT_EQ(w.run({"shader", "run", "p"}).out, "0.5 0.5; right;\n\n");
}

// The fixture is that of tests/shaders/shader_volumes_test.cpp: density = x + 10 y + 100 z, voxel (0, 0, 0) at (1, 2,
// 3).
TEST(ShaderRun, Volumes) {
  Workplace w;
  w.write("t.osl",
          "shader t(string file = \"volumes.vdb\", string part = \"density\") {\n"
          "  point p = point(1 + 2 * u, 2 + v, 3.5); string why = \"\";\n"
          "  float d = texture3d(file, p, \"width\", 0, \"subimage\", part, \"missingcolor\", color(.5), "
          "\"errormessage\", why);\n"
          "  int size[3] = {0, 0, 0}; gettextureinfo(file, \"resolution\", size);\n"
          "  printf(\"%g %g %g %d %d %d%s\\n\", d, Dx(d), Dy(d), size[0], size[1], size[2], why); }");
  std::ifstream from(KINORA_SOURCE_DIR "/tests/shaders/volumes.vdb", std::ios::binary);
  std::stringstream bytes;
  bytes << from.rdbuf();
  const std::string file = bytes.str();
  w.write("volumes.vdb", file);
  // the step of a pixel is two voxels
  const std::string expected = "110 2 20 8 6 4\n112 2 20 8 6 4\n114 2 20 8 6 4\n";
  for (const char* width : {"1", "8"})
    for (const char* threads : {"1", "2"}) {
      const Result r = quiet(w, {"-g", "3", "1", "-t", threads, "--width", width, "t"});
      EXPECT_EQ(r.out, expected) << r.err;
      EXPECT_EQ(r.exitCode, 0);
      EXPECT_EQ(r.err, "");
    }
  EXPECT_EQ(quiet(w, {"-g", "3", "1", "--param", "part", "Cd", "t"}).out, "0 2 0 8 6 4\n2 2 0 8 6 4\n4 2 0 8 6 4\n");
  w.write("cut.vdb", file.substr(0, 9000));
  for (const char* name : {"cut.vdb", "t.osl", "lost.vdb"}) {
    const Result r = quiet(w, {"--param", "file", name, "t"});
    EXPECT_EQ(r.out, "0.5 0 0 0 0 0the volume is not there\n") << name;
    EXPECT_TRUE(holds(r.err, std::string(name) == "lost.vdb" ? "ASSET-VOLUME-MISSING" : "ASSET-VOLUME-READ"))
        << r.err;
    EXPECT_EQ(r.signal, 0) << name;
  }
  // not in the help, and no command for people
  EXPECT_FALSE(holds(w.run({"--help"}).out, "read-volume"));
  EXPECT_NE(w.run({"read-volume"}).exitCode, 0);
  EXPECT_NE(w.run({"read-volume", "volumes.vdb", "", "many", "10"}).exitCode, 0);
}

TEST(ShaderRun, TheWorld) {
  Workplace w;
  w.write(
      "d.osl",
      "shader d() { printf(\"%g %g %g|%g %g|%g %g %g %g|%g %g|%g %g %g\\n\", P, u, v, Dx(P), Dy(P), Dx(u), Dy(u), "
      "Dx(v), Dy(v), N, Ng, dPdu, dPdv, surfacearea()); }");
  EXPECT_EQ(quiet(w, {"d"}).out, "0.5 0.5 1 0.5 0.5|1 0 0 0 1 0|1 0 0 1|0 0 1 0 0 1|1 0 0 0 1 0 1\n");
  EXPECT_EQ(quiet(w, {"--center", "-g", "2", "1", "--scaleuv", "2", "4", "--offsetuv", "1", "-1", "d"}).out,
            "1.5 1 1 1.5 1|2 0 0 0 4 0|1 0 0 4|0 0 1 0 0 1|1 0 0 0 1 0 1\n"
            "2.5 1 1 2.5 1|2 0 0 0 4 0|1 0 0 4|0 0 1 0 0 1|1 0 0 0 1 0 1\n");
  EXPECT_EQ(
      quiet(w, {"--vary_pdxdy", "--vary_udxdy", "--vary_vdxdy", "-g", "3", "1", "-scalest", "0.5", "0.5", "d"}).out,
      "0 0.25 1 0 0.25|1 0.75 0 0.75 1 0.125|1 0 0.75 0.25|0 0 1 0 0 1|1 0 0 0 1 0 1\n"
      "0.25 0.25 1 0.25 0.25|0.75 0.75 0.125 0.75 0.75 0.125|0.75 0.25 0.75 0.25|0 0 1 0 0 1|1 0 0 0 1 0 1\n"
      "0.5 0.25 1 0.5 0.25|0.5 0.75 0.25 0.75 0.5 0.125|0.5 0.5 0.75 0.25|0 0 1 0 0 1|1 0 0 0 1 0 1\n");
  w.write("s.osl",
          "shader s() { printf(\"%.4f|%.4f|%.4f|%.4f|%.4f\\n\", transform(\"shader\", \"common\", point(1, 0, 0)), "
          "transform(\"object\", \"common\", point(1, 0, 0)), transform(\"myspace\", point(1, 4, 1)), "
          "transform(\"NDC\", point(1, -1, 2)), transform(\"raster\", point(0, 0, 5))); }");
  EXPECT_EQ(quiet(w, {"s"}).out,
            "1.7071 0.7071 0.0000|-0.0000 2.0000 0.0000|1.0000 2.0000 1.0000|0.7500 0.2500 0.9501|0.5000 0.5000 "
            "0.9801\n");
  w.write(
      "a.osl",
      "shader a(float s = 9 [[int lockgeom = 0]], float red = -1 [[int lockgeom = 0]], int face_idx = 9 [[int "
      "lockgeom = 0]], float green = -1) { float f = 0; int n[2] = {0, 0}; string k = \"\"; "
      "printf(\"%g %g %d %g|\", s, red, face_idx, green); printf(\"%d %g \", getattribute(\"camera:fov\", f), f); "
      "printf(\"%d %d %d \", getattribute(\"camera:resolution\", n), n[0], n[1]); "
      "printf(\"%d %s \", getattribute(\"camera:projection\", k), k); "
      "printf(\"%d %g\\n\", getattribute(\"nothing\", f), Dx(s)); }");
  EXPECT_EQ(quiet(w, {"-g", "3", "1", "a"}).out,
            "0 -1 0 -1|1 90 1 3 1 1 perspective 0 0.5\n0.5 -1 2 -1|1 90 1 3 1 1 perspective 0 0.5\n"
            "1 1 4 -1|1 90 1 3 1 1 perspective 0 0.5\n");
  EXPECT_EQ(quiet(w, {"--param:lockgeom=1", "s", "7.5", "--param:lockgeom=0", "green", "4.0", "a"}).out.substr(0, 12),
            "7.5 -1 2 4|1");
  w.write("r.osl", "shader r() { printf(\"%d %d\\n\", raytype(\"camera\"), raytype(\"shadow\")); }");
  EXPECT_EQ(quiet(w, {"r"}).out, "1 0\n");
  EXPECT_EQ(quiet(w, {"--raytype", "shadow", "r"}).out, "0 1\n");
  // whether a primvar comes is known to no compiler: the option says that it does
  w.write("c.osl",
          "shader c(float x = 0 [[ int lockgeom = 0 ]], float y = 0) { printf(\"%d %d\\n\", isconnected(x), "
          "isconnected(y)); }");
  EXPECT_EQ(quiet(w, {"c"}).out, "0 0\n");
  EXPECT_EQ(quiet(w, {"--userdata_isconnected", "c"}).out, "1 0\n");
  w.write("c.osl",
          "shader c() { printf(\"%.4f %d\\n\", luminance(color(1, 0, 0)), transformc(\"ACEScg\", \"RGB\", "
          "color(0.25)) == color(0.25)); }");
  EXPECT_EQ(quiet(w, {"c"}).out.substr(0, 6), "0.2125");
  EXPECT_EQ(quiet(w, {"--colorspace", "ACEScg", "c"}).out, "0.2722 1\n");
}

TEST(ShaderRun, Parameters) {
  Workplace w;
  w.write("q.osl",
          "struct pair { float a; string b; };\n"
          "shader q(int i = 1, float f = 2, color c = 3, string s = \"x\", matrix m = 1, float l[2] = {1, 2}, "
          "string t[] = {\"z\"}, pair p = {4, \"y\"}, color cs[2] = {0, 0}) { printf(\"%d %g %g %s %g %g %s(%d) %g%s "
          "%g\\n\", i, f, c, s, m[3][0], l, t, arraylength(t), p.a, p.b, cs); }");
  EXPECT_EQ(quiet(w, {"q"}).out, "1 2 3 3 3 x 0 1 2 z(1) 4y 0 0 0 0 0 0\n");
  EXPECT_EQ(quiet(w, {"--param",
                      "i",
                      "7",
                      "-param",
                      "f",
                      "0.5",
                      "--param",
                      "c",
                      "1,2,3",
                      "--param",
                      "s",
                      "a b",
                      "--param",
                      "m",
                      "1,0,0,0,0,1,0,0,0,0,1,0,9,0,0,1",
                      "--param:type=float[2]",
                      "l",
                      "5,6",
                      "--param:type=string[]",
                      "t",
                      "u,v,w",
                      "--param",
                      "p.a",
                      "8",
                      "--param",
                      "p.b",
                      "k",
                      "--param:type=color[2]",
                      "cs",
                      "1,2,3,4,5,6",
                      "q"})
                .out,
            "7 0.5 1 2 3 a b 9 5 6 u v w(3) 8k 1 2 3 4 5 6\n");
  EXPECT_EQ(quiet(w, {"--param:type=color", "c", "2", "q"}).out.substr(0, 9), "1 2 2 0 0");
  EXPECT_EQ(quiet(w, {"--param", "i", "5", "--param", "i", "6", "q"}).out[0], '6');
  Result r = quiet(w, {"--param", "s", "1.5", "q"});  // a number for a string
  EXPECT_EQ(r.exitCode, 1);
  EXPECT_TRUE(holds(r.err, "parameter `s` of shader q is a string and was given a float")) << r.err;
  r = quiet(w, {"--param", "nothing", "1", "q"});
  EXPECT_EQ(r.exitCode, 0);
  EXPECT_TRUE(holds(r.err, "has no parameter `nothing`")) << r.err;
  for (const std::vector<std::string>& bad : {std::vector<std::string>{"--param:type=int", "i", "x", "q"},
                                              {"--param:type=float[2]", "l", "1,2,3", "q"},
                                              {"--param:type=float[0]", "l", "1", "q"},
                                              {"--param:type=float[99999999999]", "l", "1", "q"},
                                              {"--param:type=thing", "i", "1", "q"},
                                              {"--param:strange=1", "i", "1", "q"},
                                              {"q", "--param", "i", "1"}}) {
    r = quiet(w, bad);
    EXPECT_EQ(r.exitCode, 1) << bad[0];
    EXPECT_TRUE(r.err.starts_with("error: ")) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  w.write("again.osl", "shader again(float x = 1, float l[2] = {0, 0}) { printf(\"%g %g;\", x, l); }");
  EXPECT_EQ(quiet(w, {"--layer", "n", "--param", "x", "2", "again", "--iters", "3", "--reparam", "n", "x", "4",
                      "--reparam:type=float[2]", "n", "l", "5,6"})
                .out,
            "2 0 0;4 5 6;4 5 6;");
  EXPECT_EQ(quiet(w, {"again", "--iters", "2", "--reparam", "none", "x", "4"}).exitCode, 1);
}

TEST(ShaderRun, Networks) {
  Workplace w;
  w.write("up.osl",
          "shader up(float k = 1, output color c = 0, output float f = 0) { printf(\"up \"); c = color(k, 2, 3); f = "
          "k; }");
  w.write("down.osl",
          "shader down(float a = -1, color b = -1, int on = 1) { printf(\"down \"); if (on) printf(\"%g %g\\n\", a, "
          "b); }");
  const std::vector<std::string> layers = {"--param", "k", "5", "--layer", "u", "up", "--shader", "down", "d"};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), layers.begin(), layers.end());
    return quiet(w, more);
  };
  EXPECT_EQ(run({}).out, "down -1 -1 -1 -1\n");
  EXPECT_EQ(run({"--connect", "u", "f", "d", "a", "--connect", "u", "c", "d", "b"}).out, "down up 5 5 2 3\n");
  // what feeds a component runs before the layer that it feeds
  EXPECT_EQ(run({"-connect", "u", "c[1]", "d", "a", "-connect", "u", "f", "d", "b[2]"}).out, "up down 2 -1 -1 5\n");
  EXPECT_EQ(run({"-connect", "u", "c[1]", "d", "a"}).out, "down up 2 -1 -1 -1\n");
  EXPECT_EQ(run({"--connect", "u", "f", "d", "b"}).out, "down up -1 5 5 5\n");
  EXPECT_EQ(
      w.run({"shader", "run", "--layer", "u", "up", "--layer", "d", "down", "--connect", "u", "f", "d", "a"}).out,
      "Connect u.f to d.a\ndown up 1 -1 -1 -1\n\n");
  // lazy, eager, by entry
  EXPECT_EQ(run({"--options", "lazyunconnected=0"}).out, "up down -1 -1 -1 -1\n");
  EXPECT_EQ(run({"--entry", "u"}).out, "up ");
  EXPECT_EQ(run({"--entry", "d", "--entry", "u", "--connect", "u", "f", "d", "a"}).out, "down up 5 -1 -1 -1\n");
  // as text, in words and from a file
  const char* text = "param float k 5 ; shader up u; shader down d, connect u.f d.a; connect u.c d.b ;";
  EXPECT_EQ(quiet(w, {"--group", text}).out, "down up 5 5 2 3\n");
  w.write("n.oslgroup", text);
  EXPECT_EQ(quiet(w, {"--group", "n.oslgroup"}).out, "down up 5 5 2 3\n");
  const Result verbose = w.run({"shader", "run", "-v", "--groupname", "g", "--group", "n.oslgroup"});
  EXPECT_TRUE(holds(verbose.out,
                    "Shader group:\n---\nparam float k 5 ;\nshader up u ;\nshader down d ;\nconnect u.f d.a "
                    ";\nconnect u.c d.b ;\n---\n"
                    "\nShader group \"g\" layers are:\n    u\n    d\n"))
      << verbose.out;
  EXPECT_EQ(
      quiet(w, {"--expr", "printf(\"%g \", s + t); result = color(u, v, 0);", "--print", "-o", "result", "null"}).out,
      "1 Pixel (0, 0):\n  result : 0.5 0.5 0\n");

  struct Bad {
    std::vector<std::string> words;
    const char* says;
  };
  for (const Bad& bad : {Bad{{"--connect", "x", "f", "d", "a"}, "no layer is named `x`"},
                         {{"--connect", "u", "x", "d", "a"}, "`x` is no parameter of shader up"},
                         {{"--connect", "u", "c", "d", "a"}, "cannot connect a color (c) to a float (a)"},
                         {{"--connect", "u", "c[7]", "d", "a"}, "`c[7]` is no part of a color"},
                         {{"--connect", "u", "f", "d", "a", "--connect", "d", "a", "u", "k"}, "cyclic"},
                         {{"--connect", "d", "a", "d", "a"}, "cyclic"},
                         {{"--entry", "none"}, "no layer is named `none`"},
                         {{"--group", "bad thing"}, "'bad' is no statement"},
                         {{"--group", "param float x y; shader up q;"}, "'y' is no value of float x"},
                         {{"--group", "param float[2] x 1 2 3; shader up q;"}, "too many values"},
                         {{"--group", "connect ab cd;"}, "is not LAYER.OUTPUT LAYER.INPUT"},
                         {{"--group", "shader up u;"}, "two layers are named 'u'"},
                         {{"--group", "shader nothing z;"}, "nothing: error: cannot read the shader"},
                         {{"missing"}, "missing: error: cannot read the shader"},
                         {{"--expr", "result = nope;"}, "error: 'nope' is not declared"}}) {
    const Result r = run(bad.words);
    EXPECT_EQ(r.exitCode, 1) << bad.says;
    EXPECT_TRUE(holds(r.err, bad.says)) << r.err;
    EXPECT_EQ(r.out, "") << bad.says;
  }
}

TEST(ShaderRun, Outputs) {
  Workplace w;
  w.write("o.osl",
          "shader o(output color Cout = 0, output float f[2] = {0, 0}, output int n = 0, output string s = \"\") "
          "{ Cout = color(u, v, 2); f[1] = u; n = int(2 * u); printf(\"%d\", isconnected(Cout)); }");
  Result r =
      w.run({"shader", "run", "-g", "2", "2", "-o", "Cout", "c.exr", "-o", "o_0.n", "n.exr", "-o", "f", "null", "o"});
  EXPECT_EQ(r.exitCode, 0) << r.err;
  EXPECT_EQ(r.out, "\nOutput Cout to c.exr\nOutput o_0.n to n.exr\n2222");
  r = w.run({"info", "c.exr"});
  EXPECT_TRUE(holds(r.out, "channel B (float): 2 to 2")) << r.out;
  EXPECT_TRUE(holds(w.run({"info", "n.exr"}).out, "(float): 0 to 2")) << r.out;
  EXPECT_EQ(
      quiet(w, {"-g", "2", "1", "--print", "-o", "Cout", "x.exr", "-o", "f", "null", "-o", "n", "null", "o"}).out,
      "2Pixel (0, 0):\n  Cout : 0 0.5 2\n  f : 0 0\n  n : 0\n2Pixel (1, 0):\n  Cout : 1 0.5 2\n  f : 0 1\n  n : 2\n");
  EXPECT_FALSE(w.has("x.exr"));
  EXPECT_EQ(quiet(w, {"-o", "Cout", "h.exr", "-od", "half", "o"}).exitCode, 0);
  EXPECT_TRUE(holds(w.run({"info", "h.exr"}).out, "(half)"));
  EXPECT_EQ(quiet(w, {"-o", "Cout", "b.tif", "-od", "uint8", "o"}).exitCode, 0);
  r = quiet(w, {"-o", "nothing", "y.exr", "o"});
  EXPECT_EQ(r.exitCode, 1);
  EXPECT_TRUE(holds(r.err, "no layer has an output 'nothing'")) << r.err;
  r = quiet(w, {"-o", "s", "y.exr", "o"});
  EXPECT_EQ(r.exitCode, 1);
  EXPECT_TRUE(holds(r.err, "output 's' is a string")) << r.err;
  EXPECT_EQ(quiet(w, {"-o", "Cout", "no/such/folder.exr", "o"}).exitCode, 6);
  // a thousand channels of 2^28 points are refused before they are made
  w.write("big.osl", "shader big(output float f[1000] = {0}) { f[0] = u; }");
  r = quiet(w, {"-g", "16384", "16384", "-o", "f", "z.exr", "big"});
  EXPECT_EQ(r.exitCode, 1);
  EXPECT_TRUE(holds(r.err, "too large")) << r.err;
}

TEST(ShaderRun, Messages) {
  Workplace w;
  w.write("m.osl",
          "shader m() { float a[2] = {1, 2}; warning(\"w\"); error(\"e %g\", u); warning(\"w\"); "
          "printf(\"%g;\", a[int(4 * u)]); fprintf(\"log.txt\", \"%g\\n\", u); }");
  Result r = quiet(w, {"-g", "2", "1", "m"});
  EXPECT_EQ(r.exitCode, 0);
  EXPECT_EQ(r.out, "1;2;");
  EXPECT_EQ(r.err,
            "WARNING: Shader warning [m]: w\nERROR: Shader error [m]: e 0\nERROR: Shader error [m]: e 1\n"
            "ERROR: Index [4] out of range a[0..1]: m.osl:1 (group unnamed_group_1, layer 0 m_0, shader m)\n");
  EXPECT_EQ(textOf(w, "log.txt"), "0\n1\n");
  r = quiet(w, {"-g", "2", "1", "--options", "error_repeats=1,range_checking=0", "m"});
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 6) << r.err;
  EXPECT_EQ(textOf(w, "log.txt"), "0\n1\n0\n1\n");
  w.write("t.osl",
          "shader t() {\n int i = 5;\n setmessage(\"a\", u);\n printf(\"%d \", getmessage(\"a\", i));\n "
          "setmessage(\"a\", v);\n printf(\"%d %d;\", getmessage(\"b\", i), i);\n setmessage(\"b\", 1);\n}");
  r = quiet(w, {"-g", "2", "1", "t"});
  EXPECT_EQ(r.out, "0 0 5;0 0 5;");
  EXPECT_EQ(
      r.err,
      "ERROR: type mismatch for message \"a\" (created as float here: t.osl:3) cannot fetch as int from t.osl:4\n"
      "ERROR: message \"a\" already exists (created here: t.osl:3) cannot set again from t.osl:5\n"
      "ERROR: message \"b\" was queried before being set (queried here: t.osl:6) setting it now (t.osl:7) would lead "
      "to inconsistent results\n");
  w.write("out.osl", "shader out(string f = \"../escaped.txt\") { fprintf(f, \"x\"); }");
  for (const char* file : {"../escaped.txt", "/tmp/kinora_escaped.txt", ".", ""}) {
    r = quiet(w, {"-g", "2", "1", "--param:type=string", "f", file, "out"});
    EXPECT_EQ(r.exitCode, 1) << file;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  w.write("n.osl",
          "shader n(output color Cout = 0) {\n  float x;\n  Cout = x;\n  Cout[1] = exp(100) * exp(100 * u);\n}");
  r = quiet(w, {"-g", "2", "1", "--debuguninit", "n"});
  EXPECT_TRUE(
      holds(r.err,
            "Detected possible use of uninitialized value in float x at n.osl:3 (group unnamed_group_1, layer 0 "
            "n_0, shader n, op "))
      << r.err;
  // a string that was never set in either point, one that was in the second; nothing of those with a value
  w.write("text.osl",
          "shader text(output int n = 0, output string all = \"\") {\n"
          "  string never, late[2], set = \"\";\n"
          "  if (u > 0.5) late[1] = \"x\";\n"
          "  n = strlen(never) + strlen(set);\n"
          "  all = concat(set, late[1]);\n"
          "  all = concat(all, never);\n}");
  r = quiet(w, {"-g", "2", "1", "--debuguninit", "--print", "-o", "n", "null", "text"});
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 2) << r.err;
  EXPECT_TRUE(holds(r.err, "Detected possible use of uninitialized value in string never at text.osl:4 ")) << r.err;
  EXPECT_TRUE(holds(r.err, "Detected possible use of uninitialized value in string[2] late at text.osl:5 ")) << r.err;
  EXPECT_TRUE(holds(r.out, "n : 0")) << r.out;
  EXPECT_EQ(quiet(w, {"-g", "2", "1", "text"}).err, "");
  r = quiet(w, {"-g", "2", "1", "--debugnan", "--print", "-o", "Cout", "null", "n"});
  EXPECT_TRUE(holds(r.err, "Detected inf value in ")) << r.err;
  EXPECT_TRUE(holds(r.err, " value in Cout at n.osl:4 (op compassign)")) << r.err;
  EXPECT_EQ(quiet(w, {"-g", "2", "1", "n"}).err, "");
  r = w.run({"shader", "run", "--stats", "n"});
  EXPECT_TRUE(holds(r.out, "instructions ")) << r.out;
}

TEST(ShaderRun, BadCommandLines) {
  Workplace w;
  w.write("b.osl", "shader b() {}");
  for (const std::vector<std::string>& bad : {std::vector<std::string>{},
                                              {"--param", "a"},
                                              {"-g", "0", "1", "b"},
                                              {"-g", "1", "b"},
                                              {"-g", "-4", "4", "b"},
                                              {"-g", "99999999", "1", "b"},
                                              {"-g", "100000", "100000", "b"},
                                              {"--width", "3", "b"},
                                              {"-t", "x", "b"},
                                              {"-t", "99999", "b"},
                                              {"--iters", "0", "b"},
                                              {"--fancy", "b"},
                                              {"-od", "int", "b"},
                                              {"--colorspace", "none", "b"},
                                              {"--scaleuv", "1", "nan", "b"},
                                              {"--raytype"},
                                              {"-o", "x"},
                                              {"--connect", "a", "b", "c"}}) {
    const Result r = quiet(w, bad);
    EXPECT_EQ(r.exitCode, 2) << (bad.empty() ? "" : bad[0]);
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
  }
  const Result help = w.run({"shader", "run", "--help"});
  EXPECT_EQ(help.exitCode, 0);
  EXPECT_TRUE(holds(help.out, "--vary_pdxdy")) << help.out;
  // options of the tool that scripts know, without meaning here
  EXPECT_EQ(quiet(w, {"--batched", "--llvm_opt", "2", "--noshadeimage", "--texoptions", "a=1", "b"}).exitCode, 0);
}

}  // namespace
}  // namespace kinora::cli
