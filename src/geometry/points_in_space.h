// Which vertices of a mesh are one point in space. Used where faces must stay together whatever their vertices carry.
#pragma once
#include <vector>

#include "geometry/mesh.h"

namespace kinora::geometry {

struct PointsInSpace {
  explicit PointsInSpace(const Mesh& mesh);
  std::vector<uint32_t> ofVertex;  // equal numbers: the same place at every key
  uint32_t count = 0;
};

}  // namespace kinora::geometry
