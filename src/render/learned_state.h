// What an integrator learns over the samples of a frame (kinora/integrator.h, Learning): the records of an epoch, put in
// the order of sample, path and teaching at its end, and the state that the integrator makes of them. Which paths teach
// is decided here, by address alone. One object a frame; Frame sees to it that all paths of an epoch have taught before
// it ends. Memory is charged before it is taken; where it does not fit the frame ends as it does whenever memory is
// short.
#pragma once
#include <kinora/integrator.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "base/memory.h"

namespace kinora::render {

class LearnedState {
 public:
  struct Input {
    Learning wanted;
    void (*learn)(const void* integrator, const LearnServices*) = nullptr;
    const void* integrator = nullptr;
    float worldCenter[3] = {}, worldRadius = 0;
    int32_t resolution[2] = {};  // of the whole picture
    uint32_t seed = 0;
    int threads = 1;
  };
  explicit LearnedState(const Input& input);

  uint32_t recordBytes() const { return in_.wanted.recordBytes; }
  // Samples from this index on teach nothing; a power of two.
  int samples() const { return samples_; }
  // The first sample index behind the epoch of `sample`.
  static int endOfEpoch(int sample);
  // Whether the paths of a 4 x 4 block of pixels teach at a sample index; x, y: any pixel of it. Beside the picture none
  // does.
  bool teaches(int x, int y, int sample) const;

  // By the thread of that worker. path and sample by slot.
  void add(size_t worker, uint32_t n, const uint32_t* slots, const uint64_t* path, const uint32_t* sample,
           const void* records);
  // How many records the worker has added; cut() takes back what came after.
  size_t mark(size_t worker) const { return parts_.empty() ? 0 : parts_[worker].addresses.size(); }
  void cut(size_t worker, size_t count) {
    if (parts_.empty()) return;
    parts_[worker].addresses.resize(count);
    parts_[worker].records.resize(count * in_.wanted.recordBytes);
  }
  // The next epoch, [epochFirst(), epochLast()), is over: its paths have taught. Throws MemoryExceeded, also for what
  // add() had to refuse.
  void endEpoch();
  // Of the epoch whose records are collected.
  int epochFirst() const { return epochLast_ / 2; }
  int epochLast() const { return epochLast_; }
  bool isRefused() const { return refused_.load(std::memory_order_relaxed); }

  const void* state() const { return state_ ? state_->data() : nullptr; }
  uint64_t stateBytes() const { return state_ ? state_->bytes : 0; }
  uint64_t mostBytes() const { return mostBytes_; }  // that records and state have taken at a time
  uint64_t records() const { return recordCount_; }  // of all epochs

 private:
  struct Address {
    uint64_t path;
    uint32_t sample;
  };
  struct Part {  // one worker's records in the order of teaching; of a path one worker has all
    std::vector<Address> addresses;
    std::vector<std::byte> records;
  };
  struct Block {
    std::unique_ptr<std::byte[]> memory;
    uint64_t bytes = 0;
    void* data() const;
  };
  struct Host;
  Block makeBlock(uint64_t bytes);
  void forget();

  Input in_;
  int samples_ = 0, epochLast_ = 1;
  uint64_t rate_ = 0;  // of the epoch's blocks, of 2^32
  std::vector<Part> parts_;
  std::optional<Block> state_;
  uint64_t recordCount_ = 0, mostBytes_ = 0;
  std::atomic<bool> refused_{false};
  MemoryHold held_{MemoryUse::Learned};
};

}  // namespace kinora::render
