// Some seconds of the .oso fuzzer with a fixed seed: what crashes, is not read as it was written or differs between
// widths fails here. Proves nothing about memory errors that do not crash; tests/fuzz/run does.
#include <gtest/gtest.h>

#include <ctime>

#include "fuzz/oso_input.h"
#include "fuzz/oso_mutator.h"

namespace kinora::fuzz {
namespace {

TEST(OsoFuzz, SomeSecondsWithAFixedSeed) {
  OslMutator programs(7);
  std::vector<std::string> pool;
  while (pool.size() < 30)
    if (std::string oso = osoOf(programs.program()); oso.starts_with("OpenShadingLanguage"))
      pool.push_back(std::move(oso));
  OsoMutator random(1);
  const std::clock_t end = std::clock() + 3 * CLOCKS_PER_SEC;
  size_t runs = 0, read = 0;
  for (; runs < 4000 && std::clock() < end; ++runs) {
    const std::string& a = pool[random.below(pool.size())];
    std::string mutated = random.mutate(a, pool[random.below(pool.size())], 20000);
    const size_t wasRead = runOsoInput(mutated);
    read += wasRead;
    if (wasRead && runs % 8 == 0 && pool.size() < 200) pool.push_back(std::move(mutated));
  }
  EXPECT_GT(runs, 50u);
  EXPECT_GT(read, runs / 20) << "mutations that are all refused reach the reader's first lines only";
  EXPECT_LT(read, runs * 19 / 20);
}

}  // namespace
}  // namespace kinora::fuzz
