// What `kinora plugins` prints, from the declarations of the plug-ins alone: a list, one plug-in in full, and as
// Markdown the index docs/plugins.md and the pages docs/plugins/NAME.md. It loads nothing.
#pragma once
#include <kinora/plugin.h>

#include <string>
#include <vector>

namespace kinora::app {

std::string pluginList(const std::vector<const Descriptor*>& plugins);
std::string pluginText(const Descriptor& plugin);
// The index, with links to the pages and their pictures.
std::string pluginsMarkdown(const std::vector<const Descriptor*>& plugins);
std::string pluginPage(const Descriptor& plugin);
// What is not rendered, or writes what was, shows nothing of its own.
bool hasPicture(const Descriptor& plugin);

}  // namespace kinora::app
