#include "render/surfaces.h"

#include <algorithm>
#include <map>
#include <utility>
#include <variant>

namespace kinora::render {

void describeGeometries(const FlatScene& flat, const std::vector<const geometry::Mesh*>& meshes, bool softTerminator,
                        shade::ShadingWorld& w) {
  // geometry infos in the world's own order: meshes are recognised by their address
  std::map<const geometry::Mesh*, uint32_t> shapeOfMesh;
  for (uint32_t i = 0; i < meshes.size(); ++i) shapeOfMesh[meshes[i]] = i;
  w.geometries.resize(w.world->geometryCount());
  for (uint32_t g = 0; g < w.world->geometryCount(); ++g) {
    const geometry::Mesh& mesh = w.world->mesh(g);
    const uint32_t s = shapeOfMesh.at(&mesh);
    const scene::Primitive& p = *flat.shapes[s].primitive;
    shade::GeometryInfo& info = w.geometries[g];
    // what faces the ray has no back, and normals that the user gave are turned already
    info.side = mesh.flipNormals && !mesh.facesRay() && !mesh.isOriented() ? -1.f : 1.f;
    info.N = mesh.find("N");
    if (info.N && (info.N->width != 3 || info.N->data.empty())) info.N = nullptr;
    const auto coordinates = [&](const char* name, int least) {
      const geometry::Primvar* v = mesh.find(name);
      return v && v->width >= least && !v->data.empty() ? v : nullptr;
    };
    info.st = coordinates("st", 2);
    info.s = coordinates("s", 1);
    info.t = coordinates("t", 1);
    const bool moves = softTerminator && info.N && info.N->rate != geometry::Primvar::Rate::PerFace &&
                       info.N->rate != geometry::Primvar::Rate::Constant &&
                       std::holds_alternative<scene::PolygonMesh>(p.shape);
    w.movesShadowOrigins |= moves;
    info.flags = (moves ? shade::kMovesShadowOrigins : 0u) | (info.N ? shade::kHasNormals : 0u) |
                 (mesh.doubleSided ? 0u : shade::kOneSided) | (mesh.quads ? shade::kHasQuads : 0u);
    info.name = p.name();
    for (const geometry::Primvar& v : mesh.primvars)
      if (!v.data.empty() && v.width > 0) {
        uint32_t& width = w.primvarWidths[v.name];
        width = std::max(width, uint32_t(std::min(v.width, 3)));
      }
    w.hasPresence |= (info.flags & shade::kOneSided) != 0;
  }
  // what every object answers (shade/implied_primvars.h); Color and Opacity only where some request gave one
  for (const auto& [name, least] : {std::pair{"st", 2u}, {"s", 1u}, {"t", 1u}}) {
    uint32_t& width = w.primvarWidths[name];
    width = std::max(width, least);
  }
}

void describePlacements(const FlatScene& flat, shade::ShadingWorld& w) {
  w.tints.push_back({});
  std::map<shade::Tint, uint32_t> tintOf{{{}, 0}};
  for (size_t k = 0; k < w.placements.size(); ++k) {
    const scene::Attributes* a = flat.attributes[k];
    if (k > 0 && a == flat.attributes[k - 1]) {
      w.placements[k].tint = w.placements[k - 1].tint;
      continue;
    }
    shade::Tint tint;
    tint.hasColor = a && a->color;
    tint.hasOpacity = a && a->opacity;
    if (tint.hasColor) {
      tint.color = *a->color;
      w.primvarWidths["Cs"] = 3;
    }
    if (tint.hasOpacity) {
      tint.opacity = *a->opacity;
      w.primvarWidths["Os"] = 3;
    }
    const auto [it, fresh] = tintOf.try_emplace(tint, uint32_t(w.tints.size()));
    if (fresh) w.tints.push_back(tint);
    w.placements[k].tint = it->second;
  }
  for (const shade::PlacementInfo& info : w.placements) w.hasHoles |= info.hole;
  for (uint32_t m = 0; m < w.materials->size(); ++m) {
    w.hasMedia |= w.materials->encloses(m);
    w.hasTintedShadows |= w.materials->tints(m);
    w.hasPresence |= !w.materials->opaque(m);
  }
}

void describeSpaces(const scene::Scene& scene, const CameraState& camera, shade::ShadingWorld& w) {
  for (int k = 0; k < 3; ++k) w.worldOrigin[k] = camera.origin[k];
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-camera.origin[0], -camera.origin[1], -camera.origin[2]));
  w.spaces["world"] = shift;
  w.spaces["camera"] = camera.worldToCamera.inverse() * shift;
  for (const auto& [name, t] : scene.coordinateSystems) w.spaces[name] = t.at(camera.middle()) * shift;
}

}  // namespace kinora::render
