// Mutations of IES profiles: files made by the format's rules and changed in a number, a count, a line. All choices
// come from the seed. Used by the fuzzer and its short test.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace kinora::fuzz {

class IesMutator {
 public:
  explicit IesMutator(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  // One to four mutations of `input`; pieces may come from `other`. At most `limit` bytes.
  std::string mutate(const std::string& input, const std::string& other, size_t limit);
  std::string profile();     // a file that nothing is wrong with, more often than not
  uint32_t below(size_t n);  // 0 for n = 0

 private:
  using Tokens = std::vector<std::string>;  // numbers, words, and what stands between them
  static Tokens tokensOf(const std::string& text);
  std::string number();
  std::string word();
  void change(Tokens& t, const Tokens& other);

  uint64_t state_;
};

}  // namespace kinora::fuzz
