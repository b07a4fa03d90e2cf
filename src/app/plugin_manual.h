// What `kinora plugins` prints, from the declarations of the plug-ins alone: a list, one plug-in in full, and the
// manual page docs/plugins.md. It loads nothing.
#pragma once
#include <kinora/plugin.h>

#include <string>
#include <vector>

namespace kinora::app {

std::string pluginList(const std::vector<const Descriptor*>& plugins);
std::string pluginText(const Descriptor& plugin);
std::string pluginsMarkdown(const std::vector<const Descriptor*>& plugins);

}  // namespace kinora::app
