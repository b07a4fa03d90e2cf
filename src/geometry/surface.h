// What a Mesh says at (triangle, b1, b2): position, normals, derivatives, primvars; a point is (1 - b1 - b2) P0 + b1
// P1 + b2 P2. Plain scalar formulas in double, one point at a time: the reference that shade/'s wide versions are
// tested against, and what set-up code (emitting meshes, `--only-sample`) calls. Not for the sample loop.
#pragma once
#include <ImathVec.h>
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
  Imath::V3d position;    // object space, origin added
  Imath::V3d geometric;   // e1 x e2, negated when the mesh says flipNormals; twice the triangle's area long
  Imath::V3d shading;     // unit; the interpolated "N", else the geometric normal
  Imath::V3d dPdu, dPdv;  // constant over the triangle
  Imath::V2d uv;          // patch parameters
};
SurfacePoint surfacePoint(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend = {});

// dF/du and dF/dv of a value with slopes d1 = F1 - F0 and d2 = F2 - F0 over the triangle, as weights:
//   dF/du = u1 d1 + u2 d2,   dF/dv = v1 d1 + v2 d2,   (u1 v1; u2 v2) = the inverse of (du1 dv1; du2 dv2),
// where du1 = u(P1) - u(P0) ... Where the parameters of the corners lie on a line, those of a plain triangle are used
// (u = b1, v = b2), so that the derivatives are finite and span the plane.
struct ParameterSlopes {
  double u1 = 1, u2 = 0, v1 = 0, v2 = 1;
};
ParameterSlopes parameterSlopes(const Mesh& mesh, uint32_t triangle);

struct PrimvarPoint {
  std::vector<double> value, du, dv;  // `width` of each; all derivatives 0 for Constant and PerFace
};
PrimvarPoint primvarAt(const Mesh& mesh, const Primvar& primvar, uint32_t triangle, double b1, double b2,
                       KeyBlend blend = {});

}  // namespace kinora::geometry
