// `kinora shader compile|info|run`.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "app/shader_commands.h"
#include "language/program/oso_reader.h"

namespace kinora::app {

bool ShaderOptions::next() {
  if (at_ >= arguments_.size()) return false;
  word_ = arguments_[at_++];
  isOption_ = word_.size() > 1 && word_[0] == '-';
  if (isOption_) word_.erase(0, word_.starts_with("--") ? 2 : 1);
  return true;
}

bool ShaderOptions::value(std::string& out) {
  isMissing_ = at_ >= arguments_.size();
  if (!isMissing_) out = arguments_[at_++];
  return !isMissing_;
}

bool ShaderOptions::joined(std::string_view name, std::string& out) {
  if (!isOption_ || !word_.starts_with(name)) return false;
  if (word_.size() == name.size()) return value(out);
  out = word_.substr(name.size());
  return true;
}

std::optional<language::Shader> loadShader(const std::string& name, const language::CompileOptions& options,
                                           const std::vector<std::string>& path) {
  const bool hasEnding = name.ends_with(".osl") || name.ends_with(".oso");
  std::vector<std::string> candidates;
  for (size_t i = 0; i <= path.size(); ++i) {
    if (i < path.size() && name.starts_with('/')) continue;
    const std::string place = i < path.size() ? path[i] + "/" + name : name;
    if (hasEnding)
      candidates.push_back(place);
    else
      for (const char* ending : {".oso", ".osl"}) candidates.push_back(place + ending);
  }
  for (std::string& file : candidates) {
    std::optional<std::string> source = language::readSourceFile(file);
    if (!source) continue;
    if (file.ends_with(".oso")) {
      language::Shader shader;
      std::string error;
      if (language::readOso(*source, file, shader, error)) return shader;
      fmt::print(stderr, "{}\n", error);
      const std::string beside = file.substr(0, file.size() - 4) + ".osl";
      source = language::readSourceFile(beside);
      if (!source) return std::nullopt;
      fmt::print(stderr, "{}: warning: compiled instead\n", beside);
      file = beside;
    }
    language::CompileResult result = language::compile(*source, file, options);
    for (const language::CompileMessage& m : result.messages) fmt::print(stderr, "{}\n", m.str());
    return std::move(result.shader);
  }
  fmt::print(stderr, "{}: error: cannot read the shader\n", name);
  return std::nullopt;
}

namespace {

struct Subcommand {
  const char* name;
  const char* help;
  int (*run)(const Arguments&);
};
constexpr Subcommand kSubcommands[] = {
    {"compile", "compile OSL source to .oso files", &runShaderCompile},
    {"info", "parameters, defaults and metadata of shaders", &runShaderInfo},
    {"run", "run a shader or a network over a grid of points", &runShaderRun},
};

}  // namespace

int runShader(const Arguments& arguments) {
  const std::string name = arguments.empty() ? "" : arguments.front();
  for (const Subcommand& s : kSubcommands)
    if (name == s.name) return s.run({arguments.begin() + 1, arguments.end()});
  const bool isHelp = name == "--help" || name == "-h" || name == "help";
  if (!isHelp && !name.empty()) {
    Diagnostics diagnostics;
    return badCommandLine(diagnostics, "there is no command 'shader " + name + "'", "see `kinora shader --help`");
  }
  std::FILE* to = isHelp ? stdout : stderr;
  fmt::print(to, "kinora shader: OSL shaders\n\n");
  for (const Subcommand& s : kSubcommands) fmt::print(to, "  kinora shader {:<10}{}\n", s.name, s.help);
  return isHelp ? kComplete : kBadCommandLine;
}

}  // namespace kinora::app
