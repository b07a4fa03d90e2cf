#include "fuzz/osl_mutator.h"

#include <algorithm>
#include <cctype>

namespace kinora::fuzz {

namespace {

constexpr const char* kWords[] = {"int",
                                  "float",
                                  "string",
                                  "color",
                                  "point",
                                  "vector",
                                  "normal",
                                  "matrix",
                                  "closure color",
                                  "void",
                                  "struct S",
                                  "S",
                                  "if",
                                  "else",
                                  "for",
                                  "while",
                                  "do",
                                  "break",
                                  "continue",
                                  "return",
                                  "output",
                                  "shader t(",
                                  "surface t(",
                                  "displacement t(",
                                  "and",
                                  "or",
                                  "not",
                                  "a",
                                  "b",
                                  "c",
                                  "x",
                                  "s.a",
                                  "s.c",
                                  "arr",
                                  "P",
                                  "N",
                                  "Ng",
                                  "I",
                                  "u",
                                  "v",
                                  "Ci",
                                  "time",
                                  "dPdu",
                                  "sin",
                                  "mix",
                                  "noise",
                                  "pnoise",
                                  "texture",
                                  "spline",
                                  "getattribute",
                                  "printf",
                                  "format",
                                  "transform",
                                  "sincos",
                                  "clamp",
                                  "mod",
                                  "rotate",
                                  "fresnel",
                                  "aastep",
                                  "diffuse",
                                  "emission",
                                  "microfacet",
                                  "isconnected",
                                  "arraylength",
                                  "split",
                                  "regex_match",
                                  "getmatrix",
                                  "setmessage",
                                  "getmessage",
                                  "pointcloud_search",
                                  "trace",
                                  "bump",
                                  "displace",
                                  "transformu",
                                  "hash",
                                  "Dx",
                                  "filterwidth",
                                  "area",
                                  "select",
                                  "faceforward",
                                  "substr",
                                  "concat",
                                  "dict_value",
                                  "f",
                                  "g",
                                  "__operator__add__",
                                  "__operator__neg__",
                                  "\"alpha\"",
                                  "\"wrap\"",
                                  "\"perlin\"",
                                  "\"%d %f %s\"",
                                  "\"\"",
                                  "\"a\\tb\"",
                                  "[[",
                                  "]]",
                                  "[[ int lockgeom = 0 ]]",
                                  "{1, 2, 3}",
                                  "{",
                                  "}",
                                  "(",
                                  ")",
                                  "[",
                                  "]",
                                  ";",
                                  ",",
                                  "?",
                                  ":",
                                  ".",
                                  ".x",
                                  "[0]",
                                  "[i]",
                                  "+",
                                  "-",
                                  "*",
                                  "/",
                                  "%",
                                  "<<",
                                  ">>",
                                  "<",
                                  ">",
                                  "<=",
                                  ">=",
                                  "==",
                                  "!=",
                                  "&",
                                  "|",
                                  "^",
                                  "~",
                                  "!",
                                  "&&",
                                  "||",
                                  "=",
                                  "+=",
                                  "*=",
                                  "/=",
                                  "<<=",
                                  "&=",
                                  "++",
                                  "--",
                                  "(color)",
                                  "(float)",
                                  "(int)",
                                  "color(1)",
                                  "matrix(1)",
                                  "vector(u, v, 0)",
                                  "\n#define F(x) x x\n",
                                  "\n#define A A B\n",
                                  "\n#define B(x, y) x ## y #x\n",
                                  "\n#if A(1)\n",
                                  "\n#endif\n",
                                  "\n#else\n",
                                  "\n#include \"a.h\"\n",
                                  "\n#include \"color4.h\"\n",
                                  "\n#pragma once\n",
                                  "\n#undef A\n",
                                  "F(F(1))",
                                  "B(a, b)",
                                  "A",
                                  "__LINE__",
                                  "//",
                                  "/*",
                                  "*/",
                                  "\\\n",
                                  "\"",
                                  "0x",
                                  "1e",
                                  "..",
                                  "$",
                                  "\x80"};
constexpr const char* kNumbers[] = {
    "0",       "1",     "2",     "3",          "-1",         "0.5",        "1.0",
    "1e38",    "1e-45", "1e400", "2147483647", "2147483648", "0xffffffff", "1048576",
    "1000000", "65536", "7.",    ".5",         "3f",         "0x",         "99999999999999999999"};

}  // namespace

std::string OslMutator::word() { return kWords[below(std::size(kWords))]; }
std::string OslMutator::number() { return kNumbers[below(std::size(kNumbers))]; }

OslMutator::Tokens OslMutator::tokensOf(std::string_view s) {
  Tokens out;
  for (size_t i = 0; i < s.size();) {
    const auto c = static_cast<unsigned char>(s[i]);
    size_t end = i + 1;
    const auto is = [&](auto test) {
      while (end < s.size() && test(static_cast<unsigned char>(s[end]))) ++end;
    };
    if (std::isalpha(c) || c == '_')
      is([](unsigned char d) { return std::isalnum(d) || d == '_'; });
    else if (std::isdigit(c))
      is([](unsigned char d) { return std::isalnum(d) || d == '.'; });
    else if (std::isspace(c))
      is([](unsigned char d) { return std::isspace(d); });
    else if (c == '"') {
      while (end < s.size() && s[end] != '"' && s[end] != '\n') ++end;
      end = std::min(end + 1, s.size());
    }
    out.emplace_back(s.substr(i, end - i));
    i = end;
  }
  return out;
}

// Of a number mostly, so that programs often compile; now and then of anything.
std::string OslMutator::expression(int depth) {
  static constexpr const char* kLeaves[] = {"u",      "v",      "a",    "b",   "1",       "2.5",    "-1",       "s.a",
                                            "arr[1]", "arr[i]", "c[0]", "P.x", "m[1][2]", "k[0].a", "k[i].c.y", "i"};
  static constexpr const char* kAny[] = {"c", "P", "s",   "k[i]",   "t",         "\"x\"", "m", "color(1, 2, 3)",
                                         "N", "k", "arr", "{1, 2}", "diffuse(N)"};
  if (below(200) == 0) return kAny[below(std::size(kAny))];
  if (depth <= 0 || below(4) == 0) return kLeaves[below(std::size(kLeaves))];
  const auto e = [&] { return expression(depth - 1); };
  static constexpr const char* kBinary[] = {"+", "-", "*", "/", "<", "==", "!=", "&&", "||", ">="};
  static constexpr const char* kOne[] = {"sin",  "noise", "abs",       "floor", "f",
                                         "sqrt", "exp",   "cellnoise", "Dx",    "hypot(1, 2) + "};
  static constexpr const char* kTwo[] = {"pow", "mod", "min", "noise", "atan2", "f", "hypot", "step", "fmod"};
  static constexpr const char* kThree[] = {"mix", "clamp", "smoothstep", "select", "linearstep"};
  static constexpr const char* kWrapped[] = {"luminance(color(", "length(vector(", "dot(P, vector(",
                                             "length(g(color(", "determinant(matrix("};
  static constexpr const char* kEffects[] = {"a++",        "--b",          "i++",       "arr[i]++",
                                             "(c *= 2).r", "(s = k[0]).a", "(s += s).a"};
  switch (below(12)) {
    case 0:
    case 1:
    case 2:
      return e() + " " + kBinary[below(std::size(kBinary))] + " " + e();
    case 3:
      return "(" + e() + ")";
    case 4:
      return std::string(below(2) ? "-" : "!") + "(" + e() + ")";
    case 5:
      return "(" + e() + " ? " + e() + " : " + e() + ")";
    case 6:
      return std::string(kOne[below(std::size(kOne))]) + "(" + e() + ")";
    case 7:
      return std::string(kThree[below(std::size(kThree))]) + "(" + e() + ", " + e() + ", " + e() + ")";
    case 8:
      return std::string(kTwo[below(std::size(kTwo))]) + "(" + e() + ", " + e() + ")";
    case 9: {
      const std::string w = kWrapped[below(std::size(kWrapped))];
      return w + e() + std::string(size_t(std::count(w.begin(), w.end(), '(')), ')');
    }
    case 10:
      return kEffects[below(std::size(kEffects))];
    default:
      return below(2) ? "(float) texture(\"f\", " + e() + ", v, \"alpha\", a)"
                      : "(float) spline(\"linear\", " + e() + ", arr)";
  }
}

std::string OslMutator::statement(int depth) {
  const auto block = [&] {
    std::string s = "{ ";
    for (uint32_t n = below(4); n > 0; --n) s += statement(depth - 1) + " ";
    return s + "}";
  };
  if (depth <= 0) return "a = " + expression(2) + ";";
  switch (below(12)) {
    case 0:
      return "if (" + expression(2) + ") " + block() + (below(2) ? " else " + block() : "");
    case 1:
      return "for (int i = 0; i < 4; ++i) " + block();
    case 2:
      return "while (" + expression(2) + ") { " + statement(depth - 1) + " break; }";
    case 3:
      return "do " + block() + " while (" + expression(1) + ");";
    case 4:
      return "float n" + std::to_string(below(50)) + " = " + expression(3) + ";";
    case 5:
      return "c = " + expression(3) + ";";
    case 6:
      return "arr[" + std::string(below(8) ? "i" : "i % 4") + "] = " + expression(2) + ";";
    case 7:
      return "s." + std::string(below(2) ? "a" : "c") + " = " + expression(2) + ";";
    case 8:
      return "g(" + expression(1) + ", a);";
    case 9:
      return below(2) ? "k[i] = s;" : "k[i] = S(" + expression(2) + ", color(" + expression(1) + "));";
    case 10:
      return "return;";
    default:
      return expression(3) + ";";
  }
}

std::string OslMutator::program() {
  std::string s =
      "struct S { float a; color c; };\n"
      "float f(float x) { if (x > 1) return x * 0.5; return x; }\n"
      "float f(float x, float y) { return x * y; }\n"
      "color g(color x) { return x; }\nvoid g(color x, output float y) { y += x[0]; }\n"
      "S __operator__add__(S a, S b) { return S(a.a + b.a, a.c + b.c); }\n"
      "surface t(float p = u * 2, S q = {1, 2}, output color r = 0) {\n"
      "float a = 1, b = 2; color c = 0; S s = {1, color(2)}; S k[3] = {{1, 2}, {3, 4}, {5, 6}}; float arr[4] = {1, "
      "2}; matrix m = 1; string t = "
      "\"x\"; int i = 0;\n";
  for (uint32_t n = 1 + below(8); n > 0; --n) s += statement(3) + "\n";
  return s + "r = c; }\n";
}

void OslMutator::change(Tokens& t, const Tokens& other) {
  const auto at = [&] { return t.begin() + long(below(t.size())); };
  if (t.empty()) {
    t.push_back(word());
    return;
  }
  const size_t most = 1 + below(below(4) == 0 ? 40 : 5);
  switch (below(10)) {
    case 0: {
      const auto i = at();
      t.erase(i, i + std::min<long>(long(most), t.end() - i));
      break;
    }
    case 1: {
      const auto i = at();
      const Tokens piece(i, i + std::min<long>(long(most), t.end() - i));
      t.insert(at(), piece.begin(), piece.end());
      break;
    }
    case 2:
      t.insert(at(), " " + word() + " ");
      break;
    case 3:
      *at() = word();
      break;
    case 4:
      *at() = number();
      break;
    case 5:
      std::swap(*at(), *at());
      break;
    case 6:
      if (!other.empty()) {
        const auto i = other.begin() + long(below(other.size()));
        t.insert(at(), i, i + std::min<long>(long(most) * 4, other.end() - i));
      }
      break;
    case 7: {  // many of one
      const std::string one = below(2) ? *at() : word();
      std::string many;
      for (uint32_t n = below(300); n > 0; --n) many += one + (below(8) ? "" : " ");
      t.insert(at(), many);
      break;
    }
    case 8:
      t.insert(at(), " " + statement(2) + " ");
      break;
    default: {
      std::string& s = *at();
      if (!s.empty()) s[below(s.size())] = char(below(256));
    }
  }
}

std::string OslMutator::mutate(const std::string& input, const std::string& other, size_t limit) {
  if (below(12) == 0) return program().substr(0, limit);
  Tokens t = tokensOf(input);
  const Tokens pieces = tokensOf(below(3) == 0 ? program() : other);
  for (uint32_t n = 1 + below(5); n > 0; --n) change(t, pieces);
  return textOf(t, limit);
}

}  // namespace kinora::fuzz
