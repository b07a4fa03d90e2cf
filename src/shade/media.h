// Nested media: which of them surround a ray. A stack of media is the index of its innermost one in a pool, each of
// which knows the next one outward: stacks of any depth are copied as one number. Internal to shade/.
#pragma once
#include <cstdint>
#include <mutex>
#include <vector>

namespace kinora::shade {

struct Medium {
  uint32_t object;    // trace::World::bodyOf the instance whose surface was crossed
  uint32_t material;  // of that surface
  int priority;
  float ior;
  float absorption[3];  // per unit of length
  uint32_t outer;       // index of the medium around this one
  bool operator==(const Medium&) const = default;
};

// One thread's stacks, for the life of a group.
class MediaPool {
 public:
  static constexpr uint32_t kEmpty = 0;
  MediaPool() { reset(); }
  void reset() { media_.assign(1, Medium{}); }
  const Medium& operator[](uint32_t stack) const { return media_[stack]; }

  uint32_t push(uint32_t stack, Medium m) {
    m.outer = stack;
    media_.push_back(m);
    return uint32_t(media_.size() - 1);
  }
  // The medium that a ray ends when it leaves an object: the innermost one that the object began, else of its
  // material, for several objects of one material may close one volume. kEmpty: the ray was in none of them.
  uint32_t leftBy(uint32_t stack, uint32_t object, uint32_t material) const {
    uint32_t alike = kEmpty;
    for (uint32_t k = stack; k; k = media_[k].outer) {
      if (media_[k].object == object) return k;
      if (!alike && media_[k].material == material) alike = k;
    }
    return alike;
  }
  // The stack without one of its media.
  uint32_t without(uint32_t stack, uint32_t medium) {
    if (!medium) return stack;
    if (stack == medium) return media_[stack].outer;
    const uint32_t rest = without(media_[stack].outer, medium);
    return push(rest, media_[stack]);
  }
  // The innermost medium of the highest priority, which is the one that fills space; kEmpty: none does.
  uint32_t filling(uint32_t stack, uint32_t except = kEmpty) const {
    uint32_t best = kEmpty;
    for (uint32_t k = stack; k; k = media_[k].outer)
      if (k != except && (!best || media_[k].priority > media_[best].priority)) best = k;
    return best;
  }

 private:
  std::vector<Medium> media_;
};

// Stacks that records of vertices refer to: they outlive groups and are read by all threads. Equal stacks are kept
// once. Calls lock, one for a list of vertices.
class MediaArchive {
 public:
  // Stacks of n points, as numbers of the archive; and back, into another thread's pool.
  void keep(const MediaPool& pool, uint32_t n, const uint32_t* stacks, uint32_t* kept);
  void take(MediaPool& pool, uint32_t n, const uint32_t* kept, uint32_t* stacks) const;

 private:
  uint32_t keep(const MediaPool& pool, uint32_t stack);
  mutable std::mutex mutex_;
  std::vector<Medium> media_{Medium{}};
  std::vector<uint32_t> table_;  // open addressing over media_, 0: free
};

}  // namespace kinora::shade
