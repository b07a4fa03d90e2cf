// What code generation must know of a flattened program: which values are uniform, which carry derivatives, where
// masks change, and between which points a value lives. Reference: docs/architecture.md, "The shading language".
#pragma once
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "language/optimise/group.h"

namespace kinora::language {

// A piece of code that runs under one mask: a branch, a loop (its condition and step), a loop's body, a function's
// body.
struct Region {
  enum Kind : uint8_t { Root, Branch, Loop, Body, Call, Layer } kind = Root;
  int32_t parent = -1;
  bool isDivergent = false;  // points may enter or leave it apart from each other: it has a mask of its own
};

struct Analysis {
  std::vector<Region> regions;                        // 0: the whole program
  std::unordered_map<const void*, int32_t> regionOf;  // Block* of branches and bodies, Instruction* of loops
  // by symbol
  std::vector<int32_t> home;  // the innermost region that holds its whole life; -1: never used
  std::vector<uint8_t> isVarying, hasDerivs, needsZero;  // needsZero: may be read before it is written

  // Whether a write in `region` must spare points outside of its mask.
  bool blends(int32_t region, int32_t symbol) const {
    for (int32_t r = region; r != home[size_t(symbol)] && r > 0; r = regions[size_t(r)].parent)
      if (regions[size_t(r)].isDivergent) return true;
    return false;
  }
};

bool isFloatBased(Base);
bool carriesDerivsIn(std::string_view global);  // P, I, u, v, Ps

Analysis analyse(const FlatProgram&);

}  // namespace kinora::language
