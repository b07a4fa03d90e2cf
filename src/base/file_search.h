// Where a file that a scene names may stand. Scenes come from other machines: a name that is not there is sought by
// ever shorter tails along the search path ("/a/b/c.tex": "b/c.tex", "c.tex"). Used for textures and volumes. Asks no
// disk.
#pragma once
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace kinora {

struct FilePlaces {
  std::vector<std::filesystem::path> list;
  size_t exact = 0;  // so many at the front are where the name itself says
};

// Directories in order, the working directory last; backslashes count as slashes, "C:/..." is absolute.
inline FilePlaces placesOf(std::string name, const std::vector<std::string>& searchPath) {
  std::replace(name.begin(), name.end(), '\\', '/');
  FilePlaces places;
  const auto add = [&](const std::string& file) {
    for (const std::string& d : searchPath) places.list.push_back(std::filesystem::path(d) / file);
    places.list.push_back(file);
  };
  const bool isAbsolute = !name.empty() && (name[0] == '/' || (name.size() > 2 && name[1] == ':' && name[2] == '/'));
  if (isAbsolute)
    places.list.push_back(name);
  else
    add(name);
  places.exact = places.list.size();
  for (size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1))
    if (const std::string tail = name.substr(slash + 1); !tail.empty() && tail[0] != '/') add(tail);
  return places;
}

}  // namespace kinora
