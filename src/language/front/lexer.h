// Cuts the text of one file into tokens. The preprocessor calls it; it knows nothing of directives.
#pragma once
#include "language/front/token.h"

namespace kinora::language::front {

class Lexer {
 public:
  // The text must outlive the tokens.
  Lexer(std::string_view text, uint16_t file, Names& names, Messages& messages);

  Token next();                   // Kind::End at the end, as often as asked
  bool nextInLine(Token& token);  // false before the next line and at the end: nothing is taken
  void skipLine();                // to the next line's beginning
  // What the next token would be, for groups that are skipped: their text need not make sense.
  bool atHash() { return skipBlank(false), isFirst_ && at(0) == '#'; }
  bool atEnd() const { return at_ >= text_.size(); }
  uint16_t file() const { return file_; }
  Pos here() const { return {line_, 0, file_}; }

 private:
  bool skipBlank(bool stopAtNewline);  // true: stopped before a line's end
  void newline();
  Token string(Token);
  char at(size_t i) const { return at_ + i < text_.size() ? text_[at_ + i] : '\0'; }

  std::string_view text_;
  size_t at_ = 0, lineStart_ = 0;
  uint32_t line_ = 1;
  uint16_t file_;
  bool isFirst_ = true, hasSpace_ = false;
  Names& names_;
  Messages& messages_;
};

// The value of a string token: without quotes, escapes resolved. `wrong` names a bad escape, or is left alone.
std::string unescaped(std::string_view quoted, std::string& wrong);

}  // namespace kinora::language::front
