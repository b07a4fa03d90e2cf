// Files of volumes among files of pictures. Used by every reader of either.
#pragma once
#include <cstring>
#include <fstream>
#include <string>

namespace kinora::image {

// Files of volumes (OpenVDB) by their first bytes, whatever their names say. OpenImageIO opens them as pictures
// through a library that ends the program, or never returns, where a file is damaged: nobody hands it one.
inline bool holdsVolumes(const std::string& path) {
  char first[8] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  return std::memcmp(first, " BDV\0\0\0\0", sizeof first) == 0;
}

}  // namespace kinora::image
