#include <filesystem>

#include "rib/archive_search.h"
#include "rib/interpreter.h"

namespace kinora::rib {

void Interpreter::archiveBegin(Request& r) {
  Cursor c(r);
  std::string name;
  if (!c.string(name)) badArguments(r, "a name: the archive cannot be used");
  recording_ = std::make_shared<Recorded>();
  recordingName_ = name;
  recordingPos_ = r.pos;
  recordingDepth_ = 1;
}

void Interpreter::archiveEnd(Request& r) {
  if (!recording_) {
    report(Severity::Error, "RIB-NESTING", r.pos, "ArchiveEnd closes nothing", "it is ignored");
    return;
  }
  if (!recordingName_.empty()) inlineArchives_[recordingName_] = std::move(recording_);
  recording_.reset();
}

void Interpreter::readArchive(Request& r) {
  Cursor c(r);
  std::string name;
  if (!c.string(name) || name.empty()) return badArguments(r, "the name of an archive");
  readNamedArchive(name, r);
}

// The name is mapped already (--dirmap). Along the scene's own path ('@' is what the caller gave), then the caller's.
std::string Interpreter::findArchive(const std::string& asNamed, const std::string& including) const {
  const std::string own = (world_ ? *world_ : frame_.options).options.getString("searchpath:archive", "");
  return ArchiveSearch{expandSearchPath(own, read_.archivePath), {}, mainDirectory_}.find(asNamed, including);
}

void Interpreter::readNamedArchive(const std::string& name, const Request& r, bool isProcedural) {
  if (int(sources_.size()) > read_.maxArchiveDepth) {
    report(Severity::Error, "RIB-DEPTH", r.pos,
           "archives are nested more than " + std::to_string(read_.maxArchiveDepth) + " deep at '" +
               name.substr(0, 200) + "'",
           "it is not read");
    return;
  }
  if (++archiveReads_ > read_.maxArchiveReads) {
    if (archiveReads_ == read_.maxArchiveReads + 1)
      report(Severity::Error, "RIB-DEPTH", r.pos,
             "more than " + std::to_string(read_.maxArchiveReads) + " archives are read", "no more are");
    return;
  }
  Source s;
  std::string file;
  if (const auto it = inlineArchives_.find(name); it != inlineArchives_.end()) {
    s.recorded = it->second;
    s.identity = "inline:" + name;
  } else {
    file = findArchive(name, r.pos.file ? *r.pos.file : std::string());
    if (file.empty()) {
      report(Severity::Warning, "ASSET-MISSING-ARCHIVE", r.pos,
             "the archive '" + name.substr(0, 200) + "' is not found", "it is left out",
             "give its folder by --search-path archive=DIR or Option \"searchpath\" \"archive\"");
      return;
    }
    std::error_code failed;
    const auto canonical = std::filesystem::weakly_canonical(file, failed);
    s.identity = failed ? file : canonical.string();
  }
  for (const Source& open : sources_)
    if (open.identity == s.identity) {
      report(Severity::Error, "RIB-RECURSION", r.pos, "the archive '" + name.substr(0, 200) + "' reads itself",
             "it is not read again");
      return;
    }
  if (!s.recorded) {
    std::string why;
    auto source = openFile(file, why);
    if (!source) {
      report(Severity::Warning, "ASSET-MISSING-ARCHIVE", r.pos, "the archive '" + file + "' cannot be read: " + why,
             "it is left out");
      return;
    }
    s.lexer = std::make_unique<Lexer>(std::move(source), file, messages_, &isRequest);
  }
  if (isProcedural) s.restore = std::make_unique<State>(state_);
  push(std::move(s));
}

// Delayed archives are read at once: each would be needed as soon as a ray comes near it. Programs are never run.
void Interpreter::procedural(Request& r) {
  Cursor c(r);
  std::string kind;
  std::vector<std::string> data;
  if (!c.string(kind) || !c.strings(data) || data.empty()) return badArguments(r, "a kind and its arguments");
  if (kind == "DelayedReadArchive") return readNamedArchive(data[0], r, true);
  geometryRequest(r);
}

void Interpreter::procedural2(Request& r) {
  Cursor c(r);
  std::string kind, bound;
  if (!c.string(kind)) return badArguments(r, "a kind and its arguments");
  if (kind != "DelayedReadArchive2") return geometryRequest(r);
  c.string(bound);
  const std::string file = parameters(r, c.at, Use::Node).getString("filename", "");
  if (file.empty()) return badArguments(r, "\"string filename\"");
  readNamedArchive(file, r, true);
}

}  // namespace kinora::rib
