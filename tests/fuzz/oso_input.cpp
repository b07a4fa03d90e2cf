#include "fuzz/oso_input.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "language/front/compile.h"
#include "language/program/oso_reader.h"
#include "language/program/oso_writer.h"
#include "language/vm/executable.h"

namespace kinora::fuzz {

namespace {

using namespace kinora::language;

constexpr uint32_t kPoints = 21, kPadded = 32;
constexpr size_t kMostRead = 1 << 18;     // bytes of .oso that are read again
constexpr size_t kMostNumbers = 1 << 16;  // of outputs that are compared

[[noreturn]] void fail(const char* what, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n", what, why.c_str());
  std::abort();
}

// Curved points with derivatives: no two are alike.
struct SomePoints {
  float numbers[12][kPadded];
  GlobalValues globals;
  SomePoints() {
    for (uint32_t i = 0; i < kPadded; ++i) {
      const float u = float(i % 7) / 7, v = float(i / 7) / 5;
      const float all[12] = {u, v, 3 * u - 1, 2 * v, u * v, 0.01f, 0.02f, -v, u, 1, 0.5f, 1e20f * u};
      for (int k = 0; k < 12; ++k) numbers[k][i] = all[k];
    }
    using G = GlobalValues;
    const auto triple = [&](G::Name name, int first) {
      for (int c = 0; c < 3; ++c) globals.of[name].v[c] = numbers[(first + c) % 12];
      for (int c = 0; c < 3; ++c) globals.of[name].dx[c] = numbers[5 + c], globals.of[name].dy[c] = numbers[6 + c];
    };
    triple(G::P, 2), triple(G::N, 7), triple(G::Ng, 8), triple(G::I, 4), triple(G::dPdu, 1), triple(G::dPdv, 9);
    globals.of[G::u].v[0] = numbers[0], globals.of[G::v].v[0] = numbers[1];
    globals.of[G::u].dx[0] = globals.of[G::v].dy[0] = numbers[5];
    globals.of[G::time].v[0] = numbers[10];
  }
};

void forget(void*, MessageKind, const char*, uint32_t, const char*) {}

std::vector<float> outputsOf(const Executable& program, const ShaderGroup& group) {
  static const SomePoints points;
  RunState state;
  RendererServices services;
  services.message = &forget;
  RunArguments run;
  run.points = kPoints;
  run.globals = &points.globals;
  const std::vector<float> inputs = program.inputsOf(group);
  run.inputs = inputs.data();
  run.services = &services;
  size_t count = 0;
  std::vector<std::vector<float*>> cells;
  for (const Output& o : program.outputs())
    count += size_t(componentsOf(o.type.base)) * size_t(std::max(1, o.type.arrayLength));
  if (count * kPadded > kMostNumbers) return {};
  std::vector<float> numbers(count * kPadded, 0.f);
  float* next = numbers.data();
  std::vector<OutputValues> outputs;
  for (const Output& o : program.outputs()) {
    std::vector<float*>& mine = cells.emplace_back();
    for (int n = componentsOf(o.type.base) * std::max(1, o.type.arrayLength); n > 0; --n, next += kPadded)
      mine.push_back(next);
  }
  for (auto& mine : cells) outputs.push_back({mine.data()});
  run.outputs = outputs.data();
  program.run(state, run);
  return numbers;
}

}  // namespace

std::string osoOf(std::string_view bytes) {
  if (bytes.starts_with("OpenShadingLanguage")) return std::string(bytes);
  const CompileResult result = compile(bytes, "main.osl");
  return result.ok() ? osoText(*result.shader) : std::string(bytes);
}

size_t runOsoInput(std::string_view bytes) {
  const std::string text = osoOf(bytes);
  const auto shader = std::make_shared<Shader>();
  std::string error;
  if (!readOso(text, "main.oso", *shader, error)) {
    if (error.empty()) fail("refused without a message", text);
    return 0;
  }
  if (const std::string why = invalid(*shader); !why.empty()) fail("read what is invalid", why);
  toText(*shader);
  const std::string written = osoText(*shader);
  if (written.size() <= kMostRead) {
    Shader again;
    if (!readOso(written, "again.oso", again, error)) fail("wrote what is not read", error + "\n" + written);
    if (osoText(again) != written) fail("written, read and written again is something else", written);
  }
  ShaderGroup group;
  group.layers.push_back({shader, "layer", {}});
  for (const Symbol& s : shader->symbols)
    if (s.kind == SymbolKind::OutputParam && componentsOf(s.type.base) > 0) group.outputs.push_back(s.name);
  std::vector<float> first;
  for (const uint32_t width : {1u, 8u}) {
    MachineOptions options;
    options.width = width;
    options.iterationLimit = 6;
    options.optimise = text.size() % 4 != 0;
    error.clear();
    const auto program = compileGroup(group, options, error);
    if (!program) {
      if (error.empty()) fail("not run, without a message", text);
      return 1;
    }
    program->listing();
    std::vector<float> numbers = outputsOf(*program, group);
    if (width == 1) {
      first = std::move(numbers);
      continue;
    }
    for (size_t i = 0; i < first.size(); ++i)
      if (i % kPadded < kPoints && std::memcmp(&first[i], &numbers[i], 4) != 0 &&
          !(std::isnan(first[i]) && std::isnan(numbers[i])))
        fail("widths 1 and 8 differ", std::to_string(first[i]) + " and " + std::to_string(numbers[i]) + ", number " +
                                          std::to_string(i) + "\n" + written);
  }
  return 1;
}

}  // namespace kinora::fuzz
