#include "geometry/surface.h"

#include <algorithm>
#include <cmath>

namespace kinora::geometry {

using Imath::V3d;

KeyBlend blendAt(const Mesh& mesh, double time) {
  const std::vector<double>& k = mesh.times;
  if (k.size() < 2 || !(time > k.front())) return {};
  if (time >= k.back()) return {k.size() - 1, k.size() - 1, 0};
  const size_t after = size_t(std::upper_bound(k.begin(), k.end(), time) - k.begin());
  return {after - 1, after, (time - k[after - 1]) / (k[after] - k[after - 1])};
}

ParameterSlopes parameterSlopes(const Mesh& mesh, uint32_t triangle) {
  const Imath::V2d a(mesh.uvOf(triangle, 0)), e1 = Imath::V2d(mesh.uvOf(triangle, 1)) - a,
                                              e2 = Imath::V2d(mesh.uvOf(triangle, 2)) - a;
  const double det = e1.x * e2.y - e1.y * e2.x;
  if (!(std::abs(det) > 0)) return {};
  return {e2.y / det, -e1.y / det, -e2.x / det, e1.x / det};
}

// Index of the value of a corner within one key of the primvar's data.
static size_t elementOf(const Mesh& mesh, Primvar::Rate rate, uint32_t triangle, int corner) {
  switch (rate) {
    case Primvar::Rate::Constant:
      return 0;
    case Primvar::Rate::PerFace:
      return mesh.faceOf(triangle);
    case Primvar::Rate::PerVertex:
      return mesh.indices[size_t(triangle) * 3 + corner];
    case Primvar::Rate::PerCorner:
      return size_t(triangle) * 3 + corner;
  }
  return 0;
}

PrimvarPoint primvarAt(const Mesh& mesh, const Primvar& primvar, uint32_t triangle, double b1, double b2,
                       KeyBlend blend) {
  const size_t width = size_t(primvar.width);
  PrimvarPoint out{std::vector<double>(width), std::vector<double>(width), std::vector<double>(width)};
  if (primvar.data.empty()) return out;
  const ParameterSlopes slopes = parameterSlopes(mesh, triangle);
  const size_t perKey = size_t(mesh.vertexCount) * width;
  const bool moves = primvar.rate == Primvar::Rate::PerVertex && primvar.data.size() > perKey;
  for (size_t c = 0; c < width; ++c) {
    double f[3];
    for (int k = 0; k < 3; ++k) {
      const size_t i = elementOf(mesh, primvar.rate, triangle, k) * width + c;
      f[k] = moves ? primvar.data[blend.key0 * perKey + i] * (1 - blend.t) +
                         primvar.data[blend.key1 * perKey + i] * blend.t
                   : primvar.data[i];
    }
    const double d1 = f[1] - f[0], d2 = f[2] - f[0];
    out.value[c] = f[0] + b1 * d1 + b2 * d2;
    out.du[c] = slopes.u1 * d1 + slopes.u2 * d2;
    out.dv[c] = slopes.v1 * d1 + slopes.v2 * d2;
  }
  return out;
}

SurfacePoint surfacePoint(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend) {
  SurfacePoint out;
  V3d p[3];
  for (int k = 0; k < 3; ++k) {
    const uint32_t i = mesh.indices[size_t(triangle) * 3 + k];
    p[k] = V3d(mesh.points[blend.key0 * mesh.vertexCount + i]) * (1 - blend.t) +
           V3d(mesh.points[blend.key1 * mesh.vertexCount + i]) * blend.t;
  }
  const V3d e1 = p[1] - p[0], e2 = p[2] - p[0];
  out.position = mesh.origin + p[0] + e1 * b1 + e2 * b2;
  out.geometric = e1.cross(e2) * (mesh.flipNormals ? -1 : 1);
  const ParameterSlopes slopes = parameterSlopes(mesh, triangle);
  out.dPdu = e1 * slopes.u1 + e2 * slopes.u2;
  out.dPdv = e1 * slopes.v1 + e2 * slopes.v2;
  const Imath::V2d a(mesh.uvOf(triangle, 0)), b(mesh.uvOf(triangle, 1)), c(mesh.uvOf(triangle, 2));
  out.uv = a + (b - a) * b1 + (c - a) * b2;
  out.shading = out.geometric.normalized();
  if (const Primvar* n = mesh.find("N")) {
    const PrimvarPoint v = primvarAt(mesh, *n, triangle, b1, b2, blend);
    const V3d sum(v.value[0], v.value[1], v.value[2]);
    if (sum.length() > 0) out.shading = sum.normalized();
  }
  return out;
}

}  // namespace kinora::geometry
