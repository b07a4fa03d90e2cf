#include "rib/lexer.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/memory.h"
#include "base/text.h"

namespace kinora::rib {

namespace {

constexpr size_t kAhead = 512;  // bytes that any ASCII number or word may look ahead
constexpr size_t kMostArguments = 65536;

enum CharClass : uint8_t { kOther, kSpace, kDigit, kSign, kLetter };
constexpr std::array<uint8_t, 256> kClass = [] {
  std::array<uint8_t, 256> t{};
  for (unsigned char c : {' ', '\t', '\r', '\n', '\f', '\v', '\0'}) t[c] = kSpace;
  for (int c = '0'; c <= '9'; ++c) t[size_t(c)] = kDigit;
  t['.'] = kDigit;
  t['+'] = t['-'] = kSign;
  for (int c = 'a'; c <= 'z'; ++c) t[size_t(c)] = t[size_t(c - 32)] = kLetter;
  t['_'] = kLetter;
  return t;
}();
uint8_t classOf(char c) { return kClass[static_cast<unsigned char>(c)]; }

bool isDelimiter(char c) {
  return classOf(c) == kSpace || c == '[' || c == ']' || c == '"' || c == '\'' || c == '#' || (c & 0x80);
}

constexpr double kPowersOfTen[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                   1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

}  // namespace

Lexer::Lexer(std::unique_ptr<ByteSource> source, std::string_view name, Diagnostics& messages, IsRequest isRequest)
    : source_(std::move(source)), file_(name), messages_(messages), isRequest_(isRequest) {}

void Lexer::complain(Severity s, const char* code, std::string what, std::string done, std::string advice) {
  messages_.report({s, code, {file_, line_}, std::move(what), std::move(done), std::move(advice)});
}

bool Lexer::refill() {
  if (sourceEnded_) return false;
  const size_t left = size_t(end_ - cursor_);
  if (buffer_.empty()) buffer_.resize(kBuffer);
  if (left > 0) std::memmove(buffer_.data(), cursor_, left);
  const size_t n = source_->read(buffer_.data() + left, buffer_.size() - left);
  cursor_ = buffer_.data();
  end_ = cursor_ + left + n;
  bytes_ += n;
  // numbers of one request pile up before anything is made of them
  constexpr uint64_t kLookEvery = 16 * kBuffer;
  if (bytes_ / kLookEvery != (bytes_ - n) / kLookEvery) Memory::check(MemoryUse::Description);
  if (n == 0) {
    sourceEnded_ = true;
    if (const std::string why = source_->failure(); !why.empty())
      complain(Severity::Error, "RIB-TRUNCATED", "the file cannot be read to its end: " + why,
               "what came before is used");
  }
  return n > 0;
}

// Of a character just taken: a line ends with LF, CR LF, or the CR of old Macintoshes.
bool Lexer::endsLine(char c) {
  if (c != '\r') return c == '\n';
  return (cursor_ == end_ && !refill()) || *cursor_ != '\n';
}

void Lexer::skipSpace() {
  while (cursor_ != end_ && classOf(*cursor_) == kSpace)
    if (const char c = *cursor_++; c != ' ') line_ += endsLine(c);
}

// Editors of other systems put U+FEFF in front of UTF-8 text; as binary RIB its first byte means nothing.
void Lexer::skipByteOrderMark() {
  ensure(3);
  if (end_ - cursor_ >= 3 && std::memcmp(cursor_, "\xef\xbb\xbf", 3) == 0) cursor_ += 3;
}

bool Lexer::byte(unsigned char& b) {
  if (cursor_ == end_ && !refill()) return false;
  b = static_cast<unsigned char>(*cursor_++);
  return true;
}

Lexer::Token Lexer::next() {
  wordIsRequest_ = false;
  if (bytes_ == 0 && !sourceEnded_) skipByteOrderMark();
  for (;;) {
    if (ended_) return Token::End;
    skipSpace();
    if (cursor_ == end_) {
      if (refill()) continue;
      ended_ = true;
      return Token::End;
    }
    const char c = *cursor_;
    if (c == '#') {
      for (;;) {
        const void* nl = std::memchr(cursor_, '\n', size_t(end_ - cursor_));
        const char* const to = nl ? static_cast<const char*>(nl) : end_;
        const void* cr = std::memchr(cursor_, '\r', size_t(to - cursor_));
        cursor_ = cr ? static_cast<const char*>(cr) : to;
        if (nl || cr || !refill()) break;
      }
      continue;
    }
    ensure(kAhead);
    lastTokenLine_ = tokenLine_;
    tokenLine_ = line_;
    const auto lead = static_cast<unsigned char>(c);
    if (lead & 0x80) {
      ++cursor_;
      const Token t = binary(lead);
      if (t == Token::End && !ended_) continue;  // a definition, or a code that means nothing
      return t;
    }
    switch (classOf(c)) {
      case kDigit:
      case kSign:
        if (const Token t = number(); t != Token::End) return t;
        continue;
      case kLetter:
        return word();
      default:
        break;
    }
    if (c == '[') return ++cursor_, Token::ArrayBegin;
    if (c == ']') return ++cursor_, Token::ArrayEnd;
    if (c == '"') return ++cursor_, asciiString('"');
    if (c == '\'') {
      const char* close = cursor_ + 1;
      while (close != end_ && *close != '\'' && *close != '\n' && *close != '\r') ++close;
      if (close != end_ && *close == '\'') {
        complain(Severity::Warning, "RIB-QUOTES", "a string stands in single quotes", "it is read as a string",
                 "write it in double quotes");
        ++cursor_;
        return asciiString('\'');
      }
    }
    junk();
  }
}

void Lexer::junk() {
  const char* begin = cursor_++;
  while (cursor_ != end_ && !isDelimiter(*cursor_)) ++cursor_;
  if (syntaxMessages_++ == 0)
    complain(Severity::Error, "RIB-SYNTAX",
             "'" + std::string(begin, std::min<size_t>(size_t(cursor_ - begin), 40)) + "' is not RIB",
             "it is skipped", "a quote or '#' may be missing before it");
}

bool Lexer::parseNumber(double& value, bool& isInteger) {
  numberBegin_ = cursor_;
  const char* p = cursor_;
  const bool negative = *p == '-';
  if (*p == '-' || *p == '+') ++p;
  const char* const digits = p;
  uint64_t mantissa = 0;
  while (p != end_ && unsigned(*p - '0') < 10) mantissa = mantissa * 10 + unsigned(*p++ - '0');
  long count = p - digits;
  int exponent = 0;
  isInteger = true;
  if (p != end_ && *p == '.') {
    isInteger = false;
    const char* const fraction = ++p;
    while (p != end_ && unsigned(*p - '0') < 10) mantissa = mantissa * 10 + unsigned(*p++ - '0');
    exponent = -int(p - fraction);
    count += p - fraction;
  }
  if (count == 0) return false;
  if (p != end_ && (*p == 'e' || *p == 'E')) {
    const char* q = p + 1;
    const bool down = q != end_ && *q == '-';
    if (q != end_ && (*q == '-' || *q == '+')) ++q;
    if (q != end_ && unsigned(*q - '0') < 10) {
      int e = 0;
      while (q != end_ && unsigned(*q - '0') < 10) e = std::min(e * 10 + (*q++ - '0'), 100000);
      exponent += down ? -e : e;
      isInteger = false;
      p = q;
    }
  }
  // 15 digits and 22 powers of ten are exact in a double, so that one rounding gives the right answer (Clinger 1990)
  if (count <= 15 && exponent >= -22 && exponent <= 22) {
    value = double(mantissa);
    if (exponent < 0)
      value /= kPowersOfTen[-exponent];
    else if (exponent > 0)
      value *= kPowersOfTen[exponent];
    if (negative) value = -value;
  } else {
    const char* begin = *cursor_ == '+' ? cursor_ + 1 : cursor_;
    const auto result = std::from_chars(begin, p, value);
    if (result.ec == std::errc::result_out_of_range) {
      // from_chars does not say which way: the place of the first digit that counts does
      long zeros = 0;
      for (const char* q = digits; q != p && (*q == '0' || *q == '.'); ++q) zeros += *q == '0';
      value = exponent + count - zeros > 0 ? std::numeric_limits<double>::infinity() : 0.0;
      if (negative) value = -value;
    }
  }
  if (p == end_ && !sourceEnded_ && size_t(end_ - cursor_) < kBuffer) {  // it may go on in the next bytes
    refill();
    return parseNumber(value, isInteger);
  }
  if (isInteger && (value > 2147483647.0 || value < -2147483648.0)) isInteger = false;
  cursor_ = p;
  return true;
}

Lexer::Token Lexer::number() {
  if (!parseNumber(value_, isInteger_)) {
    // "-inf" and "-nan", as C's printf writes them
    const char* p = cursor_ + 1;
    text_.clear();
    while (p != end_ && classOf(*p) == kLetter && text_.size() <= 8) text_ += *p++;
    if ((p == end_ || isDelimiter(*p)) && wordToNumber()) {
      if (*cursor_ == '-') value_ = -value_;
      cursor_ = p;
      return Token::Number;
    }
    junk();
    return Token::End;
  }
  if (cursor_ != end_ && !isDelimiter(*cursor_)) {
    while (cursor_ != end_ && !isDelimiter(*cursor_)) ++cursor_;
    const std::string whole(numberBegin_, std::min<size_t>(size_t(cursor_ - numberBegin_), 40));
    if (syntaxMessages_++ == 0)
      complain(Severity::Error, "RIB-SYNTAX", "'" + whole + "' begins as a number and goes on",
               "the number is used, the rest skipped");
  }
  return Token::Number;
}

Lexer::Token Lexer::word() {
  text_.clear();
  for (;;) {
    const char* begin = cursor_;
    while (cursor_ != end_ && !isDelimiter(*cursor_)) ++cursor_;
    if (text_.size() < kMostText) text_.append(begin, cursor_);
    if (cursor_ != end_ || !refill()) return Token::Word;
  }
}

bool Lexer::wordToNumber() {
  if (text_.size() > 8) return false;
  const std::string lower = lowerCase(text_);
  if (lower == "nan")
    value_ = std::numeric_limits<double>::quiet_NaN();
  else if (lower == "inf" || lower == "infinity")
    value_ = std::numeric_limits<double>::infinity();
  else
    return false;
  isInteger_ = false;
  return true;
}

bool Lexer::looksLikeNewRequest(const char* p) const {
  while (p != end_ && classOf(*p) == kSpace) ++p;
  const char* begin = p;
  while (p != end_ && std::isalnum(static_cast<unsigned char>(*p))) ++p;
  return p != begin && p != end_ && (classOf(*p) == kSpace) && isRequest_(std::string_view(begin, size_t(p - begin)));
}

Lexer::Token Lexer::asciiString(char quote) {
  text_.clear();
  const uint32_t openedAt = line_;
  const auto unclosed = [&](const char* done) {
    messages_.report({Severity::Error,
                      "RIB-STRING",
                      {file_, openedAt},
                      "the string \"" + text_.substr(0, 40) + "\" has no closing quote",
                      done,
                      {}});
    if (const size_t eol = text_.find_first_of("\r\n"); eol != std::string::npos) text_.resize(eol);
    return Token::String;
  };
  for (;;) {
    const char* begin = cursor_;
    while (cursor_ != end_ && *cursor_ != quote && *cursor_ != '\\' && *cursor_ != '\n' && *cursor_ != '\r')
      ++cursor_;
    if (text_.size() < kMostText) text_.append(begin, cursor_);
    if (cursor_ == end_) {
      if (refill()) continue;
      return unclosed("it ends with its line");
    }
    const char c = *cursor_;
    if (c == quote) return ++cursor_, Token::String;
    ensure(kAhead);
    if (c == '\n' || c == '\r') {
      if (looksLikeNewRequest(cursor_ + 1)) return unclosed("it ends with its line");
      ++cursor_;
      line_ += endsLine(c);
      text_ += c;
      continue;
    }
    // escapes: section 1 of the RIB reference; an unknown one stands for its character
    ++cursor_;
    if (cursor_ == end_) continue;
    const char e = *cursor_++;
    switch (e) {
      case 'n':
        text_ += '\n';
        break;
      case 'r':
        text_ += '\r';
        break;
      case 't':
        text_ += '\t';
        break;
      case 'b':
        text_ += '\b';
        break;
      case 'f':
        text_ += '\f';
        break;
      case '\r':
        if (cursor_ != end_ && *cursor_ == '\n') ++cursor_;
        ++line_;
        break;
      case '\n':
        ++line_;
        break;
      default:
        if (e >= '0' && e <= '7') {
          int v = e - '0';
          for (int i = 0; i < 2 && cursor_ != end_ && *cursor_ >= '0' && *cursor_ <= '7'; ++i)
            v = v * 8 + (*cursor_++ - '0');
          text_ += char(v);
        } else {
          text_ += e;
        }
    }
  }
}

// The inner loop of reading a mesh: numbers between brackets, with no token made of each.
void Lexer::readNumberRun(Argument& a) {
  for (;;) {
    skipSpace();
    if (size_t(end_ - cursor_) < kAhead) {
      ensure(kAhead);
      skipSpace();
      if (cursor_ == end_) return;
    }
    if (const uint8_t k = classOf(*cursor_); k != kDigit && k != kSign) return;
    double v;
    bool isInteger;
    if (!parseNumber(v, isInteger)) return;  // next() has the words for it
    if (cursor_ != end_ && !isDelimiter(*cursor_)) {
      cursor_ = numberBegin_;
      return;
    }
    if (isInteger)
      a.addInteger(int(v));
    else
      a.addReal(v);
  }
}

// A flood of brackets makes no token of each.
bool Lexer::skipBrackets(char bracket) {
  bool any = false;
  for (;;) {
    for (skipSpace(); cursor_ != end_ && *cursor_ == bracket; skipSpace()) {
      ++cursor_;
      any = true;
    }
    if (cursor_ != end_ || !refill()) return any;
  }
}

void Lexer::readArray(Request& r, bool& ended) {
  Argument& a = r.add(tokenLine_);
  a.isArray = true;
  bool first = true, mixed = false, nested = false;
  const auto report = [&](bool& once, const char* what, const char* done) {
    if (!once) complain(Severity::Error, "RIB-ARRAY", "in " + r.name + ": " + what, done);
    once = true;
  };
  constexpr const char* kNested = "brackets inside brackets";
  if (skipBrackets('[')) report(nested, kNested, "the inner ones are ignored");
  for (;;) {
    if (a.kind == Argument::Kind::Numbers) readNumberRun(a);
    if (a.size() > 0) first = false;
    const Token t = next();
    switch (t) {
      case Token::End:
        ended = true;
        complain(Severity::Error, "RIB-BRACKET", "the array of " + r.name + " has no closing ']'",
                 "it ends with the file");
        return;
      case Token::ArrayEnd:
        return;
      case Token::ArrayBegin:
        report(nested, kNested, "the inner ones are ignored");
        skipBrackets('[');
        break;
      case Token::Word:
        if (!wordIsRequest_ && wordToNumber()) {
          a.addReal(value_);
          break;
        }
        if (wordIsRequest_ || (isRequest_(text_) && tokenLine_ != lastTokenLine_)) {
          complain(Severity::Error, "RIB-BRACKET", "the array of " + r.name + " has no closing ']'",
                   "it ends before " + text_);
          hasPending_ = true;
          pending_ = text_;
          pendingLine_ = tokenLine_;
          return;
        }
        [[fallthrough]];
      case Token::String:
        if (first) a.kind = Argument::Kind::Strings;
        if (a.kind == Argument::Kind::Strings)
          a.strings.push_back(text_);
        else
          report(mixed, "numbers and strings in one array", "the strings are ignored");
        break;
      case Token::Number:
        if (a.kind == Argument::Kind::Strings)
          report(mixed, "numbers and strings in one array", "the numbers are ignored");
        else if (isInteger_)
          a.addInteger(int(value_));
        else
          a.addReal(value_);
        break;
      case Token::FloatArray:
        for (float f : encoded_.floats) a.addReal(f);
        break;
    }
    first = false;
  }
}

bool Lexer::readRequest(Request& r) {
  r.clear();
  bool outside = false;
  while (!hasPending_) {
    const Token t = next();
    if (t == Token::End) return false;
    if (t == Token::Word) {
      hasPending_ = true;
      pending_ = text_;
      pendingLine_ = tokenLine_;
    } else if (!outside) {
      outside = true;
      complain(Severity::Error, "RIB-SYNTAX", "values stand before the first request", "they are skipped");
    }
    if (t == Token::ArrayBegin) skipBrackets('[');
    if (t == Token::ArrayEnd) skipBrackets(']');
  }
  hasPending_ = false;
  std::swap(r.name, pending_);
  r.pos = {file_, pendingLine_};
  bool full = false, ended = false;
  while (!hasPending_ && !ended) {
    const Token t = next();
    if (r.count >= kMostArguments && t != Token::Word && t != Token::End) {
      if (!full)
        complain(Severity::Error, "RIB-ARGUMENTS", r.name + " has more than 65536 arguments", "the rest is ignored");
      full = true;
      continue;
    }
    switch (t) {
      case Token::End:
        ended = true;
        break;
      case Token::Word:
        if (!wordIsRequest_ && !isRequest_(text_)) {
          if (wordToNumber()) {
            r.add(tokenLine_).addReal(value_);
            break;
          }
          // A word that is no request, on the line of what precedes it, is a string that lacks its quotes; at the
          // start of a line it is a request that nobody knows.
          if (tokenLine_ == lastTokenLine_ && r.count < kMostArguments) {
            complain(Severity::Warning, "RIB-QUOTES", "'" + text_.substr(0, 40) + "' in " + r.name + " has no quotes",
                     "it is read as a string");
            Argument& a = r.add(tokenLine_);
            a.kind = Argument::Kind::Strings;
            a.strings.push_back(text_);
            break;
          }
        }
        hasPending_ = true;
        pending_ = text_;
        pendingLine_ = tokenLine_;
        break;
      case Token::Number: {
        Argument& a = r.add(tokenLine_);
        if (isInteger_)
          a.addInteger(int(value_));
        else
          a.addReal(value_);
        break;
      }
      case Token::String: {
        Argument& a = r.add(tokenLine_);
        a.kind = Argument::Kind::Strings;
        a.strings.push_back(text_);
        break;
      }
      case Token::ArrayBegin:
        readArray(r, ended);
        break;
      case Token::ArrayEnd:
        complain(Severity::Error, "RIB-BRACKET", "a ']' in " + r.name + " closes nothing", "it is ignored");
        skipBrackets(']');
        break;
      case Token::FloatArray: {
        Argument& a = r.add(tokenLine_);
        std::swap(a, encoded_);
        a.isArray = true;
        a.line = tokenLine_;
        break;
      }
    }
  }
  return true;
}

}  // namespace kinora::rib
