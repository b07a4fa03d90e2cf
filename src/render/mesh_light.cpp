#include "render/mesh_light.h"

#include <algorithm>

#include "geometry/tessellate.h"
#include "render/matrix_scale.h"
#include "render/meshes.h"

namespace kinora::render {

namespace {

// Lights know less of geometry than surfaces do: what of it they leave out is said.
void warnOfWhatLightsLack(const scene::Light& l, const geometry::Mesh& mesh, bool isDisplaced,
                          Diagnostics& diagnostics) {
  const scene::Primitive& p = *l.geometry;
  const auto warn = [&](const char* what, const char* instead) {
    diagnostics.warning("LIGHT-GEOMETRY", p.pos,
                        "the light '" + l.node->handle + "' emits from " + scene::requestName(p.shape) + what,
                        instead, "an object that glows (PxrConstant, glowGain) has any shape");
  };
  if (mesh.isStrand()) return warn(", and lights of geometry have surfaces", "it is left out");
  if (!isDisplaced && p.attributes && p.attributes->displacement && p.attributes->getInt("trace:displacements", 1))
    warn(" that is displaced", "light comes from where it was before");
  if (p.solid) warn(" that is a part of a solid", "light comes from all of it, whatever the solid leaves of it");
}

}  // namespace

EmittingMesh emittingMesh(const scene::Light& l, const geometry::Mesh* displaced, const CameraState& camera,
                          Diagnostics& diagnostics) {
  EmittingMesh out;
  geometry::DiceRate rate;  // no camera: each kind's plain rate, since a light's outline is never seen sharply
  rate.worldMirrored = camera.isMirrored();
  rate.maxTriangles = kMostTrianglesOfLight;
  std::optional<geometry::Mesh> plain;
  if (!displaced) plain = geometry::tessellate(*l.geometry, rate, diagnostics);
  if (plain) uniformKeys(*plain, camera.shutterOpen, camera.shutterClose);
  const geometry::Mesh* mesh = displaced ? displaced : plain ? &*plain : nullptr;
  if (!mesh || mesh->vertexCount == 0) return out;
  warnOfWhatLightsLack(l, *mesh, displaced, diagnostics);
  if (mesh->isStrand()) return out;
  // at rest, where the light as a whole is in the middle of the shutter
  const scene::Matrix m = l.toWorld.at(camera.middle());
  out.keyCount = uint32_t(mesh->keyCount());
  for (size_t i = 0; i < size_t(mesh->vertexCount) * out.keyCount; ++i) {
    const Imath::V3d world = (Imath::V3d(mesh->points[i]) + mesh->origin) * m;
    for (int c = 0; c < 3; ++c) out.points.push_back(float(world[c] - camera.origin[c]));
  }
  // the mesh's normal goes over as a normal does: a mirroring transform leaves the outside outside
  const bool swap = mesh->flipNormals != (volumeScaleOf(m) < 0);
  out.triangles = mesh->indices;
  if (swap)
    for (size_t t = 0; t + 2 < out.triangles.size(); t += 3) std::swap(out.triangles[t + 1], out.triangles[t + 2]);
  return out;
}

}  // namespace kinora::render
