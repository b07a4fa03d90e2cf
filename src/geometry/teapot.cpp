// The teapot as RenderMan has it: Newell's patches lowered by .15, so that it stands on z = 0 and is 3 high, and
// without its bottom (both measured on pictures that people rendered with it); "bottom" 1 asks for that. All patches
// have the same grid, and what two of them share is computed from the same numbers in the same order, so that body,
// lid, handle and spout have no cracks. They go through each other, as they always did.
#include <algorithm>
#include <array>

#include "geometry/build.h"
#include "geometry/dice.h"
#include "geometry/makers.h"
#include "geometry/teapot_patches.h"
#include "geometry/tensor_surface.h"

namespace kinora::geometry {

using Imath::V3d;
using Imath::V4d;

namespace {

constexpr double kLowered = 0.15;
constexpr int kPatchesWithoutBottom = 28;

// Point k of n along the side of a patch. A neighbour names the control points the other way round.
V3d onSide(std::array<V3d, 4> c, int k, int n) {
  const auto before = [](const V3d& a, const V3d& b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
  };
  if (before(c[3], c[0]) || (c[3] == c[0] && before(c[2], c[1]))) {
    std::reverse(c.begin(), c.end());
    k = n - k;
  }
  if (k == 0) return c[0];
  if (k == n || (c[0] == c[3] && c[0] == c[1] && c[0] == c[2])) return c[3];
  const double t = double(k) / n, s = 1 - t;
  return c[0] * (s * s * s) + c[1] * (3 * s * s * t) + c[2] * (3 * s * t * t) + c[3] * (t * t * t);
}

}  // namespace

bool makeTeapot(const scene::Primitive& primitive, const DiceRate& rate, Diagnostics& diagnostics, Mesh& mesh) {
  const int patches = primitive.primvars.getFloat("bottom", 0) != 0 ? 32 : kPatchesWithoutBottom;
  std::vector<TensorSurface> surfaces(static_cast<size_t>(patches));
  DiceRate share = rate;
  share.maxTriangles = rate.maxTriangles / uint32_t(patches);
  int nu = 1, nv = 1;
  for (size_t p = 0; p < surfaces.size(); ++p) {
    TensorSurface& surface = surfaces[p];
    Axis::cubic(4, false, scene::Attributes::kBezier, 3, surface.u);
    surface.v = surface.u;
    surface.rational = {0};
    surface.keys.resize(1);
    for (const uint16_t i : kTeapotPatches[p]) {
      const float* at = kTeapotPoints[i - 1];
      surface.keys[0].emplace_back(double(at[0]), double(at[1]), double(at[2]) - kLowered, 1);
    }
    std::vector<int> u, v;
    chooseRates(surface, {}, share, u, v);
    nu = std::max(nu, u[0]);
    nv = std::max(nv, v[0]);
  }
  capGrid(nu, nv, share.maxTriangles);

  std::vector<V3d> points;
  Primvar normals = Primvar::normals();
  for (size_t p = 0; p < surfaces.size(); ++p) {
    const TensorSurface& surface = surfaces[p];
    const Axis::Span &a = surface.u.spans()[0], &b = surface.v.spans()[0];
    const auto control = [&](int i, int j) {
      const V4d& c = surface.keys[0][size_t(4 * j + i)];
      return V3d(c.x, c.y, c.z);
    };
    const auto row = [&](int j) { return std::array{control(0, j), control(1, j), control(2, j), control(3, j)}; };
    const auto column = [&](int i) { return std::array{control(i, 0), control(i, 1), control(i, 2), control(i, 3)}; };
    const uint32_t first = uint32_t(points.size()), columns = uint32_t(nu + 1);
    for (int y = 0; y <= nv; ++y)
      for (int x = 0; x <= nu; ++x) {
        const double s = double(x) / nu, t = double(y) / nv;
        points.push_back(y == 0    ? onSide(row(0), x, nu)
                         : y == nv ? onSide(row(3), x, nu)
                         : x == 0  ? onSide(column(0), y, nv)
                         : x == nu ? onSide(column(3), y, nv)
                                   : surface.at(0, a, s, b, t));
        const V3d n = surface.normal(0, a, s, b, t) * (mesh.flipNormals ? -1 : 1);
        for (int c = 0; c < 3; ++c) normals.data.push_back(float(n[c]));
        mesh.vertexUV.emplace_back(float(s), float(t));
      }
    for (int y = 0; y < nv; ++y)
      for (int x = 0; x < nu; ++x) {
        const uint32_t i = first + uint32_t(y) * columns + uint32_t(x), j = i + 1, k = j + columns, l = i + columns;
        for (const auto& t : {std::array{i, j, k}, std::array{i, k, l}}) {
          if (points[t[0]] == points[t[1]] || points[t[1]] == points[t[2]] || points[t[2]] == points[t[0]]) continue;
          mesh.indices.insert(mesh.indices.end(), t.begin(), t.end());
          mesh.faceOfTriangle.push_back(uint32_t(p));
        }
      }
  }
  mesh.quads = true;
  storePoints(points, 1, mesh);
  finishSurface(primitive, std::move(normals), diagnostics, mesh);
  return true;
}

}  // namespace kinora::geometry
