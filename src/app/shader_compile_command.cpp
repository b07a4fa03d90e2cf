// `kinora shader compile`: OSL source to .oso files, with the options of `oslc`.
#include <fmt/format.h>

#include <cstdio>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "app/shader_commands.h"
#include "image/atomic_file.h"
#include "language/front/compile.h"
#include "language/program/oso_writer.h"

namespace kinora::app {

namespace {

constexpr const char* kHelp =
    R"(kinora shader compile [options] FILE.osl ...: compiles each to NAME.oso, NAME being the shader's

  -o FILE         write this file; for one source only
  -I DIR          look for includes here; may be repeated
  -D NAME[=VALUE] define a macro; -U NAME: undefine it
  -E              only preprocess, to standard output or -o FILE
  -M, -MM         only print what the source depends on, as a rule for make
  -MD, -MMD       compile, and write that rule beside the output (FILE.d)
  -MF FILE        where to write the rule; -MT TARGET: what it makes; both also without the blank
  -Wall           all warnings, which is the default; -w: none; -Werror: warnings are errors
  -O0 -O1 -O2     accepted: programs are optimised when they are loaded, with their parameters known
  -q              say nothing but warnings and errors; -v: say more
)";

struct Job {
  language::CompileOptions options;
  std::string output, ruleFile, ruleTarget;
  bool isQuiet = false, isVerbose = false, isPreprocessed = false, isRuleOnly = false, hasRule = false;
};

std::string ruleOf(const std::string& target, const std::vector<std::string>& files) {
  std::string rule = target + ":";
  for (const std::string& f : files) {
    rule += " ";
    for (const char c : f) rule += c == ' ' ? std::string("\\ ") : c == '$' ? std::string("$$") : std::string(1, c);
  }
  return rule + "\n";
}

// False: said why on standard error.
bool write(const std::string& path, const std::string& text) {
  image::AtomicFile file(path);
  std::FILE* f = std::fopen(file.path().c_str(), "wb");
  bool isWritten = f && std::fwrite(text.data(), 1, text.size(), f) == text.size();
  if (f) isWritten &= std::fclose(f) == 0;
  if (isWritten) isWritten = file.commit().ok();
  if (!isWritten) fmt::print(stderr, "{}: error: cannot write the file\n", path);
  return isWritten;
}

std::string withoutEnding(const std::string& path) {
  const size_t dot = path.rfind('.');
  return dot == std::string::npos || path.find('/', dot) != std::string::npos ? path : path.substr(0, dot);
}

int compileOne(const std::string& path, const Job& job, Diagnostics& diagnostics) {
  const std::optional<std::string> source = language::readSourceFile(path);
  if (!source) {
    fmt::print(stderr, "{}: error: cannot read the file\n", path);
    return 1;
  }
  const auto say = [](const std::vector<language::CompileMessage>& messages) {
    for (const language::CompileMessage& m : messages) fmt::print(stderr, "{}\n", m.str());
  };
  if (job.isPreprocessed || job.isRuleOnly) {
    const language::PreprocessResult result = language::preprocess(*source, path, job.options);
    say(result.messages);
    if (!result.isOk) return 1;
    const std::string target = job.ruleTarget.empty() ? withoutEnding(path) + ".oso" : job.ruleTarget;
    const std::string text = job.isRuleOnly ? ruleOf(target, result.files) : result.text;
    const std::string& to = job.isRuleOnly && !job.ruleFile.empty() ? job.ruleFile : job.output;
    if (isOverInput(diagnostics, to, result.files) || isOverInput(diagnostics, to, {path})) return kBadCommandLine;
    if (!to.empty()) return write(to, text) ? kComplete : kCannotWrite;
    fmt::print("{}", text);
    return kComplete;
  }
  const language::CompileResult result = language::compile(*source, path, job.options);
  say(result.messages);
  if (!result.ok()) {
    if (!job.isQuiet) fmt::print("FAILED {}\n", path);
    return 1;
  }
  if (const std::string why = invalid(*result.shader); !why.empty()) {
    fmt::print(stderr, "{}: error: the compiler made a program that is wrong: {}\n", path, why);
    return kInternal;
  }
  const std::string to = job.output.empty() ? result.shader->name + ".oso" : job.output;
  const std::string rule = !job.hasRule ? "" : job.ruleFile.empty() ? withoutEnding(to) + ".d" : job.ruleFile;
  for (const std::string& file : {to, rule})
    if (isOverInput(diagnostics, file, result.files) || isOverInput(diagnostics, file, {path}))
      return kBadCommandLine;
  if (!write(to, language::osoText(*result.shader))) return kCannotWrite;
  if (job.hasRule) {
    if (!write(rule, ruleOf(job.ruleTarget.empty() ? to : job.ruleTarget, result.files))) return kCannotWrite;
  }
  if (!job.isQuiet) fmt::print("Compiled {} -> {}\n", path, to);
  if (job.isVerbose) fmt::print("  {} symbols, {} files read\n", result.shader->symbols.size(), result.files.size());
  return kComplete;
}

}  // namespace

int runShaderCompile(const Arguments& arguments) {
  Diagnostics diagnostics;
  Job job;
  std::vector<std::string> files;
  ShaderOptions o(arguments);
  std::string value;
  while (o.next()) {
    if (!o.isOption()) {
      files.push_back(o.word());
    } else if (o.is("help") || o.is("h")) {
      fmt::print("{}", kHelp);
      return kComplete;
    } else if (o.is("q")) {
      job.isQuiet = true;
    } else if (o.is("v")) {
      job.isVerbose = true;
    } else if (o.is("E")) {
      job.isPreprocessed = true;
    } else if (o.is("M") || o.is("MM")) {
      job.isRuleOnly = true;
    } else if (o.is("MD") || o.is("MMD")) {
      job.hasRule = true;
    } else if (o.joined("MF", job.ruleFile) || o.joined("MT", job.ruleTarget)) {
    } else if (o.is("Wall")) {
      job.options.withWarnings = true;
    } else if (o.is("w")) {
      job.options.withWarnings = false;
    } else if (o.is("Werror")) {
      job.options.warningsAreErrors = true;
    } else if (o.is("O") || o.is("O0") || o.is("O1") || o.is("O2") || o.is("d") || o.is("buffer") ||
               o.is("embed-source") || o.is("embed")) {  // of other compilers; they mean nothing here
    } else if (o.is("o")) {
      o.value(job.output);
    } else if (o.letter('I', value)) {
      job.options.includePaths.push_back(value);
    } else if (o.letter('D', value)) {
      job.options.defines.push_back(value);
    } else if (o.letter('U', value)) {
      job.options.undefines.push_back(value);
    } else if (!o.isMissing()) {
      return badCommandLine(diagnostics, "unknown option '-" + o.word() + "'", "see `kinora shader compile --help`");
    }
    if (o.isMissing()) return badCommandLine(diagnostics, "option -" + o.word() + " needs a value");
  }
  if (files.empty())
    return badCommandLine(diagnostics, "no source file is given", "see `kinora shader compile --help`");
  if (files.size() > 1 && (!job.output.empty() || !job.ruleFile.empty()))
    return badCommandLine(diagnostics, "-o and -MF name one file, but there are several sources");
  int worst = kComplete;
  for (const std::string& f : files) worst = std::max(worst, compileOne(f, job, diagnostics));
  return worst;
}

}  // namespace kinora::app
