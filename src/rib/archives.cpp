#include <algorithm>
#include <filesystem>

#include "rib/archive_search.h"
#include "rib/interpreter.h"
#include "rib/run_program.h"
#include "rib/words.h"

namespace kinora::rib {

namespace {

// A parameter list as kinora-procedural reads it: tokens "type name" or "type[n] name", since a shared object has no
// vertices for classes to count.
std::string textOf(const scene::ParameterList& list) {
  std::string text;
  const auto values = [&](const auto& all, const auto& append) {
    text += " [";
    for (const auto& v : all) {
      append(v, text);
      text += ' ';
    }
    text += "] ";
  };
  for (const scene::Parameter& p : list) {
    const std::string length = p.isArray ? "[" + std::to_string(p.arrayLength) + "]" : "";
    appendString(nameOf(p.type) + length + " " + p.name, text);
    if (!p.strings.empty())
      values(p.strings, appendString);
    else if (!p.ints.empty())
      values(p.ints, appendNumber<int>);
    else
      values(p.floats, appendNumber<float>);
  }
  return text;
}

}  // namespace

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
  const scene::ParameterList& options = (world_ ? *world_ : frame_.options).options;
  std::vector<std::string> path = expandSearchPath(options.getString("searchpath:archive", ""), read_.archivePath);
  // what a procedural names may stand on a path of its own
  if (const std::string own = options.getString("searchpath:procedural", ""); !own.empty())
    for (std::string& folder : expandSearchPath(own, {})) path.push_back(std::move(folder));
  return ArchiveSearch{std::move(path), {}, mainDirectory_}.find(asNamed, including);
}

bool Interpreter::readsItself(const std::string& identity, const std::string& what, const Request& r) {
  const auto isIt = [&](const Source& open) { return open.identity == identity; };
  if (std::none_of(sources_.begin(), sources_.end(), isIt) &&
      std::find(ancestors_.begin(), ancestors_.end(), identity) == ancestors_.end())
    return false;
  report(Severity::Error, "RIB-RECURSION", r.pos, what + " reads itself", "it is not read again");
  return true;
}

bool Interpreter::mayReadAnother(const std::string& name, const Request& r) {
  if (int(sources_.size() + ancestors_.size()) > read_.maxArchiveDepth) {
    report(Severity::Error, "RIB-DEPTH", r.pos,
           "archives are nested more than " + std::to_string(read_.maxArchiveDepth) + " deep at '" +
               name.substr(0, 200) + "'",
           "it is not read");
    return false;
  }
  if (const int reads = ++*archiveReads_; reads > read_.maxArchiveReads) {
    if (reads == read_.maxArchiveReads + 1)
      report(Severity::Error, "RIB-DEPTH", r.pos,
             "more than " + std::to_string(read_.maxArchiveReads) + " archives are read", "no more are");
    return false;
  }
  return true;
}

void Interpreter::readNamedArchive(const std::string& name, const Request& r, bool isProcedural) {
  if (!mayReadAnother(name, r)) return;
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
  if (readsItself(s.identity, "the archive '" + name.substr(0, 200) + "'", r)) return;
  if (!s.recorded) {
    std::string why;
    auto source = openFile(file, why);
    if (!source) {
      report(Severity::Warning, "ASSET-MISSING-ARCHIVE", r.pos, "the archive '" + file + "' cannot be read: " + why,
             "it is left out");
      return;
    }
    s.lexer = std::make_unique<Lexer>(std::move(source), file, messages_, &isRequest);
    if (!ancestors_.empty()) filesRead_.emplace_back(name, file);
  }
  if (isProcedural) s.restore = std::make_unique<State>(state_);
  push(std::move(s));
}

// The words of a command line, without a shell's other powers.
bool Interpreter::runs(std::string_view kind) const {
  return read_.allowExec && (kind == "RunProgram" || (kind == "DynamicLoad" && !read_.proceduralHost.empty()));
}

void Interpreter::readProgram(const Delayed& what, const Request& r) {
  const std::string& command = what.data[0];
  const std::string data = what.data.size() > 1 ? what.data[1] : std::string();
  const bool isObject = what.isObject();
  const std::string name = (isObject ? "the shared object '" : "the program '") + command.substr(0, 200) + "'";
  Source s;
  s.identity = "program:" + command + "\n" + data + what.parameters;
  if (!mayReadAnother(command, r) || readsItself(s.identity, name, r)) return;
  const std::string from = r.pos.file ? *r.pos.file : std::string();
  constexpr const char* kDetail = "1000000";  // all there is: how large it is seen is not known yet
  std::vector<std::string> words;
  if (isObject) {
    std::string file = findArchive(command, from);
    if (file.empty()) file = findArchive(command + ".so", from);
    if (file.empty()) {
      report(Severity::Warning, "ASSET-PROGRAM", r.pos, name + " is not found", "it is left out",
             "give its folder by --search-path procedural=DIR or Option \"searchpath\" \"procedural\"");
      return;
    }
    words = {read_.proceduralHost, std::filesystem::absolute(file).string(), "--detail", kDetail};
    if (!what.bound.empty()) words.push_back("--bound");
    for (const double x : what.bound) words.push_back(std::to_string(x));
    if (!what.parameters.empty()) words.push_back("--list");
  } else {
    for (size_t at = 0; (at = command.find_first_not_of(" \t", at)) != std::string::npos;) {
      const size_t end = std::min(command.find_first_of(" \t", at), command.size());
      words.push_back(command.substr(at, end - at));
      at = end;
    }
    // a program beside the scene may be named by its file alone
    if (!words.empty())
      if (const std::string file = findArchive(words[0], from); !file.empty())
        words[0] = std::filesystem::absolute(file).string();
  }
  ProgramLimits limits;
  limits.seconds = read_.programSeconds;
  limits.stop = read_.stop;
  std::string why;
  const std::string request = !isObject                 ? kDetail + (" " + data + "\n")
                              : what.parameters.empty() ? data
                                                        : what.parameters;
  std::optional<std::string> text = runProgram(words, request, limits, why);
  if (!text) {
    report(Severity::Warning, "ASSET-PROGRAM", r.pos, name + " gives nothing: " + why, "it is left out");
    return;
  }
  if (!ancestors_.empty()) {
    Hasher printed;
    printed.text(*text);
    programsRun_.emplace_back(command, printed.result());
  }
  s.lexer = std::make_unique<Lexer>(openText(std::move(*text)), command, messages_, &isRequest);
  s.restore = std::make_unique<State>(state_);
  push(std::move(s));
}

// Those that cannot be read later, see delay(), are read as they come.
void Interpreter::procedural(Request& r) {
  Cursor c(r);
  std::string kind;
  std::vector<std::string> data;
  if (!c.string(kind) || !c.strings(data) || data.empty()) return badArguments(r, "a kind and its arguments");
  const bool isArchive = kind == "DelayedReadArchive";
  Delayed what{kind, data, std::vector<double>(6)};
  if (isArchive || runs(kind)) {
    if (!c.numbers(6, what.bound.data())) what.bound.clear();
    if (delay(what, r)) return;
  }
  if (isArchive) return readNamedArchive(data[0], r, true);
  if (runs(kind)) return readProgram(what, r);
  geometryRequest(r);
}

// As Procedural, with named parameters.
void Interpreter::procedural2(Request& r) {
  Cursor c(r);
  std::string kind, boundKind;
  if (!c.string(kind)) return badArguments(r, "a kind and its arguments");
  if (kind.ends_with('2')) kind.pop_back();  // both spellings are in use
  const bool isArchive = kind == "DelayedReadArchive";
  if (!isArchive && !runs(kind)) return geometryRequest(r);
  c.string(boundKind);
  const scene::ParameterList given = parameters(r, c.at, Use::Node);
  Delayed what{kind, {}, {}};
  const char* const name = what.isObject() ? "dsoname" : "filename";
  what.data = {given.getString(name, "")};
  if (what.data[0].empty()) return badArguments(r, std::string("\"string ") + name + "\"");
  if (what.isObject())
    what.parameters = textOf(given);
  else if (what.isProgram())
    what.data.push_back(given.getString("data", ""));
  // the bound of a DSOBound is the object's own knowledge: without one it is run with the scene
  if (const scene::Parameter* p = given.find("bound"); p && p->floats.size() == 6 && boundKind != "DSOBound")
    what.bound.assign(p->floats.begin(), p->floats.end());
  // as an exporter says it
  if (!given.getInt("__immediatesubdivide", 0) && delay(what, r)) return;
  if (isArchive) return readNamedArchive(what.data[0], r, true);
  readProgram(what, r);
}

}  // namespace kinora::rib
