// Some seconds of the fuzzer of worlds with a fixed seed, over scenes of shapes, trim curves and solids.
#include <gtest/gtest.h>

#include "fuzz/rib_grammar.h"
#include "fuzz/rib_mutator.h"
#include "fuzz/short_run.h"
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
  const auto [runs, built] =
      shortRun(random, pool, {.seconds = 4, .bytes = 8000, .pool = 200}, [](const std::string& scene) {
        const bool isBuilt = buildWorldInput(scene) > 0;
        return Outcome{isBuilt, isBuilt};
      });
  EXPECT_GT(runs, 50u);
  EXPECT_GT(built, runs / 5) << "mutations that leave nothing to see test nothing";
}

}  // namespace
}  // namespace kinora::fuzz
