// Text of the language: format() and its kin, conversions from strings, pieces of strings. Plain code without a
// locale, called by the compiler (checking formats) and by the machine's call-outs, one point at a time. Deliberately
// knows no shaders: who prints, and with which prefix, is the caller's.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::language {

// One argument of a format: `count` numbers or strings (3 for a triple, 16 for a matrix, all elements of an array),
// of which each is converted by the same specification. Closures come as their text.
struct FormatArgument {
  enum class Kind { Int, Float, String };
  Kind kind = Kind::Int;
  int count = 1;
  const int32_t* ints = nullptr;
  const float* floats = nullptr;
  const std::string_view* strings = nullptr;
};
FormatArgument formatInts(const int32_t* v, int count = 1);
FormatArgument formatFloats(const float* v, int count = 1);
FormatArgument formatStrings(const std::string_view* v, int count = 1);

// A format cut into literal text and conversions.
struct FormatPiece {
  std::string text;  // literal text, %% resolved; or the flags, width and precision as written
  char letter = 0;   // 0: literal
};
std::vector<FormatPiece> parseFormat(std::string_view format);
// May a conversion print this kind? %s strings; d i o x X ints; f g e (and c m n p v) floats.
bool formatAccepts(char letter, FormatArgument::Kind kind);
// What is wrong with a format for arguments of these kinds ("" if nothing): a letter that does not fit or a count.
std::string checkFormat(const std::vector<FormatPiece>& format, const std::vector<FormatArgument::Kind>& kinds);
// The text. The arguments fit (checkFormat); each converted item is cut at 1024 characters.
std::string formatText(const std::vector<FormatPiece>& format, const FormatArgument* arguments);

// ---- strings to numbers ----
int32_t stoi(std::string_view s);  // saturates; 0 where there is no number
float stof(std::string_view s);    // as C's strtof in the C locale: also hexadecimal, inf, nan

// ---- pieces ----
std::string_view substr(std::string_view s, int start, int length);
int32_t getchar(std::string_view s, int index);  // 0 out of range
inline bool startswith(std::string_view s, std::string_view head) { return s.substr(0, head.size()) == head; }
inline bool endswith(std::string_view s, std::string_view tail) {
  return s.size() >= tail.size() && s.substr(s.size() - tail.size()) == tail;
}
// At most `most` pieces; the last one is the untouched rest. An empty separator means runs of blanks.
std::vector<std::string_view> split(std::string_view s, std::string_view separator, int most);

}  // namespace kinora::language
