// What a frame takes of the limit on memory beside what the stages of its world charge themselves: the description, the
// film with its pictures, and what textures' tiles hold. Held by Renderer.
#pragma once
#include <cstdint>

#include "base/memory.h"
#include "film/display_plan.h"
#include "film/film.h"
#include "texture/texture_system.h"

namespace kinora::render {

class FrameMemory {
 public:
  ~FrameMemory() { setTiles(0); }
  // These two throw MemoryExceeded where it does not fit.
  void setDescription(uint64_t bytes) { description_.set(bytes); }
  // Of the film's sums, as often as they are held, with what adaptive sampling keeps; and of what writing the largest
  // picture takes on top of them: floats and the encoded file.
  void setFilm(const film::Window& window, const film::DisplayPlan& displays, int copies, bool isAdaptive);
  // Textures live with what is left: a smaller cache costs time only. `asked`: by the command line; 0: nothing.
  static void limitTiles(TextureSystem& textures, uint64_t asked);
  // What the tile cache holds now, so that refusals can name it.
  void countTiles(const TextureSystem& textures);

 private:
  void setTiles(int64_t bytes);
  MemoryHold description_{MemoryUse::Description}, film_{MemoryUse::Film}, pictures_{MemoryUse::Pictures};
  int64_t tiles_ = 0;
};

}  // namespace kinora::render
