#include "app/plugin_path.h"

#include <cstdlib>
#include <filesystem>

namespace kinora::app {

std::vector<std::string> splitPath(const std::string& path) {
  std::vector<std::string> parts;
  for (size_t at = 0; at <= path.size();) {
    const size_t end = std::min(path.find(':', at), path.size());
    if (end > at) parts.push_back(path.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

std::string missingDirectory(const std::vector<std::string>& fromCommandLine) {
  std::error_code ignored;
  for (const std::string& given : fromCommandLine)
    for (const std::string& part : splitPath(given))
      if (!std::filesystem::is_directory(part, ignored)) return part;
  return {};
}

std::vector<std::string> pluginDirectories(const std::vector<std::string>& fromCommandLine) {
  std::vector<std::string> directories;
  for (const std::string& given : fromCommandLine)
    for (std::string& part : splitPath(given)) directories.push_back(std::move(part));
  if (const char* environment = std::getenv("KINORA_PLUGIN_PATH"))
    for (std::string& part : splitPath(environment)) directories.push_back(std::move(part));
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) directories.push_back((program.parent_path().parent_path() / "lib/kinora/plugins").string());
  return directories;
}

}  // namespace kinora::app
