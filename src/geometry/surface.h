// What a Mesh says at (triangle, b1, b2): position, normals, derivatives, primvars; a point is (1 - b1 - b2) P0 + b1
// P1 + b2 P2. On a quad (Mesh::quads) all but the position follows from its bilinear (u, v) at that point. Plain
// scalar formulas in double, one point at a time: the reference that shade/'s wide versions are tested against, and
// what set-up code (emitting meshes, `--only-sample`) calls. Not for the sample loop.
#pragma once
#include <ImathVec.h>
#include <optional>
#include <vector>

#include "geometry/mesh.h"

namespace kinora::geometry {

// Two deformation keys and how far between them a time lies; held outside the first and last key.
struct KeyBlend {
  size_t key0 = 0, key1 = 0;
  double t = 0;
};
KeyBlend blendAt(const Mesh& mesh, double time);

struct SurfacePoint {
  Imath::V3d position;   // object space, origin added
  Imath::V3d geometric;  // e1 x e2, negated when the mesh says flipNormals; twice the triangle's area long
  Imath::V3d shading;    // unit; the interpolated "N", else the geometric normal
  Imath::V3d dPdu{0, 0, 0}, dPdv{0, 0, 0};  // constant over a triangle
  Imath::V2d uv;                            // patch parameters
};
SurfacePoint surfacePoint(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend = {});

// Where in its quad a point of one of its triangles lies. The quad is seen along its mean normal, (P2 - P0) x (P3 -
// P1): continuous over the diagonal also where it is not flat. Nothing on other triangles, and on quads that are not
// convex.
struct QuadPlace {
  uint32_t first = 0;  // Mesh::quadOf()
  double u = 0, v = 0;
};
std::optional<QuadPlace> quadPlace(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend = {});

struct PrimvarPoint {
  std::vector<double> value, du, dv;  // `width` of each; all derivatives 0 for Constant and PerFace
};
PrimvarPoint primvarAt(const Mesh& mesh, const Primvar& primvar, uint32_t triangle, double b1, double b2,
                       KeyBlend blend = {});

}  // namespace kinora::geometry
