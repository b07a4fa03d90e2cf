#include <charconv>
#include <cctype>
#include <cmath>

#include "language/seexpr/syntax.h"

namespace kinora::language::seexpr {

namespace {

struct Token {
  enum class Kind : uint8_t { End, Number, String, Name, Symbol };
  Kind kind = Kind::End;
  Place place;
  std::string text;
  double number = 0;
};

bool isNameStart(char c) { return std::isalpha(static_cast<unsigned char>(c)) || c == '_'; }
bool isNamePart(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }
bool isDigit(char c) { return c >= '0' && c <= '9'; }

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  Token next() {
    skip();
    Token t;
    t.place = place_;
    if (at_ >= text_.size()) return t;
    const char c = text_[at_];
    if (isDigit(c) || (c == '.' && isDigit(peek(1)))) return number(t);
    if (c == '"' || c == '\'') return string(t);
    if (isNameStart(c) || (c == '$' && isNameStart(peek(1)))) return name(t);
    t.kind = Token::Kind::Symbol;
    static constexpr std::string_view kLong[] = {"->", "==", "!=", "<=", ">=", "&&", "||",
                                                 "+=", "-=", "*=", "/=", "%=", "^="};
    for (const std::string_view s : kLong)
      if (text_.substr(at_).starts_with(s)) return take(t, s.size());
    if (std::string_view("()[]{}<>+-*/%^!~?:,;=").find(c) != std::string_view::npos) return take(t, 1);
    throw Refused{place_, std::isprint(static_cast<unsigned char>(c))
                              ? "'" + std::string(1, c) + "' means nothing here"
                              : "a character that means nothing here"};
  }

 private:
  char peek(size_t ahead) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  void advance() {
    if (text_[at_++] == '\n')
      ++place_.line, place_.column = 1;
    else
      ++place_.column;
  }
  Token& take(Token& t, size_t n) {
    t.text += text_.substr(at_, n);
    for (size_t i = 0; i < n; ++i) advance();
    return t;
  }
  // Blanks, comments and a backslash at the end of a line, which exporters leave in.
  void skip() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') advance();
      } else if (std::isspace(static_cast<unsigned char>(c)) || (c == '\\' && (peek(1) == '\n' || peek(1) == '\r'))) {
        advance();
      } else {
        return;
      }
    }
  }
  Token number(Token& t) {
    t.kind = Token::Kind::Number;
    size_t n = 0;
    while (isDigit(peek(n))) ++n;
    if (peek(n) == '.') ++n;
    while (isDigit(peek(n))) ++n;
    if (peek(n) == 'e' || peek(n) == 'E') {
      const size_t sign = peek(n + 1) == '-' || peek(n + 1) == '+' ? 1 : 0;
      if (isDigit(peek(n + 1 + sign))) {
        n += 1 + sign;
        while (isDigit(peek(n))) ++n;
      }
    }
    take(t, n);
    const auto read = std::from_chars(t.text.data(), t.text.data() + t.text.size(), t.number);
    if (read.ec != std::errc() || !(std::fabs(t.number) <= 3e38))
      throw Refused{t.place, t.text + " is no number that fits"};
    return t;
  }
  Token string(Token& t) {
    t.kind = Token::Kind::String;
    const char quote = text_[at_];
    advance();
    while (at_ < text_.size() && text_[at_] != quote) {
      t.text += text_[at_];
      advance();
    }
    if (at_ >= text_.size()) throw Refused{t.place, "a string that never ends"};
    advance();
    return t;
  }
  Token name(Token& t) {
    t.kind = Token::Kind::Name;
    if (text_[at_] == '$') advance();
    for (;;) {
      size_t n = 0;
      while (isNamePart(peek(n))) ++n;
      take(t, n);
      if (peek(0) != ':' || peek(1) != ':' || !isNameStart(peek(2))) return t;
      take(t, 2);
    }
  }

  std::string_view text_;
  size_t at_ = 0;
  Place place_;
};

// Recursive descent; operators from loose to tight.
class Parser {
 public:
  explicit Parser(std::string_view text) : lexer_(text) { advance(), advance(); }

  Tree run() {
    while (isStatement()) tree_.statements.push_back(statement());
    if (token_.kind == Token::Kind::End) fail("the result is missing: an expression behind the last ';'");
    tree_.result = expression();
    if (is(";")) advance();
    if (token_.kind != Token::Kind::End) fail("'" + token_.text + "' behind the result");
    return std::move(tree_);
  }

 private:
  struct Deeper {
    explicit Deeper(Parser& p) : parser(p) {
      if (++parser.depth_ > kDeepest) parser.fail("more than " + std::to_string(kDeepest) + " levels of nesting");
    }
    ~Deeper() { --parser.depth_; }
    Parser& parser;
  };

  [[noreturn]] void fail(std::string what) const { throw Refused{token_.place, std::move(what)}; }
  void advance() {
    token_ = std::move(ahead_);
    ahead_ = lexer_.next();
  }
  bool is(std::string_view symbol) const { return token_.kind == Token::Kind::Symbol && token_.text == symbol; }
  bool isWord(std::string_view word) const { return token_.kind == Token::Kind::Name && token_.text == word; }
  void expect(std::string_view symbol) {
    if (!is(symbol))
      fail("'" + std::string(symbol) + "' is missing" +
           (token_.kind == Token::Kind::End ? "" : " before '" + token_.text + "'"));
    advance();
  }
  uint32_t add(Node::Kind kind, Place place, std::string text, std::vector<uint32_t> children = {}) {
    Node n{kind, place, std::move(text), 0, std::move(children), {}, {}};
    tree_.nodes.push_back(std::move(n));
    return uint32_t(tree_.nodes.size() - 1);
  }

  bool isStatement() const {
    if (isWord("if")) return true;
    static constexpr std::string_view kAssign[] = {"=", "+=", "-=", "*=", "/=", "%=", "^="};
    if (token_.kind != Token::Kind::Name || ahead_.kind != Token::Kind::Symbol) return isWord("def");
    for (const std::string_view s : kAssign)
      if (ahead_.text == s) return true;
    return false;
  }
  uint32_t statement() {
    const Deeper level(*this);
    if (isWord("def")) fail("functions of one's own (def) are not understood");
    if (isWord("if")) return condition();
    const Place place = token_.place;
    const std::string name = token_.text;
    advance();
    const std::string how = token_.text;
    advance();
    uint32_t value = expression();
    if (how != "=")
      value = add(Node::Kind::Binary, place, how.substr(0, 1), {add(Node::Kind::Variable, place, name), value});
    expect(";");
    return add(Node::Kind::Assign, place, name, {value});
  }
  uint32_t condition() {
    const Place place = token_.place;
    advance();
    expect("(");
    const uint32_t test = expression();
    expect(")");
    std::vector<uint32_t> body = block(), otherwise;
    if (isWord("else")) {
      advance();
      if (isWord("if"))
        otherwise.push_back(statement());
      else
        otherwise = block();
    }
    const uint32_t n = add(Node::Kind::If, place, "if", {test});
    tree_.nodes[n].body = std::move(body);
    tree_.nodes[n].otherwise = std::move(otherwise);
    return n;
  }
  std::vector<uint32_t> block() {
    std::vector<uint32_t> list;
    expect("{");
    while (isStatement()) list.push_back(statement());
    expect("}");
    return list;
  }

  // value -> name(more): the value becomes the first argument.
  uint32_t expression() {
    const Deeper level(*this);
    uint32_t left = choice();
    while (is("->")) {
      advance();
      if (token_.kind != Token::Kind::Name) fail("the name of a function is missing behind '->'");
      const Place place = token_.place;
      std::string name = token_.text;
      advance();
      std::vector<uint32_t> arguments = {left};
      list("(", ")", arguments);
      left = add(Node::Kind::Call, place, std::move(name), std::move(arguments));
    }
    return left;
  }
  uint32_t choice() {
    const Deeper level(*this);
    const uint32_t test = binary(0);
    if (!is("?")) return test;
    const Place place = token_.place;
    advance();
    const uint32_t yes = choice();
    expect(":");
    const uint32_t no = choice();
    return add(Node::Kind::Choice, place, "?", {test, yes, no});
  }
  static int levelOf(std::string_view symbol) {
    static constexpr std::string_view kLevels[][4] = {
        {"||"}, {"&&"}, {"==", "!="}, {"<", ">", "<=", ">="}, {"+", "-"}, {"*", "/", "%"}};
    for (int l = 0; l < 6; ++l)
      for (const std::string_view s : kLevels[l])
        if (!s.empty() && s == symbol) return l;
    return -1;
  }
  uint32_t binary(int level) {
    if (level > 5) return unary();
    uint32_t left = binary(level + 1);
    while (token_.kind == Token::Kind::Symbol && levelOf(token_.text) == level) {
      const Place place = token_.place;
      std::string symbol = token_.text;
      advance();
      left = add(Node::Kind::Binary, place, std::move(symbol), {left, binary(level + 1)});
    }
    return left;
  }
  uint32_t unary() {
    if (!is("-") && !is("+") && !is("!") && !is("~")) return power();
    const Deeper level(*this);
    const Place place = token_.place;
    std::string symbol = token_.text;
    advance();
    const uint32_t value = unary();
    return symbol == "+" ? value : add(Node::Kind::Unary, place, std::move(symbol), {value});
  }
  uint32_t power() {
    const uint32_t base = component();
    if (!is("^")) return base;
    const Deeper level(*this);
    const Place place = token_.place;
    advance();
    return add(Node::Kind::Binary, place, "^", {base, unary()});
  }
  uint32_t component() {
    uint32_t value = primary();
    while (is("[")) {
      const Place place = token_.place;
      advance();
      const uint32_t index = expression();
      expect("]");
      value = add(Node::Kind::Component, place, "[]", {value, index});
    }
    return value;
  }
  uint32_t primary() {
    const Place place = token_.place;
    if (token_.kind == Token::Kind::Number) {
      const uint32_t n = add(Node::Kind::Number, place, token_.text);
      tree_.nodes[n].number = token_.number;
      advance();
      return n;
    }
    if (token_.kind == Token::Kind::String) {
      const uint32_t n = add(Node::Kind::String, place, token_.text);
      advance();
      return n;
    }
    if (token_.kind == Token::Kind::Name) {
      std::string name = token_.text;
      advance();
      if (!is("(")) return add(Node::Kind::Variable, place, std::move(name));
      std::vector<uint32_t> arguments;
      list("(", ")", arguments);
      return add(Node::Kind::Call, place, std::move(name), std::move(arguments));
    }
    if (is("(")) {
      advance();
      const uint32_t value = expression();
      expect(")");
      return value;
    }
    if (is("[")) {
      std::vector<uint32_t> elements;
      list("[", "]", elements);
      return add(Node::Kind::Vector, place, "[]", std::move(elements));
    }
    fail(token_.kind == Token::Kind::End ? "the end comes where a value is expected"
                                         : "'" + token_.text + "' stands where a value is expected");
  }
  void list(std::string_view open, std::string_view close, std::vector<uint32_t>& to) {
    expect(open);
    if (!is(close)) {
      to.push_back(expression());
      while (is(",")) {
        advance();
        to.push_back(expression());
      }
    }
    expect(close);
  }

  Lexer lexer_;
  Token token_, ahead_;
  Tree tree_;
  uint32_t depth_ = 0;
};

}  // namespace

Tree parse(std::string_view text) {
  if (text.size() > kMostBytes)
    throw Refused{{1, 1}, "it is longer than " + std::to_string(kMostBytes / 1024) + " kB"};
  return Parser(text).run();
}

}  // namespace kinora::language::seexpr
