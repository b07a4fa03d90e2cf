#include "render/light_surfaces.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "render/mesh_light.h"
#include "render/meshes.h"
#include "scene/digests.h"

namespace kinora::render {

namespace {

constexpr double kEdgesAcrossLight = 128;  // of the diagonal of its box

}  // namespace

LightSurfaces::ByLight LightSurfaces::make(const std::vector<scene::Light>& sources, const Displacement::Tools& tools,
                                           const RenderSpace& space, const std::atomic<bool>* stop) {
  ByLight out;
  const auto before = std::exchange(kept_, {});
  scene::Scene alone;
  std::vector<const scene::Light*> lights;  // by primitive
  for (const scene::Light& l : sources) {
    if (!l.geometry || !l.geometry->attributes || !l.geometry->attributes->displacement) continue;
    auto p = std::make_shared<scene::Primitive>(*l.geometry);
    p->toWorld = l.toWorld;
    p->solid = 0;  // lights are all of their surface
    alone.primitives.push_back(std::move(p));
    lights.push_back(&l);
  }
  if (lights.empty()) return out;
  // each a shape of its own
  const std::shared_ptr<const FlatScene> flat = flatten(
      alone, space, {}, [](const scene::Attributes*) { return true; }, stop, tools.diagnostics);
  displacement_.begin(*flat, tools);
  for (size_t s = 0; s < flat->shapes.size(); ++s) {
    const auto it = std::find(alone.primitives.begin(), alone.primitives.end(), flat->shapes[s].primitive);
    if (!displacement_.moves(s) || it == alone.primitives.end()) continue;
    Hasher h;
    h.digest(scene::ownDigestOf(**it));
    h.digest(displacement_.digestOf(s));
    h.word(tools.camera.isMirrored());
    const double shutter[2] = {tools.camera.shutterOpen, tools.camera.shutterClose};
    h.bytes(shutter, sizeof shutter);
    const Digest digest = h.result();
    std::shared_ptr<const geometry::Mesh> mesh;
    if (const auto known = before.find(digest); known != before.end())
      mesh = known->second;
    else
      mesh = displaced(s, **it, tools, stop);
    kept_[digest] = mesh;
    if (mesh) out[lights[size_t(it - alone.primitives.begin())]] = mesh;
  }
  displacement_.end();
  if (stop && stop->load(std::memory_order_relaxed)) kept_.clear();  // some may not be done
  return out;
}

// Null: it has no surface.
std::shared_ptr<const geometry::Mesh> LightSurfaces::displaced(size_t shape, const scene::Primitive& primitive,
                                                               const Displacement::Tools& tools,
                                                               const std::atomic<bool>* stop) const {
  geometry::DiceRate rate;
  rate.worldMirrored = tools.camera.isMirrored();
  rate.maxTriangles = kMostTrianglesOfLight;
  Diagnostics unheard([](const std::string&, Severity) {});  // the light's geometry is made once more below
  const std::optional<geometry::Mesh> plain = geometry::tessellate(primitive, rate, unheard);
  if (!plain || !plain->triangleCount()) return nullptr;
  Imath::Box3d box;
  for (const Imath::V3f& p : plain->points) box.extendBy(Imath::V3d(p));
  const double edge = box.size().length() / kEdgesAcrossLight;
  if (!(edge > 0)) return nullptr;
  rate.edgeLength = [edge](const Imath::V3d&) { return edge; };
  rate.least = edge;
  rate.isDisplaced = true;
  std::optional<geometry::Mesh> mesh = geometry::tessellate(primitive, rate, tools.diagnostics);
  if (!mesh) return nullptr;
  uniformKeys(*mesh, tools.camera.shutterOpen, tools.camera.shutterClose);
  displacement_.apply(shape, rate, stop, *mesh, {});
  return std::make_shared<const geometry::Mesh>(std::move(*mesh));
}

}  // namespace kinora::render
