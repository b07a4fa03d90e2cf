// A fingerprint of 128 bits: of what a scene says, of what a file holds. Equal contents have equal digests on every
// machine; two that differ share one by chance with odds of 2^-128. It is no secret and withstands no forger. Used
// wherever "the same as before" or "the same as theirs" is asked (scene/identity.h, base/file_contents.h).
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kinora {

struct Digest {
  uint64_t high = 0, low = 0;
  auto operator<=>(const Digest&) const = default;
  std::string str() const;  // 32 hexadecimal digits
};

// Takes in values one after the other. Each is framed: "ab", "c" is not "a", "bc".
class Hasher {
 public:
  void word(uint64_t w) { step(w, kFrame); }
  void bytes(const void* data, size_t size);
  void text(std::string_view s) { bytes(s.data(), s.size()); }
  void digest(const Digest& d) { step(d.high, d.low); }
  Digest result() const;

 private:
  static constexpr uint64_t kFrame = 0x8f3d9c41a6e5b727u;
  // The product of two words folded to one: each bit of it depends on all of both.
  static uint64_t fold(uint64_t x, uint64_t y) {
    __extension__ using Wide = unsigned __int128;
    const Wide p = Wide(x) * y;
    return uint64_t(p) ^ uint64_t(p >> 64);
  }
  // Two lanes that take both words in other roles: a factor of 0, which would make one forget all before it, is none
  // in the other.
  void step(uint64_t x, uint64_t y) {
    high_ = fold(x ^ 0x5bd1e9955bd1e995u, y ^ high_) + 0x9e3779b97f4a7c15u;
    low_ = fold(y ^ 0xc2b2ae3d27d4eb4fu, x ^ low_) + 0x165667b19e3779f9u;
  }

  uint64_t high_ = 0x2545f4914f6cdd1du, low_ = 0xd6e8feb86659fd93u;
};

Digest digestOf(std::string_view bytes);

}  // namespace kinora
