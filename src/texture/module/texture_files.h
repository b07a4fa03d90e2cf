// Where a texture's file is and whether it can be used: search path, tails of foreign paths, other extensions, atlas
// tokens, and a check of the header before anything is allocated. Called by TextureSystem only; reads headers, no
// pixels.
#pragma once
#include <OpenImageIO/typedesc.h>

#include <string>
#include <vector>

namespace kinora::texture {

// The facts of a header that lookups need.
struct FileFacts {
  std::string path;
  int width = 0, height = 0, channels = 0;
  int alphaChannel = -1;
  bool tiled = false, mipMapped = false;
  bool cropped = false;  // the data window is not the display window
  OIIO::TypeDesc format;
  bool bytes = false;  // 8-bit integers
  bool srgb = false;   // the file says so, or stores 8-bit integers
  std::string wrap;    // "wrapmodes" of the file; "" when it has none
};

// "" when the file can be used, else what is wrong with it. Refuses images whose header promises more than a file of
// that size can hold, so that a damaged header costs neither memory nor hours.
std::string examine(const std::string& path, FileFacts& facts);

// Existing regular files that `name` may stand for, best first. `exact` receives how many of them have the very name
// along the search path (the rest are guesses that deserve a message).
std::vector<std::string> candidates(const std::string& name, const std::vector<std::string>& searchPath,
                                    size_t& exact);

// One file of an atlas: the unit square [u, u+1) x [v, v+1), v up.
struct AtlasTile {
  int u = 0, v = 0;
  std::string path;
};
inline constexpr int kMaxAtlasSide = 100;

bool isAtlas(const std::string& name);
// The files of an atlas that exist, in order of name; empty when there are none.
std::vector<AtlasTile> atlasTiles(const std::string& name, const std::vector<std::string>& searchPath);

}  // namespace kinora::texture
