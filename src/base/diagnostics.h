// What the program says to a person about a scene: one line a message, with position, code, and what was done
// instead. Called by every floor above; thread-safe. It decides nothing: exit codes belong to app/, fallbacks to the
// caller.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/file_name.h"

namespace kinora {

// Where a thing was said, in 8 bytes.
struct SourcePos {
  FileName file;            // none: not from a file (command line, default)
  uint32_t line = 0;        // from 1; 0: unknown
  std::string str() const;  // "file.rib:12", or "" when unknown
};

enum class Severity { Info, Warning, Error };

// One message. `code` is stable, short and in capitals (for `kinora explain` and for scripts), e.g.
// "RIB-ARRAY-LENGTH".
struct Message {
  Severity severity = Severity::Warning;
  std::string code;
  SourcePos pos;
  std::string what;         // what is wrong, naming the object
  std::string done;         // what was done instead ("" when nothing)
  std::string advice;       // what to try ("" when nothing)
  std::string str() const;  // `file.rib:LINE: warning CODE: what; done; advice`
};

// Collects messages; prints the first of each code at once, the others as a count with their places in summary().
class Diagnostics {
 public:
  using Sink = std::function<void(const std::string& line, Severity)>;
  explicit Diagnostics(Sink sink = {});  // empty sink: standard error
  void report(Message m);
  void error(std::string code, const SourcePos& pos, std::string what, std::string done = {},
             std::string advice = {});
  void warning(std::string code, const SourcePos& pos, std::string what, std::string done = {},
               std::string advice = {});
  void info(std::string code, const SourcePos& pos, std::string what);
  // --strict: warnings whose code is in the "asset" family (ASSET-*, PLUGIN-*) are counted as errors of class Asset.
  uint64_t count(std::string_view code) const;
  uint64_t errors() const;
  uint64_t warnings() const;
  uint64_t assetProblems() const;               // messages with a code that begins with "ASSET-" or "PLUGIN-"
  std::vector<Message> messages() const;        // the first of each code and text, at most 1,000
  void summary();                               // prints "N more of CODE, at FILE:LINE, ..." lines
  void setShown(uint64_t n) { shown_ = n; }     // of each code, for -v
  void setQuiet(int level) { quiet_ = level; }  // 1: no infos; 2: no warnings
  // While set, what was said before is not said or counted again: the same work is done once more.
  void setRepeating(bool is) {
    std::lock_guard lock(mutex_);
    isRepeating_ = is;
  }

 private:
  mutable std::mutex mutex_;
  Sink sink_;
  std::map<std::string, uint64_t, std::less<>> counts_;
  struct Hidden {
    uint64_t count = 0;
    std::vector<std::string> places;  // the first few
  };
  std::map<std::string, Hidden, std::less<>> hidden_;
  uint64_t shown_ = 1;
  std::vector<Message> kept_;
  uint64_t errors_ = 0, warnings_ = 0, asset_ = 0;
  int quiet_ = 0;
  bool isRepeating_ = false;
};

}  // namespace kinora
