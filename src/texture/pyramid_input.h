// A file without mip levels, presented to the tile cache with all of them: each made of the next finer one by area
// average, tile by tile as they are asked for, so that only the cache holds pixels. It takes the finest level, and
// levels that a part of the file may have, from the cache's own entry of the file. Used by TextureSystem.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <mutex>
#include <string>
#include <vector>

namespace kinora::texture {

// The files with levels of one cache; goes before the cache does, and no lookup is under way then.
class LevelMaker {
 public:
  explicit LevelMaker(OIIO::ImageCache& cache) : cache_(cache) {}
  ~LevelMaker();
  LevelMaker(const LevelMaker&) = delete;
  LevelMaker& operator=(const LevelMaker&) = delete;

  // The cache's entry of `file` (a path, or a decoded twin's name) with levels, made when it is not there yet. Texels
  // have more bits than the file's (16 for 8, floats for all others), so that rounding does not add up over levels.
  OIIO::ustring add(const std::string& file);

  // What the cache remembers for a thread. A reader that the cache has called cannot ask it with the caller's, which
  // is in the middle of a search; the cache's list of them only grows, so they are lent.
  class Asker {
   public:
    explicit Asker(LevelMaker& maker) : maker_(maker), thread_(maker.borrow()) {}
    ~Asker() { maker_.giveBack(thread_); }
    Asker(const Asker&) = delete;
    Asker& operator=(const Asker&) = delete;
    OIIO::ImageCache::Perthread* thread() const { return thread_; }

   private:
    LevelMaker& maker_;
    OIIO::ImageCache::Perthread* thread_;
  };
  OIIO::ImageCache& cache() { return cache_; }

 private:
  OIIO::ImageCache::Perthread* borrow();
  void giveBack(OIIO::ImageCache::Perthread* thread);

  OIIO::ImageCache& cache_;
  std::mutex mutex_;
  std::vector<OIIO::ImageCache::Perthread*> idle_;
};

}  // namespace kinora::texture
