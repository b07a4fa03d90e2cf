// `kinora merge PART ... -o FILE`; the adding is film/tools.h's.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include "app/command_line.h"
#include "app/commands.h"
#include "film/tools.h"
#include "plugin/registry.h"

namespace kinora::app {

int runMerge(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("merge",
                 "Adds parts of one frame, written by `kinora render --samples`. The pictures are the "
                 "same, bit for bit, as those of a render in one piece.");
  std::vector<std::string> parts;
  std::string output;
  bool keepShard = false;
  parser->add_option("PART", parts, "parts of one frame")->required();
  parser->add_option("-o,--output", output, "write the primary picture here; else all go where the scene says")
      ->type_name("FILE");
  parser->add_flag("--keep-samples", keepShard, "write a larger part instead of pictures; needs -o");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;
  if (keepShard && output.empty()) return badCommandLine(diagnostics, "--keep-samples needs -o FILE");
  Registry registry;
  const auto driver = [&](const std::string& name) { return registry.find(Kind::Display, name, diagnostics, {}); };
  const film::ToolResult result = film::mergeParts(parts, output, keepShard, driver, diagnostics);
  fmt::print("{}", result.text);
  return result.exitCode;
}

}  // namespace kinora::app
