// Many unmoving placements as one of Embree's geometries. An instance of Embree's own takes some 400 bytes beside its
// share of the hierarchy, a primitive of Embree's some 80 while it is built; here a few placements that lie together
// are one primitive, and a placement has its part of that, nine bytes of box, and the matrix that shading reads anyway.
// Rays are brought into the part's space by it, and answers are those of Embree's instances: ids, u, v, and the normal
// in the part's space.
// Made by world.cpp where a world has many placements; parts with user geometry and surfaces of solids stay instances.
#pragma once
#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace kinora::trace {

struct Affine;
struct Instance;

class Swarm {
 public:
  // Placements that lie together and are one primitive.
  static constexpr uint32_t kTogether = 8;
  // Of a world, which holds them too. Scenes must outlive the swarm.
  struct Data {
    std::shared_ptr<const std::vector<Instance>> instances;
    std::shared_ptr<const std::vector<Affine>> keys;          // object to render space, by Instance::firstKey
    std::shared_ptr<const std::vector<uint32_t>> partOfInfo;  // place in the list of scenes, by Instance::info
    std::shared_ptr<const std::vector<bool>> isLost;          // by instance: nothing of it is seen; empty: none
    std::vector<RTCScene> scenes;
  };
  // Of instances begin to end - 1. The first is known to hits as Embree's instance firstId.
  Swarm(Data data, uint32_t begin, uint32_t end, uint32_t firstId);
  // Not committed. The swarm must outlive it.
  RTCGeometry makeGeometry(RTCDevice device) const;

 private:
  struct Calls;  // Embree's
  struct Box {
    float lower[3], upper[3];
  };

  // Boxes of the placements of a primitive, in steps between the bounds of all of them. What is lost has none: its
  // `from` is beyond its `to`.
  struct Group {
    float lower[3], step[3];
    uint8_t from[3][kTogether], to[3][kTogether];
  };

  Data data_;
  std::vector<Box> boxes_;  // of the scenes, a little larger than they are
  std::vector<Group> groups_;
  uint32_t begin_, end_, firstId_;
};

}  // namespace kinora::trace
