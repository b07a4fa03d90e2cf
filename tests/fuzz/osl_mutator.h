// Structure-aware mutations of OSL source: words, numbers, brackets, whole statements, pieces of other files. All
// choices come from the seed, so that a run can be repeated. Used by the fuzzer and its short test.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/choices.h"

namespace kinora::fuzz {

class OslMutator : public Choices {
 public:
  using Choices::Choices;
  // One to five mutations of `input`; `other` is the file that pieces are taken from. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  // A program made from nothing: often a valid one.
  std::string program();

 private:
  using Tokens = std::vector<std::string>;
  static Tokens tokensOf(std::string_view text);
  void change(Tokens& t, const Tokens& other);
  std::string word();
  std::string number();
  std::string expression(int depth);
  std::string statement(int depth);
};

}  // namespace kinora::fuzz
