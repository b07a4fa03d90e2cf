#include "fuzz/seexpr_mutator.h"

#include <algorithm>
#include <cctype>
#include <iterator>

namespace kinora::fuzz {

namespace {

constexpr size_t kMostRepeats = 300;
constexpr const char* kNames[] = {"P",           "Nn", "Cs", "u", "v", "s", "time",
                                  "colorInput1", "PI", "$a", "b", "c", "d", "floatInput1"};
constexpr const char* kOddNames[] = {"b2", "x::y", "$P", "w", "noise", "$colorInput2", "Pobj", "e", "sin", "Vn"};
// One letter an argument: n a number, v a vector, k the rest of a curve or of a list of choices.
struct Call {
  const char *name, *arguments;
};
constexpr Call kCalls[] = {
    {"sin", "n"},          {"abs", "v"},         {"pow", "nn"},      {"mix", "vvn"},      {"clamp", "nnn"},
    {"max", "nv"},         {"fit", "nnnnn"},     {"remap", "nnnnn"}, {"noise", "v"},      {"noise", "nn"},
    {"snoise", "v"},       {"cellnoise", "v"},   {"fbm", "v"},       {"fbm", "vnnn"},     {"turbulence", "vn"},
    {"voronoi", "v"},      {"voronoi", "vnnnn"}, {"hash", "nnn"},    {"length", "v"},     {"norm", "v"},
    {"dot", "vv"},         {"cross", "vv"},      {"rotate", "vvn"},  {"rgbtohsl", "v"},   {"hsi", "vnnn"},
    {"midhsi", "vnnnnn"},  {"pnoise", "vv"},     {"cvoronoi", "v"},  {"pvoronoi", "vnn"}, {"contrast", "nn"},
    {"smoothstep", "nnn"}, {"gaussstep", "nnn"}, {"cycle", "nnn"},   {"choose", "nkk"},   {"curve", "nk"},
    {"ccurve", "nk"},      {"spline", "nnnnn"},  {"swatch", "nvvv"}, {"fbm4", "vn"},      {"atan2", "nn"},
    {"compress", "nnn"},   {"saturate", "vn"}};
constexpr const char* kOddCalls[] = {"printf", "map", "sprintf", "rand", "up", "nosuch", "wchoose", "a", "P"};
constexpr const char* kNumbers[] = {"0",    "1",     "-1",   "2",     ".5",  "1.",  "3",  "4",
                                    "1e38", "1e-45", "3e38", "65536", "1e9", "360", "257"};
constexpr const char* kOddNumbers[] = {"1e999", "nan", "0x1", "1.5.5", "1e", "."};
constexpr const char* kWords[] = {
    "(",  ")",  "[",  "]",  "{",  "}",  "<",     ">",      "+",      "-",   "*",    "/",
    "%",  "^",  "!",  "~",  "?",  ":",  ",",     ";",      "=",      "->",  "==",   "!=",
    "<=", ">=", "&&", "||", "+=", "^=", "if",    "else",   "def",    "#\n", "\\\n", "\"s\"",
    "'",  "\"", "$",  "::", "@",  "\n", "FLOAT", "VECTOR", "return", "\x80"};

}  // namespace

std::string SeExprMutator::number() {
  if (below(60) == 0) return kOddNumbers[below(std::size(kOddNumbers))];
  if (below(3) == 0) return kNumbers[below(std::size(kNumbers))];
  return std::to_string(below(1000) / 100.0);
}

std::string SeExprMutator::name() {
  return below(20) ? kNames[below(std::size(kNames))] : kOddNames[below(std::size(kOddNames))];
}

std::string SeExprMutator::word() {
  switch (below(4)) {
    case 0:
      return name();
    case 1:
      return number();
    case 2:
      return kCalls[below(std::size(kCalls))].name;
    default:
      return kWords[below(std::size(kWords))];
  }
}

std::string SeExprMutator::call(int depth) {
  const Call& c = kCalls[below(std::size(kCalls))];
  std::string s = std::string(below(30) ? c.name : kOddCalls[below(std::size(kOddCalls))]) + "(";
  const auto add = [&](const std::string& argument) {
    if (s.back() != '(') s += ", ";
    s += argument;
  };
  for (const char* k = c.arguments; *k; ++k) {
    if (*k == 's') add("\"file.tx\"");
    if (*k == 'n') add(below(3) ? number() : expression(depth - 1));
    if (*k == 'v') add(below(2) ? "P" : expression(depth - 1));
    if (*k == 'k') {
      const bool isCurve = c.name[0] == 'c' && c.name[1] != 'h';
      for (uint32_t n = 1 + below(below(20) ? 4 : 90); n > 0; --n) {
        add(number());
        if (!isCurve) continue;
        add(below(2) ? number() : "[1,0,.5]");
        add(std::to_string(below(6)));
      }
    }
  }
  return s + ")";
}

std::string SeExprMutator::expression(int depth) {
  static constexpr const char* kOperators[] = {"+", "-",  "*",  "/",  "%",  "^",  "<",
                                               ">", "<=", ">=", "==", "!=", "&&", "||"};
  if (depth <= 0) return below(2) ? number() : name();
  switch (below(9)) {
    case 0:
      return "[" + (below(10) ? number() : expression(depth - 2)) + ", P[" + std::to_string(below(3)) + "], length(" +
             expression(depth - 2) + ")]";
    case 1:
      return "(" + expression(depth - 1) + " ? " + expression(depth - 1) + " : " + expression(depth - 1) + ")";
    case 2:
      return std::string(below(2) ? "-" : "!") + expression(depth - 1);
    case 3:
      return "P[" + std::to_string(below(3)) + "]";
    case 4:
    case 5:
      return call(depth - 1);
    case 6:
      return "((" + expression(depth - 1) + ")->" + (below(2) ? "abs()" : "clamp(0, 1)") + ")";
    default:
      return "(" + expression(depth - 1) + " " + kOperators[below(std::size(kOperators))] + " " +
             expression(depth - 1) + ")";
  }
}

std::string SeExprMutator::statement(int depth) {
  if (depth > 0 && below(4) == 0)
    return "if (" + expression(2) + ") { " + statement(depth - 1) + " } else { " + statement(depth - 1) + " }\n";
  static constexpr const char* kAssign[] = {"=", "=", "=", "+=", "-=", "*=", "/=", "%=", "^="};
  return (below(2) ? "$" : "") + std::string(1, char('a' + below(4))) + " " + kAssign[below(std::size(kAssign))] +
         " " + expression(3) + ";\n";
}

std::string SeExprMutator::program() {
  std::string s = "$a = P; $b = 1; $c = u; $d = [1, 2, 3];\n";
  for (uint32_t n = below(4); n > 0; --n) s += statement(2);
  return s + expression(4);
}

SeExprMutator::Tokens SeExprMutator::tokensOf(std::string_view s) {
  Tokens t;
  const auto isPart = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.'; };
  for (size_t i = 0; i < s.size();) {
    size_t end = i + 1;
    if (isPart(s[i]))
      while (end < s.size() && isPart(s[end])) ++end;
    t.emplace_back(s.substr(i, end - i));
    i = end;
  }
  return t;
}

void SeExprMutator::change(Tokens& t, const Tokens& other) {
  if (t.empty()) return;
  const auto at = [&] { return t.begin() + std::ptrdiff_t(below(t.size())); };
  const uint32_t which = below(12);
  if (which < kRearrangements) return rearrange(which, t, other, kMostRepeats);
  switch (which) {
    case 4:
      t.insert(t.begin(), statement(2));
      break;
    case 5:
      t.insert(at(), word());
      break;
    case 6: {  // a piece again, elsewhere
      const size_t a = below(t.size()), n = 1 + below(std::min<size_t>(30, t.size() - a));
      const Tokens piece(t.begin() + std::ptrdiff_t(a), t.begin() + std::ptrdiff_t(a + n));
      t.insert(at(), piece.begin(), piece.end());
      break;
    }
    case 7: {
      std::string& s = *at();
      s[below(s.size())] = char(below(256));
      break;
    }
    case 8:
      t.insert(at(), std::string(1 + below(kMostRepeats), "([{-!~"[below(6)]));
      break;
    case 9:
      *at() = "(" + expression(3) + ")";
      break;
    case 10:
      *at() = number();
      break;
    default:
      *at() = word();
  }
}

std::string SeExprMutator::mutate(const std::string& input, const std::string& other, size_t limit) {
  if (below(8) == 0) return program().substr(0, limit);
  Tokens t = tokensOf(input);
  const Tokens pieces = tokensOf(other);
  for (uint32_t n = 1 + below(4); n > 0; --n) change(t, pieces);
  return textOf(t, limit);
}

}  // namespace kinora::fuzz
