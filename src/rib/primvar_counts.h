// How many values a primitive variable of each class must have on each primitive (section 2.1 of the RIB reference),
// and the checks of indices and counts that geometry relies on. Used by geometry.cpp. It repairs nothing itself.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace kinora::rib {

struct PrimvarCounts {
  size_t uniform = 1, varying = 4, vertex = 4, faceVarying = 4;
  // Meshes may have points that no face uses: more vertex values than `vertex` are then right as well. 0: no such
  // freedom.
  size_t vertexMost = 0;
  size_t of(scene::StorageClass c) const;
};

// Empty when the shape is sound; else what is wrong with it. `positions` is the number of points that P or Pw holds.
std::string checkShape(const scene::Shape& shape, size_t positions);
PrimvarCounts countsOf(const scene::Shape& shape, size_t positions, const scene::Attributes& attributes);

}  // namespace kinora::rib
