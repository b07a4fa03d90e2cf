// The binary encodings of RIB; the rest of the lexer is in lexer.cpp.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "rib/lexer.h"

namespace kinora::rib {

// Storage grows with what really arrives, so that a false length costs nothing.
bool Lexer::bytes(uint64_t count, std::string& to) {
  to.clear();
  while (count > 0) {
    if (cursor_ == end_ && !refill()) return false;
    const size_t n = size_t(std::min<uint64_t>(count, uint64_t(end_ - cursor_)));
    if (to.size() < kMostText) to.append(cursor_, n);
    cursor_ += n;
    count -= n;
  }
  return true;
}

bool Lexer::bigEndian(int count, uint64_t& value) {
  value = 0;
  unsigned char b;
  for (int i = 0; i < count; ++i) {
    if (!byte(b)) return false;
    value = value << 8 | b;
  }
  return true;
}

void Lexer::truncated(const char* what) {
  complain(Severity::Error, "RIB-TRUNCATED", std::string("the stream ends inside ") + what, "it is ignored",
           "write the file again; it was cut short");
  ended_ = true;
}

// The table of section 1.1 of the RIB reference; numbers are octal there and here.
Lexer::Token Lexer::binary(unsigned char lead) {
  uint64_t n = 0;
  if (lead <= 0217) {
    const int width = (lead & 3) + 1, fraction = (lead >> 2) & 3;
    if (!bigEndian(width, n)) return truncated("an encoded integer"), Token::End;
    const int64_t v = int64_t(n << (64 - 8 * width)) >> (64 - 8 * width);
    isInteger_ = fraction == 0;
    value_ = std::ldexp(double(v), -8 * fraction);
    return Token::Number;
  }
  if (lead <= 0243) {
    n = lead - 0220u;
    if (lead >= 0240 && !bigEndian(lead - 0240 + 1, n)) return truncated("an encoded string"), Token::End;
    if (!bytes(n, text_)) return truncated("an encoded string"), Token::End;
    return Token::String;
  }
  if (lead == 0244 || lead == 0245) {
    if (!bigEndian(lead == 0244 ? 4 : 8, n)) return truncated("an encoded number"), Token::End;
    value_ = lead == 0244 ? double(std::bit_cast<float>(uint32_t(n))) : std::bit_cast<double>(n);
    isInteger_ = false;
    return Token::Number;
  }
  if (lead == 0246) {
    if (!bigEndian(1, n)) return truncated("an encoded request"), Token::End;
    if (n >= requestCodes_.size() || requestCodes_[n].empty()) {
      complain(Severity::Error, "RIB-BINARY", "the encoded request " + std::to_string(n) + " was never defined",
               "it is skipped with its arguments");
      text_ = "undefined" + std::to_string(n);
    } else {
      text_ = requestCodes_[n];
    }
    wordIsRequest_ = true;
    return Token::Word;
  }
  if (lead >= 0310 && lead <= 0313) {
    if (!bigEndian(lead - 0310 + 1, n)) return truncated("an encoded array"), Token::End;
    encoded_.clear();
    encoded_.isInteger = false;
    encoded_.floats.reserve(size_t(std::min<uint64_t>(n, kBuffer)));
    while (n > 0) {
      ensure(4);
      const uint64_t have = std::min<uint64_t>(n, uint64_t(end_ - cursor_) / 4);
      if (have == 0) return truncated("an encoded array"), Token::End;
      for (uint64_t i = 0; i < have; ++i, cursor_ += 4) {
        uint32_t bits;
        std::memcpy(&bits, cursor_, 4);
        encoded_.addReal(double(std::bit_cast<float>(__builtin_bswap32(bits))));
      }
      n -= have;
    }
    return Token::FloatArray;
  }
  if (lead >= 0314 && lead <= 0316) {
    const bool isRequest = lead == 0314;
    if (!bigEndian(lead == 0316 ? 2 : 1, n)) return truncated("a definition"), Token::End;
    // the string follows directly; a definition in its place would nest without bound
    unsigned char first;
    if (!byte(first)) return truncated("a definition"), Token::End;
    const bool isString = first == '"' || (first >= 0220 && first <= 0243);
    if (!isString) {
      complain(Severity::Error, "RIB-BINARY", "a definition is not followed by a string", "it is ignored");
      --cursor_;
      return Token::End;
    }
    if ((first == '"' ? asciiString('"') : binary(first)) != Token::String) return Token::End;
    auto& table = isRequest ? requestCodes_ : stringTokens_;
    if (table.size() <= n) table.resize(size_t(n) + 1);
    table[n] = text_;
    return Token::End;
  }
  if (lead == 0317 || lead == 0320) {
    if (!bigEndian(lead == 0317 ? 1 : 2, n)) return truncated("a string token"), Token::End;
    if (n >= stringTokens_.size()) {
      complain(Severity::Error, "RIB-BINARY", "the string token " + std::to_string(n) + " was never defined",
               "it is read as \"\"");
      text_.clear();
    } else {
      text_ = stringTokens_[n];
    }
    return Token::String;
  }
  if (lead == 0377) {  // by convention the end of a streamed answer
    ended_ = true;
    return Token::End;
  }
  if (syntaxMessages_++ == 0)
    complain(Severity::Error, "RIB-BINARY", "the byte " + std::to_string(lead) + " has no meaning in RIB",
             "it is skipped", "the file may be in another encoding or not be RIB at all");
  return Token::End;
}

}  // namespace kinora::rib
