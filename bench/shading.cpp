// The family "shading": programs of the group machine against the same written by hand as fused SIMD C++, its gain by
// width, and what compiling costs. Machine and hand run in turn on the same points, in CPU time of one thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <vector>

#include "base/arena.h"
#include "language/front/compile.h"
#include "language/vm/executable.h"
#include "shading.h"
#include "shading_fused.h"
#include "shade/shader_textures.h"
#include "simd/dispatch.h"
#include "texture/texture_system.h"

namespace kinora::bench {
namespace {
using namespace kinora::language;

constexpr uint32_t kShadedPoints = 1024;

// A patch of a surface: neighbouring points, as groups of camera hits see it.
struct Patch {
  std::vector<float> arrays[17];
  GlobalValues globals;
  FusedArguments fused;
  Patch() {
    for (auto& a : arrays) a.assign(kShadedPoints, 0.f);
    for (uint32_t i = 0; i < kShadedPoints; ++i) {
      const float u = (float(i % 32) + 0.37f) / 32, v = (float(i / 32) + 0.61f) / 32;
      const float values[17] = {3 * u - 1, 2 * v,     std::sin(u * 2 + v),
                                3.f / 512, 0,         2 * std::cos(u * 2 + v) / 512,
                                0,         2.f / 512, std::cos(u * 2 + v) / 512,
                                u,         v,         1.f / 512,
                                0,         0,         1.f / 512};
      for (int k = 0; k < 15; ++k) arrays[k][i] = values[k];
    }
    using G = GlobalValues;
    fused.points = kShadedPoints;
    for (int c = 0; c < 3; ++c) {
      globals.of[G::P].v[c] = fused.P[c] = arrays[c].data();
      globals.of[G::P].dx[c] = fused.Pdx[c] = arrays[3 + c].data();
      globals.of[G::P].dy[c] = fused.Pdy[c] = arrays[6 + c].data();
    }
    globals.of[G::u].v[0] = fused.u = arrays[9].data();
    globals.of[G::v].v[0] = fused.v = arrays[10].data();
    globals.of[G::u].dx[0] = fused.udx = arrays[11].data();
    globals.of[G::u].dy[0] = fused.udy = arrays[12].data();
    globals.of[G::v].dx[0] = fused.vdx = arrays[13].data();
    globals.of[G::v].dy[0] = fused.vdy = arrays[14].data();
  }
};

ShaderGroup groupOf(const char* source) {
  ShaderGroup group;
  CompileResult result = compile(source, "bench.osl");
  for (const CompileMessage& m : result.messages) std::fprintf(stderr, "%s\n", m.str().c_str());
  if (!result.ok()) return group;
  group.layers.push_back({std::make_shared<Shader>(std::move(*result.shader)), "layer", {}});
  group.outputs = {"result"};
  return group;
}

// Lookups of one picture: the same for the machine's texture calls and for the program written by hand.
struct Pictures {
  Diagnostics diagnostics;
  TextureSystem system{diagnostics};
  Arena arena;
  shade::ShaderTextures calls{&system, nullptr, arena};
  std::string file;
  int32_t handle = TextureSystem::kNoTexture;
  explicit Pictures(int side) : file(makeTexture(side, false)) {
    if (!file.empty()) handle = system.handle(file, {});
  }
  ~Pictures() {
    if (!file.empty()) std::filesystem::remove(file);
  }
  // A program with the picture's name where it says bench.tx.
  std::string named(std::string source) const {
    const std::string said = "bench.tx";
    for (size_t at = 0; (at = source.find(said, at)) != std::string::npos; at += file.size())
      source.replace(at, said.size(), file);
    return source;
  }
  // With the options of a shader's call that names none but "wrap", "periodic".
  static void lookup(void* self, uint32_t n, const float* s, const float* t, const float* radius,
                     float* const rgba[4]) {
    Pictures& p = *static_cast<Pictures*>(self);
    TextureOptions options;
    options.wrapS = options.wrapT = 3;
    options.filter = 7;  // smart cubic
    p.system.lookup(&p.handle, false, n, s, t, radius, options, rgba);
  }
  static void call(void* self, const Batch& batch, const TextureCall& call) {
    static_cast<Pictures*>(self)->calls.texture(batch, call);
  }
};

struct Runner {
  const Patch& patch;
  std::shared_ptr<const Executable> program;
  std::vector<float> inputs, out[3];
  RunState state;
  float* pointers[3];
  OutputValues output;
  RunArguments run;
  RendererServices services;
  Runner(const Patch& p, const ShaderGroup& group, uint32_t width, Pictures& pictures) : patch(p) {
    services.self = &pictures;
    services.texture = &Pictures::call;
    run.services = &services;
    MachineOptions options;
    options.width = width;
    std::string error;
    program = compileGroup(group, options, error);
    if (!program) {
      std::fprintf(stderr, "kinora-bench: %s\n", error.c_str());
      return;
    }
    inputs = program->inputsOf(group);
    for (int c = 0; c < 3; ++c) {
      out[c].assign(kShadedPoints, 0.f);
      pointers[c] = out[c].data();
    }
    output.v = pointers;
    run.points = kShadedPoints;
    run.globals = &patch.globals;
    run.inputs = inputs.data();
    run.outputs = &output;
  }
  void operator()() { program->run(state, run); }
};

template <class F>
double secondsOf(F&& work, int times) {
  const double start = threadSeconds();
  for (int k = 0; k < times; ++k) work();
  return threadSeconds() - start;
}

}  // namespace

void measureShading(const Options& options, Figures& figures) {
  const Patch patch;
  Pictures pictures(options.quick ? 128 : 2048);
  uint32_t count = 0;
  const FusedProgram* programs = fusedPrograms(count);
  const uint32_t width = bestWidth();
  std::vector<double> all, gains;
  std::string covered;
  for (uint32_t k = 0; k < count; ++k) {
    const ShaderGroup group = groupOf(pictures.named(programs[k].source).c_str());
    if (group.layers.empty()) continue;
    Runner machine(patch, group, width, pictures), narrow(patch, group, 1, pictures);
    if (!machine.program || !narrow.program) continue;
    std::vector<float> out[3];
    FusedArguments hand = patch.fused;
    hand.lookup = &Pictures::lookup;
    hand.textures = &pictures;
    for (int c = 0; c < 3; ++c) {
      out[c].assign(kShadedPoints, 0.f);
      hand.result[c] = out[c].data();
    }
    const Fused fused = programs[k].widths[width == 16 ? 3 : 2];
    machine();
    fused(hand);
    if (options.spoil) out[1][kShadedPoints / 3] += 1.f;
    uint32_t differ = 0;
    for (uint32_t i = 0; i < kShadedPoints; ++i)
      for (int c = 0; c < 3; ++c) differ += std::memcmp(&out[c][i], &machine.out[c][i], 4) != 0;
    if (differ)
      figures.fail("BENCH-VALUES", std::string(programs[k].name) + ": " + std::to_string(differ) + " of " +
                                       std::to_string(3 * kShadedPoints) + " values differ from the fused program's");
    const double one = secondsOf([&] { fused(hand); }, 20) / 20;
    const int times = options.quick ? 2 : std::max(2, int(0.01 / one));
    std::vector<double> ratios, widths;
    for (int r = 0; r < options.repeat * 5; ++r) {
      const double a = secondsOf([&] { machine(); }, times), b = secondsOf([&] { fused(hand); }, times);
      ratios.push_back(a / b);
      if (r < options.repeat)
        widths.push_back(secondsOf([&] { narrow(); }, std::max(1, times / 8)) / std::max(1, times / 8) * times / a);
    }
    figures.add(std::string("vm_vs_fused_") + programs[k].name, ratios,
                "time of the machine over that of fused SIMD C++");
    figures.add(std::string("vm_width_gain_") + programs[k].name, widths,
                "time of the machine at width 1 over that at the best");
    if (std::string_view(programs[k].name) != "thin_loop") {
      covered += (covered.empty() ? "" : ", ") + std::string(programs[k].name);
      all.push_back(median(ratios));
      gains.push_back(median(widths));
    }
    std::printf("    %s: %zu instructions, %u slots, blocks of %u points, %.2f ns a point by hand\n",
                programs[k].name, machine.program->instructionCount(), machine.program->slotCount(),
                machine.program->blockPoints(), 1e9 * one / kShadedPoints);
  }
  figures.add("vm_vs_fused", all, "median of the medians, machine over fused SIMD C++, of " + covered);
  figures.add("vm_width_gain", gains, "median of the medians, width 1 over the best, of the same programs");

  // a shader of 200 lines, and a network of 100 nodes
  std::string lines = "shader lengthy(float a = 1, output color result = 0) {\n  float x = u;\n";
  for (int k = 0; k < 195; ++k) {
    char line[128];
    std::snprintf(line, sizeof line, "  x = %s(x * %d.5 + v) + noise(P * %d) * a;\n", k % 3 ? "sin" : "abs", k % 7,
                  k % 5 + 1);
    lines += line;
  }
  lines += "  result = x;\n}\n";
  std::vector<double> front, back, network;
  const CompileResult node = compile(
      "shader node(float a = 0.5, color b = 0, float c = 1, output color result = 0) { color n = noise(P * c); "
      "result = mix(b, n, a) * 0.9 + 0.05; }",
      "node.osl");
  const auto shader = std::make_shared<Shader>(*node.shader);
  for (int r = 0; r < options.repeat; ++r) {
    double start = threadSeconds();
    const ShaderGroup group = groupOf(lines.c_str());
    front.push_back(1e3 * (threadSeconds() - start));
    std::string error;
    start = threadSeconds();
    compileGroup(group, {}, error);
    back.push_back(front.back() + 1e3 * (threadSeconds() - start));
    ShaderGroup net;
    for (int k = 0; k < 100; ++k) {
      Setting s;
      s.parameter = "c";
      s.type = {Base::Float, 0, -1};
      s.values.floats = {float(k)};
      net.layers.push_back({shader, "n" + std::to_string(k), {s}});
      if (k > 0) net.connections.push_back({"n" + std::to_string(k - 1), "result", "n" + std::to_string(k), "b"});
    }
    net.outputs = {"result"};
    start = threadSeconds();
    if (!compileGroup(net, {}, error)) std::fprintf(stderr, "kinora-bench: %s\n", error.c_str());
    network.push_back(1e3 * (threadSeconds() - start));
  }
  figures.add("compile_front_ms_200_lines", front, "source of 200 lines to the intermediate form");
  figures.add("compile_ms_200_lines", back, "source of 200 lines to a program of the machine");
  figures.add("network_100_nodes_ms", network, "a network of 100 nodes to a program of the machine");
}

}  // namespace kinora::bench
