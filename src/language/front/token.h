// Tokens: what the lexer cuts source into, the preprocessor expands and the parser reads.
#pragma once
#include <cstdint>
#include <string_view>

#include "language/front/messages.h"
#include "language/front/names.h"

namespace kinora::language::front {

// clang-format off
enum class Punct : uint8_t {
  None, LParen, RParen, LBrace, RBrace, LBracket, RBracket, Dot, Comma, Semicolon, Colon, Question, Hash, HashHash,
  Plus, Minus, Star, Slash, Percent, Not, Tilde, Less, Greater, LessEq, GreaterEq, Equal, NotEqual, And, Or, Xor,
  AndAnd, OrOr, ShiftLeft, ShiftRight, Increment, Decrement,
  Assign, PlusAssign, MinusAssign, StarAssign, SlashAssign, AndAssign, OrAssign, XorAssign, ShiftLeftAssign,
  ShiftRightAssign, Ellipsis
};

// The first names of every compilation, in this order (Name = index + 1).
#define KN_LANGUAGE_KEYWORDS(X)                                                                                       \
  X(and) X(break) X(closure) X(color) X(continue) X(do) X(else) X(float) X(for) X(if) X(illuminance)          \
  X(illuminate) X(int) X(matrix) X(normal) X(not) X(or) X(output) X(point) X(public) X(return) X(string) X(struct)    \
  X(vector) X(void) X(while)                                                                                          \
  X(bool) X(case) X(catch) X(char) X(class) X(const) X(delete) X(default) X(double) X(enum) X(extern) X(false)        \
  X(friend) X(goto) X(inline) X(long) X(new) X(operator) X(private) X(protected) X(short) X(signed) X(sizeof)         \
  X(static) X(switch) X(template) X(this) X(throw) X(true) X(typedef) X(uniform) X(union) X(unsigned)          \
  X(varying) X(virtual) X(volatile)
// clang-format on
enum class Keyword : Name {
  None,
#define KN_X(word) k_##word,
  KN_LANGUAGE_KEYWORDS(KN_X)
#undef KN_X
      Count
};
constexpr Name kFirstReserved = Name(Keyword::k_bool);  // words kept for the future from here on

// Of operators with two operands, 1 the weakest; 0: no such operator.
constexpr int precedence(Punct p) {
  switch (p) {
    case Punct::OrOr:
      return 1;
    case Punct::AndAnd:
      return 2;
    case Punct::Or:
      return 3;
    case Punct::Xor:
      return 4;
    case Punct::And:
      return 5;
    case Punct::Equal:
    case Punct::NotEqual:
      return 6;
    case Punct::Less:
    case Punct::LessEq:
    case Punct::Greater:
    case Punct::GreaterEq:
      return 7;
    case Punct::ShiftLeft:
    case Punct::ShiftRight:
      return 8;
    case Punct::Plus:
    case Punct::Minus:
      return 9;
    case Punct::Star:
    case Punct::Slash:
    case Punct::Percent:
      return 10;
    default:
      return 0;
  }
}

struct Token {
  enum class Kind : uint8_t { End, Identifier, Number, String, Punct, Bad };
  Kind kind = Kind::End;
  Punct punct = Punct::None;
  bool isFirstOfLine = false, hasSpaceBefore = false;
  bool isPainted = false;  // an identifier that must not be expanded again
  Name name = 0;           // Identifier
  Pos pos;
  std::string_view text;  // as written; a String with its quotes
};

}  // namespace kinora::language::front
