// `kinora explain CODE`.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/explanations.h"

namespace kinora::app {

namespace {

// Breaks at spaces, so that a paragraph fits a terminal.
std::string wrapped(std::string_view text, size_t width) {
  std::string out, line;
  const auto flush = [&] {
    out += line + "\n";
    line.clear();
  };
  for (size_t at = 0; at < text.size();) {
    size_t end = text.find_first_of(" \n", at);
    if (end == std::string_view::npos) end = text.size();
    const std::string_view word = text.substr(at, end - at);
    if (!word.empty()) {
      if (!line.empty() && line.size() + 1 + word.size() > width) flush();
      if (!line.empty()) line += ' ';
      line += word;
    }
    if (end < text.size() && text[end] == '\n') flush();
    at = end + 1;
  }
  if (!line.empty()) flush();
  return out;
}

}  // namespace

int runExplain(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser = makeParser("explain", "Prints the long form of a message's code; without a code, lists them.");
  std::string code;
  parser->add_option("CODE", code, "as printed in the message, e.g. RIB-SYNTAX; case does not matter");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;

  const Explanations all = allExplanations();
  if (code.empty()) {
    for (const std::string_view known : all.codes()) fmt::print("{}\n", known);
    return kComplete;
  }
  if (const Explanation* found = all.find(code)) {
    fmt::print("{}\n\n{}", found->code, wrapped(found->text, 100));
    return kComplete;
  }
  const auto codes = all.codes();
  const std::string near = didYouMean(code, {codes.begin(), codes.end()});
  return badCommandLine(diagnostics, "there is no message code '" + code + "'",
                        near.empty() ? "`kinora explain` lists all codes" : near);
}

}  // namespace kinora::app
