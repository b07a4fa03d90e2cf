// Walks over the tree of code.
#pragma once
#include "language/program/program.h"

namespace kinora::language {

template <class F>
void forEachInstruction(const Block& block, F&& f) {
  for (const Instruction& in : block.code) {
    f(in);
    for (const Block& inner : in.blocks) forEachInstruction(inner, f);
  }
}

}  // namespace kinora::language
