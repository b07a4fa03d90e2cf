#include "language/library/text.h"

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <utility>
#include <locale.h>

namespace kinora::language {
namespace {
constexpr size_t kLongestItem = 1024;

// Flags, width and precision of a conversion. Rules are those of {fmt}'s format specifications, into which the
// reference translates C's; what {fmt} refuses is printed as its complaint.
struct Spec {
  bool left = false, plus = false, space = false, alternate = false, zero = false;
  int width = 0, precision = -1;
  bool valid = true;
};
Spec parseSpec(std::string_view text) {
  Spec s;
  size_t i = 0;
  for (; i < text.size(); ++i) {
    if (text[i] == '-')
      s.left = true;
    else if (text[i] == '+')
      s.plus = true;
    else if (text[i] == ' ')
      s.space = true;
    else if (text[i] == '#')
      s.alternate = true;
    else if (text[i] == '0')
      s.zero = true;
    else
      break;
  }
  const auto number = [&](int& value) {
    value = 0;
    for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i)
      value = std::min(value * 10 + (text[i] - '0'), 1 << 20);
  };
  number(s.width);
  if (i < text.size() && text[i] == '.') ++i, number(s.precision);
  s.valid = i == text.size();
  return s;
}
std::string complaint(std::string_view text, char type, const Spec& s, const char* why) {
  std::string spec = s.left ? "<" : "";
  for (char c : text)
    if (c != '-') spec += c;
  return "MIS-FORMAT: format \"{:" + spec + type + "}\" threw \"" + why + "\"";
}
// body with its sign and prefix apart, brought to the width
std::string pad(const std::string& sign, const std::string& body, const Spec& s, bool zeros, bool leftByDefault) {
  const size_t size = sign.size() + body.size(), width = size_t(s.width);
  if (size >= width) return sign + body;
  const std::string fill(width - size, zeros ? '0' : ' ');
  if (s.left || leftByDefault) return sign + body + std::string(width - size, ' ');
  return zeros ? sign + fill + body : fill + sign + body;
}
const char* signOf(bool negative, const Spec& s) { return negative ? "-" : s.plus ? "+" : s.space ? " " : ""; }

std::string convertInt(int32_t v, char letter, std::string_view text, const Spec& s) {
  const bool isSigned = letter == 'd' || letter == 'i';
  const char type = letter == 'i' ? 'd' : letter;
  if (s.precision >= 0) return complaint(text, type, s, "precision not allowed for this argument type");
  if (!isSigned && (s.plus || s.space)) return complaint(text, type, s, "format specifier requires signed argument");
  const bool negative = isSigned && v < 0;
  const uint32_t magnitude = negative ? 0u - uint32_t(v) : uint32_t(v);
  const int base = letter == 'o' ? 8 : letter == 'x' || letter == 'X' ? 16 : 10;
  char digits[40];
  char* end = std::to_chars(digits, digits + sizeof digits, magnitude, base).ptr;
  if (letter == 'X') std::transform(digits, end, digits, [](char c) { return c >= 'a' ? char(c - 32) : c; });
  std::string sign = signOf(negative, s);
  if (s.alternate && base == 16) sign += letter == 'x' ? "0x" : "0X";
  if (s.alternate && base == 8 && magnitude != 0) sign += "0";
  return pad(sign, std::string(digits, end), s, s.zero && !s.left, false);
}
// The digits of a non-negative finite number.
std::string digitsOf(float v, char letter, int precision, bool alternate) {
  precision = std::min(precision < 0 ? 6 : precision, 1100);
  std::vector<char> buffer(size_t(precision) + 64);
  const auto print = [&](std::chars_format f, int p) {
    return std::string(buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), v, f, p).ptr);
  };
  if (letter == 'g') {
    if (!alternate) return print(std::chars_format::general, precision);
    // all significant digits stay: C's rule spelled out
    const int significant = std::max(precision, 1);
    std::string e = print(std::chars_format::scientific, significant - 1);
    const int exponent = std::atoi(e.c_str() + e.find('e') + 1);
    std::string r =
        exponent >= -4 && exponent < significant ? print(std::chars_format::fixed, significant - 1 - exponent) : e;
    if (r.find('.') == std::string::npos) r.insert(std::min(r.find('e'), r.size()), ".");
    return r;
  }
  std::string r = print(letter == 'e' ? std::chars_format::scientific : std::chars_format::fixed, precision);
  if (alternate && r.find('.') == std::string::npos) r.insert(std::min(r.find('e'), r.size()), ".");
  return r;
}
std::string convertFloat(float v, char letter, const Spec& s) {
  const std::string sign = signOf(std::signbit(v), s);
  if (!std::isfinite(v)) return pad(sign, std::isnan(v) ? "nan" : "inf", s, false, false);
  const char type = letter == 'e' || letter == 'g' ? letter : 'f';
  return pad(sign, digitsOf(std::fabs(v), type, s.precision, s.alternate), s, s.zero && !s.left, false);
}
std::string convertString(std::string_view v, std::string_view text, const Spec& s) {
  if (s.plus || s.space || s.alternate || s.zero)
    return complaint(text, 's', s, "format specifier requires numeric argument");
  if (s.precision >= 0) v = v.substr(0, size_t(s.precision));
  return pad("", std::string(v), s, false, true);  // left by default, unlike C
}
locale_t cLocale() {
  static const locale_t c = newlocale(LC_ALL_MASK, "C", nullptr);
  return c;
}
bool isWhite(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
}  // namespace

FormatArgument formatInts(const int32_t* v, int count) {
  FormatArgument a;
  a.kind = FormatArgument::Kind::Int, a.count = count, a.ints = v;
  return a;
}
FormatArgument formatFloats(const float* v, int count) {
  FormatArgument a;
  a.kind = FormatArgument::Kind::Float, a.count = count, a.floats = v;
  return a;
}
FormatArgument formatStrings(const std::string_view* v, int count) {
  FormatArgument a;
  a.kind = FormatArgument::Kind::String, a.count = count, a.strings = v;
  return a;
}

std::vector<FormatPiece> parseFormat(std::string_view format) {
  static constexpr std::string_view kLetters = "cdefgimnopsuvxX";
  std::vector<FormatPiece> pieces;
  std::string literal;
  const auto flush = [&] {
    if (!literal.empty()) pieces.push_back({std::exchange(literal, {}), 0});
  };
  for (size_t i = 0; i < format.size(); ++i) {
    if (format[i] != '%') {
      literal += format[i];
      continue;
    }
    if (i + 1 < format.size() && format[i + 1] == '%') {
      literal += '%', ++i;
      continue;
    }
    const size_t end = format.find_first_of(kLetters, i + 1);
    if (end == std::string_view::npos) {  // an unfinished conversion stands for itself
      literal += format.substr(i);
      break;
    }
    flush();
    pieces.push_back({std::string(format.substr(i + 1, end - i - 1)), format[end]});
    i = end;
  }
  flush();
  return pieces;
}
bool formatAccepts(char letter, FormatArgument::Kind kind) {
  const std::string_view letters = kind == FormatArgument::Kind::String ? "s"
                                   : kind == FormatArgument::Kind::Int  ? "dioxX"
                                                                        : "fgecmnpv";
  return letters.find(letter) != std::string_view::npos;
}
std::string checkFormat(const std::vector<FormatPiece>& format, const std::vector<FormatArgument::Kind>& kinds) {
  static const char* const names[] = {"an int", "a float", "a string"};
  size_t at = 0;
  for (const FormatPiece& p : format) {
    if (!p.letter) continue;
    if (at == kinds.size())
      return "the format has more conversions than the " + std::to_string(kinds.size()) + " arguments given";
    if (!formatAccepts(p.letter, kinds[at]))
      return "conversion %" + p.text + p.letter + " does not fit " + names[int(kinds[at])] + " (argument " +
             std::to_string(at + 1) + ")";
    ++at;
  }
  if (at < kinds.size())
    return "the format has " + std::to_string(at) + " conversions for " + std::to_string(kinds.size()) + " arguments";
  return {};
}
std::string formatText(const std::vector<FormatPiece>& format, const FormatArgument* arguments) {
  std::string text;
  for (const FormatPiece& p : format) {
    if (!p.letter) {
      text += p.text;
      continue;
    }
    const FormatArgument& a = *arguments++;
    const Spec s = parseSpec(p.text);
    for (int i = 0; i < a.count; ++i) {
      std::string item;
      if (!s.valid)
        item = complaint(p.text, p.letter, s, "invalid format specifier");
      else if (a.kind == FormatArgument::Kind::Int)
        item = convertInt(a.ints[i], p.letter, p.text, s);
      else if (a.kind == FormatArgument::Kind::Float)
        item = convertFloat(a.floats[i], p.letter, s);
      else
        item = convertString(a.strings[i], p.text, s);
      if (i) text += ' ';
      text += item.size() > kLongestItem ? item.substr(0, kLongestItem) : item;
    }
  }
  return text;
}

int32_t stoi(std::string_view s) {
  size_t i = 0;
  while (i < s.size() && isWhite(s[i])) ++i;
  bool negative = false;
  if (i < s.size() && (s[i] == '-' || s[i] == '+')) negative = s[i++] == '-';
  int64_t v = 0;
  for (; i < s.size() && s[i] >= '0' && s[i] <= '9'; ++i) v = std::min<int64_t>(v * 10 + (s[i] - '0'), 1ll << 40);
  v = negative ? -v : v;
  return int32_t(std::clamp<int64_t>(v, INT32_MIN, INT32_MAX));
}
float stof(std::string_view s) { return strtof_l(std::string(s).c_str(), nullptr, cLocale()); }

std::string_view substr(std::string_view s, int start, int length) {
  const int64_t n = int64_t(s.size());
  const int64_t at = std::clamp<int64_t>(start < 0 ? start + n : start, 0, n);
  return s.substr(size_t(at), size_t(std::clamp<int64_t>(length, 0, n)));
}
int32_t getchar(std::string_view s, int index) {
  return index >= 0 && size_t(index) < s.size() ? int32_t(s[size_t(index)]) : 0;
}
std::vector<std::string_view> split(std::string_view s, std::string_view separator, int most) {
  std::vector<std::string_view> pieces;
  if (s.empty() || most <= 0) return pieces;
  if (!separator.empty()) {
    for (size_t end; int(pieces.size()) + 1 < most && (end = s.find(separator)) != std::string_view::npos;
         s.remove_prefix(end + separator.size()))
      pieces.push_back(s.substr(0, end));
    pieces.push_back(s);
    return pieces;
  }
  for (;;) {
    while (!s.empty() && isWhite(s.front())) s.remove_prefix(1);
    if (s.empty()) return pieces;
    if (int(pieces.size()) + 1 == most) {
      pieces.push_back(s);
      return pieces;
    }
    size_t end = 0;
    while (end < s.size() && !isWhite(s[end])) ++end;
    pieces.push_back(s.substr(0, end));
    s.remove_prefix(end);
  }
}

}  // namespace kinora::language
