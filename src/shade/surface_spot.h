// Where on a mesh one point lies, and what is stored around it: the loads behind every value at a point. What goes on
// between the corners is computed for many points at once, by the kernels of surface_points.h, of which this is a
// part.
#pragma once
#include <cstdint>

#include "geometry/mesh.h"

namespace kinora::shade {

struct GeometryInfo;

// A point on a strand: what its control points count for, and how it runs. Object space where placed.
struct StrandPlace {
  uint32_t controls = 0, vertex[4] = {};
  float weight[4] = {}, slope[4] = {};  // for values, for their derivative by v
  float uv[2] = {};
  float du[3], dv[3];  // dP/du, dP/dv; render space
  float rest[3];       // object space, undeformed
};

struct Spot {
  const geometry::Mesh* mesh;
  const GeometryInfo* info;
  uint32_t primitive;
  uint32_t quad;              // Mesh::quadOf() where place is bilinear, else Mesh::kNoQuad
  const StrandPlace* strand;  // null: on a triangle or quad
  bool isOnQuad() const { return quad != geometry::Mesh::kNoQuad; }
  int corners() const { return isOnQuad() ? 4 : 3; }
  // Where corner k stands in `indices`, and in PerCorner values.
  size_t corner(int k) const {
    return isOnQuad() ? geometry::Mesh::quadCorner(quad, k) : 3 * size_t(primitive) + size_t(k);
  }
  uint32_t vertex(int k) const { return mesh->indices[corner(k)]; }
};

// How a value goes on from what is stored: between three corners, between four, or as it is with its slopes.
enum class Across : int32_t { Triangle, Quad, Given };

inline Across acrossOf(const Spot& s) { return s.isOnQuad() ? Across::Quad : Across::Triangle; }
inline Across given(float value, float d1, float d2, float c[4]) {
  c[0] = value;
  c[1] = d1;
  c[2] = d2;
  c[3] = 0;
  return Across::Given;
}

// One component of a primvar, at the first key where it has several.
inline Across cornersOf(const geometry::Primvar& p, const Spot& s, uint32_t component, float c[4]) {
  using Rate = geometry::Primvar::Rate;
  const float* data = p.data.data() + component;
  const size_t width = size_t(p.width);
  if (p.rate == Rate::Constant) return given(data[0], 0, 0, c);
  if (p.rate == Rate::PerFace) return given(data[s.mesh->faceOf(s.primitive) * width], 0, 0, c);
  const bool perVertex = p.rate == Rate::PerVertex;
  if (s.strand) {
    float value = 0, slope = 0;
    for (uint32_t i = 0; perVertex && i < s.strand->controls; ++i) {
      const float x = data[s.strand->vertex[i] * width];
      value += s.strand->weight[i] * x;
      slope += s.strand->slope[i] * x;
    }
    return given(value, 0, slope, c);
  }
  for (int k = 0; k < s.corners(); ++k) c[k] = data[(perVertex ? size_t(s.vertex(k)) : s.corner(k)) * width];
  return acrossOf(s);
}

// Patch parameters.
inline Across cornersOfUV(const Spot& s, uint32_t j, float c[4]) {
  if (s.strand) return given(s.strand->uv[j], float(j == 0), float(j == 1), c);
  for (int k = 0; k < s.corners(); ++k)
    // the fourth corner of a quad is the third of its second triangle
    c[k] = s.isOnQuad() ? s.mesh->uvOf(s.quad + uint32_t(k == 3), k == 3 ? 2 : k)[int(j)]
                        : s.mesh->uvOf(s.primitive, k)[int(j)];
  return acrossOf(s);
}

}  // namespace kinora::shade
