// Proves: what shaders cost is counted, and many instances of one network cost little: they are compiled once.
#include <malloc.h>
#include <unistd.h>

#include <cstdio>

#include "fixture.h"

namespace kinora::tests {
namespace {

class ShaderScale : public Shaders {};

TEST_F(ShaderScale, TimePointsAndLanesAreCounted) {
  write("straight.osl", "shader straight(output color result = 0) { result = sin(P) * cos(u); }");
  write("halves.osl",
        "shader halves(output color result = 0) { result = u; if (sin(u * 100) > 0) { result = sin(P); result = "
        "cos(result); "
        "result = sin(result); result = exp(result); result *= u; } }");
  for (const char* name : {"straight", "halves"}) {
    RenderRequest r = requestOf("Pattern \"" + std::string(name) + "\" \"n\"\n" + kShow);
    r.rib.replace(r.rib.find("16 16"), 5, "64 64");
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const render::Statistics& s = render.renderer().statistics();
    ASSERT_EQ(s.shaders.size(), 1u);
    const render::ShaderCost& c = s.shaders[0];
    EXPECT_EQ(c.name, name);
    EXPECT_EQ(c.materials, 1u);
    EXPECT_EQ(c.points, 64u * 64);
    EXPECT_EQ(c.points, s.shadingPoints);
    EXPECT_GT(c.nanoseconds, 0u);
    EXPECT_GT(c.instructions, 0u);
    EXPECT_GE(c.countedRuns * 16, c.runs);
    ASSERT_GT(c.lanes.possible, 0u);
    const double use = double(c.lanes.active) / double(c.lanes.possible);
    if (c.name == "straight")
      EXPECT_EQ(use, 1);
    else
      EXPECT_LT(use, 0.9);
    EXPECT_GT(use, 0.3);
  }
}

// As many squares as instances, each with a network of its own numbers.
// `ownNumbers`: false for one network that all of them name.
std::string manyNetworks(int instances, bool ownNumbers = true) {
  std::string rib;
  rib.reserve(size_t(instances) * 500);
  for (int i = 0; i < instances; ++i) {
    char text[1024];
    const float x = float(i % 100) / 50 - 1, y = float(i / 100) / 50 - 1;
    std::snprintf(text, sizeof text,
                  "AttributeBegin\nPattern \"base\" \"a\" \"float level\" [%g] \"int seed\" [%d]\n"
                  "Pattern \"tinted\" \"n\" \"reference color base\" [\"a:result\"] \"color tint\" [%g .5 %g]\n%s"
                  "Polygon \"P\" [%g %g 0  %g %g 0  %g %g 0  %g %g 0]\nAttributeEnd\n",
                  double(i) / instances, i, 1 - double(i) / instances, double(i) / instances, kShow, x, y, x,
                  y + 0.02, x + 0.02, y + 0.02, x + 0.02, y);
    std::string square(text);
    if (!ownNumbers) {
      const size_t from = square.find("Pattern"), to = square.find("Polygon");
      if (i == 0) rib += square.substr(from, to - from);
      square.erase(from, to - from);
    }
    rib += square;
  }
  return rib;
}

uint64_t resident() {
  malloc_trim(0);
  long pages = 0, held = 0;
  if (FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%ld %ld", &pages, &held) != 2) held = 0;
    std::fclose(f);
  }
  return uint64_t(held) * uint64_t(sysconf(_SC_PAGESIZE));
}

// 10,000 instances that differ in numbers, integers among them: compiled once, each at most 2 KB.
TEST_F(ShaderScale, TenThousandInstancesShareOneProgram) {
  write("base.osl",
        "shader base(float level = 0, int seed = 0, output color result = 0) { result = level * "
        "(color)cellnoise(seed + 0.5); }");
  write("tinted.osl",
        "shader tinted(color base = 0, color tint = 1, output color result = 0) { result = base * tint; }");
  constexpr int kInstances = 10000;
  const auto requestFor = [&](int n, bool ownNumbers = true) {
    RenderRequest r = requestOf(manyNetworks(n, ownNumbers));
    // the square of the fixture is left out: only those of the instances stand
    r.rib.erase(r.rib.find("Polygon \"P\" [-1 -1 0  -1 1 0  1 1 0"));
    r.rib += "WorldEnd\n";
    return r;
  };
  const auto owned = [](SceneRender& r, const std::string& name) {
    for (const auto& o : r.renderer().statistics().memory)
      if (o.name == name) return o.bytes;
    return uint64_t(0);
  };
  SceneRender few(requestFor(100));
  const uint64_t start = resident();
  SceneRender alike(requestFor(kInstances, false));
  const uint64_t middle = resident();
  SceneRender many(requestFor(kInstances));
  const uint64_t end = resident();
  ASSERT_TRUE(few.ok() && alike.ok() && many.ok());
  EXPECT_EQ(alike.renderer().statistics().materials, 1u);
  // what the squares need is there both times; the rest is what the scene says, by far: three nodes, eight parameters
  const int64_t grown = int64_t(end - middle) - int64_t(middle - start);
#ifndef KINORA_SANITIZED  // whose own memory is in it
  EXPECT_LE(grown / kInstances, 2560);
#endif
  const render::Statistics& s = many.renderer().statistics();
  EXPECT_EQ(s.materials, uint64_t(kInstances));
  EXPECT_EQ(s.programs, 1u);
  EXPECT_EQ(s.shaderPrograms, 1u);
  EXPECT_EQ(s.shadersCompiled, 2u);
  const uint64_t each = (owned(many, "materials") + owned(many, "shader programs")) / kInstances;
  EXPECT_LE(each, 256u);
  std::printf("    an instance: %llu bytes counted, %lld of the process with its description\n",
              static_cast<unsigned long long>(each), static_cast<long long>(grown / kInstances));
  // squares of both ends of the list show their own numbers
  const image::Image a = many.channel("Ci");
  EXPECT_NE(a.at(2, 2)[0], a.at(12, 12)[0]);
}

// Names of textures are numbers too; what a condition asks is not.
TEST_F(ShaderScale, WhatDecidesTheCodeIsAProgramOfItsOwn) {
  write("named.osl",
        "shader named(string file = \"\", int mode = 0, int seed = 0, output color result = 0) { if (file != \"\") "
        "result = "
        "texture(file, u, v, \"missingcolor\", color(0, 0, 1)); if (mode == 1) result += hash(seed); }");
  const auto pattern = [](const std::string& parameters) {
    return "Pattern \"named\" \"n\" " + parameters + "\n" + kShow +
           "Polygon \"P\" [-1 -1 1  -1 1 1  0 1 1  0 -1 1]\n";
  };
  const auto programs = [&](const std::string& a, const std::string& b) {
    SceneRender render(requestOf("AttributeBegin\n" + pattern(a) + "AttributeEnd\n" + pattern(b)));
    return render.renderer().statistics().programs;
  };
  EXPECT_EQ(programs("\"string file\" [\"a.tex\"]", "\"string file\" [\"b.tex\"]"), 1u);
  EXPECT_EQ(programs("\"int seed\" [3]", "\"int seed\" [4]"), 1u);
  EXPECT_EQ(programs("\"int mode\" [0]", "\"int mode\" [1]"), 2u);
  // and each shows its own
  SceneRender render(requestOf("AttributeBegin\nPattern \"named\" \"n\" \"string file\" [\"nowhere.tex\"]\n" +
                               std::string(kShow) +
                               "Polygon \"P\" [-1 -1 0  -1 1 0  0 1 0  0 -1 0]\nAttributeEnd\nTranslate 0 0 .5\n"
                               "Pattern \"named\" \"n\" \"string file\" [\"\"]\n" +
                               kShow));
  const image::Image picture = render.channel("Ci");
  EXPECT_EQ(picture.at(3, 8)[2], 1);
  EXPECT_EQ(picture.at(12, 8)[2], 0);
}

}  // namespace
}  // namespace kinora::tests
