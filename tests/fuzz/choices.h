// What the mutators share: choices that all follow from one seed, so that a run can be repeated, and text put together
// again within a limit.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kinora::fuzz {

class Choices {
 public:
  explicit Choices(uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
  // A number below n; 0 for n = 0.
  uint32_t below(size_t n) {
    state_ += 0x9E3779B97F4A7C15u;  // splitmix64 (Vigna)
    uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    z ^= z >> 31;
    return n ? uint32_t(z % n) : 0;
  }

 private:
  uint64_t state_;
};

// Mutators of texts that are lists of tokens.
class TokenChoices : public Choices {
 public:
  using Choices::Choices;

 protected:
  using Tokens = std::vector<std::string>;
  static constexpr uint32_t kRearrangements = 4;
  // Of a list that is not empty: a token taken away, put in again (`mostRepeats` times at most), exchanged with another,
  // or replaced by one of `other`.
  void rearrange(uint32_t which, Tokens& t, const Tokens& other, size_t mostRepeats) {
    const auto at = [&] { return t.begin() + std::ptrdiff_t(below(t.size())); };
    switch (which) {
      case 0:
        t.erase(at());
        break;
      case 1: {
        const std::string copy = *at();
        t.insert(at(), 1 + (below(8) ? 0 : below(mostRepeats)), copy);
        break;
      }
      case 2:
        std::iter_swap(at(), at());
        break;
      default:
        if (!other.empty()) *at() = other[below(other.size())];
    }
  }
};

// As many whole tokens as `limit` bytes hold.
inline std::string textOf(const std::vector<std::string>& tokens, size_t limit) {
  std::string s;
  for (const std::string& token : tokens) {
    if (s.size() + token.size() > limit) break;
    s += token;
  }
  return s;
}

}  // namespace kinora::fuzz
