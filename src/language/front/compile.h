// The door of the front end: OSL source to the intermediate form. Called by the material builder, `kinora shader` and
// tests. It keeps nothing between calls and reads files only through the reader it is given, so that any number of
// threads may compile at once, and source from anywhere is safe to compile. It does not optimise.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "language/program/program.h"

namespace kinora::language {

struct CompileMessage {
  Severity severity = Severity::Error;
  SourcePos pos;
  uint32_t column = 0;     // from 1, in bytes; 0: the message belongs to no place in a line
  std::string text;        // without position
  std::string sourceLine;  // the line that pos names, without its end
  // "file.osl:3: error: text", and two more lines where there is a column: "  3:9 | float x = y;" and a caret.
  std::string str() const;
};

struct CompileOptions {
  std::vector<std::string> includePaths;
  std::vector<std::string> defines;    // NAME or NAME=VALUE
  std::vector<std::string> undefines;  // NAME
  bool warningsAreErrors = false;
  bool withWarnings = true;
  uint32_t maxErrors = 50;  // then the compilation stops
  // Gets each operator and library function that the source uses, with types: "float + color", "float sin (float)".
  std::vector<std::string>* uses = nullptr;
};

// The text of a file, or nothing when it cannot be read. `path` is as the include has it, after a search path where
// there is one.
using FileReader = std::function<std::optional<std::string>(const std::string& path)>;
// Reads files of at most 64 MB.
std::optional<std::string> readSourceFile(const std::string& path);

struct CompileResult {
  std::optional<Shader> shader;  // when there was no error
  std::vector<CompileMessage> messages;
  std::vector<std::string> files;  // what was read, `name` first, without the headers that are built in
  bool ok() const { return shader.has_value(); }
};
CompileResult compile(std::string_view source, const std::string& name, const CompileOptions& = {},
                      const FileReader& = readSourceFile);

struct PreprocessResult {
  std::string text;  // with the lines of `name` where they were
  std::vector<CompileMessage> messages;
  std::vector<std::string> files;
  bool isOk = false;
};
PreprocessResult preprocess(std::string_view source, const std::string& name, const CompileOptions& = {},
                            const FileReader& = readSourceFile);

}  // namespace kinora::language
