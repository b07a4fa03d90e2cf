// Mutations of IES profiles: files made by the format's rules and changed in a number, a count, a line. All choices
// come from the seed. Used by the fuzzer and its short test.
#pragma once
#include <string>
#include <vector>

#include "fuzz/choices.h"

namespace kinora::fuzz {

class IesMutator : public TokenChoices {
 public:
  using TokenChoices::TokenChoices;
  // One to four mutations of `input`; pieces may come from `other`. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  std::string profile();  // a file that nothing is wrong with, more often than not

 private:
  // numbers, words, and what stands between them
  static Tokens tokensOf(const std::string& text);
  std::string number();
  std::string word();
  void change(Tokens& t, const Tokens& other);
};

}  // namespace kinora::fuzz
