// Several readers of one file at once, presented to the tile cache as one: the library's readers let one thread in at a
// time, which would have all others wait while a disk or a network answers. Another reader is opened when all of a file
// are busy, within what the process may have open. Used by TextureStore through ImageCache::add_file.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <atomic>
#include <cstdint>
#include <string>

namespace kinora::texture {

// What the readers of one cache share. It lives as long as the cache, whose entries know it.
struct ReadPace {
  // Microseconds that a read has lately been without the CPU because it waited for its file.
  std::atomic<float> waited{0};
  std::atomic<int> extra{0};       // readers beside the first of each file
  std::atomic<uint32_t> delay{0};  // microseconds that each read takes longer (TextureReading)

  // Whether tiles are worth being read by threads of their own: handing a tile over costs some 20 microseconds.
  bool isSlow() const { return waited.load(std::memory_order_relaxed) > 100.f; }
};

// Enters a file into the cache, unless it is there already: as it is stored, or what createSrgbInput() makes of it.
void addPooledFile(OIIO::ImageCache& cache, OIIO::ustring name, ReadPace& pace, bool isSrgb,
                   OIIO::ImageSpec config = OIIO::ImageSpec());

}  // namespace kinora::texture
