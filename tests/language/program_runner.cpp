#include "language/program_runner.h"

#include "language/vm/strings.h"

namespace kinora::oracle {

using namespace language;
using language::testing::Points;

Ran runOnce(const Executable& program, const ShaderGroup& group, const Points& points, float shiftU, float shiftV) {
  Ran ran;
  RunState state;
  MockRenderer mock;
  mock.shiftU = shiftU;
  mock.shiftV = shiftV;
  const RendererServices services = mock.services();
  RunArguments run;
  run.points = points.count;
  run.globals = &points.globals;
  run.services = &services;
  const std::vector<float> inputs = program.inputsOf(group);
  run.inputs = inputs.data();
  // every point gets the default
  std::vector<std::vector<float>> arrays;
  std::vector<std::vector<const float*>> pointers;
  std::vector<VaryingInput> varying;
  for (const Input& input : program.inputs()) {
    if (!input.isVarying) continue;
    const Shader& shader = *group.layers[size_t(input.layer)].shader;
    const Values& values = shader.symbols[size_t(shader.find(input.parameter))].values;
    const size_t n = size_t(componentsOf(input.type.base)) * size_t(std::max(1, input.type.arrayLength));
    pointers.emplace_back();
    for (size_t c = 0; c < n; ++c) {
      float x = 0;
      if (input.type.base == Base::Int || input.type.base == Base::String) {
        const int32_t bits = input.type.base == Base::Int ? (c < values.ints.size() ? values.ints[c] : 0)
                             : c < values.strings.size()  ? internString(values.strings[c])
                                                          : 0;
        std::memcpy(&x, &bits, 4);
      } else if (c < values.floats.size()) {
        x = values.floats[c];
      }
      arrays.emplace_back(points.padded, x);
      pointers.back().push_back(nullptr);
    }
  }
  size_t at = 0;
  for (auto& list : pointers) {
    for (const float*& p : list) p = arrays[at++].data();
    varying.push_back({list.data(), nullptr, nullptr});
  }
  run.varyingInputs = varying.data();
  std::vector<std::vector<float*>> outputs;
  for (const Output& o : program.outputs()) {
    const int n = componentsOf(o.type.base) * std::max(1, o.type.arrayLength);
    outputs.emplace_back();
    for (int c = 0; c < n; ++c) {
      std::vector<float>& v = ran.values[n == 1 ? o.name : o.name + "." + std::to_string(c)];
      v.assign(points.padded + 16, -99.f);
      outputs.back().push_back(v.data());
    }
  }
  std::vector<OutputValues> outputValues;
  for (const auto& o : outputs) outputValues.push_back({o.data()});
  run.outputs = outputValues.data();
  program.run(state, run);
  for (auto& [name, v] : ran.values) v.resize(points.count);
  ran.messages = std::move(mock.messages);
  return ran;
}

}  // namespace kinora::oracle
