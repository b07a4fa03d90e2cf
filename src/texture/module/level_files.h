// Files without mip levels, made tiled with all levels once and kept in a folder for later frames and other processes:
// what the tile cache reads of them instead has the same bits. Called by TextureSystem where the user names a folder.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <string>

namespace kinora::texture {

// The finest level as the source stores it, and all coarser ones (two files: their texels have other types).
struct LevelFiles {
  std::string finest, coarser;
};

// Of `source`, which the cache knows as `finest` and with levels as `levels`. Files that are there and whole are taken;
// their names follow from the source's place, size and time, and from how it is decoded, so that one that has changed
// is made anew. "" or why there are none; what is half made is removed. May run in several processes at once.
std::string keepLevels(OIIO::ImageCache& cache, OIIO::ImageCache::Perthread* thread, const std::string& folder,
                       const std::string& source, OIIO::ustring finest, OIIO::ustring levels, LevelFiles& out);

}  // namespace kinora::texture
