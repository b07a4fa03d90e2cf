// A part of a world as it is held: its BVH, and what its hits are called. For the files of World alone: world_build.cpp
// makes parts, world.cpp reads them.
#pragma once
#include <embree3/rtcore.h>

#include <memory>
#include <utility>
#include <vector>

#include "trace/world.h"

namespace kinora::trace {

inline constexpr uint32_t kNone = 0xffffffffu;

// A BVH over shapes, with the tables that lead from Embree's ids to ours.
struct World::Part {
  uint64_t key = 0;
  std::vector<std::pair<uint64_t, uint64_t>> identity;  // (shape key, revision) of all it holds, for reuse
  RTCScene scene = nullptr;
  std::vector<std::shared_ptr<geometry::Mesh>> meshes;     // in part order
  std::vector<std::shared_ptr<const UserGeometry>> users;  // as meshes; null: triangles
  std::vector<uint32_t> visibility;
  bool hasUser = false;
  // Embree geometry -> first of its merged shapes; a shape alone has one entry with start 0
  struct Slice {
    uint32_t start, shape;
  };                                 // first triangle, index into meshes
  std::vector<uint32_t> firstSlice;  // by Embree geometry id, one more at the end
  std::vector<Slice> slices;
  std::vector<std::pair<uint32_t, uint32_t>> placeOfShape;  // its Embree geometry and first triangle
  std::vector<std::vector<float>> mergedPoints;
  std::vector<std::vector<uint32_t>> mergedIndices;
  bool batch = false, watertight = false;
  bool ofSolid = false;  // some placement of it is
  float lower[3] = {0, 0, 0}, upper[3] = {0, 0, 0};

  ~Part() {
    if (scene) rtcReleaseScene(scene);
  }
  void build();
};

}  // namespace kinora::trace
