// Structure-aware mutations of OSL source: words, numbers, brackets, whole statements, pieces of other files. All
// choices come from the seed, so that a run can be repeated. Used by the fuzzer and its short test.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::fuzz {

class OslMutator {
 public:
  explicit OslMutator(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  // One to five mutations of `input`; `other` is the file that pieces are taken from. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  // A program made from nothing: often a valid one.
  std::string program();
  uint32_t below(size_t n);  // 0 for n = 0

 private:
  using Tokens = std::vector<std::string>;
  static Tokens tokensOf(std::string_view text);
  void change(Tokens& t, const Tokens& other);
  std::string word();
  std::string number();
  std::string expression(int depth);
  std::string statement(int depth);

  uint64_t state_;
};

}  // namespace kinora::fuzz
