#include "rib/archive_search.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>

#include "base/text.h"
#include "rib/byte_source.h"
#include "rib/condition.h"

namespace kinora::rib {

std::string mapDirectory(const std::string& name, const Dirmap& map) {
  for (const auto& [from, to] : map) {
    if (from.empty() || !name.starts_with(from)) continue;
    const bool isWholePart = name.size() == from.size() || from.ends_with('/') || from.ends_with('\\') ||
                             name[from.size()] == '/' || name[from.size()] == '\\';
    if (isWholePart) return to + name.substr(from.size());
  }
  return name;
}

bool readDirmap(const std::string& text, Dirmap& out) {
  out.clear();
  size_t at = 0;
  const auto next = [&] {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    return at < text.size() ? text[at] : '\0';
  };
  while (next() == '[') {
    ++at;
    std::string parts[3];
    for (std::string& part : parts) {
      if (next() != '"') return false;
      const size_t end = text.find('"', ++at);
      if (end == std::string::npos) return false;
      part = text.substr(at, end - at);
      at = end + 1;
    }
    if (next() != ']') return false;
    ++at;
    std::error_code ignored;
    if (!parts[1].empty() && (lowerCase(parts[0]) == "nfs" || std::filesystem::is_directory(parts[2], ignored)))
      out.emplace_back(parts[1], parts[2]);
  }
  return next() == '\0';
}

std::string withEnvironment(const std::string& path) {
  return substitute(path, '$', true, [](std::string_view name) -> std::optional<std::string> {
    const char* value = std::getenv(std::string(name).c_str());
    return value ? std::optional<std::string>(value) : std::nullopt;
  });
}

std::vector<std::string> expandSearchPath(const std::string& own, const std::vector<std::string>& standard) {
  std::vector<std::string> path;
  for (size_t at = 0; at < own.size();) {
    const size_t colon = std::min(own.find(':', at), own.size());
    const std::string part = own.substr(at, colon - at);
    if (part == "@")
      path.insert(path.end(), standard.begin(), standard.end());
    else if (!part.empty() && part != "&")  // the previous value: nothing before the scene says one
      path.push_back(part);
    at = colon + 1;
  }
  path.insert(path.end(), standard.begin(), standard.end());
  return path;
}

std::string folderOf(const std::string& file) {
  const size_t slash = file.rfind('/', file.find('!'));
  return slash == std::string::npos ? "" : file.substr(0, slash + 1);
}

std::string ArchiveSearch::find(const std::string& asNamed, const std::string& including) const {
  const std::string name = mapDirectory(asNamed, dirmap);
  std::vector<std::string> directories{""};
  if (const size_t end = including.find_last_of("/!"); end != std::string::npos)
    directories.push_back(including.substr(0, end + 1));
  if (const size_t bang = including.find('!'); bang != std::string::npos) {
    directories.push_back(including.substr(0, bang + 1));
    directories.push_back(folderOf(including));
  }
  directories.push_back(mainDirectory);
  for (const std::string& given : path) {
    const std::string d = mapDirectory(given, dirmap);
    directories.push_back(d.ends_with('/') ? d : d + "/");
    if (!d.starts_with('/')) directories.push_back(mainDirectory + directories.back());
  }
  std::string base = name.substr(name.rfind('/') == std::string::npos ? 0 : name.rfind('/') + 1);
  // a member of a zip archive of another machine: "path/a.zip!inner/b.rib" -> "a.zip!inner/b.rib"
  std::string zipBase;
  if (const size_t bang = name.find('!'); bang != std::string::npos) {
    const size_t slash = name.rfind('/', bang);
    zipBase = slash == std::string::npos ? name : name.substr(slash + 1);
  }
  for (const std::string* form : std::initializer_list<const std::string*>{&name, &zipBase, &base}) {
    const std::string& candidate = *form;
    if (candidate.empty()) continue;
    for (const std::string& d : directories) {
      if (candidate.starts_with('/') && !d.empty()) continue;
      if (isReadable(d + candidate)) return d + candidate;
    }
    // exporters write names from the project's folder, which holds the scene some folders further down
    constexpr int kMostUp = 8;
    std::string up = mainDirectory.empty() ? "./" : mainDirectory;
    for (int i = 0; i < kMostUp && form != &base && !candidate.starts_with('/'); ++i)
      if (isReadable((up += "../") + candidate)) return up + candidate;
  }
  return {};
}

}  // namespace kinora::rib
