#include "render/surfaces.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <variant>

namespace kinora::render {

namespace {

// What definitions of objects name, by primitive: to the space of that primitive. (What stands in the world is named
// for all, see describeSpaces().)
using SystemsOf = std::map<const scene::Primitive*, decltype(shade::GeometryInfo::systems)>;
SystemsOf systemsOfObjects(const scene::Scene& scene, double middle, shade::ShadingWorld& w) {
  SystemsOf of;
  for (const scene::Prototype& object : scene.prototypes)
    for (const scene::PrimitivePtr& p : object.primitives) {
      const auto* named = p->attributes ? p->attributes->coordinateSystems.get() : nullptr;
      const scene::Matrix fromObject = p->toWorld.at(middle);
      if (!named || !(std::fabs(fromObject.determinant()) > 1e-300)) continue;
      auto systems = std::make_shared<std::map<std::string, scene::Matrix, std::less<>>>();
      for (const auto& [name, t] : *named) {
        (*systems)[name] = t.at(middle) * fromObject.inverse();
        w.objectSystems.insert(name);
      }
      of[p.get()] = std::move(systems);
    }
  return of;
}

}  // namespace

void describeGeometries(const scene::Scene& scene, double middle, const FlatScene& flat,
                        const std::vector<const geometry::Mesh*>& meshes, bool softTerminator,
                        shade::ShadingWorld& w) {
  // geometry infos in the world's own order: meshes are recognised by their address
  std::map<const geometry::Mesh*, uint32_t> shapeOfMesh;
  for (uint32_t i = 0; i < meshes.size(); ++i) shapeOfMesh[meshes[i]] = i;
  const SystemsOf systems = systemsOfObjects(scene, middle, w);
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
    if (const auto it = systems.find(&p); it != systems.end()) info.systems = it->second;
    if (flat.shapes[s].isBaked && p.toWorld.matrices[0] != scene::Matrix())
      info.baked = std::make_shared<const shade::BakedSpace>(
          shade::BakedSpace{p.toWorld.matrices[0], p.toWorld.matrices[0].inverse()});
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

namespace {

struct BoundBox {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  float radius = INFINITY;  // about the middle, where it is known to be less than that of the corners
  void add(const float p[3]) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  void add(const BoundBox& b) {
    add(b.low);
    add(b.high);
  }
  float middle(int axis) const { return 0.5f * (low[axis] + high[axis]); }
};

// By how much a space that is only turned, moved and scaled becomes larger; others: infinity.
float uniformScaleOf(const trace::Affine& a) {
  float dots[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      dots[i][j] = 0;
      for (int k = 0; k < 3; ++k) dots[i][j] += a.m[k][i] * a.m[k][j];
    }
  const float s2 = dots[0][0];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (std::fabs(dots[i][j] - (i == j ? s2 : 0.f)) > 1e-3f * s2) return INFINITY;
  return std::sqrt(s2);
}

// Spheres around `boxes`, at most `most`: halves of the list along the longest way between middles.
void addSpheres(BoundBox* boxes, size_t n, size_t most, std::vector<WalkBound>& out) {
  if (n > 1 && most > 1) {
    BoundBox middles;
    for (size_t i = 0; i < n; ++i) {
      const float p[3] = {boxes[i].middle(0), boxes[i].middle(1), boxes[i].middle(2)};
      middles.add(p);
    }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (middles.high[k] - middles.low[k] > middles.high[axis] - middles.low[axis]) axis = k;
    std::stable_sort(boxes, boxes + n,
                     [&](const BoundBox& a, const BoundBox& b) { return a.middle(axis) < b.middle(axis); });
    addSpheres(boxes, n / 2, most / 2, out);
    addSpheres(boxes + n / 2, n - n / 2, most - most / 2, out);
    return;
  }
  BoundBox all;
  for (size_t i = 0; i < n; ++i) all.add(boxes[i]);
  if (n == 1) all.radius = boxes[0].radius;
  WalkBound b{};
  float r2 = 0;
  for (int k = 0; k < 3; ++k) {
    b.center[k] = all.middle(k);
    r2 += (all.high[k] - b.center[k]) * (all.high[k] - b.center[k]);
  }
  b.radius = std::min(std::sqrt(r2), all.radius) * 1.0001f;
  if (std::isfinite(b.radius)) out.push_back(b);
}

}  // namespace

void describeWalks(const FlatScene& flat, const std::vector<const geometry::Mesh*>& meshes, shade::ShadingWorld& w) {
  constexpr size_t kMostSpheres = 32;
  bool any = false;
  for (uint32_t m = 0; m < w.materials->size(); ++m) any = any || w.materials->isWalkable(m);
  if (!any) return;
  std::map<const geometry::Mesh*, BoundBox> boxOf;  // of points as they are stored, over all keys
  std::vector<BoundBox> boxes;
  const auto add = [&](const trace::Instance& instance, const geometry::Mesh* mesh) {
    const auto [it, isNew] = boxOf.try_emplace(mesh);
    if (isNew) {
      for (const Imath::V3f& p : mesh->points) it->second.add(&p.x);
      float r2 = 0;
      const Imath::V3f middle(it->second.middle(0), it->second.middle(1), it->second.middle(2));
      for (const Imath::V3f& p : mesh->points) r2 = std::max(r2, (p - middle).length2());
      it->second.radius = std::sqrt(r2);
    }
    if (mesh->points.empty()) return;
    if (instance.baked) {
      boxes.push_back(it->second);
      return;
    }
    BoundBox box;
    for (uint32_t k = 0; k < instance.keyCount; ++k)
      for (int corner = 0; corner < 8; ++corner) {
        float p[3], q[3];
        for (int c = 0; c < 3; ++c) p[c] = corner >> c & 1 ? it->second.high[c] : it->second.low[c];
        w.world->keys(instance)[k].point(p, q);
        box.add(q);
      }
    if (instance.keyCount == 1) box.radius = it->second.radius * uniformScaleOf(w.world->keys(instance)[0]);
    boxes.push_back(box);
  };
  for (uint32_t i = 0; i < w.world->instanceCount(); ++i) {
    const trace::Instance& instance = w.world->instance(i);
    const std::vector<uint32_t>& shapes = flat.parts[flat.partOf(instance.user)].shapes;
    for (uint32_t k = 0; k < shapes.size(); ++k)
      if (w.materials->isWalkable(w.placements[instance.info + k].material)) add(instance, meshes[shapes[k]]);
  }
  addSpheres(boxes.data(), boxes.size(), kMostSpheres, w.walkBounds);
}

void describeSpaces(const scene::Scene& scene, const CameraState& camera, shade::ShadingWorld& w) {
  for (int k = 0; k < 3; ++k) w.worldOrigin[k] = camera.origin[k];
  scene::Matrix shift;
  shift.setTranslation(Imath::V3d(-camera.origin[0], -camera.origin[1], -camera.origin[2]));
  w.spaces["world"] = shift;
  w.spaces["camera"] = camera.worldToCamera.inverse() * shift;
  const double open = camera.shutterOpen, length = camera.shutterClose - open;
  const auto add = [&](const std::string& name, const scene::Transform& toWorld) {
    w.spaces[name] = toWorld.at(camera.middle()) * shift;
    w.movingSpaces.erase(name);
    if (toWorld.isStatic() || !(length > 0)) return;
    scene::Transform& t = w.movingSpaces[name] = toWorld;
    for (double& time : t.times) time = (time - open) / length;
    for (scene::Matrix& m : t.matrices) m = m * shift;
  };
  for (const auto& [name, t] : scene.coordinateSystems) add(name, t);
}

}  // namespace kinora::render
