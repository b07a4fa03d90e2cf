// Memory of one thread for one group of rays: a pointer moves forward, everything is let go at once. It grows while
// the first groups run and then never asks the system again. Not thread-safe, runs no destructors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>
#ifdef KINORA_SANITIZED
#include <sanitizer/asan_interface.h>
#endif

namespace kinora {

// Builds with sanitizers know which bytes of an arena are given out: what was released, and what lies between two
// allocations, is as if it were freed.
#ifdef KINORA_SANITIZED
inline void giveOut(const void* p, size_t bytes) { __asan_unpoison_memory_region(p, bytes); }
inline void takeBack(const void* p, size_t bytes) { __asan_poison_memory_region(p, bytes); }
#else
inline void giveOut(const void*, size_t) {}
inline void takeBack(const void*, size_t) {}
#endif

class Arena {
 public:
  static constexpr size_t kAlign = 64, kBlock = size_t(1) << 20;
  ~Arena() {
    for (const Block& b : blocks_) {
      giveOut(b.memory, b.size);
      std::free(b.memory);
    }
  }
  Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  void* allocate(size_t bytes) {
    const size_t whole = (bytes + kAlign - 1) / kAlign * kAlign;  // vectors are read and written whole
    // an odd number of lines: arrays of 2^k floats side by side would all start in the same set of the cache
    bytes = (((bytes + kAlign - 1) / kAlign) | 1) * kAlign;
    while (current_ < blocks_.size() && used_ + bytes > blocks_[current_].size) {
      ++current_;
      used_ = 0;
    }
    if (current_ == blocks_.size()) grow(bytes);
    void* p = blocks_[current_].memory + used_;
    used_ += bytes;
    giveOut(p, whole);
    return p;
  }
  template <class T>
  T* make(size_t n) {
    return static_cast<T*>(allocate(n * sizeof(T)));
  }

  // A place to go back to, as often as wanted: release() lets go of what was taken since, and of marks made since.
  struct Mark {
    size_t block, used;
    bool operator==(const Mark&) const = default;
    bool operator<(const Mark& o) const { return block != o.block ? block < o.block : used < o.used; }
  };
  Mark mark() {
    const Mark here{current_, used_};
    if (marks_.empty() || !(marks_.back().at == here)) marks_.push_back({here, ++clock_, 0});
    ++marks_.back().holders;
    return here;
  }
  void release(Mark m) {
    while (!marks_.empty() && m < marks_.back().at) marks_.pop_back();
    const uint64_t made = marks_.empty() || !(marks_.back().at == m) ? 0 : marks_.back().made;
    for (; !kept_.empty() && !(kept_.back().at < m); kept_.pop_back())
      if (const Kept& k = kept_.back(); k.born < made) std::memcpy(k.object, k.bytes, k.size);
    for (size_t b = m.block; b < blocks_.size() && b <= current_; ++b)
      takeBack(blocks_[b].memory + (b == m.block ? m.used : 0), blocks_[b].size - (b == m.block ? m.used : 0));
    current_ = m.block;
    used_ = m.used;
  }
  // The same, and nobody goes back there any more.
  void end(Mark m) {
    release(m);
    if (!marks_.empty() && marks_.back().at == m && --marks_.back().holders == 0) marks_.pop_back();
  }
  void reset() {
    for (const Block& b : blocks_) takeBack(b.memory, b.size);
    current_ = 0;
    used_ = 0;
    marks_.clear();
    kept_.clear();
  }

  // What is older than a mark may find things out later, and note where in the arena they are: when that memory goes, it
  // must forget them. Time runs by marks: what was born() at a time is older than marks made later. An object that is
  // older than the newest mark keeps what it is before it changes.
  uint64_t now() const { return clock_; }
  uint64_t newestMark() const { return marks_.empty() ? 0 : marks_.back().made; }
  void keepUntilRelease(void* object, size_t size, uint64_t born) {
    const Mark at{current_, used_};
    void* bytes = allocate(size);
    std::memcpy(bytes, object, size);
    kept_.push_back({at, object, bytes, size, born});
  }
  size_t bytes() const {
    size_t n = 0;
    for (const Block& b : blocks_) n += b.size;
    return n;
  }

 private:
  struct Block {
    char* memory;
    size_t size;
  };
  void grow(size_t least) {
    const size_t size = (least > kBlock ? least : kBlock);
    void* m = std::aligned_alloc(kAlign, size);
    if (!m) throw std::bad_alloc();
    blocks_.push_back({static_cast<char*>(m), size});
    takeBack(m, size);
    used_ = 0;
  }
  struct Held {
    Mark at;
    uint64_t made;     // when
    uint32_t holders;  // as many as have it
  };
  struct Kept {
    Mark at;
    void *object, *bytes;
    size_t size;
    uint64_t born;
  };
  std::vector<Block> blocks_;
  size_t current_ = 0, used_ = 0;
  uint64_t clock_ = 0;
  std::vector<Held> marks_;
  std::vector<Kept> kept_;
};

// Gives back at its end what was taken from an arena since it was made.
class ArenaScope {
 public:
  explicit ArenaScope(Arena& arena) : arena_(arena), mark_(arena.mark()) {}
  ~ArenaScope() { arena_.end(mark_); }
  ArenaScope(const ArenaScope&) = delete;
  ArenaScope& operator=(const ArenaScope&) = delete;

 private:
  Arena& arena_;
  const Arena::Mark mark_;
};

}  // namespace kinora
