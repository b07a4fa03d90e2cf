// The library's functions that are opcodes, with their overloads. Asked by the checker and by lowering.
#pragma once
#include <array>
#include <span>
#include <string_view>

#include "language/program/program.h"

namespace kinora::language::front {

// Signatures are text, separated by spaces: the result and the arguments, a letter each:
//   i f s c p v n m x C   int float string color point vector normal matrix void closure
//   T V G                 one of fcpvn, cpvn, pvn: the same wherever it stands in the signature
//   !t                    an output; t[ an array of any length; ? anything but a struct
// and at the end: + as many again of the last as there are, * anything, @ pairs of a token and a value.
struct Builtin {
  std::string_view name;
  Opcode opcode;
  std::string_view signatures;
};

constexpr size_t kMostFormals = 12;
struct Formal {
  Type type;
  bool isOutput = false, isAny = false;
};
struct Signature {
  Type result;
  std::array<Formal, kMostFormals> formals;
  uint32_t count = 0;
  char rest = 0;  // '+', '*', '@' or none
  // of argument i; beyond the formals: the last one again, or anything
  Formal at(uint32_t i) const {
    if (i < count) return formals[i];
    if (rest == '+') return formals[count - 1];
    Formal any;
    any.isAny = true;
    return any;
  }
};

// All functions of a name stand side by side; null when there is none. closures: opcode MakeClosure.
const Builtin* builtinNamed(std::string_view name);
std::span<const Builtin> allBuiltins();
// All of a builtin's, one for each type that a T, V or G stands for. They are made once and stay.
std::span<const Signature> signaturesOf(const Builtin&);

// Not void, which is the absence of a value, but the absence of a message: what a wrong expression has.
constexpr Type kPoison{Base::Void, 0, -2};
constexpr bool isPoison(const Type& t) { return t.base == Base::Void && t.structure == -2; }
constexpr bool isPlain(const Type& t) { return t.arrayLength == 0; }
// Whether it may decide: not 0, not "", not the closure that is none.
inline bool isCondition(const Type& t) { return isPlain(t) && (componentsOf(t.base) > 0 || t.base == Base::Closure); }

bool assignable(const Type& to, const Type& from);
int matchScore(const Type& formal, const Type& actual);  // 0: does not match

}  // namespace kinora::language::front
