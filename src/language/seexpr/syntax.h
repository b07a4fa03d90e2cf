// The tree of an expression in SeExpr's language (Walt Disney Animation Studios' expressions, versions 1 and 2):
// assignments, conditions and a last expression that is the result. Made by parse(), read by translate.cpp. It knows
// words and places alone; what names mean is the translator's.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::language::seexpr {

inline constexpr size_t kMostBytes = 64 * 1024;
inline constexpr uint32_t kDeepest = 100;  // of brackets, operators and conditions within each other

struct Place {
  uint32_t line = 1, column = 1;
};

struct Node {
  enum class Kind : uint8_t { Number, String, Variable, Vector, Component, Unary, Binary, Choice, Call, Assign, If };
  Kind kind;
  Place place;
  std::string text;  // name, operator ("+", "&&"), string; of an assignment the name
  double number = 0;
  std::vector<uint32_t> children;         // of Choice and If the condition first
  std::vector<uint32_t> body, otherwise;  // of If: statements
};

struct Tree {
  std::vector<Node> nodes;
  std::vector<uint32_t> statements;  // Assign and If
  uint32_t result = 0;
};

// Thrown by parse() and the translator: what is wrong, and where.
struct Refused {
  Place place;
  std::string what;
};

Tree parse(std::string_view text);

}  // namespace kinora::language::seexpr
