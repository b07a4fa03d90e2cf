// Memory of one thread for one group of rays: a pointer moves forward, everything is let go at once. It grows while
// the first groups run and then never asks the system again. Not thread-safe, runs no destructors.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

namespace kinora {

class Arena {
 public:
  static constexpr size_t kAlign = 64, kBlock = size_t(1) << 20;
  ~Arena() {
    for (const Block& b : blocks_) std::free(b.memory);
  }
  Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  void* allocate(size_t bytes) {
    // an odd number of lines: arrays of 2^k floats side by side would all start in the same set of the cache
    bytes = (((bytes + kAlign - 1) / kAlign) | 1) * kAlign;
    while (current_ < blocks_.size() && used_ + bytes > blocks_[current_].size) {
      ++current_;
      used_ = 0;
    }
    if (current_ == blocks_.size()) grow(bytes);
    void* p = blocks_[current_].memory + used_;
    used_ += bytes;
    return p;
  }
  template <class T>
  T* make(size_t n) {
    return static_cast<T*>(allocate(n * sizeof(T)));
  }

  struct Mark {
    size_t block, used;
  };
  Mark mark() const { return {current_, used_}; }
  void release(Mark m) {
    current_ = m.block;
    used_ = m.used;
  }
  void reset() {
    current_ = 0;
    used_ = 0;
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
    used_ = 0;
  }
  std::vector<Block> blocks_;
  size_t current_ = 0, used_ = 0;
};

// Gives back at its end what was taken from an arena since it was made.
class ArenaScope {
 public:
  explicit ArenaScope(Arena& arena) : arena_(arena), mark_(arena.mark()) {}
  ~ArenaScope() { arena_.release(mark_); }
  ArenaScope(const ArenaScope&) = delete;
  ArenaScope& operator=(const ArenaScope&) = delete;

 private:
  Arena& arena_;
  const Arena::Mark mark_;
};

}  // namespace kinora
