// Face lists as checked input, and the polygon maker that works from them; also what a subdivision cage falls back
// to. Used inside geometry/ only.
#pragma once
#include <span>
#include <vector>

#include "geometry/build.h"

namespace kinora::geometry {

// Faces that are known to lie within their arrays; vertex numbers themselves are not checked yet.
struct PolygonFaces {
  std::span<const int> loopsPerFace, verticesPerLoop, vertices;  // as in scene::PolygonMesh
  size_t faceCount = 0, cornerCount = 0;
  int arity = 0;             // corners that every face has, 0 when they differ or have holes
  bool needCorners = false;  // some primvar is facevarying
  std::vector<int> ownSizes;

  // Set when the faces are a selection of a larger list: their numbers in it, for face ids and primvars.
  size_t uniformCount = 0, faceVaryingCount = 0;  // 0: faceCount, cornerCount
  std::vector<uint32_t> originalFace, originalCorner;
};

// Cuts the list off (with a message) at the first face that does not fit.
PolygonFaces readFaces(const scene::Primitive& primitive, const std::vector<int>& loopsPerFace,
                       const std::vector<int>& verticesPerLoop, const std::vector<int>& vertices, size_t pointCount,
                       Diagnostics& diagnostics);

bool makePolygons(const scene::Primitive& primitive, const PointKeys& points, PolygonFaces& faces,
                  Diagnostics& diagnostics, Mesh& mesh);

}  // namespace kinora::geometry
