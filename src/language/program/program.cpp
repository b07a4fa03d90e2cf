#include "language/program/program.h"

#include <cstdio>

namespace kinora::language {

std::string nameOf(const Type& type) {
  static constexpr const char* kNames[] = {"void",   "int",    "float",  "string",        "color", "point",
                                           "vector", "normal", "matrix", "closure color", "struct"};
  std::string name = kNames[size_t(type.base)];
  if (type.arrayLength < 0) name += "[]";
  if (type.arrayLength > 0) name += "[" + std::to_string(type.arrayLength) + "]";
  return name;
}

std::string nineDigits(float f) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", double(f));
  return text;
}

SymbolId Shader::find(std::string_view name) const {
  for (size_t i = 0; i < symbols.size(); ++i)
    if (symbols[i].name == name) return SymbolId(i);
  return kNone;
}

char accessOf(const Shader& shader, const Instruction& instruction, uint32_t argument) {
  const auto& arguments = instruction.arguments;
  const char access = accessOf(instruction.opcode, argument, uint32_t(arguments.size()));
  if (instruction.opcode == Opcode::ArrayCopy && argument == 0) {  // the rest of a longer array stays
    const auto length = [&](size_t i) { return shader.symbols[size_t(arguments[i])].type.arrayLength; };
    return length(1) < length(0) ? 'W' : access;
  }
  if (access != 'r' || argument == 0 || !(factsOf(instruction.opcode).flags & kOpTable)) return access;
  const Symbol& token = shader.symbols[size_t(arguments[argument - 1])];
  if (token.kind != SymbolKind::Constant || token.type.base != Base::String || token.values.strings.empty())
    return access;
  return token.values.strings[0] == "alpha" || token.values.strings[0] == "errormessage" ? 'W' : access;
}

}  // namespace kinora::language
