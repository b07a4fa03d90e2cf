// Some seconds of the front end's fuzzer with a fixed seed: what crashes, compiles to an invalid program or does not
// survive being written and read fails here. Proves nothing about memory errors that do not crash; tests/fuzz/run
// does.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/osl_input.h"
#include "fuzz/osl_mutator.h"
#include "fuzz/short_run.h"

namespace kinora::fuzz {
namespace {

TEST(OslFuzz, SomeSecondsWithAFixedSeed) {
  std::vector<std::string> pool;
  for (const auto& e : std::filesystem::recursive_directory_iterator(KINORA_SOURCE_DIR "/tests/language/refused")) {
    std::ifstream in(e.path(), std::ios::binary);
    pool.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  std::sort(pool.begin(), pool.end());
  OslMutator random(1);
  for (int i = 0; i < 40; ++i) pool.push_back(random.program());
  const auto [runs, messages] =
      shortRun(random, pool, {}, [](const std::string& source) { return Outcome{compileOslInput(source)}; });
  EXPECT_GT(runs, 50u);
  EXPECT_GT(messages, runs / 2) << "mutations that nothing is wrong with test nothing";
}

TEST(OslFuzz, FilesOfAnInputAreIncluded) {
  EXPECT_EQ(compileOslInput("#include \"a.h\"\nshader t() { f(); }\n##file a.h\nvoid f() { }\n"), 0u);
  EXPECT_GT(compileOslInput("#include \"b.h\"\nshader t() { f(); }\n##file a.h\nvoid f() { }\n"), 0u);
}

}  // namespace
}  // namespace kinora::fuzz
