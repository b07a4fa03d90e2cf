// Structure-aware mutations of RIB: tokens, numbers, arrays, blocks, binary encodings, gzip, splices of two files.
// All choices come from the seed, so that a run can be repeated. Used by the fuzzer and its short test.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/choices.h"

namespace kinora::fuzz {

struct Token {
  enum class Kind : uint8_t { Space, Word, Number, String, Open, Close, Other };
  Kind kind;
  std::string text;
};
std::vector<Token> tokensOf(std::string_view text);
std::string textOf(const std::vector<Token>& tokens);

class RibMutator : public Choices {
 public:
  using Choices::Choices;
  // One to four mutations of `input`; `other` is the file that pieces are taken from. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);

 private:
  std::string mutateText(std::string text, const std::string& other, size_t limit);
  void mutateTokens(std::vector<Token>& t, const std::vector<Token>& other);
  void mutateRequests(std::vector<Token>& t, const std::vector<Token>& other);
  void mutateArray(std::vector<Token>& t);
  void encode(std::vector<Token>& t);
  void mutateBytes(std::string& s);
  std::string number();
  std::string string();
  std::string request();
  std::string value(char kind);
};

}  // namespace kinora::fuzz
