// Some seconds of the fuzzer of IES profiles with a fixed seed: what crashes, or is read as something that no light
// can use, fails here. Memory errors that do not crash are for tests/fuzz/run.
#include <gtest/gtest.h>

#include "fuzz/ies_input.h"
#include "fuzz/ies_mutator.h"
#include "fuzz/short_run.h"

namespace kinora::fuzz {
namespace {

TEST(IesFuzz, SomeSecondsWithAFixedSeed) {
  IesMutator random(1);
  std::vector<std::string> pool;
  size_t whole = 0;
  for (int i = 0; i < 60; ++i) {
    pool.push_back(random.profile());
    whole += readIesInput(pool.back()) == 0;
  }
  EXPECT_GT(whole, 30u) << "files by the rules are mostly read";
  const auto [runs, refused] = shortRun(random, pool, {.seconds = 2, .runs = 20000, .bytes = 8000},
                                        [](const std::string& profile) { return Outcome{readIesInput(profile)}; });
  EXPECT_GT(runs, 1000u);
  EXPECT_GT(refused, runs / 4) << "mutations that nothing is wrong with test nothing";
  EXPECT_LT(refused, runs * 39 / 40) << "mutations that are all refused reach the reader's first lines only";
}

}  // namespace
}  // namespace kinora::fuzz
