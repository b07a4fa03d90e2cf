// The expressions of IfBegin and ElseIf, and "$name" inside strings. Used by the interpreter, which answers for the
// values of names. It runs nothing and knows no request.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "scene/parameters.h"

namespace kinora::rib {

// Numbers as names of files and conditions want them: the shortest text that reads back as the same number, without
// an exponent where it is of a usual size ("100000", not "1e+05").
std::string plainText(float v);
std::string plainText(int v);
// Of a parameter: its first string, or its numbers with blanks between them, the first sixteen.
std::string plainText(const scene::Parameter& p);

// The value of "user:pass", "Frame", ... as text; empty when nobody defined it.
using Lookup = std::function<std::optional<std::string>(std::string_view name)>;

// `problem` is set to what is wrong when the expression cannot be understood; it then counts as false.
bool evaluateCondition(std::string_view expression, const Lookup& lookup, std::string& problem);

// Replaces "${name}" (and "$name" when `bare`) by its value; what is not defined stays as it is.
std::string substitute(std::string_view text, char marker, bool bare, const Lookup& lookup);

}  // namespace kinora::rib
