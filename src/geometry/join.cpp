#include "geometry/join.h"

#include <algorithm>

namespace kinora::geometry {

namespace {

using Rate = Primvar::Rate;

uint32_t facesOf(const Mesh& m) {
  if (m.faceOfTriangle.empty()) return m.quadPairs ? m.triangleCount() / 2 : m.triangleCount();
  return m.triangleCount() ? *std::max_element(m.faceOfTriangle.begin(), m.faceOfTriangle.end()) + 1 : 0;
}

// Where the value of a corner of a triangle begins.
const float* valueAt(const Mesh& m, const Primvar& p, uint32_t triangle, uint32_t corner) {
  const size_t at = p.rate == Rate::Constant    ? 0
                    : p.rate == Rate::PerFace   ? m.faceOf(triangle)
                    : p.rate == Rate::PerVertex ? m.indices[3 * size_t(triangle) + corner]
                                                : 3 * size_t(triangle) + corner;
  return p.data.data() + at * size_t(p.width);
}

// A single quad whose corners are where those of quads without parameters of their own are.
bool isPlainQuad(const Mesh& m) {
  if (m.triangleCount() != 2 || m.quadOf(0) != 0) return false;
  static const Imath::V2f kCorners[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int k = 0; k < 4; ++k) {
    const size_t at = Mesh::quadCorner(0, k);
    if (m.uvOf(uint32_t(at / 3), int(at % 3)) != kCorners[k]) return false;
  }
  return true;
}

// One of the primvars of the first mesh, of all of them.
Primvar joinedPrimvar(const std::vector<Mesh>& meshes, const Primvar& first, bool& hasFaces) {
  Primvar out;
  out.name = first.name;
  out.type = first.type;
  out.width = first.width;
  // what is constant on each may differ between them
  out.rate = first.rate == Rate::Constant ? Rate::PerFace : first.rate;
  for (const Mesh& m : meshes) {
    const Primvar* p = m.find(first.name);
    if (!p || p->width != first.width || p->rate != first.rate) out.rate = Rate::PerCorner;
  }
  const std::vector<float> none(size_t(first.width), 0.f);
  size_t values = 0;
  for (const Mesh& m : meshes) {
    const Primvar* p = m.find(first.name);
    values += out.rate == Rate::PerCorner    ? m.indices.size() * size_t(first.width)
              : first.rate == Rate::Constant ? facesOf(m) * size_t(first.width)
                                             : p->data.size();
  }
  out.data.reserve(values);
  for (const Mesh& m : meshes) {
    const Primvar* p = m.find(first.name);
    if (p && (p->width != first.width || p->data.empty())) p = nullptr;
    const auto append = [&](const float* value) { out.data.insert(out.data.end(), value, value + first.width); };
    if (out.rate == Rate::PerCorner) {
      for (uint32_t t = 0; t < m.triangleCount(); ++t)
        for (uint32_t c = 0; c < 3; ++c) append(p ? valueAt(m, *p, t, c) : none.data());
    } else if (first.rate == Rate::Constant) {
      for (uint32_t f = 0; f < facesOf(m); ++f) append(p->data.data());
    } else {
      out.data.insert(out.data.end(), p->data.begin(), p->data.end());
    }
  }
  hasFaces |= out.rate == Rate::PerFace;
  return out;
}

}  // namespace

Mesh joined(const std::vector<Mesh>& meshes) {
  const Mesh& first = meshes.front();
  Mesh out;
  out.origin = first.origin;
  out.quads = first.quads;
  out.quadPairs = first.quadPairs;
  out.flipNormals = first.flipNormals;
  out.doubleSided = first.doubleSided;
  bool hasVertexUV = true, hasUV = false;
  size_t vertices = 0, corners = 0;
  for (const Mesh& m : meshes) {
    hasVertexUV &= !m.vertexUV.empty();
    hasUV |= !m.vertexUV.empty() || !m.cornerUV.empty();
    out.quadPairs &= m.quadPairs;
    out.quads |= m.quads;
    vertices += m.vertexCount;
    corners += m.indices.size();
  }
  if (std::all_of(meshes.begin(), meshes.end(), isPlainQuad)) {
    out.quadPairs = true;
    hasUV = hasVertexUV = false;
  }
  bool hasFaces = !out.quadPairs;
  for (const Primvar& p : first.primvars)
    if (!p.data.empty()) out.primvars.push_back(joinedPrimvar(meshes, p, hasFaces));
  out.points.reserve(vertices + 2);
  out.indices.reserve(corners);
  if (hasFaces) out.faceOfTriangle.reserve(corners / 3);
  if (hasUV) hasVertexUV ? out.vertexUV.reserve(vertices) : out.cornerUV.reserve(corners);
  uint32_t faces = 0;
  for (const Mesh& m : meshes) {
    const Imath::V3d shift = m.origin - out.origin;
    for (const Imath::V3f& p : m.points) out.points.push_back(Imath::V3f(Imath::V3d(p) + shift));
    for (const uint32_t i : m.indices) out.indices.push_back(out.vertexCount + i);
    for (uint32_t t = 0; t < m.triangleCount(); ++t) {
      if (hasFaces) out.faceOfTriangle.push_back(faces + m.faceOf(t));
      for (int c = 0; hasUV && !hasVertexUV && c < 3; ++c) out.cornerUV.push_back(m.uvOf(t, c));
    }
    if (hasVertexUV) out.vertexUV.insert(out.vertexUV.end(), m.vertexUV.begin(), m.vertexUV.end());
    out.vertexCount += m.vertexCount;
    faces += facesOf(m);
    out.bounds.extendBy(m.bounds);
  }
  return out;
}

}  // namespace kinora::geometry
