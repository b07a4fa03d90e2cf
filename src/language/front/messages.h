// The files of one compilation and what was found wrong in them. Every step of the front end reports here; nothing is
// printed.
#pragma once
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "language/front/compile.h"

namespace kinora::language::front {

struct Pos {
  uint32_t line = 0;
  uint16_t column = 0;  // 0 beyond 65,535
  uint16_t file = 0;
};

// Thrown when going on is pointless (too many errors, a limit): only compile() and preprocess() catch it.
struct Stop {};

class Messages {
 public:
  explicit Messages(const CompileOptions& options) : options_(options) {}

  uint16_t addFile(const std::string& name, std::string text);
  std::string_view text(uint16_t file) const { return files_[file].text; }
  const std::string& nameOf(uint16_t file) const { return *files_[file].name; }
  SourcePos sourcePos(Pos) const;

  void error(Pos, std::string text);
  void warning(Pos, std::string text);
  [[noreturn]] void fatal(Pos, std::string text);  // an error after which nothing follows
  void keepQuiet(uint16_t file, uint32_t line) { quiet_.insert(uint64_t(file) << 32 | line); }  // no warnings of it
  bool hasErrors() const { return errors_ > 0; }
  std::vector<CompileMessage> take() { return std::move(messages_); }

 private:
  struct File {
    FileName name;
    std::string text;
    std::vector<uint32_t> lines;  // where each begins; made when the first message needs it
  };
  void add(Severity, Pos, std::string text);
  std::string lineOf(Pos);

  const CompileOptions& options_;
  std::deque<File> files_;
  std::vector<CompileMessage> messages_;
  std::unordered_set<std::string> said_;
  std::unordered_set<uint64_t> quiet_;
  uint32_t errors_ = 0;
};

}  // namespace kinora::language::front
