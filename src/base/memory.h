// Who holds how much of the process's memory, and a limit that is kept by refusing sizes before they are taken. Large
// owners (description, meshes, hierarchies, film, textures) charge what they are about to allocate; what nobody
// charges shows in the resident size, which is looked at now and then. Called from every floor, thread-safe. Without
// a limit it only counts.
#pragma once
#include <atomic>
#include <cstdint>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace kinora {

enum class MemoryUse : uint8_t {
  Program,
  Description,
  Meshes,
  Hierarchies,
  Film,
  Pictures,
  Textures,
  Records,
  Learned,
  Lights,
  Count
};
const char* nameOf(MemoryUse use);

// "512 MiB", "1.5 GiB".
std::string asBinaryBytes(uint64_t bytes);

// A size was refused. `what()` says whose, how large, and names the largest owners.
class MemoryExceeded : public std::bad_alloc {
 public:
  explicit MemoryExceeded(std::string text) : text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

class Memory {
 public:
  // 0: none. What the process holds at this moment is charged to Program.
  static void setLimit(uint64_t bytes);
  static uint64_t limit();
  // What can still be charged; without a limit a very large number.
  static uint64_t left();

  // Called before the bytes are allocated. Throws MemoryExceeded when they do not fit.
  static void charge(MemoryUse use, uint64_t bytes);
  // For callers that cannot throw (callbacks of libraries): false instead; refusal() then says what charge() would.
  static bool tryCharge(MemoryUse use, uint64_t bytes) noexcept;
  static std::string refusal();
  static void release(MemoryUse use, uint64_t bytes) noexcept;
  // What is so already, whether it fits or not.
  static void count(MemoryUse use, int64_t change) noexcept;
  // Compares what the process really holds with the limit; throws MemoryExceeded. Costs a few microseconds.
  static void check(MemoryUse use);

  static uint64_t used(MemoryUse use);
  static uint64_t resident();  // of the process, without what it shares with files
  // "meshes 320 MiB, film 100 MiB ..." of at most four owners, largest first.
  static std::string largest();
};

// A charge that lives with its owner.
class MemoryHold {
 public:
  explicit MemoryHold(MemoryUse use) : use_(use) {}
  ~MemoryHold() { Memory::release(use_, bytes_); }
  MemoryHold(const MemoryHold&) = delete;
  MemoryHold& operator=(const MemoryHold&) = delete;
  // From any thread.
  void add(uint64_t bytes) {
    Memory::charge(use_, bytes);
    bytes_.fetch_add(bytes, std::memory_order_relaxed);
  }
  // The owner's size from now on.
  void set(uint64_t bytes) {
    if (bytes > bytes_) return add(bytes - bytes_);
    Memory::release(use_, bytes_ - bytes);
    bytes_ = bytes;
  }
  uint64_t bytes() const { return bytes_; }

 private:
  MemoryUse use_;
  std::atomic<uint64_t> bytes_{0};
};

}  // namespace kinora
