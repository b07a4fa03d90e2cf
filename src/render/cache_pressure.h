// Whether caches of bounded size, of tessellations and of textures' tiles, hold what a pass made until the next one.
// Asked between passes by Renderer, whose passes are longer where they don't; no pixel follows from it.
#pragma once
#include <array>
#include <cstdint>

#include "render/statistics.h"
#include "render/world_build.h"
#include "texture/texture_system.h"

namespace kinora::render {

class CachePressure {
 public:
  // What was made or read before is of no account.
  explicit CachePressure(WorldBuilder& builder) : builder_(builder), before_(work()) {}
  // Whether of what was made or read since the last question, or the beginning, more than a quarter is gone, or came
  // once more because it was: then a pass of many samples makes it once for all of these.
  bool isHigh() {
    const std::array<Work, 2> was = before_;
    before_ = work();
    for (size_t k = 0; k < was.size(); ++k)
      if (4 * (before_[k].lost - was[k].lost) > before_[k].all - was[k].all) return true;
    return false;
  }

 private:
  struct Work {
    uint64_t all = 0, lost = 0;
  };
  std::array<Work, 2> work() const {
    Statistics now;
    builder_.countLevels(now);
    const TextureStatistics t = builder_.textures().statistics();
    return {Work{now.geometry.made, now.geometry.evicted}, Work{t.cacheMisses, t.tilesAgain}};
  }
  WorldBuilder& builder_;
  std::array<Work, 2> before_;
};

}  // namespace kinora::render
