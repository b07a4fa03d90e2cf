// The lights of a world: plug-in instances, their filters and geometry, and which objects they light.
#include <algorithm>
#include <set>

#include "render/filters.h"
#include "render/mesh_light.h"
#include "render/world_build.h"

namespace kinora::render {

std::shared_ptr<const light::LightSet> WorldBuilder::makeLights(const scene::Scene& scene,
                                                                const std::vector<scene::Light>& sources,
                                                                const film::LightPaths& paths,
                                                                const LinkSets& links) {
  const trace::World& world = *shading_->world;
  std::vector<light::LightEntry> lights;
  std::vector<std::set<std::string>> groups;
  for (const scene::Light& l : sources) {
    if (!l.node) continue;
    if (l.attributes && l.attributes->getInt("lighting:mute", 0)) continue;
    const Descriptor* d = registry_.find(Kind::Light, l.node->plugin, diagnostics_, l.node->pos);
    if (!d) {
      diagnostics_.warning("PLUGIN-MISSING", l.node->pos,
                           "no light '" + l.node->plugin + "' (node '" + l.node->handle + "')", "it is left out",
                           "is its library on the plug-in path?");
      continue;
    }
    const Placement placement = placementOf(l.toWorld);
    Instance inst;
    EmittingMesh emitting;
    if (l.geometry)
      emitting = emittingMesh(*l.geometry, l.toWorld, 0.5 * (camera_.shutterOpen + camera_.shutterClose), origin_,
                              camera_.worldToCamera.determinant() < 0, diagnostics_);
    const LightMesh lightMesh = emitting.mesh();
    if (!inst.create(*d, l.node.get(), &placement, &lightMesh, host_, diagnostics_)) continue;
    light::LightEntry e;
    for (uint32_t width : {1u, 4u, 8u, 16u})
      e.byWidth[width] = static_cast<const LightFunctions*>(functionsFor(*d, width));
    e.owner = inst.owner();
    e.instance = inst.data();
    e.description.visibleToCamera = 1;
    e.description.diffuse = e.description.specular = 1;
    if (const auto* traits = static_cast<const LightTraits*>(d->traits); traits && traits->describe)
      traits->describe(inst.data(), &e.description);
    // power of infinite lights is per area of the world's disk
    if (e.description.isInfinite) e.description.power *= 3.14159265f * world.radius() * world.radius();
    float largestFactor = 1;
    e.filters = makeLightFilters(
        l, scene, [this](const scene::Transform& t) { return placementOf(t); }, registry_, host_, diagnostics_,
        largestFactor);
    e.description.power *= largestFactor;
    e.group = paths.end(l.node->params.getString("lightGroup", ""));
    e.visibility = 0;
    if (!l.attributes || l.attributes->getInt("visibility:camera", 1)) e.visibility |= 1;
    if (!l.attributes || l.attributes->getInt("visibility:indirect", 1)) e.visibility |= 2;
    // light met by indirect rays is one half of multiple importance sampling: it cannot be switched off alone
    e.visibility |= 2;
    std::set<std::string> names;
    if (l.attributes)
      for (const std::string& g : groupNames(l.attributes->named.getString("grouping:membership", "")))
        names.insert(g);
    names.insert(l.node->handle);
    groups.push_back(std::move(names));
    lights.push_back(std::move(e));
  }
  if (lights.empty())
    diagnostics_.warning("RENDER-NO-LIGHTS", scene.pos, "the scene has no light that is rendered",
                         "only glowing surfaces will be seen", "add a Light, e.g. Light \"PxrDomeLight\" \"dome\"");
  std::vector<std::vector<uint32_t>> sets(links.size());
  std::set<std::string> unknown;
  for (const auto& [key, index] : links) {
    const std::vector<std::string> subset = groupNames(key.first), exclude = groupNames(key.second);
    for (const auto* names : {&subset, &exclude})
      for (const std::string& n : *names)
        if (std::none_of(groups.begin(), groups.end(), [&](const auto& g) { return g.count(n) > 0; }) &&
            unknown.insert(n).second)
          diagnostics_.warning(
              "LIGHT-LINK", scene.pos, "light linking names '" + n + "', which no light is or belongs to",
              names == &subset ? "objects that name nothing else in lighting:subset are unlit"
                               : "nothing is excluded by it",
              "a light's handle, or its Attribute \"grouping\" \"string membership\", is such a name");
    for (uint32_t i = 0; i < lights.size(); ++i) {
      const auto in = [&](const std::vector<std::string>& names) {
        return std::any_of(names.begin(), names.end(), [&](const std::string& n) { return groups[i].count(n) > 0; });
      };
      if ((subset.empty() || in(subset)) && !in(exclude)) sets[index].push_back(i);
    }
  }
  return std::make_shared<light::LightSet>(std::move(lights), std::move(sets), world.center(), world.radius());
}

}  // namespace kinora::render
