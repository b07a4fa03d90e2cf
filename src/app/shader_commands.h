// What the commands under `kinora shader` share: their options are spelled as those of the tools that shader writers
// know, with one dash or two, a value in the same word or the next. Each command has a file of its own.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "base/diagnostics.h"
#include "language/front/compile.h"

namespace kinora::app {

int runShaderCompile(const Arguments& arguments);
int runShaderInfo(const Arguments& arguments);
int runShaderRun(const Arguments& arguments);

// One argument after the other. An option is compared without its dashes.
class ShaderOptions {
 public:
  explicit ShaderOptions(const Arguments& arguments) : arguments_(arguments) {}
  bool next();  // false at the end
  bool isOption() const { return isOption_; }
  const std::string& word() const { return word_; }  // an option's name without dashes, or what is no option
  bool is(std::string_view name) const { return isOption_ && word_ == name; }
  // -DX and -D X: the value of a one-letter option; nothing when it is another or the value is missing.
  bool letter(char c, std::string& value) { return joined(std::string_view(&c, 1), value); }
  bool joined(std::string_view name, std::string& value);  // -MFX and -MF X alike
  // The next argument; false: there is none.
  bool value(std::string& out);
  bool isMissing() const { return isMissing_; }

 private:
  const Arguments& arguments_;
  size_t at_ = 0;
  std::string word_;
  bool isOption_ = false, isMissing_ = false;
};

// A shader from NAME.osl (compiled in memory), NAME.oso, or NAME with one of these endings. Nothing: why not was said
// on standard error.
// Relative names are sought in the directories of `path`, then here.
std::optional<language::Shader> loadShader(const std::string& name, const language::CompileOptions& options,
                                           const std::vector<std::string>& path = {});

}  // namespace kinora::app
