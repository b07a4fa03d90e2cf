// What a world's making must know of the shaders in a scene before light paths are planned.
#include <algorithm>
#include <set>

#include "render/legacy_lights.h"
#include "render/world_build.h"

namespace kinora::render {

void WorldBuilder::openShaders(const scene::Scene& scene) {
  shaders_.begin(searchPath(scene, "shader"), scene.options.getInt("shader:cache", 0) != 0);
  asksRayType_ = false;
  shadersInUse_.clear();
  std::set<const scene::Network*> seen;
  const auto lookAt = [&](const scene::NodePtr& n, Kind kind, bool isBxdf) {
    if (!n || registry_.find(kind, n->plugin, diagnostics_, n->pos)) return;
    const std::string name = shade::shaderNameOf(*n);
    const auto shader = name.empty() ? nullptr : shaders_.find(name, n->pos);
    asksRayType_ |= isBxdf && shader && shader->asksRayType;
    shadersInUse_.push_back(shader);
  };
  const auto look = [&](const scene::AttributesPtr& attributes) {
    if (!attributes) return;
    for (const scene::NetworkPtr* network : {&attributes->bxdf, &attributes->displacement}) {
      if (!*network || !seen.insert(network->get()).second) continue;
      const bool isBxdf = network == &attributes->bxdf;
      for (const scene::NodePtr& n : (*network)->patterns) lookAt(n, Kind::Pattern, isBxdf);
      if (!isBxdf) lookAt((*network)->terminal, Kind::Displacement, false);
    }
  };
  const auto lookAll = [&](const std::vector<scene::PrimitivePtr>& primitives, const scene::InstanceList& instances) {
    const scene::Attributes* last = nullptr;  // most objects share those of the one before
    for (const auto& p : primitives)
      if (p->attributes.get() != last) {
        last = p->attributes.get();
        look(p->attributes);
      }
    for (size_t i = 0; i < instances.size(); ++i)
      if (const scene::AttributesPtr& a = instances.attributesOf(i); a.get() != last) {
        last = a.get();
        look(a);
      }
  };
  lookAll(scene.primitives, scene.instances);
  for (const scene::Prototype& p : scene.prototypes) lookAll(p.primitives, p.instances);
}

bool WorldBuilder::needsSplit(const scene::Scene& scene) const {
  // as they will be rendered: stand-ins and lights of prototypes have factors too
  Diagnostics quiet([](const std::string&, Severity) {});
  const LightsToRender rendered = lightsToRender(scene, registry_, quiet);
  const auto splits = [](const scene::Node& n) {
    return n.params.getFloat("diffuse", 1) != n.params.getFloat("specular", 1);
  };
  const auto doFiltersSplit = [&](const scene::Light& l) {
    return std::any_of(l.filters.begin(), l.filters.end(), [&](const scene::NodePtr& f) { return splits(*f); });
  };
  for (const scene::Light& l : rendered.lights) {
    if (!l.node) continue;
    if (splits(*l.node) || doFiltersSplit(l)) return true;
    if (const scene::Light* dome = domeShownBy(l, rendered.domes); dome && doFiltersSplit(*dome)) return true;
    const Descriptor* d = registry_.find(Kind::Light, l.node->plugin, quiet, l.node->pos);
    const auto* traits = d ? static_cast<const LightTraits*>(d->traits) : nullptr;
    if (traits && traits->mark) return true;  // marks go on along specular reflections alone
  }
  return asksRayType_;
}

}  // namespace kinora::render
