// What a run keeps of the closures of programs that look at them (optimise/closure_values.cpp): each is the number of
// an entry, 0 where there is none. Entries live as long as a block of points. Used by the kernels of
// scalar_closures.cpp alone.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kinora::language {

class ClosureTable {
 public:
  using Weight = std::array<float, 3>;
  void clear() { entries_.clear(); }
  bool isFull() const { return entries_.size() >= kMostEntries; }  // nothing is added then: 0 is answered
  int32_t make(std::string text);                                  // name and parameters, as they are printed
  int32_t sum(int32_t a, int32_t b);
  int32_t scaled(int32_t a, const Weight& weight);
  // "(r, g, b) * name (parameters)", terms one below the other; "" of none. Cut behind many terms.
  std::string text(int32_t closure) const;

 private:
  static constexpr size_t kMostEntries = 1u << 20, kMostTerms = 4096;
  struct Entry {
    int32_t a = 0, b = 0;  // of a sum; a alone of what is weighed; neither of what was made
    Weight weight{};
    std::string made;
  };
  int32_t add(Entry entry);
  std::vector<Entry> entries_;
};

}  // namespace kinora::language
