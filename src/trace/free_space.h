// How far it is, at least, from a place to the surface of a shape: for walks inside objects, whose short flights need no
// ray where nothing can be in the way. Answers are remembered by cell of a grid as fine as the caller's lengths, in a
// table of bounded size that forgets what falls on one place: an answer follows from shape and cell alone, never from
// what is remembered. Of World alone; any thread.
#pragma once
#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>

#include "base/memory.h"

namespace kinora::trace {

class FreeSpace {
 public:
  FreeSpace();
  // A shape in its part's own space, none of which moves.
  struct Shape {
    RTCScene scene;          // its part's
    uint32_t key;            // tells it from all other shapes that this object is asked about
    uint32_t firstGeometry;  // of Embree's ids in the scene: the one that holds it
    uint32_t firstTriangle;  // of that geometry: its own
    uint32_t triangles;
    const float* points;  // of the shape's vertices
    const uint32_t* indices;
  };
  // The radius of a sphere around p that no triangle of the shape reaches into, 0 where none is known. What is farther
  // than about twice `reach` is not told apart.
  float radius(const Shape& shape, const float p[3], float reach) const;

 private:
  static constexpr uint32_t kEntries = 1u << 17;
  // `check` is the cell's hash exclusive-or `value`: an entry that two threads wrote at once is none.
  struct Entry {
    std::atomic<uint64_t> check{0}, value{0};
  };
  MemoryHold held_{MemoryUse::Hierarchies};
  std::unique_ptr<Entry[]> entries_;
};

}  // namespace kinora::trace
