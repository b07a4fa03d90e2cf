#include "base/memory.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <limits>
#include <mutex>

namespace kinora {

namespace {

constexpr size_t kUses = size_t(MemoryUse::Count);
std::array<std::atomic<int64_t>, kUses> used{};
std::atomic<uint64_t> limitBytes{0};
// Charged since the resident size was last looked at.
std::atomic<uint64_t> unseen{0};
constexpr uint64_t kLookEvery = 4 << 20;

std::mutex refusalMutex;
std::string lastRefusal;

uint64_t sum() {
  int64_t n = 0;
  for (const auto& u : used) n += std::max<int64_t>(0, u.load(std::memory_order_relaxed));
  return uint64_t(n);
}

std::string refusalOf(MemoryUse use, uint64_t bytes) {
  const std::string limit = asBinaryBytes(limitBytes.load());
  std::string text = bytes > 0 ? std::string(nameOf(use)) + " would take " + asBinaryBytes(bytes) +
                                     " more, which the limit of " + limit + " does not hold"
                               : "the process holds " + asBinaryBytes(Memory::resident()) +
                                     ", more than the limit of " + limit + " (noticed by: " + nameOf(use) + ")";
  text += "; the largest so far: " + Memory::largest();
  // buffers of libraries, freed memory that the allocator keeps
  constexpr uint64_t kWorthSaying = 16 << 20;
  const uint64_t resident = Memory::resident(), counted = sum();
  if (bytes == 0 && resident > counted + kWorthSaying)
    text += ", libraries' buffers and others " + asBinaryBytes(resident - counted);
  return text;
}

bool fits(uint64_t bytes) {
  const uint64_t limit = limitBytes.load(std::memory_order_relaxed);
  if (limit == 0) return true;
  if (bytes > limit || sum() > limit - bytes) return false;
  if (unseen.fetch_add(bytes, std::memory_order_relaxed) + bytes < kLookEvery) return true;
  unseen.store(0, std::memory_order_relaxed);
  const uint64_t resident = Memory::resident();
  return resident <= limit && bytes <= limit - resident;
}

}  // namespace

const char* nameOf(MemoryUse use) {
  static const char* const kNames[] = {"program", "scene description", "meshes",   "bvh (Embree)",
                                       "film",    "pictures",          "textures", "records between stages",
                                       "what paths learn", "lights"};
  static_assert(std::size(kNames) == kUses);
  return kNames[size_t(use)];
}

std::string asBinaryBytes(uint64_t bytes) {
  static const char* const kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = double(bytes);
  size_t unit = 0;
  while (value >= 1023.5 && unit + 1 < std::size(kUnits)) value /= 1024, ++unit;
  char text[32];
  std::snprintf(text, sizeof text, unit > 0 && value < 9.95 ? "%.1f %s" : "%.0f %s", value, kUnits[unit]);
  return text;
}

void Memory::setLimit(uint64_t bytes) {
  limitBytes = bytes;
  unseen = 0;
  kinora::used[size_t(MemoryUse::Program)] = bytes ? int64_t(resident()) : 0;
}

uint64_t Memory::limit() { return limitBytes.load(std::memory_order_relaxed); }

uint64_t Memory::left() {
  const uint64_t l = limit();
  if (l == 0) return std::numeric_limits<uint64_t>::max();
  const uint64_t held = std::max(sum(), resident());
  return l > held ? l - held : 0;
}

bool Memory::tryCharge(MemoryUse use, uint64_t bytes) noexcept {
  if (!fits(bytes)) {
    try {
      std::string text = refusalOf(use, bytes);
      const std::lock_guard lock(refusalMutex);
      lastRefusal = std::move(text);
    } catch (...) {  // no memory for the words
    }
    return false;
  }
  kinora::used[size_t(use)].fetch_add(int64_t(bytes), std::memory_order_relaxed);
  return true;
}

std::string Memory::refusal() {
  const std::lock_guard lock(refusalMutex);
  return lastRefusal;
}

void Memory::charge(MemoryUse use, uint64_t bytes) {
  if (!tryCharge(use, bytes)) throw MemoryExceeded(refusal());
}

void Memory::release(MemoryUse use, uint64_t bytes) noexcept { count(use, -int64_t(bytes)); }

void Memory::count(MemoryUse use, int64_t change) noexcept {
  kinora::used[size_t(use)].fetch_add(change, std::memory_order_relaxed);
}

void Memory::check(MemoryUse use) {
  const uint64_t l = limit();
  if (l == 0 || resident() <= l) return;
  throw MemoryExceeded(refusalOf(use, 0));
}

uint64_t Memory::used(MemoryUse use) { return uint64_t(std::max<int64_t>(0, kinora::used[size_t(use)].load())); }

uint64_t Memory::resident() {
  long pages = 0, resident = 0, shared = 0;
  if (FILE* f = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(f, "%ld %ld %ld", &pages, &resident, &shared) != 3) resident = shared = 0;
    std::fclose(f);
  }
  return uint64_t(std::max(0l, resident - shared)) * uint64_t(sysconf(_SC_PAGESIZE));
}

std::string Memory::largest() {
  std::vector<std::pair<uint64_t, MemoryUse>> list;
  for (size_t i = 0; i < kUses; ++i)
    if (const uint64_t n = used(MemoryUse(i)); n > 0) list.emplace_back(n, MemoryUse(i));
  std::sort(list.rbegin(), list.rend());
  list.resize(std::min<size_t>(list.size(), 4));
  std::string text;
  for (const auto& [n, use] : list)
    text += (text.empty() ? "" : ", ") + std::string(nameOf(use)) + " " + asBinaryBytes(n);
  return text.empty() ? "nothing counted" : text;
}

}  // namespace kinora
