#include "language/optimise/structure.h"

#include "language/optimise/walk.h"

namespace kinora::language {

namespace {

// What an instruction makes of an int or a string that it reads as argument i.
enum class Use { Number, Result, Decides };

Use useOf(const Shader& shader, const Instruction& in, uint32_t i) {
  const auto isInt = [&](uint32_t k) { return shader.symbols[size_t(in.arguments[k])].type.base == Base::Int; };
  const Symbol& read = shader.symbols[size_t(in.arguments[i])];
  switch (in.opcode) {
    case Opcode::Assign:
      return isInt(0) || read.type.base == Base::String ? Use::Result : Use::Number;
    case Opcode::Add:
    case Opcode::Sub:
    case Opcode::Mul:
    case Opcode::Div:
    case Opcode::Mod:
    case Opcode::FloorMod:
    case Opcode::Neg:
    case Opcode::BitAnd:
    case Opcode::BitOr:
    case Opcode::BitXor:
    case Opcode::ShiftLeft:
    case Opcode::ShiftRight:
    case Opcode::Complement:
    case Opcode::Min:
    case Opcode::Max:
    case Opcode::Clamp:
    case Opcode::Abs:
    case Opcode::Hash:
      return isInt(0) ? Use::Result : Use::Number;
    case Opcode::MakeColor:
    case Opcode::MakePoint:
    case Opcode::MakeVector:
    case Opcode::MakeNormal:
      return read.type.base == Base::Int ? Use::Number : Use::Decides;
    case Opcode::Concat:
      return Use::Result;
    case Opcode::Eq:
    case Opcode::Neq:
      return read.type.base == Base::String ? Use::Number : Use::Decides;  // a name that is there or not
    case Opcode::Texture:
    case Opcode::Texture3d:
    case Opcode::Environment:
    case Opcode::GetTextureInfo:
      return i == 1 ? Use::Number : Use::Decides;
    case Opcode::UseParam:
      return Use::Number;
    case Opcode::Printf:
    case Opcode::Warning:
    case Opcode::Error:
      return i > 0 ? Use::Number : Use::Decides;
    default:
      return Use::Decides;
  }
}

}  // namespace

std::vector<bool> structuralSymbols(const Shader& shader) {
  std::vector<bool> decides(shader.symbols.size());
  bool hasChanged = true;
  const auto look = [&](const Instruction& in) {
    for (uint32_t i = 0; i < in.arguments.size(); ++i) {
      const SymbolId id = in.arguments[i];
      if (id < 0 || decides[size_t(id)] || accessOf(shader, in, i) == 'w') continue;
      const Base base = shader.symbols[size_t(id)].type.base;
      if (base != Base::Int && base != Base::String) continue;
      const Use use = useOf(shader, in, i);
      if (use == Use::Number || (use == Use::Result && !decides[size_t(in.arguments[0])])) continue;
      decides[size_t(id)] = hasChanged = true;
    }
  };
  // what feeds a value that decides, decides too
  while (hasChanged) {
    hasChanged = false;
    forEachInstruction(shader.main, look);
    for (const Initialiser& i : shader.initialisers) forEachInstruction(i.code, look);
  }
  return decides;
}

}  // namespace kinora::language
