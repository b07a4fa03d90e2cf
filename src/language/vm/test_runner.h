// For tests: runs a program given as .oso text at every width and at several numbers of points, and checks that all
// give the same bits.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "language/front/compile.h"
#include "language/program/oso_reader.h"
#include "language/vm/executable.h"
#include "simd/dispatch.h"

namespace kinora::language::testing {

// Points of a curved patch: u, v, P and what follows, with derivatives. The same for the first n points whatever n
// is.
struct Points {
  uint32_t count, padded;
  std::map<std::string, std::vector<float>> arrays;
  GlobalValues globals;
  const float* add(const std::string& name, float (*f)(float u, float v)) {
    std::vector<float>& a = arrays[name];
    a.resize(padded);
    for (uint32_t i = 0; i < padded; ++i) a[i] = f(uOf(i), vOf(i));
    return a.data();
  }
  static float uOf(uint32_t i) { return float(i % 17) / 17.f + 0.01f; }
  static float vOf(uint32_t i) { return float(i % 29) / 29.f + 0.003f; }
  static constexpr float kStep = 1.f / 256;  // derivatives: u along x, v along y
  explicit Points(uint32_t n, float shiftU = 0, float shiftV = 0) : count(n), padded((n + 15) / 16 * 16) {
    static float su, sv;
    su = shiftU, sv = shiftV;
    using G = GlobalValues;
    globals.of[G::u].v[0] = add("u", [](float u, float) { return u + su; });
    globals.of[G::u].dx[0] = add("udx", [](float, float) { return kStep; });
    globals.of[G::v].v[0] = add("v", [](float, float v) { return v + sv; });
    globals.of[G::v].dy[0] = add("vdy", [](float, float) { return kStep; });
    globals.of[G::P].v[0] = add("Px", [](float u, float) { return 3 * (u + su) - 1; });
    globals.of[G::P].dx[0] = add("Pxdx", [](float, float) { return 3 * kStep; });
    globals.of[G::P].v[1] = add("Py", [](float, float v) { return 2 * (v + sv); });
    globals.of[G::P].dy[1] = add("Pydy", [](float, float) { return 2 * kStep; });
    globals.of[G::P].v[2] = add("Pz", [](float u, float v) { return (u + su) * (v + sv); });
    globals.of[G::P].dx[2] = add("Pzdx", [](float, float v) { return (v + sv) * kStep; });
    globals.of[G::P].dy[2] = add("Pzdy", [](float u, float) { return (u + su) * kStep; });
    globals.of[G::N].v[0] = add("Nx", [](float u, float) { return std::sin(u); });
    globals.of[G::N].v[2] = add("Nz", [](float u, float) { return std::cos(u); });
    globals.of[G::time].v[0] = add("time", [](float, float) { return 0.25f; });
  }
};

struct Answer {
  std::map<std::string, std::vector<float>> values;  // "name" or "name.0"
  std::vector<std::string> messages;
  float of(const std::string& name, uint32_t i) const { return values.at(name)[i]; }
  int32_t intOf(const std::string& name, uint32_t i) const {
    int32_t x;
    std::memcpy(&x, &values.at(name)[i], 4);
    return x;
  }
};

inline void keepMessage(void* self, MessageKind, const char* text, uint32_t length, const char*) {
  static_cast<std::vector<std::string>*>(self)->emplace_back(text, length);
}

inline Answer runOn(const Executable& program, const ShaderGroup& group, const Points& points) {
  Answer answer;
  RunState state;
  RendererServices services;
  services.self = &answer.messages;
  services.message = &keepMessage;
  RunArguments run;
  run.points = points.count;
  run.globals = &points.globals;
  const std::vector<float> inputs = program.inputsOf(group);
  run.inputs = inputs.data();
  run.services = &services;
  std::vector<OutputValues> outputs;
  std::vector<std::vector<float*>> pointers;
  for (const Output& o : program.outputs()) {
    const int n = componentsOf(o.type.base) * std::max(1, o.type.arrayLength);
    std::vector<float*> ps;
    for (int c = 0; c < n; ++c) {
      std::vector<float>& v = answer.values[n == 1 ? o.name : o.name + "." + std::to_string(c)];
      v.assign(points.padded + 16, -99.f);
      ps.push_back(v.data());
    }
    pointers.push_back(std::move(ps));
  }
  for (const auto& p : pointers) outputs.push_back({p.data()});
  run.outputs = outputs.data();
  program.run(state, run);
  for (auto& [name, v] : answer.values) v.resize(points.count);
  return answer;
}

// From .osl or .oso text.
inline std::shared_ptr<const Shader> shaderOf(const std::string& text) {
  auto shader = std::make_shared<Shader>();
  if (text.starts_with("OpenShadingLanguage")) {
    std::string error;
    EXPECT_TRUE(readOso(text, "test.oso", *shader, error)) << error;
    return shader;
  }
  CompileResult result = compile(text, "test.osl");
  for (const CompileMessage& m : result.messages)
    if (!result.ok()) ADD_FAILURE() << m.str();
  if (result.ok()) *shader = std::move(*result.shader);
  return shader;
}
inline ShaderGroup groupOf(const std::string& text, std::vector<std::string> outputs) {
  ShaderGroup group;
  group.layers.push_back({shaderOf(text), "layer", {}});
  group.outputs = std::move(outputs);
  return group;
}

// 300 points; every width, block and number of points must agree with width 1, optimised or not.
inline Answer runEverywhere(const ShaderGroup& group, float shiftU = 0, float shiftV = 0) {
  Answer reference;
  bool isFirst = true;
  for (const bool optimised : {false, true})
    for (const uint32_t width : {1u, 4u, 8u, 16u}) {
      if (width == 16 && !cpuHasAvx512()) continue;
      for (const uint32_t block : {0u, 64u}) {
        MachineOptions options;
        options.width = width;
        options.blockPoints = block;
        options.optimise = optimised;
        std::string error;
        const auto program = compileGroup(group, options, error);
        EXPECT_TRUE(program) << error;
        if (!program) return reference;
        for (const uint32_t n : {300u, 1u, 7u, 64u}) {
          Answer got = runOn(*program, group, Points(n, shiftU, shiftV));
          if (isFirst) {
            reference = std::move(got);
            isFirst = false;
            continue;
          }
          for (const auto& [name, values] : got.values)
            for (uint32_t i = 0; i < n; ++i) {
              if (std::memcmp(&values[i], &reference.values.at(name)[i], 4) != 0) {
                ADD_FAILURE() << name << " of point " << i << " of " << n << " at width " << width << " block "
                              << block << " optimised " << optimised << ": " << values[i] << " instead of "
                              << reference.values.at(name)[i] << "\n"
                              << program->listing();
                return reference;
              }
            }
          if (n == 300) {
            EXPECT_EQ(got.messages, reference.messages) << "width " << width << " optimised " << optimised;
          }
        }
      }
    }
  return reference;
}

}  // namespace kinora::language::testing
