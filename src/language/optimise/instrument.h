// A shader with checks in it, for finding mistakes: after each operation whether what it wrote is finite, before each
// one whether the variables that it reads were ever set. Used by `kinora shader run --debugnan --debuguninit`.
#pragma once
#include "language/program/program.h"

namespace kinora::language {

// Strings that were never set; numbers are NaN and the least int.
inline constexpr const char* kUninitialisedText = "!!!uninitialized!!!";

Shader instrumented(Shader shader, bool tellsNan, bool tellsUninitialised);

}  // namespace kinora::language
