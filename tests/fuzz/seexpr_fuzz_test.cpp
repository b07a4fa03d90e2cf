// Some seconds of the fuzzer of expressions with a fixed seed: a crash, a translation that does not compile and widths
// that differ fail here. Memory errors that do not crash are for tests/fuzz/run.
#include <gtest/gtest.h>

#include "fuzz/seexpr_input.h"
#include "fuzz/seexpr_mutator.h"
#include "fuzz/short_run.h"

namespace kinora::fuzz {
namespace {

TEST(SeExprFuzz, SomeSecondsWithAFixedSeed) {
  SeExprMutator random(1);
  std::vector<std::string> pool = {"fbm(P * 2)", "$a = P[0]; if (a > .5) { a = 2; } a",
                                   "ccurve(u, 0, [1,0,0], 4, 1, [0,0,1], 4) -> saturate(.5)"};
  for (int i = 0; i < 40; ++i) pool.push_back(random.program());
  const auto [runs, refused] =
      shortRun(random, pool, {.bytes = 4000, .pool = 200}, [](const std::string& expression) {
        const size_t wasRefused = runSeExprInput(expression);
        return Outcome{wasRefused, wasRefused == 0};
      });
  EXPECT_GT(runs, 50u);
  EXPECT_GT(refused, runs / 20) << "mutations that nothing is wrong with test nothing";
  EXPECT_LT(refused, runs * 19 / 20) << "mutations that are all refused reach the parser's first words only";
}

}  // namespace
}  // namespace kinora::fuzz
