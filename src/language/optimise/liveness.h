// Which symbols are read later, at each place of the tree of code: backwards over blocks, to a fixed point in loops.
#pragma once
#include <cstdint>
#include <functional>
#include <unordered_map>
#include <vector>

#include "language/program/program.h"

namespace kinora::language {

class SymbolSet {
 public:
  explicit SymbolSet(size_t symbols = 0) : words_((symbols + 63) / 64) {}
  bool has(SymbolId s) const { return words_[size_t(s) >> 6] >> (s & 63) & 1; }
  void add(SymbolId s) { words_[size_t(s) >> 6] |= uint64_t(1) << (s & 63); }
  void remove(SymbolId s) { words_[size_t(s) >> 6] &= ~(uint64_t(1) << (s & 63)); }
  void unite(const SymbolSet& other) {
    for (size_t i = 0; i < words_.size(); ++i) words_[i] |= other.words_[i];
  }
  friend bool operator==(const SymbolSet&, const SymbolSet&) = default;

 private:
  std::vector<uint64_t> words_;
};

class Liveness {
 public:
  explicit Liveness(const Shader& shader) : shader_(shader) {}
  // What is live before a branch's or body's block (Block*) or before a loop's next turn (Instruction*).
  std::function<void(const void*, const SymbolSet&)> atEntry;
  // Asked of each instruction without blocks and its live results; true: it is as if it were not there. In loops an
  // instruction is asked again until nothing changes: the last answer counts.
  std::function<bool(const Instruction&, const SymbolSet& after)> isDead;
  // live: behind the block; becomes what is live before it.
  void run(const Block& block, SymbolSet& live) {
    heads_.clear();
    go(block, live, Targets());
  }

 private:
  struct Targets {
    const SymbolSet *onBreak = nullptr, *onContinue = nullptr, *onReturn = nullptr, *onExit = nullptr;
  };
  void go(const Block&, SymbolSet& live, const Targets&);
  void step(const Instruction&, SymbolSet& live, const Targets&);
  const Shader& shader_;
  std::unordered_map<const Instruction*, SymbolSet> heads_;  // of loops: before a turn
};

}  // namespace kinora::language
