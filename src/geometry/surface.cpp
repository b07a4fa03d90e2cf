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

namespace {

V3d pointAt(const Mesh& mesh, size_t index, KeyBlend blend) {
  const uint32_t i = mesh.indices[index];
  return V3d(mesh.points[blend.key0 * mesh.vertexCount + i]) * (1 - blend.t) +
         V3d(mesh.points[blend.key1 * mesh.vertexCount + i]) * blend.t;
}

// Index of the value of a corner (a place in Mesh::indices) within one key of the primvar's data.
size_t elementOf(const Mesh& mesh, Primvar::Rate rate, size_t corner) {
  switch (rate) {
    case Primvar::Rate::Constant:
      return 0;
    case Primvar::Rate::PerFace:
      return mesh.faceOf(uint32_t(corner / 3));
    case Primvar::Rate::PerVertex:
      return mesh.indices[corner];
    case Primvar::Rate::PerCorner:
      return corner;
  }
  return 0;
}

// The corners around a point with their weights for values, and for derivatives by the patch parameters.
struct Weights {
  int count = 3;
  size_t corner[4];
  double value[4], du[4], dv[4];
};

Weights weightsAt(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend) {
  Weights w;
  double slope[4][2];  // of the weights, along two directions
  if (const std::optional<QuadPlace> q = quadPlace(mesh, triangle, b1, b2, blend)) {
    w.count = 4;
    for (int k = 0; k < 4; ++k) {
      const double u = k == 1 || k == 2 ? q->u : 1 - q->u, v = k >= 2 ? q->v : 1 - q->v;
      w.corner[k] = Mesh::quadCorner(q->first, k);
      w.value[k] = u * v;
      slope[k][0] = k == 1 || k == 2 ? v : -v;
      slope[k][1] = k >= 2 ? u : -u;
    }
  } else {
    const double value[3] = {1 - b1 - b2, b1, b2}, along[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
    for (int k = 0; k < 3; ++k) {
      w.corner[k] = size_t(triangle) * 3 + size_t(k);
      w.value[k] = value[k];
      for (int j = 0; j < 2; ++j) slope[k][j] = along[k][j];
    }
  }
  // From those directions to the patch parameters. Where these lie on a line the directions themselves are taken, so
  // that derivatives are finite and span the plane.
  double m[2][2] = {{0, 0}, {0, 0}};  // d(u, v) along each direction
  for (int k = 0; k < w.count; ++k) {
    const Imath::V2d uv(mesh.uvOf(uint32_t(w.corner[k] / 3), int(w.corner[k] % 3)));
    for (int j = 0; j < 2; ++j)
      for (int c = 0; c < 2; ++c) m[j][c] += slope[k][j] * uv[c];
  }
  const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  for (int k = 0; k < w.count; ++k) {
    const double a = slope[k][0], b = slope[k][1];
    w.du[k] = det != 0 ? (m[1][1] * a - m[0][1] * b) / det : a;
    w.dv[k] = det != 0 ? (m[0][0] * b - m[1][0] * a) / det : b;
  }
  return w;
}

}  // namespace

std::optional<QuadPlace> quadPlace(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend) {
  const uint32_t first = mesh.quadOf(triangle);
  if (first == Mesh::kNoQuad) return std::nullopt;
  V3d q[4];
  for (int k = 0; k < 4; ++k) q[k] = pointAt(mesh, Mesh::quadCorner(first, k), blend);
  const V3d normal = (q[2] - q[0]).cross(q[3] - q[1]);
  for (int k = 0; k < 4; ++k)
    if (!((q[(k + 1) % 4] - q[k]).cross(q[(k + 3) % 4] - q[k]).dot(normal) >= -1e-5 * normal.length2()))
      return std::nullopt;
  if (!(normal.length2() > 0)) return std::nullopt;
  // Halving: at each u the segment from side to side has the point on one side or the other.
  const V3d p = pointAt(mesh, size_t(triangle) * 3, blend) * (1 - b1 - b2) +
                pointAt(mesh, size_t(triangle) * 3 + 1, blend) * b1 +
                pointAt(mesh, size_t(triangle) * 3 + 2, blend) * b2;
  const auto halve = [&](const V3d& a0, const V3d& a1, const V3d& b0, const V3d& b1) {
    double low = 0, high = 1;
    for (int step = 0; step < 60; ++step) {
      const double t = (low + high) / 2;
      const V3d from = a0 + (a1 - a0) * t, to = b0 + (b1 - b0) * t;
      ((to - from).cross(p - from).dot(normal) < 0 ? low : high) = t;
    }
    return (low + high) / 2;
  };
  return QuadPlace{first, halve(q[0], q[1], q[3], q[2]), 1 - halve(q[3], q[0], q[2], q[1])};
}

PrimvarPoint primvarAt(const Mesh& mesh, const Primvar& primvar, uint32_t triangle, double b1, double b2,
                       KeyBlend blend) {
  const size_t width = size_t(primvar.width);
  PrimvarPoint out{std::vector<double>(width), std::vector<double>(width), std::vector<double>(width)};
  if (primvar.data.empty()) return out;
  const Weights w = weightsAt(mesh, triangle, b1, b2, blend);
  const size_t perKey = size_t(mesh.vertexCount) * width;
  const bool moves = primvar.rate == Primvar::Rate::PerVertex && primvar.data.size() > perKey;
  for (size_t c = 0; c < width; ++c)
    for (int k = 0; k < w.count; ++k) {
      const size_t i = elementOf(mesh, primvar.rate, w.corner[k]) * width + c;
      const double f = moves ? primvar.data[blend.key0 * perKey + i] * (1 - blend.t) +
                                   primvar.data[blend.key1 * perKey + i] * blend.t
                             : primvar.data[i];
      out.value[c] += w.value[k] * f;
      out.du[c] += w.du[k] * f;
      out.dv[c] += w.dv[k] * f;
    }
  return out;
}

SurfacePoint surfacePoint(const Mesh& mesh, uint32_t triangle, double b1, double b2, KeyBlend blend) {
  SurfacePoint out;
  V3d p[3];
  for (int k = 0; k < 3; ++k) p[k] = pointAt(mesh, size_t(triangle) * 3 + size_t(k), blend);
  const V3d e1 = p[1] - p[0], e2 = p[2] - p[0];
  out.position = mesh.origin + p[0] + e1 * b1 + e2 * b2;
  out.geometric = e1.cross(e2) * (mesh.flipNormals ? -1 : 1);
  const Weights w = weightsAt(mesh, triangle, b1, b2, blend);
  Imath::V2d uv(0);
  for (int k = 0; k < w.count; ++k) {
    const V3d corner = pointAt(mesh, w.corner[k], blend);
    out.dPdu += corner * w.du[k];
    out.dPdv += corner * w.dv[k];
    uv += Imath::V2d(mesh.uvOf(uint32_t(w.corner[k] / 3), int(w.corner[k] % 3))) * w.value[k];
  }
  out.uv = uv;
  out.shading = out.geometric.normalized();
  if (const Primvar* n = mesh.find("N")) {
    const PrimvarPoint v = primvarAt(mesh, *n, triangle, b1, b2, blend);
    const V3d sum(v.value[0], v.value[1], v.value[2]);
    if (sum.length() > 0) out.shading = sum.normalized();
  }
  return out;
}

}  // namespace kinora::geometry
