// Vertices between others, for meshes of one key whose primvars are by vertex. Used where faces are cut.
#pragma once
#include <algorithm>
#include <unordered_map>

#include "geometry/mesh.h"

namespace kinora::geometry {

inline uint64_t pairOf(uint32_t a, uint32_t b) { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); }

// The vertices of a mesh at one of its keys, and what it is, without its faces. Behind the first key the only primvar is
// the one that has values for each: "N".
inline Mesh verticesOf(const Mesh& mesh, size_t key = 0) {
  Mesh out = emptyLike(mesh);
  out.vertexCount = mesh.vertexCount;
  const auto first = std::ptrdiff_t(key * mesh.vertexCount);
  out.points.assign(mesh.points.begin() + first, mesh.points.begin() + first + std::ptrdiff_t(mesh.vertexCount));
  for (const Primvar& p : mesh.primvars) {
    const bool moves = mesh.movesWithKeys(p);
    if (key > 0 && !moves) continue;
    out.primvars.push_back(p);
    if (!moves) continue;
    const auto size = std::ptrdiff_t(size_t(p.width) * mesh.vertexCount), from = std::ptrdiff_t(key) * size;
    out.primvars.back().data.assign(p.data.begin() + from, p.data.begin() + from + size);
  }
  return out;
}

// Adds vertices that are means of others.
class VertexMeans {
 public:
  explicit VertexMeans(Mesh& mesh) : mesh_(mesh) {}
  uint32_t of(const uint32_t* v, int count) {
    Imath::V3d p(0);
    for (int k = 0; k < count; ++k) p += Imath::V3d(mesh_.points[v[k]]) / count;
    mesh_.points.push_back(Imath::V3f(p));
    for (Primvar& x : mesh_.primvars) {
      if (x.rate != Primvar::Rate::PerVertex || x.data.empty()) continue;
      const size_t width = size_t(x.width);
      Imath::V3d n(0);
      for (size_t c = 0; c < width; ++c) {
        double sum = 0;
        for (int k = 0; k < count; ++k) sum += double(x.data[v[k] * width + c]) / count;
        x.data.push_back(float(sum));
        if (c < 3) n[int(c)] = sum;
      }
      if (x.name != "N") continue;
      const double length = n.length();
      for (size_t c = 0; c < 3; ++c)
        x.data[x.data.size() - 3 + c] = float(length > 0 ? n[int(c)] / length : double(c == 2));
    }
    return mesh_.vertexCount++;
  }
  uint32_t between(uint32_t a, uint32_t b) {
    const auto [it, isNew] = middles_.try_emplace(pairOf(a, b), 0);
    const uint32_t ends[2] = {std::min(a, b), std::max(a, b)};
    if (isNew) it->second = of(ends, 2);
    return it->second;
  }

 private:
  Mesh& mesh_;
  std::unordered_map<uint64_t, uint32_t> middles_;
};

}  // namespace kinora::geometry
