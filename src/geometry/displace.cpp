#include "geometry/displace.h"

#include <ImathMatrix.h>
#include <ImathMatrixAlgo.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/points_in_space.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V3f;

namespace {

constexpr double kSameNormal = 1 - 1e-5;

V3d normalAt(const Mesh& mesh, const Primvar& n, size_t key, uint32_t vertex) {
  const float* x = &n.data[3 * ((mesh.movesWithKeys(n) ? key * mesh.vertexCount : 0) + vertex)];
  return V3d(x[0], x[1], x[2]);
}

// Vertices of one point with one normal: a piece of surface that is smooth there.
struct SmoothPieces {
  std::vector<uint32_t> ofVertex;
  uint32_t count = 0;
  SmoothPieces(const Mesh& mesh, const Primvar& n, const Micropolygons& grid) : ofVertex(mesh.vertexCount) {
    const size_t keys = mesh.movesWithKeys(n) ? size_t(mesh.keyCount()) : 1;
    const auto isSmooth = [&](uint32_t v, uint32_t w) {  // at all times
      bool yes = true;
      for (size_t k = 0; k < keys && yes; ++k)
        yes = normalAt(mesh, n, k, v).dot(normalAt(mesh, n, k, w)) > kSameNormal;
      return yes;
    };
    for (size_t p = 0; p + 1 < grid.first.size(); ++p)
      for (uint32_t i = grid.first[p]; i < grid.first[p + 1]; ++i) {
        const uint32_t v = grid.ofPoint[i];
        uint32_t like = i;
        for (uint32_t j = grid.first[p]; j < i && like == i; ++j)
          if (isSmooth(v, grid.ofPoint[j])) like = j;
        ofVertex[v] = like == i ? count++ : ofVertex[grid.ofPoint[like]];
      }
  }
};

// Normals of the pieces, from the micropolygons around: on a grid they are those of central differences. Not unit; 0
// where nothing has area.
std::vector<V3d> pieceNormals(const Mesh& mesh, const SmoothPieces& pieces, size_t key) {
  std::vector<V3d> sum(pieces.count, V3d(0));
  const V3f* points = mesh.points.data() + key * mesh.vertexCount;
  const double side = mesh.flipNormals ? -1 : 1;
  const auto add = [&](const uint32_t* v, int corners) {
    for (int k = 0; k < corners; ++k) {
      const V3d p(points[v[k]]);
      const V3d x = V3d(points[v[(k + 1) % corners]]) - p, y = V3d(points[v[(k + corners - 1) % corners]]) - p;
      V3d n = x.cross(y) * side;
      if (corners == 3) n *= std::atan2(n.length(), x.dot(y)) * (2 / std::numbers::pi);
      sum[pieces.ofVertex[v[k]]] += n;
    }
  };
  for (uint32_t t = 0; t < mesh.triangleCount();) {
    const bool isQuad = mesh.quadOf(t) == t;
    uint32_t v[4];
    for (int k = 0; k < (isQuad ? 4 : 3); ++k)
      v[k] = mesh.indices[isQuad ? Mesh::quadCorner(t, k) : 3 * size_t(t) + size_t(k)];
    add(v, isQuad ? 4 : 3);
    t += isQuad ? 2 : 1;
  }
  return sum;
}

}  // namespace

V3d turned(const V3d& n, const V3d& from, const V3d& to) {
  const double lengths = from.length() * to.length();
  if (!(lengths > 0) || !std::isfinite(lengths)) return n;
  const V3d axis = from.cross(to) / lengths;
  const double cosine = from.dot(to) / lengths;
  if (cosine < -0.999) return to.normalized();
  return (n * cosine + axis.cross(n) + axis * (axis.dot(n) / (1 + cosine))).normalized();
}

V3d jointOffset(const std::vector<V3d>& offsets, const std::vector<V3d>& normals) {
  V3d mean(0);
  for (const V3d& o : offsets) mean += o;
  mean /= double(offsets.size());
  bool isSmooth = true;
  for (const V3d& n : normals) isSmooth &= n.dot(normals[0]) > kSameNormal;
  if (isSmooth) return mean;
  // least squares of what is missing along the normals; directions that they hardly span are left alone
  Imath::M33d a(0, 0, 0, 0, 0, 0, 0, 0, 0), axes;
  V3d b(0), strengths;
  for (size_t i = 0; i < offsets.size(); ++i) {
    const V3d& n = normals[i];
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) a[r][c] += n[r] * n[c] / double(offsets.size());
    b += n * (n.dot(offsets[i] - mean) / double(offsets.size()));
  }
  Imath::jacobiEigenSolver(a, strengths, axes);
  constexpr double kLeastStrength = 0.05;
  V3d out = mean;
  for (int c = 0; c < 3; ++c) {
    const V3d axis(axes[0][c], axes[1][c], axes[2][c]);
    if (strengths[c] > kLeastStrength) out += axis * (axis.dot(b) / strengths[c]);
  }
  return out;
}

Micropolygons::Micropolygons(const Mesh& mesh)
    : corner(mesh.vertexCount, kNone), size(mesh.vertexCount, 0.f), ofPoint(mesh.vertexCount) {
  std::vector<uint32_t> edges(mesh.vertexCount, 0);
  for (size_t i = 0; i < mesh.indices.size(); ++i) {
    const uint32_t v = mesh.indices[i];
    if (corner[v] == kNone) corner[v] = uint32_t(i);
  }
  const auto add = [&](uint32_t a, uint32_t b) {
    const float length = (mesh.points[a] - mesh.points[b]).length();
    for (const uint32_t v : {a, b}) {
      size[v] += length;
      ++edges[v];
    }
  };
  for (uint32_t t = 0; t < mesh.triangleCount();) {
    const bool isQuad = mesh.quadOf(t) == t;
    const int corners = isQuad ? 4 : 3;
    const auto at = [&](int k) {
      return mesh.indices[isQuad ? Mesh::quadCorner(t, k % corners) : 3 * size_t(t) + size_t(k % corners)];
    };
    for (int k = 0; k < corners; ++k) add(at(k), at(k + 1));
    t += isQuad ? 2 : 1;
  }
  for (size_t v = 0; v < size.size(); ++v)
    if (edges[v]) size[v] /= float(edges[v]);
  const PointsInSpace points(mesh);
  first.assign(size_t(points.count) + 1, 0);
  for (const uint32_t p : points.ofVertex) ++first[p + 1];
  for (size_t p = 0; p < points.count; ++p) first[p + 1] += first[p];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (uint32_t v = 0; v < mesh.vertexCount; ++v) ofPoint[next[points.ofVertex[v]]++] = v;
}

DisplacementResult displace(Mesh& mesh, const Micropolygons& grid, std::vector<V3f> offsets,
                            const std::vector<V3f>& given) {
  DisplacementResult result;
  const auto found =
      std::find_if(mesh.primvars.begin(), mesh.primvars.end(), [](const Primvar& p) { return p.name == "N"; });
  if (found == mesh.primvars.end() || found->rate != Primvar::Rate::PerVertex) return result;
  Primvar& n = *found;
  const size_t count = mesh.vertexCount, keys = size_t(mesh.keyCount());
  for (size_t v = 0; v < count; ++v) {
    bool good = true;
    for (size_t k = 0; k < keys; ++k) {
      const double length = V3d(offsets[k * count + v]).length();
      good &= length <= kMostOffset;
    }
    if (grid.corner[v] == Micropolygons::kNone) good = false;
    if (good) continue;
    for (size_t k = 0; k < keys; ++k) offsets[k * count + v] = V3f(0);
    if (grid.corner[v] == Micropolygons::kNone) continue;
    if (!result.notFinite++) result.firstFace = mesh.faceOf(grid.corner[v] / 3);
  }
  const SmoothPieces pieces(mesh, n, grid);
  std::vector<std::vector<V3d>> before;
  for (size_t k = 0; k < keys; ++k) before.push_back(pieceNormals(mesh, pieces, k));

  mesh.rest.assign(mesh.points.begin(), mesh.points.begin() + std::ptrdiff_t(count));
  std::vector<V3d> of, normals;
  for (size_t k = 0; k < keys; ++k)
    for (size_t p = 0; p + 1 < grid.first.size(); ++p) {
      of.clear();
      normals.clear();
      for (uint32_t i = grid.first[p]; i < grid.first[p + 1]; ++i) {
        const uint32_t v = grid.ofPoint[i];
        if (grid.corner[v] == Micropolygons::kNone) continue;
        of.push_back(V3d(offsets[k * count + v]));
        normals.push_back(normalAt(mesh, n, k, v));
      }
      if (of.empty()) continue;
      const V3d offset = of.size() == 1 ? of[0] : jointOffset(of, normals);
      result.longest = std::max(result.longest, offset.length());
      for (uint32_t i = grid.first[p]; i < grid.first[p + 1]; ++i) {
        V3f& at = mesh.points[k * count + grid.ofPoint[i]];
        at = V3f(V3d(at) + offset);
      }
    }

  std::vector<float> moved(3 * count * keys);
  for (size_t k = 0; k < keys; ++k) {
    const std::vector<V3d> after = pieceNormals(mesh, pieces, k);
    std::vector<V3d> wanted(given.empty() ? 0 : pieces.count, V3d(0));  // one for each piece, on its side
    for (uint32_t v = 0; v < count && !given.empty(); ++v) {
      const V3d x(given[k * count + v]);
      const uint32_t piece = pieces.ofVertex[v];
      if (!(x.length() > 0) || !std::isfinite(x.length())) continue;
      wanted[piece] += x.dot(after[piece]) < 0 ? -x.normalized() : x.normalized();
    }
    for (uint32_t v = 0; v < count; ++v) {
      const uint32_t piece = pieces.ofVertex[v];
      const bool isWanted = !wanted.empty() && wanted[piece].length() > 1e-3;
      const V3d x =
          isWanted ? wanted[piece].normalized() : turned(normalAt(mesh, n, k, v), before[k][piece], after[piece]);
      for (int c = 0; c < 3; ++c) moved[3 * (k * count + v) + size_t(c)] = float(x[c]);
    }
  }
  n.data = std::move(moved);
  mesh.bounds.makeEmpty();
  for (const V3f& p : mesh.points) mesh.bounds.extendBy(V3d(p) + mesh.origin);
  return result;
}

}  // namespace kinora::geometry
