#include "language/front/lexer.h"

#include <array>
#include <utility>

namespace kinora::language::front {

namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

// longest first
constexpr std::array<std::pair<std::string_view, Punct>, 46> kPuncts = {{
    {"<<=", Punct::ShiftLeftAssign},
    {">>=", Punct::ShiftRightAssign},
    {"...", Punct::Ellipsis},
    {"##", Punct::HashHash},
    {"<=", Punct::LessEq},
    {">=", Punct::GreaterEq},
    {"==", Punct::Equal},
    {"!=", Punct::NotEqual},
    {"&&", Punct::AndAnd},
    {"||", Punct::OrOr},
    {"<<", Punct::ShiftLeft},
    {">>", Punct::ShiftRight},
    {"++", Punct::Increment},
    {"--", Punct::Decrement},
    {"+=", Punct::PlusAssign},
    {"-=", Punct::MinusAssign},
    {"*=", Punct::StarAssign},
    {"/=", Punct::SlashAssign},
    {"&=", Punct::AndAssign},
    {"|=", Punct::OrAssign},
    {"^=", Punct::XorAssign},
    {"(", Punct::LParen},
    {")", Punct::RParen},
    {"{", Punct::LBrace},
    {"}", Punct::RBrace},
    {"[", Punct::LBracket},
    {"]", Punct::RBracket},
    {".", Punct::Dot},
    {",", Punct::Comma},
    {";", Punct::Semicolon},
    {":", Punct::Colon},
    {"?", Punct::Question},
    {"#", Punct::Hash},
    {"+", Punct::Plus},
    {"-", Punct::Minus},
    {"*", Punct::Star},
    {"/", Punct::Slash},
    {"%", Punct::Percent},
    {"!", Punct::Not},
    {"~", Punct::Tilde},
    {"<", Punct::Less},
    {">", Punct::Greater},
    {"=", Punct::Assign},
    {"&", Punct::And},
    {"|", Punct::Or},
    {"^", Punct::Xor},
}};

// first entry of kPuncts for each character, so that most are found at once
constexpr std::array<int8_t, 128> kFirstPunct = [] {
  std::array<int8_t, 128> first{};
  for (auto& f : first) f = -1;
  for (int i = int(kPuncts.size()) - 1; i >= 0; --i) first[size_t(kPuncts[size_t(i)].first[0])] = int8_t(i);
  return first;
}();

}  // namespace

Lexer::Lexer(std::string_view text, uint16_t file, Names& names, Messages& messages)
    : text_(text), file_(file), names_(names), messages_(messages) {
  if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;  // a byte order mark
}

void Lexer::newline() {
  ++line_;
  lineStart_ = at_;
  isFirst_ = true;
}

bool Lexer::skipBlank(bool stopAtNewline) {
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == '\n') {
      if (stopAtNewline) return true;
      ++at_;
      newline();
    } else if (c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f') {
      ++at_;
    } else if (c == '\\' && (at(1) == '\n' || (at(1) == '\r' && at(2) == '\n'))) {
      at_ += at(1) == '\n' ? 2 : 3;  // a line that goes on
      const bool wasFirst = isFirst_;
      newline();
      isFirst_ = wasFirst;
    } else if (c == '/' && at(1) == '/') {
      while (at_ < text_.size() && text_[at_] != '\n') {
        if (text_[at_] == '\\' && at(1) == '\n') {
          at_ += 2;
          const bool wasFirst = isFirst_;
          newline();
          isFirst_ = wasFirst;
        } else {
          ++at_;
        }
      }
    } else if (c == '/' && at(1) == '*') {
      const Pos begin{line_, uint16_t(at_ - lineStart_ < 65535 ? at_ - lineStart_ + 1 : 0), file_};
      at_ += 2;
      while (at_ < text_.size() && !(text_[at_] == '*' && at(1) == '/')) {
        ++at_;
        if (text_[at_ - 1] == '\n') {
          const bool wasFirst = isFirst_;
          newline();
          isFirst_ = wasFirst;
        }
      }
      if (at_ >= text_.size()) {
        messages_.error(begin, "this comment has no end");
        return stopAtNewline;
      }
      at_ += 2;
    } else {
      return false;
    }
    hasSpace_ = true;
  }
  return stopAtNewline;
}

void Lexer::skipLine() {
  while (at_ < text_.size() && text_[at_] != '\n') {
    // strings and comments may hold what looks like a comment or a line's end
    if (text_[at_] == '/' && (at(1) == '*' || at(1) == '/')) {
      if (skipBlank(true)) break;
    } else if (text_[at_] == '\\' && at(1) == '\n') {
      at_ += 2;
      newline();
    } else {
      ++at_;
    }
  }
  if (at_ < text_.size()) {
    ++at_;
    newline();
  }
}

bool Lexer::nextInLine(Token& token) {
  if (skipBlank(true)) return false;
  token = next();
  return token.kind != Token::Kind::End;
}

Token Lexer::string(Token t) {
  size_t i = at_ + 1;
  while (i < text_.size() && text_[i] != '"' && text_[i] != '\n') {
    if (text_[i] == '\\' && i + 1 < text_.size()) {
      if (text_[i + 1] == '\n') {  // goes on in the next line
        ++line_;
        lineStart_ = i + 2;
      }
      ++i;
    }
    ++i;
  }
  if (i >= text_.size() || text_[i] != '"') {
    messages_.error(t.pos, "this string has no closing quote");
    i = i < text_.size() ? i : text_.size();
    t.kind = Token::Kind::String;
    t.text = "\"\"";
    at_ = i;
    return t;
  }
  t.kind = Token::Kind::String;
  t.text = text_.substr(at_, i + 1 - at_);
  at_ = i + 1;
  return t;
}

Token Lexer::next() {
  skipBlank(false);
  Token t;
  const size_t column = at_ - lineStart_ + 1;
  t.pos = {line_, uint16_t(column < 65536 ? column : 0), file_};
  t.isFirstOfLine = isFirst_;
  t.hasSpaceBefore = hasSpace_;
  hasSpace_ = false;
  if (at_ >= text_.size()) {
    t.isFirstOfLine = true;
    return t;
  }
  isFirst_ = false;
  const char c = text_[at_];
  if (isLetter(c)) {
    size_t i = at_ + 1;
    while (i < text_.size() && (isLetter(text_[i]) || isDigit(text_[i]))) ++i;
    t.kind = Token::Kind::Identifier;
    t.text = text_.substr(at_, i - at_);
    t.name = names_.intern(t.text);
    at_ = i;
    return t;
  }
  if (isDigit(c) || (c == '.' && isDigit(at(1)))) {
    size_t i = at_ + 1;
    while (i < text_.size()) {
      const char d = text_[i];
      const bool isExponent = (text_[i - 1] == 'e' || text_[i - 1] == 'E') && !(c == '0' && (at(1) | 32) == 'x');
      if (!(isDigit(d) || isLetter(d) || d == '.' || ((d == '+' || d == '-') && isExponent))) break;
      ++i;
    }
    t.kind = Token::Kind::Number;
    t.text = text_.substr(at_, i - at_);
    at_ = i;
    return t;
  }
  if (c == '"') return string(t);
  if (static_cast<unsigned char>(c) < 128 && kFirstPunct[size_t(c)] >= 0) {
    for (size_t i = size_t(kFirstPunct[size_t(c)]); i < kPuncts.size(); ++i) {
      const auto& [text, punct] = kPuncts[i];
      if (text_.substr(at_, text.size()) != text) continue;
      t.kind = Token::Kind::Punct;
      t.punct = punct;
      t.text = text_.substr(at_, text.size());
      at_ += text.size();
      return t;
    }
  }
  size_t i = at_ + 1;
  while (i < text_.size() && static_cast<unsigned char>(text_[i]) >= 128) ++i;  // one message for a whole word
  t.kind = Token::Kind::Bad;
  t.text = text_.substr(at_, i - at_);
  at_ = i;
  return t;
}

std::string unescaped(std::string_view quoted, std::string& wrong) {
  std::string s;
  if (quoted.size() < 2) return s;
  quoted = quoted.substr(1, quoted.size() - 2);
  s.reserve(quoted.size());
  for (size_t i = 0; i < quoted.size(); ++i) {
    char c = quoted[i];
    if (c != '\\' || i + 1 >= quoted.size()) {
      s += c;
      continue;
    }
    c = quoted[++i];
    switch (c) {
      case 'n':
        s += '\n';
        break;
      case 't':
        s += '\t';
        break;
      case 'r':
        s += '\r';
        break;
      case 'v':
        s += '\v';
        break;
      case 'f':
        s += '\f';
        break;
      case 'a':
        s += '\a';
        break;
      case 'b':
        s += '\b';
        break;
      case '\\':
      case '"':
      case '\'':
      case '?':
        s += c;
        break;
      case '\n':
        break;
      case '\r':
        if (i + 1 < quoted.size() && quoted[i + 1] == '\n') ++i;
        break;
      default:
        if (c >= '0' && c <= '7') {
          unsigned v = 0;
          size_t n = 0;
          while (n < 3 && i < quoted.size() && quoted[i] >= '0' && quoted[i] <= '7')
            v = v * 8 + unsigned(quoted[i++] - '0'), ++n;
          --i;
          s += char(v);
        } else {  // kept as it stands, as C compilers do
          wrong = std::string("\\") + c;
          s += '\\';
          s += c;
        }
    }
  }
  return s;
}

}  // namespace kinora::language::front
