// Regular expressions of the language (ECMAScript, as the reference takes them from C++), compiled once each and safe
// for any input. The standard library has two executors: backtracking, which may take exponential time and deep
// stacks, and breadth-first, whose time is polynomial, which knows no back references and takes the longest
// alternative instead of the first. Whether there is a match is the same for both; positions come from backtracking
// where a bound on its steps allows, else from the other. Back references beyond the bound are refused. Any thread
// may call.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace kinora::language {

inline constexpr size_t kLongestRegexPattern = 1024, kLongestRegexSubject = 16384;

// Does the pattern match the whole subject (regex_match) or a part of it (regex_search)? results: begin and end of
// the match and of each group; what is left over is filled with the pattern's length, as in the reference. A pattern
// that cannot be used gives false and a reason; a reason is empty otherwise.
bool matchRegex(std::string_view subject, std::string_view pattern, bool whole, int32_t* results, int count,
                std::string& reason);

}  // namespace kinora::language
