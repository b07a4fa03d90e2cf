// `kinora merge PART ... -o FILE`; the adding is film/tools.h's.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/plugin_path.h"
#include "film/tools.h"
#include "plugin/registry.h"
#include "render/filters.h"

namespace kinora::app {

int runMerge(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser =
      makeParser("merge",
                 "Adds parts of one frame, written by `kinora render --samples`. The pictures are the "
                 "same, bit for bit, as those of a render in one piece.");
  std::vector<std::string> parts;
  std::string output;
  std::vector<std::string> pluginPath;
  bool keepShard = false;
  parser->add_option("PART", parts, "parts of one frame")->required();
  parser
      ->add_option("-o,--output", output,
                   "write the primary picture here; else it goes where the scene says, as the others do")
      ->type_name("FILE");
  parser->add_flag("--keep-samples", keepShard, "write a larger part instead of pictures; needs -o");
  takeOneAtATime(parser->add_option("--plugin-path", pluginPath, "look for display drivers and display filters here")
                     ->type_name("DIR"));
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;
  if (keepShard && output.empty()) return badCommandLine(diagnostics, "--keep-samples needs -o FILE");
  Registry registry;
  registry.setPath(pluginDirectories(pluginPath));
  const auto driver = [&](const std::string& name) { return registry.find(Kind::Display, name, diagnostics, {}); };
  const auto filters = [&](const film::DisplayPlan& plan, const film::Film& film) {
    return render::displayFiltersOf(plan, film, registry, diagnostics);
  };
  const film::ToolResult result = film::mergeParts(parts, output, keepShard, driver, filters, diagnostics);
  fmt::print("{}", result.text);
  return result.exitCode;
}

}  // namespace kinora::app
