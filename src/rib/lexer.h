// RIB's lexical rules, ASCII and binary in any mixture: cuts a byte source into requests with their arguments. Used
// by the interpreter, one lexer a file. It knows which words are request names (by the function given) and nothing of
// their meaning.
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "rib/byte_source.h"
#include "rib/request.h"

namespace kinora::rib {

class Lexer {
 public:
  using IsRequest = bool (*)(std::string_view word);
  Lexer(std::unique_ptr<ByteSource> source, std::string_view name, Diagnostics& messages, IsRequest isRequest);

  // The next request and all that stands before the one after it; false at the end of the stream.
  bool readRequest(Request& r);
  const std::string& name() const { return *file_; }
  SourcePos pos() const { return {file_, line_}; }
  uint64_t bytesRead() const { return bytes_; }

 private:
  static constexpr size_t kBuffer = 1 << 18;
  static constexpr size_t kMostText = 64 << 20;  // longest string that is stored
  enum class Token : uint8_t { End, Word, Number, String, ArrayBegin, ArrayEnd, FloatArray };
  Token next();
  Token number();
  Token word();
  Token asciiString(char quote);
  Token binary(unsigned char lead);
  void junk();
  void readArray(Request& r, bool& ended);
  void readNumberRun(Argument& a);
  bool skipBrackets(char bracket);                   // and the space between them; true when there were any
  bool parseNumber(double& value, bool& isInteger);  // at cursor_; leaves it behind the number
  bool wordToNumber();                               // nan, inf, infinity
  bool looksLikeNewRequest(const char* at) const;    // after a line break inside quotes

  bool refill();               // more bytes behind those not yet used; false when there are none
  void ensure(size_t bytes) {  // at least so many ahead, unless the stream ends before
    while (size_t(end_ - cursor_) < bytes && refill()) {
    }
  }
  bool byte(unsigned char& b);
  bool bytes(uint64_t count, std::string& to);
  bool bigEndian(int count, uint64_t& value);
  void truncated(const char* what);
  bool endsLine(char c);
  void skipSpace();
  void skipByteOrderMark();
  void complain(Severity s, const char* code, std::string what, std::string done, std::string advice = {});

  std::unique_ptr<ByteSource> source_;
  FileName file_;
  Diagnostics& messages_;
  IsRequest isRequest_;

  std::vector<char> buffer_;
  const char* cursor_ = nullptr;
  const char* end_ = nullptr;
  const char* numberBegin_ = nullptr;  // of the number just parsed: reading on may have moved it
  bool sourceEnded_ = false, ended_ = false;
  uint64_t bytes_ = 0;

  uint32_t line_ = 1, tokenLine_ = 1, lastTokenLine_ = 0;
  double value_ = 0;
  bool isInteger_ = false;
  std::string text_;
  bool wordIsRequest_ = false;  // the word came as an encoded request
  Argument encoded_;            // numbers of an encoded array

  std::string pending_;  // a request name that ended the arguments of the one before
  uint32_t pendingLine_ = 0;
  bool hasPending_ = false;
  std::vector<std::string> requestCodes_, stringTokens_;
  uint32_t syntaxMessages_ = 0;
};

}  // namespace kinora::rib
