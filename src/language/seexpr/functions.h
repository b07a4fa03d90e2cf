// The functions of SeExpr as they stand in the shading language: which take which arguments, and the source of those
// that the shading language lacks. Read by translate.cpp.
#pragma once
#include <string_view>

namespace kinora::language::seexpr {

// Types of a signature, the result first: 'f' a number, 'v' a vector, 'e' a number for each component (all arguments
// 'e' are vectors where one is). Arguments that may be left out have values in `defaults`, separated by '|'.
struct Function {
  std::string_view name, signature, code, defaults = {};
  bool isNative = false;  // of 'e': the shading language's own takes vectors as well
};

const Function* findFunction(std::string_view name);
// Source of all functions that `code` of non-native ones names.
std::string_view librarySource();

}  // namespace kinora::language::seexpr
