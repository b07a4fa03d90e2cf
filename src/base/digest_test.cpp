// Digests differ for contents that differ in one bit, in length or in how they are cut, and no bit of a digest is
// idle. Misses forgeries, which a digest does not promise to withstand.
#include "base/digest.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <set>
#include <string>

namespace kinora {
namespace {

TEST(Digest, EveryBitCounts) {
  std::mt19937_64 rng(1);
  std::set<Digest> seen;
  size_t contents = 0;
  for (const size_t size : {1, 7, 8, 15, 16, 17, 31, 32, 100}) {
    std::string s(size, '\0');
    for (char& c : s) c = char(rng());
    const Digest whole = digestOf(s);
    seen.insert(whole);
    ++contents;
    int least = 128;
    for (size_t bit = 0; bit < size * 8; ++bit, ++contents) {
      std::string other = s;
      other[bit / 8] = char(other[bit / 8] ^ 1 << bit % 8);
      const Digest d = digestOf(other);
      seen.insert(d);
      least = std::min(least, std::popcount(d.high ^ whole.high) + std::popcount(d.low ^ whole.low));
    }
    // 64 +- 5.7 of 128 bits turn; over all flips of this test fewer than 30 have odds of 1e-6
    EXPECT_GE(least, 30) << size;
  }
  EXPECT_EQ(seen.size(), contents);
}

TEST(Digest, LengthsAndCutsCount) {
  std::set<Digest> seen;
  for (size_t n = 0; n < 70; ++n) seen.insert(digestOf(std::string(n, '\0')));
  EXPECT_EQ(seen.size(), 70u) << "zeros of other lengths";
  const std::string text = "abcdefghijklmnopqrstuvwxyz0123456789";
  seen.clear();
  for (size_t cut = 0; cut <= text.size(); ++cut) {
    Hasher h;
    h.text(std::string_view(text).substr(0, cut));
    h.text(std::string_view(text).substr(cut));
    seen.insert(h.result());
  }
  EXPECT_EQ(seen.size(), text.size() + 1);
}

// Small numbers are what scenes are made of: no two short lists of them meet.
TEST(Digest, ShortListsOfSmallNumbers) {
  std::set<Digest> seen;
  size_t lists = 0;
  for (uint64_t a = 0; a < 40; ++a)
    for (uint64_t b = 0; b < 40; ++b)
      for (uint64_t c = 0; c < 40; ++c, ++lists) {
        Hasher h;
        for (const uint64_t w : {a, b, c}) h.word(w);
        seen.insert(h.result());
      }
  EXPECT_EQ(seen.size(), lists);
  std::set<uint64_t> halves;
  for (const Digest& d : seen) halves.insert(d.high);
  EXPECT_EQ(halves.size(), lists) << "64 bits alone meet with odds of 1e-10";
}

TEST(Digest, IsTheSameOnEveryMachine) {
  // parts of a frame compare digests of many machines: a change of the function is a change of their version
  EXPECT_EQ(digestOf("").str(), "99f4190941bd9fa8c88cd44b6ae7852c");
  EXPECT_EQ(digestOf("kinora renders frames").str(), "66a465baae31d85a207d1edfa05a6dfc");
}

}  // namespace
}  // namespace kinora
