// Some seconds of the fuzzer of worlds with a fixed seed, over scenes of shapes, trim curves and solids.
#include <gtest/gtest.h>

#include <ctime>

#include "fuzz/rib_grammar.h"
#include "fuzz/rib_mutator.h"
#include "fuzz/world_input.h"

namespace kinora::fuzz {
namespace {

std::string worldOf(const std::string& body) { return "WorldBegin\n" + body + "\nWorldEnd\n"; }

TEST(WorldFuzz, EachPieceOfTheGrammarIsThereToBeTraced) {
  for (const char* piece : kPieces) EXPECT_GT(buildWorldInput(worldOf(piece)), 0u) << piece;
}

TEST(WorldFuzz, SomeSecondsWithAFixedSeed) {
  std::vector<std::string> pool;
  for (const char* piece : kPieces) pool.push_back(worldOf(piece));
  RibMutator random(1);
  const std::clock_t end = std::clock() + 4 * CLOCKS_PER_SEC;
  size_t runs = 0, built = 0;
  for (; runs < 4000 && std::clock() < end; ++runs) {
    std::string mutated = random.mutate(pool[random.below(pool.size())], pool[random.below(pool.size())], 8000);
    const bool isBuilt = buildWorldInput(mutated) > 0;
    built += isBuilt;
    if (isBuilt && runs % 8 == 0 && pool.size() < 200) pool.push_back(std::move(mutated));
  }
  EXPECT_GT(runs, 50u);
  EXPECT_GT(built, runs / 5) << "mutations that leave nothing to see test nothing";
}

}  // namespace
}  // namespace kinora::fuzz
