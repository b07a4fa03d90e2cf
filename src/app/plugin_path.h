// Where plug-in libraries are looked for. Called by commands that need the registry; it opens nothing.
#pragma once
#include <string>
#include <vector>

namespace kinora::app {

// "a:b" as a list; empty parts are left out.
std::vector<std::string> splitPath(const std::string& path);

// The first that is no directory; "" when all are.
std::string missingDirectory(const std::vector<std::string>& fromCommandLine);

// In order: directories of the command line, those of the environment's KINORA_PLUGIN_PATH, and the folder that
// belongs to this program (../lib/kinora/plugins as seen from the executable, so that an installed tree can be
// moved).
std::vector<std::string> pluginDirectories(const std::vector<std::string>& fromCommandLine);

}  // namespace kinora::app
