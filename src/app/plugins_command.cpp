// `kinora plugins [NAME]`.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <fmt/format.h>

#include <algorithm>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/plugin_manual.h"
#include "app/plugin_path.h"
#include "base/text.h"
#include "plugin/registry.h"

namespace kinora::app {

int runPlugins(const Arguments& arguments) {
  Diagnostics diagnostics;
  const auto parser = makeParser("plugins", "Lists plug-ins, or one's parameters with defaults, ranges and help.");
  std::string name;
  std::vector<std::string> path;
  bool markdown = false;
  parser->add_option("NAME", name, "a plug-in; case does not matter");
  takeOneAtATime(
      parser->add_option("--plugin-path", path, "look for plug-ins here too; may be repeated")->type_name("DIR"));
  parser->add_flag("--markdown", markdown, "as the manual has it: the index of stock plug-ins, or the page of NAME");
  if (const auto done = parse(*parser, arguments, diagnostics)) return *done;

  if (const std::string missing = missingDirectory(path); !missing.empty())
    return badCommandLine(diagnostics, "the plug-in folder '" + missing + "' does not exist");

  Registry registry;
  if (markdown && name.empty()) {
    // the page in docs/ must not depend on what a machine has installed
    fmt::print("{}", pluginsMarkdown(registry.all()));
    return kComplete;
  }
  registry.setPath(pluginDirectories(path));
  registry.loadAll(diagnostics);
  if (name.empty()) {
    fmt::print("{}", pluginList(registry.all()));
    return kComplete;
  }
  // one name may stand for plug-ins of several kinds
  bool isFound = false;
  std::vector<std::string> names;
  for (const Descriptor* d : registry.all()) {
    names.emplace_back(d->name);
    if (!sameName(d->name, name)) continue;
    fmt::print("{}{}", isFound ? "\n" : "", markdown ? pluginPage(*d) : pluginText(*d));
    isFound = true;
  }
  if (isFound) return kComplete;
  return badCommandLine(diagnostics, "there is no plug-in '" + name + "'", didYouMean(name, names));
}

}  // namespace kinora::app
