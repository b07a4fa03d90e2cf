// Records that an integrator keeps from one stage of a pass to the next (kinora/integrator.h, RecordList): appended
// by any worker, sorted at the barrier by sample, path and order of appending, so that nothing shows who appended
// when. One object a frame; one pass at a time. Memory is charged before it is taken: a store that would outgrow the
// limit takes no more, and the frame ends as it does whenever memory is short.
#pragma once
#include <kinora/integrator.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "base/memory.h"

namespace kinora::render {

class PassStore {
 public:
  PassStore(std::vector<RecordList> lists, size_t workers);

  // Before the first stage of a pass: empties everything.
  void beginPass();
  // The same, and none of the memory stays; mostBytes() is so many again.
  void forget(uint64_t most);
  void beginStage(uint32_t stage) { stage_ = stage; }
  // Sorts what the stage has written. Throws MemoryExceeded, also for what append() had to refuse.
  void endStage(int threads);

  // By the thread of that worker. path and sample by slot. Records for lists of other stages are dropped and counted.
  void append(size_t worker, uint32_t list, uint32_t n, const uint32_t* slots, const uint64_t* path,
              const uint32_t* sample, const void* records);
  // How many records of each list the worker has appended; cut() takes back what came after.
  void mark(size_t worker, std::vector<size_t>& counts) const;
  void cut(size_t worker, const std::vector<size_t>& counts);
  StoredRecords stored(uint32_t list) const;
  void find(uint32_t list, uint32_t n, const uint64_t* paths, const uint32_t* samples, uint64_t* first,
            uint32_t* count) const;

  bool isRefused() const { return refused_.load(std::memory_order_relaxed); }
  // What the pass takes, after the stages that write records: of records what their parts and the sorted ones come to
  // at most, and what was made of them. A function of the records alone, not of who appended them.
  uint64_t foreseenBytes() const;
  uint64_t mostBytes() const { return mostBytes_; }  // that any pass has held, with what was made of its records
  uint64_t dropped() const { return dropped_.load(std::memory_order_relaxed); }

  // Memory until the next pass, and what an integrator makes of it.
  void* allocate(uint64_t bytes);
  void setIndex(const void* index) { index_ = index; }
  const void* index() const { return index_; }

 private:
  struct Address {
    uint64_t path;
    uint32_t sample;
  };
  struct Part {  // one worker's records of one list, as they were appended; of a path one worker has all
    std::vector<Address> addresses;
    std::vector<std::byte> records;
    void clear() {
      addresses.clear();
      records.clear();
    }
  };
  // By path of each sample: paths are numbered from 0 on and most of them leave records, so that a table of where
  // those of each end is small, and quick to sort by.
  struct Sorted {
    size_t count = 0;  // in use
    std::vector<std::byte> records;
    uint32_t firstSample = 0, samples = 0;
    uint64_t paths = 0;          // of a sample
    std::vector<uint64_t> ends;  // by sample and path
    size_t placeOf(const Address& a) const { return size_t((a.sample - firstSample) * paths + a.path); }
  };
  uint64_t bytes() const;  // of all lists
  void noteMost();
  bool grow(Part& part, size_t n, size_t bytes);

  std::vector<RecordList> lists_;
  std::vector<std::vector<Part>> parts_;  // by list, worker
  std::vector<Sorted> sorted_;            // by list
  std::vector<std::unique_ptr<std::byte[]>> blocks_;
  uint64_t made_ = 0, mostBytes_ = 0;  // bytes of blocks_
  const void* index_ = nullptr;
  uint32_t stage_ = 0;
  std::atomic<bool> refused_{false};
  std::atomic<uint64_t> dropped_{0};
  MemoryHold held_{MemoryUse::Records};
};

}  // namespace kinora::render
