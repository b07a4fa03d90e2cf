// The expression of #if and #elif: integers, names (0), defined, the operators of C.
#include <charconv>

#include "language/front/preprocessor.h"

namespace kinora::language::front {

namespace {

class Evaluator {
 public:
  Evaluator(const std::vector<Token>& tokens, Pos end, Messages& messages)
      : tokens_(tokens), end_(end), messages_(messages) {}
  int64_t run() {
    const int64_t v = ternary();
    if (at_ < tokens_.size()) wrong("this does not belong to the condition");
    return isWrong_ ? 0 : v;
  }

 private:
  Punct punct() const { return at_ < tokens_.size() && !isWrong_ ? tokens_[at_].punct : Punct::None; }
  bool take(Punct p) {
    if (punct() != p) return false;
    ++at_;
    return true;
  }
  void wrong(const char* what) {
    if (!isWrong_) messages_.error(at_ < tokens_.size() ? tokens_[at_].pos : end_, what);
    isWrong_ = true;
  }
  bool tooDeep() {
    if (depth_ > 200) wrong("this condition is nested too deeply");
    return isWrong_;
  }

  int64_t ternary() {
    ++depth_;
    int64_t v = tooDeep() ? 0 : binary(0);
    if (!isWrong_ && take(Punct::Question)) {
      const int64_t a = ternary();
      if (!take(Punct::Colon)) wrong("expected ':'");
      const int64_t b = ternary();
      v = v ? a : b;
    }
    --depth_;
    return v;
  }
  int64_t binary(int above) {
    int64_t a = unary();
    for (;;) {
      const Punct op = punct();
      const int p = precedence(op);
      if (p <= above || isWrong_) return a;
      ++at_;
      ++depth_;
      const int64_t b = tooDeep() ? 0 : binary(p);
      --depth_;
      a = apply(op, a, b);
    }
  }
  // wraps as unsigned arithmetic does
  static int64_t apply(Punct op, int64_t a, int64_t b) {
    const auto u = uint64_t(a), w = uint64_t(b);
    switch (op) {
      case Punct::OrOr:
        return a || b;
      case Punct::AndAnd:
        return a && b;
      case Punct::Or:
        return a | b;
      case Punct::Xor:
        return a ^ b;
      case Punct::And:
        return a & b;
      case Punct::Equal:
        return a == b;
      case Punct::NotEqual:
        return a != b;
      case Punct::Less:
        return a < b;
      case Punct::LessEq:
        return a <= b;
      case Punct::Greater:
        return a > b;
      case Punct::GreaterEq:
        return a >= b;
      case Punct::ShiftLeft:
        return w < 64 ? int64_t(u << w) : 0;
      case Punct::ShiftRight:
        return w < 64 ? a >> b : 0;
      case Punct::Plus:
        return int64_t(u + w);
      case Punct::Minus:
        return int64_t(u - w);
      case Punct::Star:
        return int64_t(u * w);
      case Punct::Slash:
        return b == 0 ? 0 : b == -1 ? int64_t(0 - u) : a / b;
      case Punct::Percent:
        return b == 0 || b == -1 ? 0 : a % b;
      default:
        return 0;
    }
  }
  int64_t unary() {
    bool isNot = false, isMinus = false, isComplement = false;
    ++depth_;
    int64_t v = 0;
    if (tooDeep()) {
    } else if (take(Punct::Not)) {
      isNot = true;
      v = unary();
    } else if (take(Punct::Minus)) {
      isMinus = true;
      v = unary();
    } else if (take(Punct::Tilde)) {
      isComplement = true;
      v = unary();
    } else if (take(Punct::Plus)) {
      v = unary();
    } else if (take(Punct::LParen)) {
      v = ternary();
      if (!take(Punct::RParen)) wrong("expected ')'");
    } else if (at_ < tokens_.size() && tokens_[at_].kind == Token::Kind::Number) {
      std::string_view text = tokens_[at_].text;
      int base = 10;
      if (text.size() > 2 && text[0] == '0' && (text[1] | 32) == 'x') {
        base = 16;
        text.remove_prefix(2);
      }
      while (!text.empty() && ((text.back() | 32) == 'l' || (text.back() | 32) == 'u')) text.remove_suffix(1);
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v, base);
      if (error != std::errc() || end != text.data() + text.size()) wrong("conditions are about whole numbers");
      ++at_;
    } else if (at_ < tokens_.size() && tokens_[at_].kind == Token::Kind::Identifier) {
      ++at_;  // a name that is no macro
    } else {
      wrong("expected a number");
    }
    --depth_;
    if (isNot) return !v;
    if (isMinus) return int64_t(0 - uint64_t(v));
    return isComplement ? ~v : v;
  }

  const std::vector<Token>& tokens_;
  Pos end_;
  Messages& messages_;
  size_t at_ = 0;
  int depth_ = 0;
  bool isWrong_ = false;
};

}  // namespace

bool Preprocessor::condition(const Token& at) {
  const std::vector<Token> line = restOfLine();
  std::vector<Token> tokens;
  for (size_t i = 0; i < line.size(); ++i) {
    Token t = line[i];
    if (t.kind == Token::Kind::Identifier && t.name == defined_) {
      const bool hasParen = i + 1 < line.size() && line[i + 1].punct == Punct::LParen;
      const size_t n = i + (hasParen ? 2 : 1);
      if (n >= line.size() || line[n].kind != Token::Kind::Identifier ||
          (hasParen && (n + 1 >= line.size() || line[n + 1].punct != Punct::RParen))) {
        messages_.error(t.pos, "'defined' needs a name");
        return false;
      }
      t.kind = Token::Kind::Number;
      t.name = 0;
      t.text = macroOf(line[n].name) ? "1" : "0";
      i = n + (hasParen ? 1 : 0);
    }
    tokens.push_back(t);
  }
  if (tokens.empty()) {
    messages_.error(at.pos, "#" + std::string(at.text) + " without a condition");
    return false;
  }
  return Evaluator(expandedAlone(tokens), at.pos, messages_).run() != 0;
}

}  // namespace kinora::language::front
