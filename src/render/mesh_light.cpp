#include "render/mesh_light.h"

#include <algorithm>

#include "geometry/tessellate.h"
#include "render/matrix_scale.h"

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
  const bool deforms = mesh.times.size() > 1, isPlain = !isDisplaced && p.attributes && p.attributes->displacement &&
                                                        p.attributes->getInt("trace:displacements", 1);
  if (deforms && isPlain)
    warn(" that is displaced and deforms while the shutter is open",
         "light comes from where it was before its displacement, with the shape of the middle of that time");
  else if (deforms)
    warn(" that deforms while the shutter is open", "it keeps the shape of the middle of that time");
  else if (isPlain)
    warn(" that is displaced", "light comes from where it was before");
  if (p.solid) warn(" that is a part of a solid", "light comes from all of it, whatever the solid leaves of it");
}

}  // namespace

EmittingMesh emittingMesh(const scene::Light& l, const geometry::Mesh* displaced, double time, const double origin[3],
                          bool worldMirrored, Diagnostics& diagnostics) {
  EmittingMesh out;
  geometry::DiceRate rate;  // no camera: each kind's plain rate, since a light's outline is never seen sharply
  rate.worldMirrored = worldMirrored;
  rate.maxTriangles = kMostTrianglesOfLight;
  std::optional<geometry::Mesh> plain;
  if (!displaced) plain = geometry::tessellate(*l.geometry, rate, diagnostics);
  const geometry::Mesh* mesh = displaced ? displaced : plain ? &*plain : nullptr;
  if (!mesh || mesh->vertexCount == 0) return out;
  warnOfWhatLightsLack(l, *mesh, displaced, diagnostics);
  if (mesh->isStrand()) return out;
  // between the keys around that time
  size_t after = 0;
  while (after + 1 < mesh->times.size() && mesh->times[after] < time) ++after;
  const size_t before = after ? after - 1 : 0;
  const double span = after > before ? mesh->times[after] - mesh->times[before] : 0;
  const double share = span > 0 ? std::clamp((time - mesh->times[before]) / span, 0., 1.) : 0;
  const scene::Matrix m = l.toWorld.at(time);
  for (uint32_t i = 0; i < mesh->vertexCount; ++i) {
    const Imath::V3d p(mesh->points[before * mesh->vertexCount + i]), q(mesh->points[after * mesh->vertexCount + i]);
    const Imath::V3d world = (p + (q - p) * share + mesh->origin) * m;
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
