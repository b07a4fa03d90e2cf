// Where the bricks of grids lie: in memory up to a bound, and beyond it in a file without a name that is mapped, of which
// no more stays in memory than the bound allows. Made by VolumeSystem for all grids that it reads; asked by VoxelGrid.
// Bricks are written once and keep their addresses, so that a lookup reads them as if all were in memory: what the bound
// decides is time alone.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/memory.h"

namespace kinora::volume {

class VoxelStore {
 public:
  // bytes: the bound, 0: none, all is in memory. folder: of the file, "": TMPDIR or else /tmp, unless that is a file system in
  // memory and /var/tmp is not.
  explicit VoxelStore(uint64_t bytes, std::string folder = "");
  ~VoxelStore();
  VoxelStore(const VoxelStore&) = delete;
  VoxelStore& operator=(const VoxelStore&) = delete;

  // Room for so many numbers, not initialised, for the life of the store. One thread at a time. Throws MemoryExceeded
  // or bad_alloc. level: of the grid that they belong to, 0 being the finest. The coarse ones are what most lookups of a
  // grid that does not fit read: room in memory is kept for them, and in the file they lie apart from the finest.
  float* add(size_t floats, uint32_t level = 0);
  // Gives back all that was added since mark(), whose addresses nobody holds any more. Between calls of add().
  struct Mark {
    size_t slabs;
    uint64_t slabBytes, used, fineBytes;
  };
  Mark mark() const { return {slabs_.size(), slabBytes_, used_, fineBytes_}; }
  void release(const Mark& mark);
  // While a process reads a file, which takes memory of its own, no more of what comes and goes is in memory than kLeast:
  // bricks are written one behind another then. Between calls of add().
  class Filling {
   public:
    explicit Filling(std::shared_ptr<VoxelStore> store) : store_(std::move(store)) {
      if (store_) store_->isFilling_ = true;
    }
    ~Filling() {
      if (store_) store_->isFilling_ = false;
    }
    Filling(const Filling&) = delete;
    Filling& operator=(const Filling&) = delete;

   private:
    const std::shared_ptr<VoxelStore> store_;
  };
  // Before a number that add() gave is read or written: what lies in the file and was let go counts as being in memory
  // again. Thread-safe.
  void use(const float* at) {
    const uintptr_t offset = reinterpret_cast<uintptr_t>(at) - base_;
    if (offset >= kReach || !base_) return;
    const size_t chunk = offset / kChunk;
    if (chunks_[chunk].load(std::memory_order_relaxed) != kUsed) comeIn(chunk);
  }
  uint64_t limit() const { return most_; }
  // Why more than the bound is in memory all the same; "": it is not.
  const std::string& failure() const { return failure_; }

  struct Counts {
    uint64_t memoryBytes = 0, fileBytes = 0;  // of bricks by where they lie
    uint64_t cameIn = 0, wentOut = 0;         // chunks of the file
    uint64_t mostBytes = 0;                   // in memory at a time, of both
  };
  Counts counts() const;

  static constexpr uint64_t kChunk = uint64_t(1) << 21;   // goes out as one, bytes; a huge page
  static constexpr uint64_t kLeast = uint64_t(64) << 20;  // bound of the part of the file that is in memory

 private:
  enum : uint8_t { kOut, kUsed, kOld };  // old: in memory, not used since the hand of the clock came by
  static constexpr uint64_t kReach = uint64_t(1) << 38, kSegment = uint64_t(64) << 20;

  // Room in a file of so much, of a piece; null: there is none.
  float* addToFile(uint64_t bytes);
  bool openFile();
  bool growFile();
  void comeIn(size_t chunk);
  void letGo();
  uint64_t mostInside() const {
    return isFilling_.load(std::memory_order_relaxed) ? std::min(kLeast / kChunk, mostChunks_) : mostChunks_;
  }

  const uint64_t most_;
  const std::string folder_;
  std::string failure_;
  std::vector<std::unique_ptr<float[]>> slabs_;
  uint64_t slabBytes_ = 0, fineBytes_ = 0;  // in memory; of finest levels among them
  uintptr_t base_ = 0;                      // of the mapped file; 0: there is none
  int file_ = -1;
  uint64_t length_ = 0, used_ = 0;  // of the file
  struct Room {
    float* at = nullptr;
    uint64_t bytes = 0;
  };
  Room coarse_[2];  // what is left of chunks of the file for levels 1, and for coarser ones
  std::unique_ptr<std::atomic<uint8_t>[]> chunks_;
  uint64_t mostChunks_ = 0;  // in memory
  std::atomic<bool> isFilling_{false};
  std::atomic<uint64_t> inside_{0}, cameIn_{0}, wentOut_{0}, mostInside_{0};
  std::mutex letting_;
  size_t hand_ = 0;
  MemoryHold memory_{MemoryUse::Textures};
};

}  // namespace kinora::volume
