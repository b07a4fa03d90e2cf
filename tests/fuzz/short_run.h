// The loop of the short tests: mutations of a pool of inputs, some of which join it, for a number of seconds of CPU
// time. What a mutation must not do (crash, above all) is the reader's to find; the counts tell whether mutations reach
// anything.
#pragma once
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace kinora::fuzz {

struct ShortRunLimits {
  int seconds = 3;
  size_t runs = 4000, bytes = 20000, pool = 300;
};
struct Outcome {
  size_t count;       // of what the test counts: messages, refusals, what was built
  bool joins = true;  // whether the mutation is worth mutating again
};
struct ShortRun {
  size_t runs = 0, count = 0;
};

// read(text) gives an Outcome.
template <class Mutator, class Read>
ShortRun shortRun(Mutator& random, std::vector<std::string> pool, const ShortRunLimits& limits, Read&& read) {
  ShortRun total;
  const std::clock_t end = std::clock() + limits.seconds * CLOCKS_PER_SEC;
  for (; total.runs < limits.runs && std::clock() < end; ++total.runs) {
    const std::string& a = pool[random.below(pool.size())];
    const std::string& b = pool[random.below(pool.size())];
    std::string mutated = random.mutate(a, b, limits.bytes);
    const Outcome outcome = read(mutated);
    total.count += outcome.count;
    if (outcome.joins && total.runs % 8 == 0 && pool.size() < limits.pool) pool.push_back(std::move(mutated));
  }
  return total;
}

}  // namespace kinora::fuzz
