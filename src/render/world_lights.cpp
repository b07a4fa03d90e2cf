// The lights of a world: plug-in instances, their filters and geometry, and which objects they light.
#include <algorithm>
#include <map>
#include <set>

#include "render/filters.h"
#include "render/mesh_light.h"
#include "render/world_build.h"

namespace kinora::render {

// Objects of the same lights share a set; set 0 is that of all lights.
WorldBuilder::LinkSets WorldBuilder::linkObjects(const scene::Scene& scene,
                                                 const std::vector<scene::Light>& sources) {
  std::set<uint32_t> rendered;
  for (const scene::Light& l : sources) rendered.insert(l.id);
  std::vector<uint32_t> classic;
  for (const scene::Light& l : scene.classicLights)
    if (l.node && l.node->kind == "LightSource" && rendered.count(l.id)) classic.push_back(l.id);
  std::sort(classic.begin(), classic.end());
  std::map<const std::vector<uint32_t>*, std::vector<uint32_t>> known;  // list -> what is not on it
  const auto unlisted = [&](const std::vector<uint32_t>* list) -> const std::vector<uint32_t>& {
    const auto [it, isNew] = known.try_emplace(list);
    if (isNew && list)
      std::set_difference(classic.begin(), classic.end(), list->begin(), list->end(), std::back_inserter(it->second));
    else if (isNew)
      it->second = classic;
    return it->second;
  };
  LinkSets sets{{Linking{}, 0}};
  for (size_t k = 0; k < placements_.size(); ++k) {
    const scene::Attributes* a = attributesOfPlacement_[k];
    Linking key;
    if (a) {
      key.subset = a->named.getString("lighting:subset", "");
      key.exclude = a->named.getString("lighting:excludesubset", "");
      if (const scene::Parameter* off = a->named.find("illuminate:off")) key.off = off->strings;
    }
    key.unlisted = unlisted(a ? a->lightSources.get() : nullptr);
    placementInfos_[k].linkSet = sets.try_emplace(std::move(key), uint32_t(sets.size())).first->second;
  }
  return sets;
}

// A LightSource whose block ends before any object is said is off for all of them (RISpec): no mistake, but likely
// one.
void WorldBuilder::tellOfUnusedLights(const std::vector<std::vector<uint32_t>>& sets,
                                      const std::vector<const scene::Light*>& sourceOf, const scene::Scene& scene) {
  if (placementInfos_.empty()) return;
  std::vector<bool> isUsed(sets.size(), false), shines(sourceOf.size(), false);
  for (const shade::PlacementInfo& p : placementInfos_) isUsed[p.linkSet] = true;
  for (size_t k = 0; k < sets.size(); ++k)
    for (const uint32_t i : sets[k]) shines[i] = shines[i] || isUsed[k];
  std::set<uint32_t> dark;
  for (size_t i = 0; i < sourceOf.size(); ++i)
    if (!shines[i]) dark.insert(sourceOf[i]->id);
  for (const scene::Light& l : scene.classicLights)
    if (l.node && l.node->kind == "LightSource" && dark.count(l.id))
      diagnostics_.warning(
          "LIGHT-OFF", l.node->pos, "LightSource '" + l.node->handle + "' shines on no object", "it lights nothing",
          "a LightSource ends with its attribute block; Illuminate switches it on again for what follows");
}

std::shared_ptr<const light::LightSet> WorldBuilder::makeLights(const scene::Scene& scene,
                                                                const std::vector<scene::Light>& sources,
                                                                const film::LightPaths& paths,
                                                                const LinkSets& links) {
  const trace::World& world = *shading_->world;
  std::vector<light::LightKind> kinds;
  std::map<const Descriptor*, uint32_t> kindOf;
  std::vector<light::LightEntry> lights;
  std::vector<std::set<std::string>> names;  // of each light: its handle and its groups
  std::vector<const scene::Light*> sourceOf;
  std::set<std::string> known;  // those of lights that are not rendered too
  const auto namesOf = [](const scene::Light& l) {
    std::set<std::string> all{l.node->handle};
    if (l.attributes)
      for (std::string& g : groupNames(l.attributes->named.getString("grouping:membership", "")))
        all.insert(std::move(g));
    return all;
  };
  for (const auto* list : {&scene.classicLights, &sources})
    for (const scene::Light& l : *list)
      if (l.node) known.merge(namesOf(l));
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
    const auto [kind, isNewKind] = kindOf.try_emplace(d, uint32_t(kinds.size()));
    if (isNewKind) {
      kinds.emplace_back();
      for (uint32_t width : {1u, 4u, 8u, 16u})
        kinds.back().byWidth[width] = static_cast<const LightFunctions*>(functionsFor(*d, width));
    }
    e.kind = kind->second;
    e.owner = inst.owner();
    e.instance = inst.data();
    e.description.visibleToCamera = 1;
    e.description.diffuse = e.description.specular = 1;
    if (const auto* traits = static_cast<const LightTraits*>(d->traits); traits && traits->describe)
      traits->describe(inst.data(), &e.description);
    float largestFactor = 1;
    e.filters = makeLightFilters(
        l, scene, [this](const scene::Transform& t) { return placementOf(t); }, registry_, host_, diagnostics_,
        largestFactor);
    e.description.power *= largestFactor;
    e.group = paths.end(l.node->params.getString("lightGroup", ""));
    e.visibility = 0;
    if (!l.attributes || l.attributes->getInt("visibility:camera", 1)) e.visibility |= light::kLightSeenByCamera;
    if (!l.attributes || l.attributes->getInt("visibility:indirect", 1)) e.visibility |= light::kLightSeenByMirrors;
    e.castsShadow = l.node->params.getInt("enableShadows", 1) != 0;
    e.isIndirectToo = l.node->params.getInt("__indirect", 1) != 0;
    names.push_back(namesOf(l));
    sourceOf.push_back(&l);
    lights.push_back(std::move(e));
  }
  if (lights.empty())
    diagnostics_.warning("RENDER-NO-LIGHTS", scene.pos, "the scene has no light that is rendered",
                         "only glowing surfaces will be seen", "add a Light, e.g. Light \"PxrDomeLight\" \"dome\"");
  std::vector<std::vector<uint32_t>> sets(links.size());
  std::set<std::string> unknown;
  const auto check = [&](const std::vector<std::string>& list, const char* what, const char* done) {
    for (const std::string& n : list)
      if (!known.count(n) && unknown.insert(n).second)
        diagnostics_.warning("LIGHT-LINK", scene.pos,
                             std::string(what) + " names '" + n + "', which no light is or belongs to", done,
                             "a light's handle, or its Attribute \"grouping\" \"string membership\", is such a name");
  };
  for (const auto& [key, index] : links) {
    const std::vector<std::string> subset = groupNames(key.subset), exclude = groupNames(key.exclude);
    check(subset, "light linking", "objects that name nothing else in lighting:subset are unlit");
    check(exclude, "light linking", "nothing is excluded by it");
    check(key.off, "Illuminate", "nothing is switched off by it");
    for (uint32_t i = 0; i < lights.size(); ++i) {
      const auto in = [&](const std::vector<std::string>& list) {
        return std::any_of(list.begin(), list.end(), [&](const std::string& n) { return names[i].count(n) > 0; });
      };
      const auto has = [](const auto& list, const auto& x) {
        return std::find(list.begin(), list.end(), x) != list.end();
      };
      if ((!subset.empty() && !in(subset)) || in(exclude) || has(key.off, sourceOf[i]->node->handle)) continue;
      if (!has(key.unlisted, sourceOf[i]->id)) sets[index].push_back(i);
    }
  }
  tellOfUnusedLights(sets, sourceOf, scene);
  if (std::any_of(lights.begin(), lights.end(), [](const light::LightEntry& e) { return !e.isIndirectToo; })) {
    shading_->indirectSets = uint32_t(links.size());
    shading_->hasLinks = true;
    for (size_t k = 0; k < links.size(); ++k) {
      sets.push_back(sets[k]);
      std::erase_if(sets.back(), [&](uint32_t i) { return !lights[i].isIndirectToo; });
    }
  }
  return std::make_shared<light::LightSet>(std::move(kinds), std::move(lights), sets, world.center(), world.radius());
}

}  // namespace kinora::render
