// Some seconds of the fuzzer of expressions with a fixed seed: a crash, a translation that does not compile and widths
// that differ fail here. Memory errors that do not crash are for tests/fuzz/run.
#include <gtest/gtest.h>

#include <ctime>

#include "fuzz/seexpr_input.h"
#include "fuzz/seexpr_mutator.h"

namespace kinora::fuzz {
namespace {

TEST(SeExprFuzz, SomeSecondsWithAFixedSeed) {
  SeExprMutator random(1);
  std::vector<std::string> pool = {"fbm(P * 2)", "$a = P[0]; if (a > .5) { a = 2; } a",
                                   "ccurve(u, 0, [1,0,0], 4, 1, [0,0,1], 4) -> saturate(.5)"};
  for (int i = 0; i < 40; ++i) pool.push_back(random.program());
  const std::clock_t end = std::clock() + 3 * CLOCKS_PER_SEC;
  size_t runs = 0, refused = 0;
  for (; runs < 4000 && std::clock() < end; ++runs) {
    std::string mutated = random.mutate(pool[random.below(pool.size())], pool[random.below(pool.size())], 4000);
    const size_t wasRefused = runSeExprInput(mutated);
    refused += wasRefused;
    if (!wasRefused && runs % 4 == 0 && pool.size() < 200) pool.push_back(std::move(mutated));
  }
  EXPECT_GT(runs, 50u);
  EXPECT_GT(refused, runs / 20) << "mutations that nothing is wrong with test nothing";
  EXPECT_LT(refused, runs * 19 / 20) << "mutations that are all refused reach the parser's first words only";
}

}  // namespace
}  // namespace kinora::fuzz
