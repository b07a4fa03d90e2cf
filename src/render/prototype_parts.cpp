#include "render/prototype_parts.h"

#include <ImathBox.h>

#include <algorithm>
#include <cmath>

#include "render/matrix_scale.h"
#include "scene/swept_box.h"
#include "trace/strands.h"

namespace kinora::render {

namespace {

// As large as its arguments say, about its own origin.
double reachOf(const scene::Quadric& q) {
  using Kind = scene::Quadric::Kind;
  const size_t lengths = q.kind == Kind::Hyperboloid                                                        ? 6
                         : q.kind == Kind::Sphere || q.kind == Kind::Cylinder || q.kind == Kind::Paraboloid ? 3
                                                                                                            : 2;
  double sum = 0;
  for (size_t k = 0; k < lengths; ++k) sum += std::fabs(double(q.args[k]));
  return sum;
}

Imath::Box3d ownBounds(const scene::Primitive& p) {
  Imath::Box3d box;
  if (const auto* q = std::get_if<scene::Quadric>(&p.shape)) {
    const double r = reachOf(*q);
    box.extendBy(Imath::V3d(-r, -r, -r));
    box.extendBy(Imath::V3d(r, r, r));
    return box;
  }
  if (std::holds_alternative<scene::OtherPrimitive>(p.shape)) return box;
  const scene::Parameter* points = p.primvars.find("P");
  for (size_t i = 0; points && i + 2 < points->floats.size(); i += 3)
    box.extendBy(Imath::V3d(points->floats[i], points->floats[i + 1], points->floats[i + 2]));
  return box;
}

// Rays and normals go through it and back without loss.
bool isWellMade(const scene::Matrix& m) {
  if (!isFinite(m)) return false;
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return false;
  double size = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) size = std::max(size, std::fabs(m[i][j]));
  return size > 1e-12 && size < 1e12 && std::fabs(volumeScaleOf(m)) > 1e-4 * size * size * size;
}

}  // namespace

bool maySharePart(const scene::Primitive& p) {
  constexpr double kFarthest = 2048;  // sizes: 13 bits are left of a float's 24
  if (!p.toWorld.isStatic() || !isWellMade(p.toWorld.matrices[0])) return false;
  const bool isStrand =
      std::holds_alternative<scene::Curves>(p.shape) || std::holds_alternative<scene::Points>(p.shape);
  if (isStrand && !trace::keepsWidths(p.toWorld.matrices[0])) return false;
  const Imath::Box3d own = ownBounds(p);
  if (own.isEmpty()) return false;
  const Imath::Box3d box = scene::sweptBox(own, p.toWorld);
  const Imath::V3d size = box.size(), middle = box.center();
  const double far = std::max({std::fabs(middle.x), std::fabs(middle.y), std::fabs(middle.z)}),
               extent = std::max({size.x, size.y, size.z});
  return std::isfinite(far + extent) && far <= kFarthest * extent;
}

}  // namespace kinora::render
