#include "fuzz/oso_mutator.h"

#include <algorithm>
#include <cctype>

#include "fuzz/oso_input.h"
#include "language/program/opcodes.h"

namespace kinora::fuzz {

namespace {

constexpr const char* kOpcodes[] = {
#define KN_X(enumerator, name, letters, flags) name,
    KN_LANGUAGE_OPCODES(KN_X)
#undef KN_X
};
constexpr const char* kWords[] = {"param",
                                  "oparam",
                                  "local",
                                  "temp",
                                  "global",
                                  "const",
                                  "int",
                                  "float",
                                  "string",
                                  "color",
                                  "point",
                                  "vector",
                                  "normal",
                                  "matrix",
                                  "closure",
                                  "struct",
                                  "float[4]",
                                  "int[]",
                                  "color[3]",
                                  "string[2]",
                                  "code",
                                  "___main___",
                                  "surface",
                                  "shader",
                                  "displacement",
                                  "volume",
                                  "0",
                                  "1",
                                  "-1",
                                  "2",
                                  "3",
                                  "7",
                                  "1e38",
                                  "-1e38",
                                  "nan",
                                  "inf",
                                  "1e-45",
                                  "2147483647",
                                  "-2147483648",
                                  "2147483648",
                                  "99999999999999",
                                  "1048576",
                                  "\"\"",
                                  "\"x\"",
                                  "\"perlin\"",
                                  "\"gabor\"",
                                  "\"bezier\"",
                                  "\"%d %s %f\"",
                                  "\"\\",
                                  "%read{0,9}",
                                  "%write{0,9}",
                                  "%derivs",
                                  "%initexpr",
                                  "%argrw{\"wrr\"}",
                                  "%line{0}",
                                  "%filename{\"f\"}",
                                  "%struct{\"S\"}",
                                  "%mystruct{s}",
                                  "%mystructfield{0}",
                                  "%structfields{a,b}",
                                  "%meta{int,lockgeom,0}",
                                  "%",
                                  "#",
                                  "\t",
                                  " ",
                                  "\n",
                                  "P",
                                  "N",
                                  "u",
                                  "v",
                                  "Ci",
                                  "$const1",
                                  "$tmp1"};

}  // namespace

OsoMutator::Lines OsoMutator::linesOf(const std::string& s) {
  Lines lines(1);
  for (size_t i = 0; i < s.size();) {
    size_t end = i + 1;
    const char c = s[i];
    if (c == '\n') {
      lines.back().emplace_back("\n");
      lines.emplace_back();
      i = end;
      continue;
    }
    const auto isBlank = [](char d) { return d == ' ' || d == '\t'; };
    if (isBlank(c))
      while (end < s.size() && isBlank(s[end])) ++end;
    else if (c == '"') {
      while (end < s.size() && s[end] != '"' && s[end] != '\n') end += s[end] == '\\' ? 2u : 1u;
      end = std::min(end + 1, s.size());
    } else
      while (end < s.size() && !isBlank(s[end]) && s[end] != '\n' && s[end] != '"') ++end;
    lines.back().push_back(s.substr(i, end - i));
    i = end;
  }
  return lines;
}

std::string OsoMutator::word(const Lines& lines) {
  switch (below(4)) {
    case 0:
      return kWords[below(std::size(kWords))];
    case 1:
      return kOpcodes[below(std::size(kOpcodes))];
    default: {  // one that stands in the file: names of symbols, mostly
      const auto& line = lines[below(lines.size())];
      return line.empty() ? "0" : line[below(line.size())];
    }
  }
}

void OsoMutator::change(Lines& lines, const Lines& other) {
  auto& line = lines[below(lines.size())];
  const auto at = [&] { return lines.begin() + long(below(lines.size())); };
  switch (below(12)) {
    case 0:
      if (lines.size() > 1) lines.erase(at());
      break;
    case 1: {
      const auto copy = lines[below(lines.size())];
      lines.insert(at(), copy);
      break;
    }
    case 2:
      std::iter_swap(at(), at());
      break;
    case 3: {
      const auto copy = other[below(other.size())];
      lines.insert(at(), copy);
      break;
    }
    case 4:
      if (!line.empty()) line.erase(line.begin() + long(below(line.size())));
      break;
    case 5:
      line.insert(line.begin() + long(below(line.size() + 1)), "\t" + word(lines) + " ");
      break;
    case 6:  // the operation of a line
      for (std::string& w : line)
        if (!w.empty() && std::isalpha(static_cast<unsigned char>(w[0]))) {
          w = kOpcodes[below(std::size(kOpcodes))];
          break;
        }
      break;
    case 7:  // a number
      for (uint32_t tries = 0; tries < 20; ++tries) {
        auto& l = lines[below(lines.size())];
        if (l.empty()) continue;
        std::string& w = l[below(l.size())];
        if (w.empty() || !std::isdigit(static_cast<unsigned char>(w[0]))) continue;
        w = below(3) ? std::to_string(below(40)) : kWords[26 + below(16)];
        break;
      }
      break;
    case 8:
      if (!line.empty()) {
        std::string& w = line[below(line.size())];
        if (!w.empty()) w[below(w.size())] = char(below(256));
      }
      break;
    default:
      if (!line.empty()) line[below(line.size())] = word(lines);
  }
}

std::string OsoMutator::mutate(const std::string& input, const std::string& other, size_t limit) {
  if (below(12) == 0) return osoOf(random_.program()).substr(0, limit);
  Lines lines = linesOf(osoOf(input));
  const Lines pieces = linesOf(below(3) == 0 ? osoOf(random_.program()) : osoOf(other));
  for (uint32_t n = 1 + below(4); n > 0; --n) change(lines, pieces);
  std::string s;
  for (const auto& line : lines)
    for (const std::string& w : line) {
      if (s.size() + w.size() > limit) return s;
      s += w;
    }
  return s;
}

}  // namespace kinora::fuzz
