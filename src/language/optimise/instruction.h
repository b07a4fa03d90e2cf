// Instructions that passes over a flattened network make. Used by optimise/.
#pragma once
#include <utility>
#include <vector>

#include "language/program/program.h"

namespace kinora::language {

inline Instruction makeInstruction(Opcode op, std::vector<SymbolId> arguments, int32_t layer) {
  Instruction in;
  in.opcode = op;
  in.arguments = std::move(arguments);
  in.layer = layer;
  return in;
}

}  // namespace kinora::language
