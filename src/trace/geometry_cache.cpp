#include "trace/geometry_cache.h"

#include <algorithm>
#include <deque>

namespace kinora::trace {

namespace {

// Epochs: a reader says when it began (0: it does not read); what was taken out of its slot at an epoch is freed once
// all readers have begun later (K. Fraser, "Practical lock-freedom", 2004).
std::atomic<uint64_t> epoch{1};

struct alignas(64) ReaderPlace {
  std::atomic<uint64_t> began{0};
  std::atomic<bool> isTaken{false};
};

struct Readers {
  std::mutex mutex;
  std::deque<ReaderPlace> places;  // they stay where they are
  ReaderPlace* take() {
    const std::lock_guard lock(mutex);
    for (ReaderPlace& p : places)
      if (!p.isTaken.exchange(true)) return &p;
    places.emplace_back().isTaken = true;
    return &places.back();
  }
  uint64_t earliest() {
    const std::lock_guard lock(mutex);
    uint64_t least = ~uint64_t(0);
    for (const ReaderPlace& p : places)
      if (const uint64_t b = p.began.load(std::memory_order_seq_cst)) least = std::min(least, b);
    return least;
  }
};

Readers& readers() {
  static Readers* const all = new Readers();  // threads may end after everything else
  return *all;
}

struct OwnPlace {
  ReaderPlace* place = readers().take();
  ~OwnPlace() { place->isTaken = false; }
};

}  // namespace

bool& GeometryCache::wasCutShort() {
  static thread_local bool was = false;
  return was;
}

GeometryCache::Reading::Reading() {
  thread_local OwnPlace own;
  mine_ = &own.place->began;
  enter();
}

void GeometryCache::Reading::enter() {
  mine_->store(epoch.load(std::memory_order_seq_cst), std::memory_order_seq_cst);
}

void GeometryCache::Reading::leave() { mine_->store(0, std::memory_order_release); }

GeometryCache::~GeometryCache() {
  for (const Entry& e : ring_) Tessellation::destroy(e.tessellation);
  for (const Waiting& w : waiting_) Tessellation::destroy(w.tessellation);
  Memory::count(MemoryUse::Meshes, -int64_t(bytes_));
}

const Tessellation* GeometryCache::put(const void* owner, Slot& slot, Tessellation::Ptr made) {
  const std::lock_guard lock(mutex_);
  if (Tessellation* there = slot.held.load(std::memory_order_seq_cst)) {
    ++counts_.twice;
    return there;
  }
  ++counts_.made;
  counts_.again += slot.wasMade.exchange(true);
  const uint64_t size = made->bytes();
  bytes_ += size;
  Memory::count(MemoryUse::Meshes, int64_t(size));
  Tessellation* t = made.release();
  ring_.push_back({owner, &slot, t});
  slot.held.store(t, std::memory_order_seq_cst);
  if (bytes_ > limit_) {
    reclaim();
    if (bytes_ > limit_) evict(&slot);
  }
  counts_.bytes = bytes_;
  counts_.mostBytes = std::max(counts_.mostBytes, bytes_);
  return t;
}

// Second chance: the hand goes round, and takes what nobody has asked for since it came by.
void GeometryCache::evict(const Slot* spared) {
  uint64_t leaving = 0;
  for (const Waiting& w : waiting_) leaving += w.tessellation->bytes();
  size_t kept = 0;
  while (bytes_ - leaving > limit_ && kept <= 2 * ring_.size()) {
    if (hand_ >= ring_.size()) hand_ = 0;
    Entry& e = ring_[hand_];
    if (e.slot == spared || e.tessellation->isUsed.exchange(0, std::memory_order_relaxed)) {
      ++hand_;
      ++kept;
      continue;
    }
    e.slot->held.store(nullptr, std::memory_order_seq_cst);
    leaving += e.tessellation->bytes();
    waiting_.push_back({epoch.fetch_add(1, std::memory_order_seq_cst), e.tessellation});
    e = ring_.back();
    ring_.pop_back();
    ++counts_.evicted;
    if (ring_.empty()) break;
  }
  reclaim();
}

void GeometryCache::reclaim() {
  if (waiting_.empty()) return;
  const uint64_t earliest = readers().earliest();
  const auto isOver = [&](const Waiting& w) {
    if (w.since >= earliest) return false;
    const uint64_t size = w.tessellation->bytes();
    bytes_ -= size;
    Memory::count(MemoryUse::Meshes, -int64_t(size));
    Tessellation::destroy(w.tessellation);
    return true;
  };
  waiting_.erase(std::remove_if(waiting_.begin(), waiting_.end(), isOver), waiting_.end());
}

void GeometryCache::forget(const void* owner) {
  const std::lock_guard lock(mutex_);
  const auto goes = [&](const Entry& e) {
    if (e.owner != owner) return false;
    const uint64_t size = e.tessellation->bytes();
    bytes_ -= size;
    Memory::count(MemoryUse::Meshes, -int64_t(size));
    e.slot->held = nullptr;
    Tessellation::destroy(e.tessellation);
    return true;
  };
  ring_.erase(std::remove_if(ring_.begin(), ring_.end(), goes), ring_.end());
  hand_ = 0;
  reclaim();
  counts_.bytes = bytes_;
}

GeometryCache::Counts GeometryCache::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace kinora::trace
