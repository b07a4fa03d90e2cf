// Regions around places that the surface of a shape does not reach into: for walks inside objects, whose short flights
// need no ray where nothing can be in the way. A region is a ball; where the surface is near, what it has in common with
// a second one that touches it: flights beside a smooth surface are free nearly up to it. Answers are remembered by cell of a grid as fine as the
// caller's lengths, in a table of bounded size that forgets what falls on one place: an answer follows from shape, cell
// and side of the surface alone, never from what is remembered. Of World alone; any thread.
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
  // As in FreeRegions.
  struct Region {
    float center[3];
    float radius;  // 0: nothing is known
    float normal[3], curvature, offset;
  };
  // One that p is in, by lengths of about `reach`; what is farther than some of these is not told apart.
  Region region(const Shape& shape, const float p[3], float reach) const;

 private:
  static constexpr uint32_t kEntries = 1u << 17;
  // Of a cell: the plane of the surface by its normal and distance from the cell's middle; before it and behind it the
  // radius of the ball around the middle and the curvature of the one beside the surface, but for a slack.
  struct Cell {
    uint32_t normal;  // as packed() has it
    float distance;   // infinite: there is no plane, and all of the first ball is free
    float radius[2], curvature[2];
  };
  static Cell find(const Shape& shape, const float middle[3], float edge);
  // `check` is the cell's hash exclusive-or all words: an entry that two threads wrote at once is none.
  struct Entry {
    std::atomic<uint64_t> check{0}, word[3]{};
  };
  MemoryHold held_{MemoryUse::Hierarchies};
  std::unique_ptr<Entry[]> entries_;
};

}  // namespace kinora::trace
