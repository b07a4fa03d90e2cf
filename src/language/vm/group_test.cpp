// Proves networks of shaders: connections of every kind, the order in which layers run and that unneeded ones do not,
// errors for what cannot be connected, instances that share one program.
#include "language/vm/test_runner.h"

namespace kinora::language {
namespace {
using namespace testing;

ShaderGroup network(std::vector<std::pair<std::string, std::string>> layers, std::vector<Connection> connections,
                    std::vector<std::string> outputs = {"r"}) {
  ShaderGroup group;
  for (auto& [name, text] : layers) group.layers.push_back({shaderOf(text), name, {}});
  group.connections = std::move(connections);
  group.outputs = std::move(outputs);
  return group;
}
std::string errorOf(const ShaderGroup& group) {
  std::string error;
  EXPECT_FALSE(compileGroup(group, {}, error));
  return error;
}
Setting number(const std::string& name, float value) {
  Setting s;
  s.parameter = name;
  s.type = {Base::Float, 0, -1};
  s.values.floats = {value};
  return s;
}

const char* const kSource =
    "shader source(float gain = 2, output float f = 0, output color c = 0, output int i = 0) { f = u * gain; c = "
    "color(u, v, f); i = int(u * 5); }";

TEST(LanguageGroups, ValuesPassConnections) {
  const Answer a = runEverywhere(network(
      {{"a", kSource},
       {"b", "shader sink(float x = 7, color y = 0, float z = 1, output float r = 0) { r = x + y[1] * 10 + z; }"}},
      {{"a", "f", "b", "x"}, {"a", "c", "b", "y"}, {"a", "i", "b", "z"}}));
  for (uint32_t k = 0; k < 300; ++k) {
    const float u = Points::uOf(k), v = Points::vOf(k);
    EXPECT_EQ(a.of("r", k), u * 2 + v * 10 + float(int(u * 5)));
  }
}

TEST(LanguageGroups, ComponentsAndScalarsConvert) {
  const Answer a = runEverywhere(network({{"a", kSource},
                                          {"b",
                                           "shader sink(color x = color(5, 6, 7), color y = 0, output float r = 0) { "
                                           "r = x[0] + 10 * x[1] + 100 * x[2] + y[2]; }"}},
                                         {{"a", "c[1]", "b", "x[1]"}, {"a", "f", "b", "y"}}));
  for (uint32_t k = 0; k < 300; ++k) {
    const float u = Points::uOf(k), v = Points::vOf(k);
    EXPECT_FLOAT_EQ(a.of("r", k), 5 + 10 * v + 700 + u * 2);
  }
}

TEST(LanguageGroups, StructsConnectWhole) {
  const std::string s = "struct S { float a; color b; };\n";
  const Answer a =
      runEverywhere(network({{"a", s + "shader source(output S o = {1, 2}) { o.a = u; o.b = color(v, 1, 2); }"},
                             {"b", s + "shader sink(S i = {0, 0}, output float r = 0) { r = i.a + i.b[0] * 2; }"}},
                            {{"a", "o", "b", "i"}}));
  for (uint32_t k = 0; k < 300; ++k) EXPECT_FLOAT_EQ(a.of("r", k), Points::uOf(k) + Points::vOf(k) * 2);
}

TEST(LanguageGroups, DerivativesPassConnections) {
  const Answer a = runEverywhere(
      network({{"a", kSource}, {"b", "shader sink(float x = 7, output float r = 0) { r = Dx(x * x); }"}},
              {{"a", "f", "b", "x"}}));
  for (uint32_t k = 0; k < 300; ++k) EXPECT_FLOAT_EQ(a.of("r", k), 2 * (Points::uOf(k) * 2) * (2 * Points::kStep));
}

TEST(LanguageGroups, LayersRunOnceAndOnlyWhereNeeded) {
  const char* talking = "shader source(output float f = 0) { printf(\"ran\"); f = u; }";
  // twice used: once run
  const auto twice = network({{"a", talking},
                              {"b", "shader mid(float x = 0, output float f = 0) { f = x * 2; }"},
                              {"c", "shader sink(float x = 0, float y = 0, output float r = 0) { r = x + y; }"}},
                             {{"a", "f", "b", "x"}, {"a", "f", "c", "x"}, {"b", "f", "c", "y"}});
  EXPECT_EQ(runEverywhere(twice).messages.size(), 300u);
  // needed by some points only
  const Answer some = runEverywhere(
      network({{"a", talking}, {"b", "shader sink(float x = 0, output float r = 0) { r = 1; if (v > 0.5) r = x; }"}},
              {{"a", "f", "b", "x"}}));
  size_t wanted = 0;
  for (uint32_t k = 0; k < 300; ++k) {
    const bool needs = Points::vOf(k) > 0.5f;
    wanted += needs;
    EXPECT_EQ(some.of("r", k), needs ? Points::uOf(k) : 1.f);
  }
  EXPECT_EQ(some.messages.size(), wanted);
  // by nobody
  EXPECT_TRUE(
      runEverywhere(network({{"a", talking}, {"b", "shader sink(float x = 0, output float r = 0) { r = 1; }"}},
                            {{"a", "f", "b", "x"}}))
          .messages.empty());
}

TEST(LanguageGroups, ExitEndsItsLayerAlone) {
  const Answer a = runEverywhere(
      network({{"a", "shader source(output float f = 3) { if (u > 0.5) { f = 4; exit(); } f = 5; }"},
               {"b", "shader sink(float x = 0, output float r = 0) { r = x; if (v > 0.5) return; r += 100; }"}},
              {{"a", "f", "b", "x"}}));
  for (uint32_t k = 0; k < 300; ++k)
    EXPECT_EQ(a.of("r", k), (Points::uOf(k) > 0.5f ? 4.f : 5.f) + (Points::vOf(k) > 0.5f ? 0.f : 100.f));
}

TEST(LanguageGroups, DefaultsSettingsAndConnectionsHaveTheirRanks) {
  const char* text = "shader test(float a = 2, float b = a * 3, output float r = 0) { r = a + b * 10; }";
  EXPECT_EQ(runEverywhere(network({{"a", text}}, {})).of("r", 0), 62.f);
  ShaderGroup set = network({{"a", text}}, {});
  set.layers[0].settings = {number("a", 5)};
  EXPECT_EQ(runEverywhere(set).of("r", 0), 155.f);
  set.layers[0].settings = {number("b", 1)};
  EXPECT_EQ(runEverywhere(set).of("r", 0), 12.f);
}

TEST(LanguageGroups, IsConnectedKnowsBothSides) {
  const Answer a = runEverywhere(network(
      {{"a", "shader source(output float f = 0, output float g = 0) { f = isconnected(f) * 10 + isconnected(g); }"},
       {"b", "shader sink(float x = 0, output float r = 0) { r = x * 10 + isconnected(x); }"}},
      {{"a", "f", "b", "x"}}));
  EXPECT_EQ(a.of("r", 0), 201.f);
}

TEST(LanguageGroups, WhatCannotBeConnectedIsSaid) {
  const char* sink =
      "shader sink(string s = \"\", float x[2] = {0, 0}, color c = 0, output float r = 0, float g = 0) { r = c[0] + "
      "x[0] + g; }";
  EXPECT_NE(errorOf(network({{"a", kSource}, {"b", sink}}, {{"a", "f", "b", "s"}}))
                .find("cannot connect a float (f) to a string (s)"),
            std::string::npos);
  EXPECT_NE(
      errorOf(network({{"a", kSource}, {"b", sink}}, {{"a", "f", "b", "nothing"}})).find("`nothing` is no parameter"),
      std::string::npos);
  EXPECT_NE(errorOf(network({{"a", kSource}, {"b", sink}}, {{"zzz", "f", "b", "s"}})).find("no layer is named `zzz`"),
            std::string::npos);
  EXPECT_NE(
      errorOf(network({{"a", kSource}, {"b", sink}}, {{"a", "c[5]", "b", "g"}})).find("`c[5]` is no part of a color"),
      std::string::npos);
  EXPECT_NE(errorOf(network({{"a", "shader s(float x = 0, output float f = 0) { f = x; }"},
                             {"b", "shader s(float x = 0, output float r = 0) { r = x; }"}},
                            {{"a", "f", "b", "x"}, {"b", "r", "a", "x"}}))
                .find("cyclic"),
            std::string::npos);
  EXPECT_NE(errorOf(network({{"a", kSource}}, {}, {"nothing"})).find("no output"), std::string::npos);
  ShaderGroup bad = network({{"a", kSource}}, {}, {"f"});
  Setting s;
  s.parameter = "gain";
  s.type = {Base::String, 0, -1};
  s.values.strings = {"x"};
  bad.layers[0].settings = {s};
  EXPECT_NE(errorOf(bad).find("is a float and was given a string"), std::string::npos);
}

TEST(LanguageGroups, InstancesThatDifferInNumbersShareAProgram) {
  ExecutableCache cache;
  std::string error;
  const auto source = shaderOf(kSource);
  const auto sink = shaderOf("shader sink(float x = 0, color tint = 1, output color r = 0) { r = x * tint; }");
  std::shared_ptr<const Executable> first;
  size_t bytes = 0;
  for (int i = 0; i < 1000; ++i) {
    ShaderGroup group;
    group.layers = {{source, "a", {number("gain", float(i))}}, {sink, "b", {number("tint", 0.5f)}}};
    group.connections = {{"a", "f", "b", "x"}};
    group.outputs = {"r"};
    const auto program = cache.get(group, {}, error);
    ASSERT_TRUE(program) << error;
    if (!first) first = program;
    EXPECT_EQ(program, first);
    const auto inputs = program->inputsOf(group);
    bytes = inputs.size() * 4;
    const Answer a = runOn(*program, group, Points(20));
    EXPECT_EQ(a.of("r.1", 7), Points::uOf(7) * float(i) * 0.5f);
  }
  EXPECT_EQ(cache.size(), 1u);
  EXPECT_LE(bytes, 2048u);
}

}  // namespace
}  // namespace kinora::language
