// Reads the tiles that a group of lookups is missing: by the thread that asks, in order; where files keep their readers
// waiting (a disk, a network) together with a few threads that do nothing else, so that the waits overlap. What is
// read, and every value, are the same. Called by TileTable.
#pragma once
#include <OpenImageIO/imagecache.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "texture/module/pyramid_input.h"
#include "texture/module/reader_pool.h"
#include "texture/texture_system.h"

namespace kinora::texture {

// One tile, and what came of it: null when it cannot be read.
struct TileRead {
  OIIO::ImageCache::ImageHandle* file = nullptr;
  int level = 0, x = 0, y = 0;
  bool isWithPrevious = false;  // to be read by the same thread: what is read for one serves the other
  OIIO::ImageCache::Tile* tile = nullptr;
};

// Thread-safe. Its threads start when they are first of use, and end with it; then no lookup is under way.
class TileReaders {
 public:
  // 1,600 tiles a second where each takes 10 ms; they sleep nearly always.
  static constexpr int kThreads = 16;

  TileReaders(LevelMaker& maker, ReadPace& pace) : maker_(maker), pace_(pace) {}
  ~TileReaders();
  TileReaders(const TileReaders&) = delete;
  TileReaders& operator=(const TileReaders&) = delete;

  void setWay(TextureReading::Way way) { way_.store(way, std::memory_order_relaxed); }
  TextureReading::Way way() const { return way_.load(std::memory_order_relaxed); }

  // Reads all of them; no lock is held meanwhile. `why` says what was wrong with one, if any was.
  void read(TileRead* reads, uint32_t count, OIIO::ImageCache::Perthread* thread, std::string& why);

 private:
  struct Batch {
    TileRead* reads = nullptr;
    uint32_t count = 0;
    // the rest is under mutex_
    uint32_t next = 0;     // not begun
    uint32_t helpers = 0;  // threads that are at some of it
    std::string why;
    std::exception_ptr failed;
  };
  struct Job {
    uint32_t begin = 0, end = 0;
  };
  static Job take(Batch& batch);
  void readOne(TileRead& read, OIIO::ImageCache::Perthread* thread, std::string& why);
  // Takes and reads one job; `lock` holds mutex_ before and after. False: all are begun.
  bool workOn(Batch& batch, OIIO::ImageCache::Perthread* thread, std::unique_lock<std::mutex>& lock);
  void help();

  LevelMaker& maker_;
  ReadPace& pace_;
  std::atomic<TextureReading::Way> way_{TextureReading::Measured};
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::deque<Batch*> open_;  // with something not begun; threads take from them in turn
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace kinora::texture
