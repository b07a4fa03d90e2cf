// Structure-aware mutations of SeExpr expressions: names, operators, brackets, whole assignments. All choices come from
// the seed. Used by the fuzzer and its short test.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/choices.h"

namespace kinora::fuzz {

class SeExprMutator : public TokenChoices {
 public:
  using TokenChoices::TokenChoices;
  // One to four mutations of `input`; pieces may come from `other`. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  std::string program();  // made by the grammar: often a valid one

 private:
  static Tokens tokensOf(std::string_view text);
  std::string number();
  std::string name();
  std::string word();
  std::string expression(int depth);
  std::string call(int depth);
  std::string statement(int depth);
  void change(Tokens& t, const Tokens& other);
};

}  // namespace kinora::fuzz
