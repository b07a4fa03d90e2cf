// Tessellations of all surfaces that have several, in memory of a bounded size. What is there is found without a lock;
// what was not asked for longest goes first, and is made again when a ray wants it. Which tessellation a ray sees never
// follows from what is in here. Shared by the surfaces of a world; from any thread.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <vector>

#include "base/memory.h"
#include "trace/tessellation.h"

namespace kinora::trace {

class GeometryCache {
 public:
  explicit GeometryCache(uint64_t limit) : limit_(limit) {}
  ~GeometryCache();
  GeometryCache(const GeometryCache&) = delete;

  // Where a tessellation is kept; empty or not. Those of one owner are forgotten before they go.
  struct Slot {
    std::atomic<Tessellation*> held{nullptr};
    std::atomic<bool> wasMade{false};
  };

  // While one lives on a thread, what it has found stays. Not for long: memory waits for it.
  class Reading {
   public:
    Reading();
    ~Reading() { leave(); }
    Reading(const Reading&) = delete;
    void leave();
    void enter();

   private:
    std::atomic<uint64_t>* mine_;
  };

  // Null: not there. Within a Reading.
  const Tessellation* find(const Slot& slot) {
    const Tessellation* t = slot.held.load(std::memory_order_seq_cst);
    if (t && !t->isUsed.load(std::memory_order_relaxed)) t->isUsed.store(1, std::memory_order_relaxed);
    return t;
  }
  static bool has(const Slot& slot) { return slot.held.load(std::memory_order_relaxed) != nullptr; }
  // The one that is there from now on: another thread's, where that was faster. Within a Reading.
  const Tessellation* put(const void* owner, Slot& slot, Tessellation::Ptr made);
  // Nothing of the owner's is read any more.
  void forget(const void* owner);

  // While the flag is set rays are to make nothing any more: whoever would make it answers without, and says so to its
  // thread. Null: none. It must last as long as rays are traced.
  void setStop(const std::atomic<bool>* stop) { stop_.store(stop, std::memory_order_relaxed); }
  bool isStopping() const {
    const std::atomic<bool>* const stop = stop_.load(std::memory_order_relaxed);
    return stop && stop->load(std::memory_order_relaxed);
  }
  // Of the calling thread: a ray was answered so since whoever traces cleared this. What its paths bring is to be dropped.
  static bool& wasCutShort();

  uint64_t limit() const { return limit_; }
  void setLimit(uint64_t bytes) { limit_ = bytes; }

  struct Counts {
    uint64_t bytes = 0, mostBytes = 0;                     // held now, and at most
    uint64_t made = 0, again = 0, twice = 0, evicted = 0;  // again: was there before; twice: by two threads at a time
  };
  Counts counts() const;

 private:
  struct Entry {
    const void* owner;
    Slot* slot;
    Tessellation* tessellation;
  };
  struct Waiting {
    uint64_t since;
    Tessellation* tessellation;
  };
  void evict(const Slot* spared);
  void reclaim();

  std::atomic<uint64_t> limit_;
  std::atomic<const std::atomic<bool>*> stop_{nullptr};
  mutable std::mutex mutex_;
  std::vector<Entry> ring_;
  size_t hand_ = 0;
  std::vector<Waiting> waiting_;  // out of their slots, but a thread may still read them
  uint64_t bytes_ = 0;            // of both
  Counts counts_;
};

}  // namespace kinora::trace
