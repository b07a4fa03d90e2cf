// The preprocessor: a file and what it includes become one list of tokens, macros expanded. Called by compile() and
// preprocess(). All that could explode is bounded: expansions, includes and their depth, conditions.
#pragma once
#include <deque>
#include <functional>
#include <optional>
#include <unordered_set>

#include "language/front/compile.h"
#include "language/front/lexer.h"

namespace kinora::language::front {

class Preprocessor {
 public:
  Preprocessor(const CompileOptions& options, const FileReader& reader, Pool& pool, Names& names, Messages& messages);
  // Reads everything; the last token is End.
  std::vector<Token> run(const std::string& name, std::string_view source);
  const std::vector<std::string>& filesRead() const { return filesRead_; }

 private:
  struct Macro {
    std::vector<Name> parameters;
    std::vector<Token> body;
    bool isFunction = false, isVariadic = false, isDefined = false;
    uint32_t disabled = 0;  // expansions of it that are being read
    enum class Own : uint8_t { No, File, Line } own = Own::No;
  };
  struct Context {  // tokens that are read before the file goes on
    std::vector<Token> tokens;
    size_t at = 0;
    Macro* macro = nullptr;
  };
  struct Condition {
    bool isTaken, hasElse;
    Pos pos;
  };
  struct File {
    Lexer lexer;
    std::string path;
    size_t conditions;  // that were open when it began
    Pos includedAt;
  };

  // preprocessor.cpp
  void read(const std::string& path, std::string text, Pos includedAt);
  Token fileToken();
  void directive(const Token& hash);
  void define(const Token& at);
  void include(const Token& at);
  void pragma(const Token& at);
  void message(const Token& at, bool isError);
  void beginCondition(const Token& at, bool isTrue);
  void skipGroup(bool toElse);
  std::vector<Token> restOfLine();
  void endOfLine(const char* directive);
  Macro* macroOf(Name name);
  // macros.cpp
  Token raw();
  Token expanded();
  bool expand(Token& name, Macro& macro);
  bool arguments(const Token& name, const Macro& macro, std::vector<std::vector<Token>>& out);
  std::vector<Token> substituted(const Token& name, const Macro& macro, std::vector<std::vector<Token>> arguments);
  std::vector<Token> expandedAlone(const std::vector<Token>& tokens);
  Token pasted(const Token& a, const Token& b);
  Token stringOf(const std::vector<Token>& tokens, const Token& at);
  void push(std::vector<Token> tokens, Macro* macro);
  // condition.cpp
  bool condition(const Token& at);

  const CompileOptions& options_;
  const FileReader& reader_;
  Pool& pool_;
  Names& names_;
  Messages& messages_;
  std::deque<Macro> macros_;
  std::vector<Macro*> byName_;
  std::vector<File> files_;
  std::vector<Condition> conditions_;
  std::vector<Context> contexts_;
  size_t floor_ = 0;       // contexts below belong to somebody else
  uint32_t nested_ = 0;    // arguments expanded inside arguments
  uint64_t work_ = 0;      // tokens made by macros
  uint32_t included_ = 0;  // files
  std::unordered_set<std::string> once_;
  std::vector<std::string> filesRead_;
  Name defined_, vaArgs_;
};

// Tokens as text again, each file's tokens on the lines where they were.
std::string textOf(const std::vector<Token>& tokens, const Messages& messages);

}  // namespace kinora::language::front
