// What is made to hurt, when it runs and not only when it is compiled: large and deep programs, large arrays,
// compiled files that are cut off. Refusals at compile time are tested beside the front end (limits_test.cpp).
#include <gtest/gtest.h>

#include <ctime>

#include "language/front/compile.h"
#include "language/program/oso_reader.h"
#include "language/program/oso_writer.h"
#include "language/program_file.h"
#include "language/program_runner.h"

namespace kinora::oracle {
namespace {

using namespace language;
using language::testing::Points;

std::string repeated(const std::string& s, size_t n) {
  std::string out;
  for (size_t i = 0; i < n; ++i) out += s;
  return out;
}

ShaderGroup groupOf(const std::string& source) {
  ShaderGroup group;
  CompileResult r = compile(source, "t.osl");
  EXPECT_TRUE(r.ok()) << (r.messages.empty() ? "" : r.messages[0].str());
  if (!r.ok()) return group;
  group.layers.push_back({std::make_shared<const Shader>(std::move(*r.shader)), "layer", {}});
  group.outputs = {"r"};
  return group;
}
// r of point 3
float valueOf(const std::string& source) {
  const ShaderGroup group = groupOf(source);
  std::string error;
  const auto program = compileGroup(group, {}, error);
  EXPECT_TRUE(program) << error;
  return program ? runOnce(*program, group, Points(20)).values.at("r")[3] : -1;
}
double seconds(std::clock_t from) { return double(std::clock() - from) / CLOCKS_PER_SEC; }

TEST(BadInput, AHundredThousandLinesRun) {
  std::string source = "shader t(output float r = 0) {\n";
  for (int i = 0; i < 100000; ++i) source += "  r = r * 0.5 + u;\n";
  const std::clock_t begin = std::clock();
  EXPECT_NEAR(valueOf(source + "}\n"), 2 * Points::uOf(3), 1e-5);
  EXPECT_LT(seconds(begin), 30.0);
}

TEST(BadInput, DeepNestingRuns) {
  EXPECT_EQ(valueOf("shader t(output float r = 0) { " + repeated("if (u < 2) { ", 60) + "r = 3;" + repeated("}", 60) +
                    " }"),
            3);
  EXPECT_EQ(valueOf("shader t(output float r = 0) { " + repeated("for (int i = 0; i < 1; i++) { ", 60) +
                    "r += u < 2;" + repeated("}", 60) + " }"),
            1);
  std::string chain = "float f0(float x) { if (x > 5) return 1; return x; }\n";
  for (int i = 1; i < 60; ++i)
    chain += "float f" + std::to_string(i) + "(float x) { if (x > 5) return 2; return f" + std::to_string(i - 1) +
             "(x) + 1; }\n";
  EXPECT_EQ(valueOf(chain + "shader t(output float r = 0) { r = f59(floor(u)); }"), 59);
}

TEST(BadInput, LargeArraysRunOrAreRefusedWithAMessage) {
  EXPECT_EQ(valueOf("shader t(output float r = 0) { int a[1000]; for (int i = 0; i < 1000; i++) a[i] = i; r = "
                    "a[int(u * 0) + 999]; }"),
            999);
  // as many as the language takes: more than a block of points holds
  const ShaderGroup group =
      groupOf("shader t(output float r = 0) { float a[1048576]; a[int(u * 10)] = v; r = a[5]; }");
  std::string error;
  const auto program = compileGroup(group, {}, error);
  EXPECT_TRUE(program || error.find("more memory than a program may take") != std::string::npos) << error;
  // more than that are no array at all
  EXPECT_FALSE(compile("shader t() { float a[1048577]; }", "t.osl").ok());
}

// The compiled form of each program gives what the source gives; cut off anywhere it is refused with its line, or is
// a whole program of its own.
TEST(BadInput, CompiledProgramsComeBackAndWhatIsCutOffIsRefused) {
  size_t count = 0, refused = 0;
  for (const ProgramFile& p : readPrograms()) {
    if (!p.wrong.empty()) continue;
    SCOPED_TRACE(p.name);
    ShaderGroup group = p.group;
    for (size_t l = 0; l < group.layers.size(); ++l) {
      const std::string text = osoText(*p.shaders[l]);
      Shader again;
      std::string error;
      ASSERT_TRUE(readOso(text, p.name, again, error)) << error << "\n" << text;
      EXPECT_EQ(osoText(again), text);
      group.layers[l].shader = std::make_shared<const Shader>(std::move(again));
      for (size_t k = 0; k < 12; ++k) {
        const std::string part = text.substr(0, (text.size() * (2 * k + 1) / 24 + count) % text.size());
        Shader cut;
        error.clear();
        const bool isRead = readOso(part, "cut.oso", cut, error);
        EXPECT_EQ(isRead, error.empty());
        if (isRead)
          EXPECT_EQ(invalid(cut), "");
        else
          ++refused;
      }
    }
    MachineOptions options;
    options.iterationLimit = 2000;
    std::string error;
    const auto own = compileGroup(p.group, options, error), read = compileGroup(group, options, error);
    ASSERT_TRUE(own && read) << error;
    const Points points(50);
    const Ran a = runOnce(*own, p.group, points), b = runOnce(*read, group, points);
    for (const auto& [name, values] : a.values)
      EXPECT_EQ(std::memcmp(values.data(), b.values.at(name).data(), values.size() * 4), 0) << name;
    EXPECT_EQ(a.messages, b.messages);
    ++count;
  }
  EXPECT_GE(count, 250u);
  EXPECT_GE(refused, 2000u);
}

}  // namespace
}  // namespace kinora::oracle
