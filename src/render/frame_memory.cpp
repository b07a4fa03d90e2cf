#include "render/frame_memory.h"

#include <algorithm>

#include "render/adaptive.h"

namespace kinora::render {

void FrameMemory::setFilm(const film::Window& window, const film::DisplayPlan& displays, int copies,
                          bool isAdaptive) {
  film_.set(0);
  pictures_.set(0);
  uint64_t bytes = film::Film::bytesNeeded(window, displays.layout);
  if (isAdaptive) {
    const size_t blocks = ActivePixels(window).blocks();
    bytes += NoiseEstimate::bytesFor(blocks) + Convergence::bytesFor(blocks);
  }
  film_.set(uint64_t(copies) * bytes);
  uint64_t floats = 0;
  for (const film::Output& o : displays.outputs) {
    uint64_t n = 0;
    for (const film::OutputChannel& k : o.channels) n += uint64_t(displays.layout[k.channel].width);
    floats = std::max(floats, n);
  }
  pictures_.set(floats * window.pixels() * sizeof(float) * 3 / 2);
}

void FrameMemory::limitTiles(TextureSystem& textures, uint64_t asked) {
  constexpr uint64_t kLeast = 16 << 20, kUsual = 1 << 30;
  if (Memory::limit() > 0)
    textures.setCacheLimit(std::max(kLeast, std::min(asked ? asked : kUsual, Memory::left() / 4 * 3)));
}

void FrameMemory::countTiles(const TextureSystem& textures) {
  if (Memory::limit() > 0) setTiles(int64_t(textures.statistics().cacheBytes));
}

void FrameMemory::setTiles(int64_t bytes) {
  Memory::count(MemoryUse::Textures, bytes - tiles_);
  tiles_ = bytes;
}

}  // namespace kinora::render
