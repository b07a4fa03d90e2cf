#include "geometry/mesh.h"

namespace kinora::geometry {

const Primvar* Mesh::find(std::string_view name) const {
  for (const Primvar& p : primvars)
    if (p.name == name) return &p;
  return nullptr;
}

Imath::V2f Mesh::uvOf(uint32_t triangle, int corner) const {
  static const Imath::V2f kTriangle[3] = {{0, 0}, {1, 0}, {0, 1}};
  static const Imath::V2f kEven[3] = {{0, 0}, {1, 0}, {1, 1}}, kOdd[3] = {{0, 0}, {1, 1}, {0, 1}};
  if (!cornerUV.empty()) return cornerUV[size_t(triangle) * 3 + corner];
  if (!vertexUV.empty()) return vertexUV[indices[size_t(triangle) * 3 + corner]];
  const uint32_t first = quadOf(triangle);
  return (first == kNoQuad ? kTriangle : first == triangle ? kEven : kOdd)[corner];
}

float Mesh::ownWidth(uint32_t piece, float s) const {
  // radii are mixed as points are, and so is the part of them that is the curve's own
  const uint32_t first = indices[piece];
  const float t = 1 - s;
  const float cubic[4] = {t * t * t, 3 * s * t * t, 3 * s * s * t, s * s * s}, linear[2] = {t, s};
  const float* weights = isCubic() ? cubic : linear;
  float part = 0, whole = 0;
  for (int k = 0; k < controlsOfPiece(); ++k) {
    const float w = weights[k] * spine[first + size_t(k)].w;
    whole += w;
    part += w * own[first + size_t(k)];
  }
  return whole > 0 ? part / whole : 1;
}

size_t Mesh::bytes() const {
  size_t n = own.capacity() * sizeof(float) + spine.capacity() * sizeof(Imath::V4f) +
             spineNormals.capacity() * sizeof(Imath::V3f) + along.capacity() * sizeof(Imath::V2f);
  n += sizeof(Mesh) + (points.capacity() + rest.capacity()) * sizeof(Imath::V3f) + times.capacity() * sizeof(double) +
       (indices.capacity() + faceOfTriangle.capacity()) * sizeof(uint32_t) +
       (cornerUV.capacity() + vertexUV.capacity()) * sizeof(Imath::V2f) + primvars.capacity() * sizeof(Primvar);
  for (const Primvar& p : primvars) {
    n += p.name.capacity() + p.data.capacity() * sizeof(float) + p.strings.capacity() * sizeof(std::string);
    for (const std::string& s : p.strings) n += s.capacity();
  }
  return n;
}

}  // namespace kinora::geometry
