// Moves the vertices of a diced mesh and finds the normals of the surface that comes out. Called by render/, which
// has the offsets shaded in between: where each vertex is to be shaded is told by Micropolygons. It runs no shader.
#pragma once
#include <vector>

#include "geometry/mesh.h"

namespace kinora::geometry {

// A diced mesh as displacement sees it. Its normals are by vertex.
struct Micropolygons {
  explicit Micropolygons(const Mesh& mesh);
  static constexpr uint32_t kNone = ~0u;
  std::vector<uint32_t> corner;   // by vertex: where it stands in `indices` first; kNone: nowhere
  std::vector<float> size;        // by vertex: mean length of the edges there, first key
  std::vector<uint32_t> ofPoint;  // vertices, those of one point in space behind each other, points in order
  std::vector<uint32_t> first;    // by point: where its vertices begin in ofPoint; one more at the end
};

struct DisplacementResult {
  double longest = 0;      // way of a vertex, object units
  uint32_t notFinite = 0;  // vertices whose offset is no number or too large for rays; they stay
  uint32_t firstFace = 0;  // of one of those
};

// `offsets`: keys x vertices, object space. Vertices that are one point move together: where the surface is smooth
// there, by their mean; where it has an edge, so that each side comes as far along its normal as it asks for.
// `normals`: as offsets, how the surface is to be shaded, of any length and on either side; 0, or empty: as it lies.
DisplacementResult displace(Mesh& mesh, const Micropolygons& grid, std::vector<Imath::V3f> offsets,
                            const std::vector<Imath::V3f>& normals = {});

// Longer ones are none: rays go no farther than 1e18.
inline constexpr double kMostOffset = 1e15;
// One offset for a point of which several pieces of surface ask their own, each along its normal: their mean, and where
// they have an edge what is missing of each along its normal, by least squares.
Imath::V3d jointOffset(const std::vector<Imath::V3d>& offsets, const std::vector<Imath::V3d>& normals);
// n (unit) turned as `from` must be to become `to`.
Imath::V3d turned(const Imath::V3d& n, const Imath::V3d& from, const Imath::V3d& to);

}  // namespace kinora::geometry
