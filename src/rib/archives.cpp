#include <filesystem>

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

// Directories to look in: the scene's own path ('@' is what the caller gave), then the caller's.
std::vector<std::string> Interpreter::searchPath() const {
  std::vector<std::string> path;
  const std::string own = (world_ ? *world_ : frame_.options).options.getString("searchpath:archive", "");
  for (size_t at = 0; at < own.size();) {
    const size_t colon = std::min(own.find(':', at), own.size());
    const std::string part = own.substr(at, colon - at);
    if (part == "@")
      path.insert(path.end(), read_.archivePath.begin(), read_.archivePath.end());
    else if (!part.empty())
      path.push_back(part);
    at = colon + 1;
  }
  path.insert(path.end(), read_.archivePath.begin(), read_.archivePath.end());
  return path;
}

// As named; beside the file that names it; beside the main file; along the search path; in the folders above the main
// file; then its base name beside these files and along the path, for paths of another machine. "" when it is
// nowhere.
std::string Interpreter::findArchive(const std::string& asNamed, const std::string& including) const {
  std::string name = asNamed;
  for (const auto& [from, to] : read_.dirmap)
    if (!from.empty() && name.starts_with(from)) {
      name = to + name.substr(from.size());
      break;
    }
  std::vector<std::string> directories{""};
  if (const size_t slash = including.rfind('/'); slash != std::string::npos)
    directories.push_back(including.substr(0, slash + 1));
  directories.push_back(mainDirectory_);
  for (const std::string& d : searchPath()) {
    directories.push_back(d.ends_with('/') ? d : d + "/");
    if (!d.starts_with('/')) directories.push_back(mainDirectory_ + directories.back());
  }
  std::string base = name.substr(name.rfind('/') == std::string::npos ? 0 : name.rfind('/') + 1);
  // a member of a zip archive of another machine: "path/a.zip!inner/b.rib" -> "a.zip!inner/b.rib"
  std::string zipBase;
  if (const size_t bang = name.find('!'); bang != std::string::npos) {
    const size_t slash = name.rfind('/', bang);
    zipBase = slash == std::string::npos ? name : name.substr(slash + 1);
  }
  for (const std::string* form : {&name, &zipBase, &base}) {
    const std::string& candidate = *form;
    if (candidate.empty()) continue;
    for (const std::string& d : directories) {
      if (candidate.starts_with('/') && !d.empty()) continue;
      if (isReadable(d + candidate)) return d + candidate;
    }
    // exporters write names from the project's folder, which holds the scene some folders further down
    constexpr int kMostUp = 8;
    std::string up = mainDirectory_.empty() ? "./" : mainDirectory_;
    for (int i = 0; i < kMostUp && form != &base && !candidate.starts_with('/'); ++i)
      if (isReadable((up += "../") + candidate)) return up + candidate;
  }
  return {};
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
