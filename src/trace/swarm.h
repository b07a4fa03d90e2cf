// Many unmoving placements as one of Embree's geometries. An instance of Embree's own takes some 400 bytes beside its
// share of the hierarchy; a placement here takes 8, and the matrix that shading reads anyway. Rays are brought into
// the part's space by it, and answers are those of Embree's instances: ids, u, v, and the normal in the part's space.
// Made by world.cpp where a world has many placements; parts with user geometry and surfaces of solids stay instances.
#pragma once
#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace kinora::trace {

struct Affine;

class Swarm {
 public:
  struct Item {
    uint32_t key;   // place in the list of matrices
    uint32_t part;  // place in the list of scenes
  };
  // The placement of item i is known to hits as instance firstId + i. `keys`: object to render space; the swarm holds
  // them. Scenes must outlive it.
  Swarm(std::shared_ptr<const std::vector<Affine>> keys, std::vector<RTCScene> scenes, std::vector<Item> items,
        uint32_t firstId);
  // Not committed. The swarm must outlive it.
  RTCGeometry makeGeometry(RTCDevice device) const;
  uint64_t bytes() const { return items_.capacity() * sizeof(Item) + scenes_.capacity() * sizeof(RTCScene); }

 private:
  struct Calls;  // Embree's

  std::shared_ptr<const std::vector<Affine>> keys_;
  std::vector<RTCScene> scenes_;
  std::vector<Item> items_;
  uint32_t firstId_;
};

}  // namespace kinora::trace
