// A file without mip levels, presented to the tile cache with all of them, each made of the next finer one by area
// average. The first coarse level is made tile by tile as it is asked for; those from the second on, a twelfth of the
// image, are made together and kept: a cache that is short of memory would make them of the whole image again and
// again. The finest level, and levels that a part of the file may have, come from the cache's own entry of the file.
// Used by TextureSystem.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kinora::texture {

// The files with levels of one cache; goes before the cache does, and no lookup is under way then.
class LevelMaker {
 public:
  using Lent = std::vector<OIIO::ImageCache::Perthread*>;  // see Asker
  explicit LevelMaker(OIIO::ImageCache& cache, Lent lent = {}) : cache_(cache), idle_(std::move(lent)) {}
  ~LevelMaker();
  LevelMaker(const LevelMaker&) = delete;
  LevelMaker& operator=(const LevelMaker&) = delete;

  // The cache's entry of `file` (a path, or a decoded twin's name) with levels, made when it is not there yet. Texels
  // have more bits than the file's (16 for 8, floats for all others), so that rounding does not add up over levels.
  OIIO::ustring add(const std::string& file);

  // What it has lent, for the next one of the same cache.
  Lent handOver() { return std::move(idle_); }

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

  // Levels of one part of a file from the second coarse one on; empty until they are made. They outlive the cache's
  // closing of the file.
  struct Kept {
    std::mutex mutex;
    std::vector<std::vector<float>> levels;
  };
  Kept& kept(const std::string& file, int part);

 private:
  OIIO::ImageCache::Perthread* borrow();
  void giveBack(OIIO::ImageCache::Perthread* thread);

  OIIO::ImageCache& cache_;
  std::mutex mutex_;
  std::mutex adding_;
  std::set<std::string> added_;
  Lent idle_;
  std::map<std::pair<std::string, int>, Kept> kept_;
};

}  // namespace kinora::texture
