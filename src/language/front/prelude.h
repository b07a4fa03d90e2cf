// What every shader finds without including anything: macros, and library functions that are written in the language
// itself. Those are parsed when a shader names them, so that they cost nothing otherwise.
#pragma once
#include <string_view>
#include <vector>

namespace kinora::language::front {

std::string_view preludeMacros();                       // text of #defines
std::string_view preludeHeader(std::string_view name);  // a header that is built in; "" when there is none
std::string_view preludeFunction(
    std::string_view name);  // source of all functions of that name; "" when there is none
std::vector<std::string_view> preludeFunctionNames();

}  // namespace kinora::language::front
