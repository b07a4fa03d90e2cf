// Some seconds of the fuzzer of IES profiles with a fixed seed: what crashes, or is read as something that no light
// can use, fails here. Memory errors that do not crash are for tests/fuzz/run.
#include <gtest/gtest.h>

#include <ctime>

#include "fuzz/ies_input.h"
#include "fuzz/ies_mutator.h"

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
  const std::clock_t end = std::clock() + 2 * CLOCKS_PER_SEC;
  size_t runs = 0, refused = 0;
  for (; runs < 20000 && std::clock() < end; ++runs) {
    std::string mutated = random.mutate(pool[random.below(pool.size())], pool[random.below(pool.size())], 8000);
    refused += readIesInput(mutated);
    if (runs % 8 == 0 && pool.size() < 300) pool.push_back(std::move(mutated));
  }
  EXPECT_GT(runs, 1000u);
  EXPECT_GT(refused, runs / 4) << "mutations that nothing is wrong with test nothing";
  EXPECT_LT(refused, runs * 39 / 40) << "mutations that are all refused reach the reader's first lines only";
}

}  // namespace
}  // namespace kinora::fuzz
