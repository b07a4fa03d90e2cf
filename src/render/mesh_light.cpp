#include "render/mesh_light.h"

#include <cmath>

#include "geometry/tessellate.h"
#include "render/matrix_scale.h"

namespace kinora::render {

EmittingMesh emittingMesh(const scene::Primitive& primitive, const scene::Transform& toWorld, double time,
                          const double origin[3], bool worldMirrored, Diagnostics& diagnostics) {
  EmittingMesh out;
  geometry::DiceRate rate;  // no camera: each kind's plain rate, since a light's outline is never seen sharply
  rate.worldMirrored = worldMirrored;
  rate.maxTriangles = 200'000;
  const std::optional<geometry::Mesh> mesh = geometry::tessellate(primitive, rate, diagnostics);
  if (!mesh || mesh->vertexCount == 0) return out;
  size_t key = 0;
  for (size_t k = 1; k < mesh->times.size(); ++k)
    if (std::fabs(mesh->times[k] - time) < std::fabs(mesh->times[key] - time)) key = k;
  const scene::Matrix m = toWorld.at(time);
  for (uint32_t i = 0; i < mesh->vertexCount; ++i) {
    const Imath::V3f& p = mesh->points[key * mesh->vertexCount + i];
    const Imath::V3d world = (Imath::V3d(p.x, p.y, p.z) + mesh->origin) * m;
    for (int c = 0; c < 3; ++c) out.points.push_back(float(world[c] - origin[c]));
  }
  // the mesh's normal goes over as a normal does: a mirroring transform leaves the outside outside
  const bool swap = mesh->flipNormals != (volumeScaleOf(m) < 0);
  out.triangles = mesh->indices;
  if (swap)
    for (size_t t = 0; t + 2 < out.triangles.size(); t += 3) std::swap(out.triangles[t + 1], out.triangles[t + 2]);
  return out;
}

}  // namespace kinora::render
