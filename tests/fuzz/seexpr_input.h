// One fuzzing input for PxrSeExpr: the text of an expression. Used by the fuzzer and its short test.
#pragma once
#include <string_view>

namespace kinora::fuzz {

// Translates it, with some inputs as a node gives them; compiles what comes out and runs that as oso_input.h says. What
// is translated must compile, and what is refused must be told with a place: otherwise the process is aborted. Returns
// 1 when the expression was refused, else 0.
size_t runSeExprInput(std::string_view expression);

}  // namespace kinora::fuzz
