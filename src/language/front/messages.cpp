#include "language/front/messages.h"

#include <algorithm>
#include <fstream>

namespace kinora::language {

namespace {

constexpr size_t kLongestLineShown = 160;  // of a source line

// Control characters would let a source file write over the terminal.
std::string printable(std::string s) {
  for (char& c : s)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  return s;
}

}  // namespace

std::string CompileMessage::str() const {
  std::string s = pos.str();
  if (!s.empty()) s += ": ";
  s += severity == Severity::Error ? "error: " : "warning: ";
  s += printable(text);
  if (column == 0) return s;
  std::string line = printable(sourceLine);
  size_t at = column - 1, from = 0;
  if (line.size() > kLongestLineShown) {
    from = at > kLongestLineShown / 2 ? at - kLongestLineShown / 2 : 0;
    line = line.substr(std::min(from, line.size()), kLongestLineShown);
  }
  const std::string place = "  " + std::to_string(pos.line) + ":" + std::to_string(column);
  return s + "\n" + place + " | " + line + "\n" + std::string(place.size(), ' ') + " | " +
         std::string(std::min(at - from, line.size()), ' ') + "^";
}

std::optional<std::string> readSourceFile(const std::string& path) {
  constexpr size_t kMost = size_t(64) << 20;
  std::ifstream in(path, std::ios::binary);
  if (!in) return {};
  std::string text;
  char piece[1 << 16];
  while (in.read(piece, sizeof piece), in.gcount() > 0) {
    text.append(piece, size_t(in.gcount()));
    if (text.size() > kMost) return {};
  }
  if (in.bad() || (text.empty() && !in.eof())) return {};
  return text;
}

}  // namespace kinora::language

namespace kinora::language::front {

uint16_t Messages::addFile(const std::string& name, std::string text) {
  files_.push_back({FileName(name), std::move(text), {}});
  return uint16_t(files_.size() - 1);
}

SourcePos Messages::sourcePos(Pos pos) const {
  return pos.line && pos.file < files_.size() ? SourcePos{files_[pos.file].name, pos.line} : SourcePos{};
}

std::string Messages::lineOf(Pos pos) {
  File& file = files_[pos.file];
  if (file.lines.empty()) {
    file.lines.push_back(0);
    for (size_t i = 0; i < file.text.size(); ++i)
      if (file.text[i] == '\n') file.lines.push_back(uint32_t(i + 1));
  }
  if (pos.line == 0 || pos.line > file.lines.size()) return {};
  const size_t begin = file.lines[pos.line - 1];
  size_t end = std::min(file.text.find('\n', begin), file.text.size());
  if (end > begin && file.text[end - 1] == '\r') --end;
  return file.text.substr(begin, std::min<size_t>(end - begin, 70000));
}

void Messages::add(Severity severity, Pos pos, std::string text) {
  // the same thing said twice of one line is noise: macros, functions inlined many times
  if (!said_.insert(std::to_string(pos.file) + ":" + std::to_string(pos.line) + ":" + text).second) return;
  CompileMessage m;
  m.severity = severity;
  m.pos = sourcePos(pos);
  m.text = std::move(text);
  if (pos.column && pos.file < files_.size()) {
    m.sourceLine = lineOf(pos);
    m.column = pos.column;
  }
  messages_.push_back(std::move(m));
}

void Messages::error(Pos pos, std::string text) {
  const size_t before = messages_.size();
  add(Severity::Error, pos, std::move(text));
  if (messages_.size() == before) return;
  if (++errors_ >= options_.maxErrors) fatal({pos.line, 0, pos.file}, "too many errors; stopped");
}

void Messages::warning(Pos pos, std::string text) {
  if (!options_.withWarnings || quiet_.count(uint64_t(pos.file) << 32 | pos.line)) return;
  if (options_.warningsAreErrors)
    error(pos, std::move(text));
  else if (messages_.size() < 10000)
    add(Severity::Warning, pos, std::move(text));
}

void Messages::fatal(Pos pos, std::string text) {
  add(Severity::Error, pos, std::move(text));
  ++errors_;
  throw Stop{};
}

}  // namespace kinora::language::front
