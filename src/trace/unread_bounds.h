// Bounds of what has not been read yet (procedurals): boxes that rays are tested against once their hits in a World are
// known. A ray that enters one before its hit cannot be answered. Asked by World; made by render/, which reads what was
// met and asks again in another world.
#pragma once
#include <kinora/integrator.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace kinora::trace {

class UnreadBounds {
 public:
  static constexpr uint32_t kNone = ~0u;
  struct Box {  // in render space, over the shutter
    float lower[3], upper[3];
    bool operator==(const Box&) const = default;
  };
  explicit UnreadBounds(std::vector<Box> boxes);

  size_t size() const { return boxes_.size(); }
  // The box that a ray enters first, of those that it enters within [0, length]; of equally near ones the first of the
  // list. Never misses one that the ray touches; may find one that it passes by a millionth of its size.
  uint32_t firstOf(const float o[3], const float d[3], float length) const;

  // After a query for nearest hits: rays that enter a box before their hit meet nothing, and the box is noted.
  void meet(const Rays& rays, const Hits& hits, uint32_t n, const uint32_t* slots) const;  // null: 0 to n - 1
  // After one for occlusion: rays that nothing stops and that enter a box count as stopped.
  void meet(uint32_t n, const float* const o[3], const float* const d[3], const float* length,
            uint32_t* blocked) const;

  // Notes by the calling thread so far, of all objects of this class: a group of rays that adds to it is void.
  static uint64_t& notesOfThread();
  // Boxes that were noted, in order.
  std::vector<uint32_t> noted() const;

 private:
  static constexpr uint32_t kChildren = 8, kIsBox = 0x80000000;
  struct Node {  // boxes of children side by side, which are tested at once
    float lower[3][kChildren], upper[3][kChildren];
    uint32_t child[kChildren];  // a node, or with kIsBox a box; those that are not there lie beyond all rays
  };
  void note(uint32_t box) const;
  uint32_t build(std::vector<uint32_t>& order, size_t first, size_t last);

  std::vector<Box> boxes_;
  std::vector<Node> nodes_;
  std::unique_ptr<std::atomic<uint8_t>[]> noted_;
};

}  // namespace kinora::trace
