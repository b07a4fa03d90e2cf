// Structure-aware mutations of .oso text: lines, words of a line, names of symbols, jump targets, hints, numbers,
// operations. All choices come from the seed. Used by the fuzzer and its short test.
#pragma once
#include <string>

#include "fuzz/osl_mutator.h"

namespace kinora::fuzz {

class OsoMutator {
 public:
  explicit OsoMutator(uint64_t seed) : random_(seed) {}
  // One to four mutations of `input` (OSL source becomes .oso first); lines may come from `other`. At most `limit`
  // bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  uint32_t below(size_t n) { return random_.below(n); }

 private:
  using Lines = std::vector<std::vector<std::string>>;  // a line is its words with the blanks between them
  static Lines linesOf(const std::string& text);
  void change(Lines& lines, const Lines& other);
  std::string word(const Lines& lines);

  OslMutator random_;
};

}  // namespace kinora::fuzz
