// Structure-aware mutations of SeExpr expressions: names, operators, brackets, whole assignments. All choices come from
// the seed. Used by the fuzzer and its short test.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::fuzz {

class SeExprMutator {
 public:
  explicit SeExprMutator(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  // One to four mutations of `input`; pieces may come from `other`. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  std::string program();     // made by the grammar: often a valid one
  uint32_t below(size_t n);  // 0 for n = 0

 private:
  using Tokens = std::vector<std::string>;
  static Tokens tokensOf(std::string_view text);
  std::string number();
  std::string name();
  std::string word();
  std::string expression(int depth);
  std::string call(int depth);
  std::string statement(int depth);
  void change(Tokens& t, const Tokens& other);

  uint64_t state_;
};

}  // namespace kinora::fuzz
