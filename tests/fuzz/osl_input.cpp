#include "fuzz/osl_input.h"

#include <cstdio>
#include <cstdlib>
#include <map>

#include "language/front/compile.h"
#include "language/program/oso_reader.h"
#include "language/program/oso_writer.h"

namespace kinora::fuzz {

namespace {

constexpr std::string_view kCut = "\n##file ";
constexpr size_t kMostRead = 1 << 18;  // bytes of .oso that are read again

[[noreturn]] void fail(const char* what, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n", what, why.c_str());
  std::abort();
}

}  // namespace

size_t compileOslInput(std::string_view bytes) {
  std::map<std::string, std::string, std::less<>> files;
  size_t at = bytes.find(kCut);
  const std::string_view source = bytes.substr(0, at);
  while (at != std::string_view::npos && files.size() < 8) {
    const size_t name = at + kCut.size(), end = bytes.find('\n', name);
    if (end == std::string_view::npos) break;
    const size_t next = bytes.find(kCut, end);
    files.emplace(bytes.substr(name, end - name), bytes.substr(end + 1, next - end - 1));
    at = next;
  }
  const language::FileReader reader = [&](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  };
  language::CompileOptions options;
  if (bytes.size() % 4 == 1) options.defines = {"SIZE=4"};
  if (bytes.size() % 8 == 3) language::preprocess(source, "main.osl", options, reader);
  const language::CompileResult result = language::compile(source, "main.osl", options, reader);
  size_t length = 0;
  for (const language::CompileMessage& m : result.messages) length += m.str().size();
  if (!result.ok()) {
    if (length == 0) fail("refused without a message", std::string(source));
    return result.messages.size();
  }
  if (const std::string why = invalid(*result.shader); !why.empty()) fail("compiled to what is invalid", why);
  toText(*result.shader);
  const std::string text = language::osoText(*result.shader);
  if (text.size() > kMostRead) return result.messages.size();
  language::Shader again;
  std::string error;
  if (!language::readOso(text, "main.oso", again, error)) fail("wrote what is not read", error + "\n" + text);
  if (language::osoText(again) != text) fail("written, read and written again is something else", text);
  return result.messages.size();
}

}  // namespace kinora::fuzz
