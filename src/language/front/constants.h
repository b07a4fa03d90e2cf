// Values known without running anything: defaults, metadata, lengths of arrays, literals.
#pragma once
#include "language/front/ast.h"
#include "language/front/builtins.h"

namespace kinora::language::front {

constexpr bool isScalarNumber(const Type& t) {
  return t.arrayLength == 0 && (t.base == Base::Int || t.base == Base::Float);
}
constexpr bool isPlainNumber(const Type& t) {
  return t.arrayLength == 0 && (isScalarNumber(t) || isTriple(t.base) || t.base == Base::Matrix);
}

// Of a checked expression: literals, their arithmetic, constructors and lists of them. False when it is not constant.
// Values are of type e.type.
bool constantOf(const Expr& e, Values& out);
// From one plain type or array to another to which it can be assigned.
Values converted(const Values& values, const Type& from, const Type& to);
// Zeros, or empty strings.
Values zeros(const Type& type);

}  // namespace kinora::language::front
