// Random valid programs: the group machine, at three widths, optimised or not, against the slow interpreter. Programs
// whose answer moves when every function's result is disturbed by a few units of the last place, up or down, decide
// nothing and are left out. KINORA_PROGRAMS: how many programs (400); KINORA_SEED: the first one's seed.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "fuzz/osl_mutator.h"
#include "language/interpreter.h"
#include "language/vm/test_runner.h"
#include "language/width16/kernels.h"

namespace kinora::oracle {
namespace {

constexpr uint32_t kPoints = 40;

// The interpreter's globals of one of the machine's points.
std::map<std::string, Cells> globalsOf(const language::testing::Points& points, uint32_t i) {
  using G = language::GlobalValues;
  std::map<std::string, Cells> all;
  for (const auto& [name, id, n] : {std::tuple<const char*, G::Name, size_t>{"u", G::u, 1},
                                    {"v", G::v, 1},
                                    {"P", G::P, 3},
                                    {"N", G::N, 3},
                                    {"time", G::time, 1}}) {
    Cells c;
    const auto at = [&](const float* p) { return p ? double(p[i]) : 0.0; };
    const G::Values& g = points.globals.of[id];
    for (size_t k = 0; k < n; ++k) c.numbers.push_back({at(g.v[k]), at(g.dx[k]), at(g.dy[k])});
    all.emplace(name, c);
  }
  return all;
}

bool isNear(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b)) || std::fabs(a - b) <= 2e-3 * (1 + std::fabs(a) + std::fabs(b));
}

uint64_t setting(const char* name, uint64_t otherwise) {
  const char* s = std::getenv(name);
  return s ? std::strtoull(s, nullptr, 10) : otherwise;
}

TEST(RandomPrograms, TheMachineAgreesWithTheInterpreter) {
  const uint64_t count = setting("KINORA_PROGRAMS", 400), first = setting("KINORA_SEED", 1);
  size_t compared = 0, unclear = 0;
  for (uint64_t seed = first; seed < first + count && !HasFailure(); ++seed) {
    fuzz::OslMutator random(seed);
    const std::string source = random.program();
    language::CompileResult result = language::compile(source, "random.osl");
    if (!result.ok()) continue;
    const auto shader = std::make_shared<const language::Shader>(std::move(*result.shader));
    const language::testing::Points points(kPoints);
    std::vector<std::vector<double>> expected(kPoints), more(kPoints), less(kPoints);
    std::string gaveUp;
    for (uint32_t i = 0; i < kPoints && gaveUp.empty(); ++i)
      for (auto* answers : {&expected, &more, &less}) {
        Interpreter oracle(*shader);
        oracle.instructionLimit = 20000;
        oracle.disturbance = answers == &more ? 5e-6 : answers == &less ? -5e-6 : 0;
        oracle.given = globalsOf(points, i);
        gaveUp = oracle.run();
        for (const Dual& d : oracle.of("r").numbers) (*answers)[i].push_back(d.v);
        if (!gaveUp.empty()) break;
      }
    if (!gaveUp.empty()) continue;
    language::ShaderGroup group;
    group.layers.push_back({shader, "layer", {}});
    group.outputs = {"r"};
    for (const bool optimised : {false, true})
      for (const uint32_t width : {1u, 8u, 16u}) {
        if (width == 16 && optimised) continue;
        language::MachineOptions options = optionsOfWidth(width);
        options.optimise = optimised;
        std::string error;
        const auto program = language::compileGroup(group, options, error);
        ASSERT_TRUE(program) << error << source;
        const language::testing::Answer got = language::testing::runOn(*program, group, points);
        for (uint32_t i = 0; i < kPoints; ++i)
          for (size_t k = 0; k < 3; ++k) {
            const double e = expected[i][k];
            if (!isNear(e, more[i][k]) || !isNear(e, less[i][k]) || std::fabs(e) > 1e6) {
              ++unclear;
              continue;
            }
            ++compared;
            if (isNear(e, got.of("r." + std::to_string(k), i))) continue;
            FAIL() << "seed " << seed << " width " << width << " optimised " << optimised << " point " << i
                   << " component " << k << ": " << got.of("r." + std::to_string(k), i) << " instead of " << e << "\n"
                   << source << program->listing();
          }
      }
  }
  if (count >= 400) {
    EXPECT_GT(compared, 10000u);
    EXPECT_LT(unclear, compared / 5);
  }
}

}  // namespace
}  // namespace kinora::oracle
