#include "base/diagnostics.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <string_view>

namespace kinora {

std::string SourcePos::str() const {
  if (!file) return {};
  return line ? *file + ":" + std::to_string(line) : *file;
}

namespace {
// What a message names first, in its quotes ("no pattern 'PxrFoo'"), or nothing. An apostrophe within a word is none.
std::string_view nameIn(std::string_view what) {
  const auto isWord = [&](size_t i) { return i < what.size() && std::isalnum(static_cast<unsigned char>(what[i])); };
  for (size_t open = what.find('\''); open != what.npos; open = what.find('\'', open + 1)) {
    if (open > 0 && isWord(open - 1)) continue;
    const size_t close = what.find('\'', open + 1);
    constexpr size_t kLongest = 64;
    if (close == what.npos || close - open > kLongest) return {};
    return what.substr(open, close + 1 - open);
  }
  return {};
}

// Begins a line of its own in an advice: a text, and a caret under its mistake (film/path_expression.h).
constexpr char kExcerpt = '\x1e';
}  // namespace

std::string Message::str() const {
  static const char* const kNames[] = {"info", "warning", "error"};
  std::string s = pos.str();
  s += s.empty() ? "kinora: " : ": ";
  s += kNames[int(severity)];
  s += ' ';
  s += code;
  s += ": ";
  s += what;
  if (!done.empty()) s += "; " + done;
  const size_t line = s.size();
  if (!advice.empty()) s += (advice[0] == kExcerpt ? "" : "; ") + advice;
  // a message is one line, whatever a scene's strings hold; but for an excerpt with its caret at the end of the
  // advice
  for (size_t i = 0; i < s.size(); ++i)
    if (static_cast<unsigned char>(s[i]) < 32) s[i] = i >= line && s[i] == kExcerpt ? '\n' : ' ';
  return s;
}

Diagnostics::Diagnostics(Sink sink) : sink_(std::move(sink)) {
  if (!sink_) sink_ = [](const std::string& line, Severity) { std::fprintf(stderr, "%s\n", line.c_str()); };
}

void Diagnostics::report(Message m) {
  std::lock_guard lock(mutex_);
  const auto isSame = [&](const Message& k) {
    return k.code == m.code && k.what == m.what && k.pos.file == m.pos.file && k.pos.line == m.pos.line;
  };
  if (isRepeating_ && std::any_of(kept_.begin(), kept_.end(), isSame)) return;
  const uint64_t n = ++counts_[m.code];
  if (m.severity == Severity::Error) ++errors_;
  if (m.severity == Severity::Warning) ++warnings_;
  if (m.code.starts_with("ASSET-") || m.code.starts_with("PLUGIN-")) ++asset_;
  if (int(m.severity) >= quiet_) {
    if (n <= shown_) {
      sink_(m.str(), m.severity);
    } else {
      // the first places; of what is named, each name once with its first place
      Hidden& h = hidden_[m.code];
      constexpr size_t kPlaces = 3, kNames = 12;
      const std::string place = m.pos.str(), name(nameIn(m.what));
      const std::string entry = name.empty() || place.empty() ? name + place : name + " at " + place;
      const bool isKnown = std::any_of(h.places.begin(), h.places.end(), [&](const std::string& p) {
        return name.empty() ? p == entry : p.starts_with(name);
      });
      if (++h.count && !entry.empty() && h.places.size() < (name.empty() ? kPlaces : kNames) && !isKnown)
        h.places.push_back(entry);
    }
  }
  if (kept_.size() < 1000) kept_.push_back(std::move(m));
}

void Diagnostics::error(std::string code, const SourcePos& pos, std::string what, std::string done,
                        std::string advice) {
  report({Severity::Error, std::move(code), pos, std::move(what), std::move(done), std::move(advice)});
}
void Diagnostics::warning(std::string code, const SourcePos& pos, std::string what, std::string done,
                          std::string advice) {
  report({Severity::Warning, std::move(code), pos, std::move(what), std::move(done), std::move(advice)});
}
void Diagnostics::info(std::string code, const SourcePos& pos, std::string what) {
  report({Severity::Info, std::move(code), pos, std::move(what), {}, {}});
}

uint64_t Diagnostics::count(std::string_view code) const {
  std::lock_guard lock(mutex_);
  const auto it = counts_.find(code);
  return it == counts_.end() ? 0 : it->second;
}
uint64_t Diagnostics::errors() const {
  std::lock_guard lock(mutex_);
  return errors_;
}
uint64_t Diagnostics::warnings() const {
  std::lock_guard lock(mutex_);
  return warnings_;
}
uint64_t Diagnostics::assetProblems() const {
  std::lock_guard lock(mutex_);
  return asset_;
}
std::vector<Message> Diagnostics::messages() const {
  std::lock_guard lock(mutex_);
  return kept_;
}

void Diagnostics::summary() {
  std::lock_guard lock(mutex_);
  for (const auto& [code, h] : hidden_) {
    std::string places;
    for (const std::string& p : h.places) places += (!places.empty() ? ", " : p[0] == '\'' ? ": " : ", at ") + p;
    if (h.count > h.places.size() && !places.empty()) places += " ...";
    sink_("kinora: " + std::to_string(h.count) + " more of " + code + places + " (kinora explain " + code + ")",
          Severity::Info);
  }
  hidden_.clear();
}

}  // namespace kinora
