// Some seconds of the .oso fuzzer with a fixed seed: what crashes, is not read as it was written or differs between
// widths fails here. Proves nothing about memory errors that do not crash; tests/fuzz/run does.
#include <gtest/gtest.h>

#include "fuzz/oso_input.h"
#include "fuzz/oso_mutator.h"
#include "fuzz/short_run.h"

namespace kinora::fuzz {
namespace {

TEST(OsoFuzz, SomeSecondsWithAFixedSeed) {
  OslMutator programs(7);
  std::vector<std::string> pool;
  while (pool.size() < 30)
    if (std::string oso = osoOf(programs.program()); oso.starts_with("OpenShadingLanguage"))
      pool.push_back(std::move(oso));
  OsoMutator random(1);
  const auto [runs, read] = shortRun(random, pool, {.pool = 200}, [](const std::string& oso) {
    const size_t wasRead = runOsoInput(oso);
    return Outcome{wasRead, wasRead > 0};
  });
  EXPECT_GT(runs, 50u);
  EXPECT_GT(read, runs / 20) << "mutations that are all refused reach the reader's first lines only";
  EXPECT_LT(read, runs * 19 / 20);
}

}  // namespace
}  // namespace kinora::fuzz
