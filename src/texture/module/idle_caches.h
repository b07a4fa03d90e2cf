// Tile caches that are not in use, for the texture stores to come. Taken and given back by OpenTextures.
#pragma once
#include <OpenImageIO/texture.h>

#include <mutex>
#include <utility>
#include <vector>

#include "texture/module/pyramid_input.h"
#include "texture/module/reader_pool.h"

namespace kinora::texture {

// Tile caches that are not in use. The library knows what it keeps for a thread by the cache's address, and forgets it for
// the thread alone that frees the cache: another cache in the same place would be asked with files of the one before, by
// threads that live on. So caches are emptied and used again, and never freed.
struct LentCache {
  OIIO::TextureSystem* cache = nullptr;
  texture::LevelMaker::Lent threads;  // the library cannot count once one of them was destroyed
  ReadPace* pace = nullptr;           // of the files that the cache knows, so that it stays, too
};
class IdleCaches {
 public:
  static LentCache take() {
    const std::lock_guard lock(mutex());
    std::vector<LentCache>& list = idle();
    if (list.empty()) return {OIIO::TextureSystem::create(false), {}, new ReadPace};
    LentCache lent = std::move(list.back());
    list.pop_back();
    return lent;
  }
  static void giveBack(LentCache lent) {
    lent.cache->invalidate_all(true);  // files are looked at anew
    lent.cache->reset_stats();
    lent.pace->delay = 0;
    lent.pace->waited = 0;
    const std::lock_guard lock(mutex());
    idle().push_back(std::move(lent));
  }

 private:
  static std::mutex& mutex() {
    static auto* const m = new std::mutex;
    return *m;
  }
  static std::vector<LentCache>& idle() {
    static auto* const list = new std::vector<LentCache>;
    return *list;
  }
};

}  // namespace kinora::texture
