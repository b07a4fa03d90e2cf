#include "language/program/opcodes.h"

#include <algorithm>
#include <array>
#include <map>

namespace kinora::language {

namespace {

constexpr std::array<OpcodeFacts, size_t(Opcode::Count)> kFacts = {{
#define KN_X(enumerator, name, letters, flags) {name, letters, uint32_t(flags)},
    KN_LANGUAGE_OPCODES(KN_X)
#undef KN_X
}};

}  // namespace

const OpcodeFacts& factsOf(Opcode op) { return kFacts[std::min(size_t(op), kFacts.size() - 1)]; }

Opcode opcodeNamed(std::string_view name) {
  static const std::map<std::string_view, Opcode> kByName = [] {
    std::map<std::string_view, Opcode> map;
    for (size_t i = 0; i < kFacts.size(); ++i)
      if (Opcode(i) < Opcode::DebugNan)  // what follows is in no file
        map.emplace(kFacts[i].name, Opcode(i));
    return map;
  }();
  const auto found = kByName.find(name);
  return found == kByName.end() ? Opcode::Count : found->second;
}

char accessOf(Opcode op, uint32_t i, uint32_t count) {
  switch (op) {  // a destination that comes last
    case Opcode::GetMatrix:
    case Opcode::GetTextureInfo:
    case Opcode::GetAttribute:
    case Opcode::GetMessage:
    case Opcode::DictValue:
      if (i != 0 && i + 1 == count) return op == Opcode::GetMatrix ? 'w' : 'W';
      break;
    case Opcode::RegexSearch:
    case Opcode::RegexMatch:
      if (count == 4 && i == 2) return 'W';
      break;
    default:
      break;
  }
  const OpcodeFacts& facts = factsOf(op);
  return i < facts.fixed ? facts.letters[i] : facts.further;
}

}  // namespace kinora::language
