#include "shade/shader_library.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "language/front/compile.h"
#include "language/optimise/walk.h"
#include "language/program/oso_reader.h"
#include "language/program/oso_writer.h"

namespace kinora::shade {

namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

constexpr std::string_view kReads = "# Reads ";  // in what writeBeside() writes: an included file, to its line's end

bool isFile(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

int64_t timeOf(const struct stat& s) { return int64_t(s.st_mtim.tv_sec) * 1000000000 + s.st_mtim.tv_nsec; }
int64_t timeOf(const std::string& path) {  // -1: no such file
  struct stat s;
  return stat(path.c_str(), &s) ? -1 : timeOf(s);
}

uint64_t hashOf(const std::string& text) { return std::hash<std::string>()(text); }

// A pattern computes values; what scatters light is the bxdf that they feed.
void warnOfClosures(const language::Shader& shader, Diagnostics& diagnostics) {
  const language::Instruction* first = nullptr;
  language::forEachInstruction(shader.main, [&](const language::Instruction& in) {
    if (in.opcode == language::Opcode::MakeClosure && !first) first = &in;
  });
  if (!first) return;
  const language::Symbol* name = nullptr;
  for (size_t i = 1; i < first->arguments.size() && !name; ++i) {
    const language::Symbol& s = shader.symbols[size_t(first->arguments[i])];
    if (s.type.base == language::Base::String && s.values.strings.size() == 1) name = &s;
  }
  diagnostics.warning("SHADER-CLOSURE", first->pos,
                      "closure " + (name ? name->values.strings[0] + "()" : std::string()) + " of shader '" +
                          shader.name + "' has no effect in a pattern",
                      "Ci and outputs that are closures are left out; its other outputs are computed",
                      "connect them to a Bxdf, which scatters the light");
}

void forgetPlaces(language::Block& block) {
  for (language::Instruction& in : block.code) {
    in.pos = {};
    for (language::Block& inner : in.blocks) forgetPlaces(inner);
  }
}

// Of a compiled shader; "" where there is none, and of sources.
std::string sourceBeside(const std::string& path) {
  if (!path.ends_with(".oso")) return {};
  const std::string source = path.substr(0, path.size() - 4) + ".osl";
  return isFile(source) ? source : std::string();
}

// Of what a shader computes: the same for its source, for a copy in another folder and for what it was compiled to.
Digest programOf(language::Shader shader) {
  forgetPlaces(shader.main);
  for (language::Initialiser& i : shader.initialisers) forgetPlaces(i.code);
  return digestOf(language::osoText(shader));
}

}  // namespace

ShaderLibrary::Stamp ShaderLibrary::stampOf(const std::string& path) {
  Stamp stamp;
  stamp.path = path;
  struct stat s;
  if (!stat(path.c_str(), &s)) {
    stamp.time = timeOf(s);
    stamp.size = uint64_t(s.st_size);
    stamp.isYoung = std::time(nullptr) - s.st_mtim.tv_sec < 2;
  }
  return stamp;
}

bool ShaderLibrary::isAsBefore(Stamp& stamp) {
  Stamp now = stampOf(stamp.path);
  if (!stamp.isYoung && now.time == stamp.time && now.size == stamp.size) return true;
  const std::optional<std::string> text = language::readSourceFile(stamp.path);
  now.textHash = text ? hashOf(*text) : 0;
  if (now.textHash != stamp.textHash) return false;
  stamp = std::move(now);
  return true;
}

void ShaderLibrary::begin(std::vector<std::string> searchPath, bool keepCompiled) {
  searchPath_ = std::move(searchPath);
  keepCompiled_ = keepCompiled;
  byName_.clear();
  // what the last world did not ask for
  std::erase_if(texts_, [&](const auto& text) {
    if (text.second.usedAt == generation_) return false;
    if (text.second.node->shader) executables_.forget(*text.second.node->shader);
    return true;
  });
  // of files that have changed
  std::erase_if(displacements_, [&](const auto& of) {
    if (of.first.use_count() > 1) return false;
    if (of.second) executables_.forget(*of.second->shader);
    return true;
  });
  ++generation_;
}

std::shared_ptr<const ShaderNode> ShaderLibrary::displacementOf(const std::shared_ptr<const ShaderNode>& node) {
  const auto [it, isNew] = displacements_.try_emplace(node);
  if (isNew) it->second = withMovedPoint(*node);
  return it->second;
}

std::shared_ptr<const ShaderNode> ShaderLibrary::fromSource(const std::string& source, const std::string& name) {
  Text& text = texts_[source];
  text.usedAt = generation_;
  if (text.node) return text.node;
  const SteadyClock::time_point start = SteadyClock::now();
  ++compiled_;
  language::CompileOptions options;
  options.withWarnings = false;
  language::CompileResult result =
      language::compile(source, name, options, [](const std::string&) { return std::optional<std::string>(); });
  std::shared_ptr<language::Shader> shader;
  if (result.ok())
    shader = std::make_shared<language::Shader>(std::move(*result.shader));
  else
    diagnostics_.error("SHADER-COMPILE", {},
                       "what stands for '" + name + "' cannot be used: " +
                           (result.messages.empty() ? std::string() : result.messages[0].str()),
                       "what it feeds is magenta where it is a colour, else has its default");
  compileSeconds_ += std::chrono::duration<double>(SteadyClock::now() - start).count();
  text.node = makeShaderNode(name, std::move(shader));
  return text.node;
}

std::shared_ptr<const ShaderNode> ShaderLibrary::refused(const std::string& expression, const std::string& problem,
                                                         const SourcePos& pos) {
  Text& text = texts_["refused " + expression];
  text.usedAt = generation_;
  if (text.node) return text.node;
  diagnostics_.error("PATTERN-EXPRESSION", pos, "an expression cannot be used: " + problem,
                     "what it feeds is magenta where it is a colour, else has its default");
  text.node = makeShaderNode("expression", nullptr);
  return text.node;
}

std::shared_ptr<language::Shader> ShaderLibrary::read(const std::string& path, File& file) {
  const SteadyClock::time_point start = SteadyClock::now();
  ++compiled_;
  file.wrong.clear();
  file.stamps.clear();
  // stamped before it is read: what is written meanwhile is seen as a change
  const auto reader = [&](const std::string& name) {
    Stamp stamp = stampOf(name);
    std::optional<std::string> text = language::readSourceFile(name);
    if (text) stamp.textHash = hashOf(*text);
    file.stamps.push_back(std::move(stamp));
    return text;
  };
  auto shader = std::make_shared<language::Shader>();
  const std::optional<std::string> text = reader(path);
  if (!text) {
    file.wrong = "it cannot be read";
  } else if (path.ends_with(".oso")) {
    if (!language::readOso(*text, path, *shader, file.wrong) && file.wrong.empty())
      file.wrong = "it is no compiled shader";
  } else {
    language::CompileOptions options;
    options.includePaths = searchPath_;
    options.includePaths.insert(options.includePaths.begin(), fs::path(path).parent_path().string());
    options.withWarnings = false;
    options.maxErrors = 10;
    language::CompileResult result = language::compile(*text, path, options, reader);
    for (const language::CompileMessage& m : result.messages)
      if (m.severity == Severity::Error) file.wrong += (file.wrong.empty() ? "" : "\n") + m.str();
    if (result.ok())
      *shader = std::move(*result.shader);
    else if (file.wrong.empty())
      file.wrong = "it cannot be compiled";
  }
  compileSeconds_ += std::chrono::duration<double>(SteadyClock::now() - start).count();
  return file.wrong.empty() ? shader : nullptr;
}

std::shared_ptr<const ShaderNode> ShaderLibrary::open(const std::string& path, const SourcePos& pos) {
  File& file = files_[path];
  if (file.lookedAt == generation_) return file.node;
  file.lookedAt = generation_;
  bool isSame = file.node != nullptr;
  for (Stamp& stamp : file.stamps) isSame = isSame && isAsBefore(stamp);
  // what was wrong may have been an include that was not there
  if (isSame && file.node->shader) return file.node;
  const std::shared_ptr<const ShaderNode> before = file.node;
  const std::string wrongBefore = file.wrong;
  std::shared_ptr<language::Shader> shader = read(path, file);
  if (before && before->shader) executables_.forget(*before->shader);
  if (before && (shader || file.wrong != wrongBefore))
    diagnostics_.info("SHADER-RECOMPILED", pos, "shader '" + path + "' has changed and is compiled again");
  if (shader && keepCompiled_ && path.ends_with(".osl")) writeBeside(path, *shader, file, pos);
  const bool isNews = !shader && !(before && file.wrong == wrongBefore);
  if (isNews && !sourceBeside(path).empty())
    diagnostics_.warning("SHADER-OSO", pos, "compiled shader '" + path + "' cannot be used: " + file.wrong,
                         "its source beside it is compiled", "removing the .oso file ends this message");
  else if (isNews)
    diagnostics_.error("SHADER-COMPILE", pos, "shader '" + path + "' cannot be used: " + file.wrong,
                       "what it feeds is magenta where it is a colour, else has its default",
                       "kinora shader compile says the same without rendering");
  if (shader) warnOfClosures(*shader, diagnostics_);
  if (contents_) file.program = shader ? programOf(*shader) : digestOf("it cannot be compiled");
  file.node = makeShaderNode(path, std::move(shader));
  return file.node;
}

void ShaderLibrary::writeBeside(const std::string& path, const language::Shader& shader, const File& file,
                                const SourcePos& pos) {
  std::string text = language::osoText(shader);
  std::string reads;
  for (size_t i = 1; i < file.stamps.size(); ++i)
    if (file.stamps[i].path.find('\n') == std::string::npos)
      reads += std::string(kReads) + file.stamps[i].path + "\n";
  text.insert(text.find('\n') + 1, reads);
  const std::string name = path.substr(0, path.size() - 4) + ".oso", other = name + "." + std::to_string(getpid());
  // whole or not at all: others may read it now
  std::ofstream out(other, std::ios::binary);
  out << text;
  out.close();
  std::error_code failed;
  if (out) fs::rename(other, name, failed);
  if (out && !failed) return;
  fs::remove(other, failed);
  diagnostics_.warning("SHADER-CACHE", pos, "compiled shader '" + name + "' cannot be written",
                       "it is compiled again next time", "Option \"shader\" \"int cache\" [0] does not ask for it");
}

// NAME.osl or NAME.oso, "" when there is neither. A compiled one counts when it is newer than all of its sources.
std::string ShaderLibrary::choose(const std::string& base) const {
  const std::string source = base + ".osl", compiled = base + ".oso";
  const bool hasSource = isFile(source), hasCompiled = isFile(compiled);
  if (!hasSource || !hasCompiled) return hasSource ? source : hasCompiled ? compiled : "";
  if (files_.count(source)) return source;  // in memory, and looked at again
  const int64_t written = timeOf(compiled);
  if (timeOf(source) >= written) return source;
  std::ifstream in(compiled);
  std::string line;
  std::getline(in, line);
  if (!line.starts_with("OpenShadingLanguage 1.00")) return source;
  while (std::getline(in, line) && line.starts_with("#"))
    if (line.starts_with(kReads)) {
      const int64_t time = timeOf(line.substr(kReads.size()));
      if (time < 0 || time >= written) return source;
    }
  return compiled;
}

std::shared_ptr<const ShaderNode> ShaderLibrary::find(const std::string& name, const SourcePos& pos) {
  if (const auto it = byName_.find(name); it != byName_.end()) return it->second;
  std::vector<fs::path> places;
  const fs::path asked(name);
  if (!asked.is_absolute())
    for (const std::string& directory : searchPath_) places.push_back(fs::path(directory) / asked);
  places.push_back(asked);
  std::string path;
  for (size_t i = 0; i < places.size() && path.empty(); ++i) {
    const std::string extension = places[i].extension().string();
    if ((extension == ".osl" || extension == ".oso") && isFile(places[i].string()))
      path = places[i].string();
    else
      path = choose(places[i].string());
  }
  std::shared_ptr<const ShaderNode>& found = byName_[name];
  if (!path.empty()) found = open(path, pos);
  if (found && !found->shader && !sourceBeside(path).empty()) {
    path = sourceBeside(path);
    found = open(path, pos);
  }
  if (contents_ && found)
    contents_->use("shader", name, files_[path].program);
  else if (contents_)
    contents_->use("shader", name, std::vector<std::string>());
  return found;
}

}  // namespace kinora::shade
