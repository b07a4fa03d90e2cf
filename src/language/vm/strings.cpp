#include "language/vm/strings.h"

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace kinora::language {

namespace {

constexpr uint32_t kPageBits = 12, kPages = 1u << 12;

// Readers take no lock: pages of pointers are made once and never move.
struct Table {
  std::mutex mutex;
  std::unordered_map<std::string_view, int32_t> handles;
  std::array<std::atomic<const std::string**>, kPages> pages{};
  std::atomic<uint32_t> count{0};

  Table() { add(""); }
  int32_t add(std::string_view text) {
    const uint32_t id = count.load(std::memory_order_relaxed);
    if (id >= kPages << kPageBits) return 0;  // sixteen million different strings: the rest is empty
    auto& page = pages[id >> kPageBits];
    if (!page.load(std::memory_order_relaxed))
      page.store(new const std::string*[1u << kPageBits](), std::memory_order_release);
    const std::string* kept = new std::string(text);
    page.load(std::memory_order_relaxed)[id & ((1u << kPageBits) - 1)] = kept;
    handles.emplace(*kept, int32_t(id));
    count.store(id + 1, std::memory_order_release);
    return int32_t(id);
  }
};
Table& table() {
  static Table* const instance = new Table;  // never destroyed: handles outlive everything
  return *instance;
}

}  // namespace

int32_t internString(std::string_view text) {
  if (text.empty()) return 0;
  Table& t = table();
  const std::lock_guard lock(t.mutex);
  const auto found = t.handles.find(text);
  return found != t.handles.end() ? found->second : t.add(text);
}

const std::string& stringOf(int32_t handle) {
  Table& t = table();
  const uint32_t id = uint32_t(handle);
  static const std::string kEmpty;
  if (id >= t.count.load(std::memory_order_acquire)) return kEmpty;
  return *t.pages[id >> kPageBits].load(std::memory_order_acquire)[id & ((1u << kPageBits) - 1)];
}

}  // namespace kinora::language
