// How grids and cells write their triangles and quads into a mesh. Used by the makers of meshes.
#pragma once
#include <algorithm>
#include <array>

#include "geometry/mesh.h"

namespace kinora::geometry {

// Appends a triangle, or a quad as its two halves, with patch parameters by corner. A triangle that happens to go on
// where the one before ended must not pass for the other half of a quad, nor must the first half of one: those begin
// at another corner.
inline void appendFacet(Mesh& mesh, uint32_t face, const std::array<uint32_t, 4>& vertices,
                        const std::array<Imath::V2f, 4>& uv, int corners) {
  const std::vector<uint32_t>& at = mesh.indices;
  const bool follows = at.size() >= 3 && at[at.size() - 3] == vertices[0] && at[at.size() - 1] == vertices[1] &&
                       mesh.faceOfTriangle.back() == face;
  const int turn = !follows ? 0 : corners == 4 ? 2 : 1;
  static constexpr int kHalves[6] = {0, 1, 2, 0, 2, 3};
  for (int k = 0; k < 3 * (corners - 2); ++k) {
    const auto i = size_t((kHalves[k] + turn) % corners);
    mesh.indices.push_back(vertices[i]);
    mesh.cornerUV.push_back(uv[i]);
  }
  mesh.faceOfTriangle.insert(mesh.faceOfTriangle.end(), size_t(corners - 2), face);
  mesh.quads |= corners == 4;
}

}  // namespace kinora::geometry
