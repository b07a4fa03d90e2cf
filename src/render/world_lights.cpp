#include "render/world_lights.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "plugin/refused.h"
#include "render/filters.h"
#include "render/ies_profiles.h"
#include "render/light_places.h"
#include "render/mesh_light.h"
#include "render/overrides.h"
#include "scene/digests.h"
#include "shade/medium_light.h"

namespace kinora::render {

LinkSets linkObjects(const scene::Scene& scene, const LightsToRender& sources, const FlatScene& flat,
                     std::vector<shade::PlacementInfo>& infos) {
  std::set<uint32_t> rendered;
  for (const scene::Light& l : sources.lights) rendered.insert(l.id);
  for (const auto& [portal, dome] : sources.domes) rendered.insert(dome->id);
  std::vector<uint32_t> classic, ambient;
  for (const scene::Light& l : sources.lights)
    if (isAmbient(l)) ambient.push_back(l.id);
  std::sort(ambient.begin(), ambient.end());
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
  for (size_t k = 0; k < infos.size(); ++k) {
    const scene::Attributes* a = flat.attributes[k];
    // most objects share the attributes of the one before
    if (k > 0 && a == flat.attributes[k - 1]) {
      infos[k].linkSet = infos[k - 1].linkSet;
      continue;
    }
    Linking key;
    if (a) {
      key.subset = a->named.getString("lighting:subset", "");
      key.exclude = a->named.getString("lighting:excludesubset", "");
      key.filters = a->named.getString("lightfilter:subset", "");
      if (const scene::Parameter* off = a->named.find("illuminate:off")) key.off = off->strings;
    }
    key.unlisted = unlisted(a ? a->lightSources.get() : nullptr);
    if (surfaceOf(a)) {  // its material has them already
      std::vector<uint32_t> all;
      std::set_union(key.unlisted.begin(), key.unlisted.end(), ambient.begin(), ambient.end(),
                     std::back_inserter(all));
      key.unlisted = std::move(all);
    }
    infos[k].linkSet = sets.try_emplace(std::move(key), uint32_t(sets.size())).first->second;
  }
  return sets;
}

namespace {

// A light's handle and its groups, of a portal those of its dome, too.
std::set<std::string> namesOf(const scene::Light& l, const ShownDomes& domes = {}) {
  std::set<std::string> all{l.node->handle};
  if (l.attributes)
    for (std::string& g : groupNames(l.attributes->named.getString("grouping:membership", "")))
      all.insert(std::move(g));
  if (const scene::Light* dome = domeShownBy(l, domes)) all.merge(namesOf(*dome));
  return all;
}

// Names that light linking may call what a medium emits by: the object's, and its groups.
std::set<std::string> namesOf(const shade::SpaceMedium& m, const FlatScene& flat, const shade::ShadingWorld& world) {
  std::set<std::string> all{m.name};
  if (const scene::Attributes* a = flat.attributes[world.world->instance(m.instance).info])
    for (std::string& g : groupNames(a->named.getString("grouping:membership", ""))) all.insert(std::move(g));
  return all;
}

// What is emitted by a medium of these names lights all objects, as what surfaces emit does; but where some object's
// linking calls it by name it is a light among the others, which the lists of each choose.
void linkMedium(uint32_t light, const std::set<std::string>& names, const LinkSets& links,
                std::vector<std::vector<uint32_t>>& sets) {
  const auto in = [&](const std::string& list) {
    const std::vector<std::string> all = groupNames(list);
    return std::any_of(all.begin(), all.end(), [&](const std::string& n) { return names.count(n) > 0; });
  };
  bool isCalled = false;
  for (const auto& [key, index] : links) isCalled |= in(key.subset) || in(key.exclude);
  for (const auto& [key, index] : links)
    if (!isCalled || ((groupNames(key.subset).empty() || in(key.subset)) && !in(key.exclude)))
      sets[index].push_back(light);
}

// Lights keep their size and shape over the shutter: told where they should not.
std::shared_ptr<const light::LightMotion> motionOf(const scene::Light& l, const CameraState& camera,
                                                   Diagnostics& diagnostics) {
  LightMoves moves = movesOf(l.toWorld, camera);
  warnOfShape(l, moves, diagnostics);
  return std::move(moves.motion);
}

// Of all that a light's own data are made of.
Digest digestOf(const scene::Light& l, const scene::Light* dome, const Descriptor& plugin, const scene::Scene& scene,
                const CameraState& camera) {
  Hasher h;
  h.digest(scene::ownDigestOf(l));
  h.text(plugin.name);
  h.bytes(camera.origin, sizeof camera.origin);
  const double shutter[2] = {camera.shutterOpen, camera.shutterClose};  // filters move
  h.bytes(shutter, sizeof shutter);
  if (l.geometry) {
    h.word(camera.isMirrored());
    h.digest(scene::digestOf(l.geometry->toWorld));
  }
  // filters stand in coordinate systems by name
  const bool isDomeFiltered = dome && !dome->filters.empty();
  if (!l.filters.empty() || isDomeFiltered) h.digest(scene::digestOf(scene.coordinateSystems));
  if (!l.filters.empty() && l.attributes && l.attributes->coordinateSystems)
    h.digest(scene::digestOf(*l.attributes->coordinateSystems));
  if (isDomeFiltered) {
    h.digest(scene::ownDigestOf(*dome));
    if (dome->attributes && dome->attributes->coordinateSystems)
      h.digest(scene::digestOf(*dome->attributes->coordinateSystems));
  }
  return h.result();
}

// A LightSource whose block ends before any object is said is off for all of them (RISpec): no mistake, but likely
// one.
void warnOfUnusedLights(const std::vector<std::vector<uint32_t>>& sets,
                        const std::vector<const scene::Light*>& sourceOf, const scene::Scene& scene,
                        const std::vector<shade::PlacementInfo>& infos, Diagnostics& diagnostics) {
  if (infos.empty()) return;
  std::vector<bool> isUsed(sets.size(), false), shines(sourceOf.size(), false);
  for (const shade::PlacementInfo& p : infos) isUsed[p.linkSet] = true;
  for (size_t k = 0; k < sets.size(); ++k)
    for (const uint32_t i : sets[k]) shines[i] = shines[i] || isUsed[k];
  std::set<uint32_t> dark;
  for (size_t i = 0; i < sourceOf.size(); ++i)
    if (!shines[i] && !isAmbient(*sourceOf[i]))  // which materials have as a colour
      dark.insert(sourceOf[i]->id);
  for (const scene::Light& l : scene.classicLights)
    if (l.node && l.node->kind == "LightSource" && dark.count(l.id))
      diagnostics.warning(
          "LIGHT-OFF", l.node->pos, "LightSource '" + l.node->handle + "' shines on no object", "it lights nothing",
          "a LightSource ends with its attribute block; Illuminate switches it on again for what follows");
}

// Whether a material sends light that only the camera and mirrors see.
bool hasUnlitColors(const shade::MaterialSet& materials) {
  for (uint32_t i = 0; i < materials.programCount(); ++i)
    if (sameName(materials.program(i).nodes.back().plugin->name, "ClassicSurface")) return true;
  return false;
}

// Which lights each link set holds; names that no light has are told of.
std::vector<std::vector<uint32_t>> membersOf(const LinkSets& links, const std::vector<std::set<std::string>>& names,
                                             const std::vector<const scene::Light*>& sourceOf,
                                             const ShownDomes& domes, const std::set<std::string>& known,
                                             const scene::Scene& scene, Diagnostics& diagnostics) {
  std::vector<std::vector<uint32_t>> sets(links.size());
  std::set<std::string> unknown;
  const auto check = [&](const std::vector<std::string>& list, const char* what, const char* done) {
    for (const std::string& n : list)
      if (!known.count(n) && unknown.insert(n).second)
        diagnostics.warning("LIGHT-LINK", scene.pos,
                            std::string(what) + " names '" + n + "', which no light is or belongs to", done,
                            "a light's handle, or its Attribute \"grouping\" \"string membership\", is such a name");
  };
  for (const auto& [key, index] : links) {
    const std::vector<std::string> subset = groupNames(key.subset), exclude = groupNames(key.exclude);
    check(subset, "light linking", "objects that name nothing else in lighting:subset are unlit");
    check(exclude, "light linking", "nothing is excluded by it");
    check(key.off, "Illuminate", "nothing is switched off by it");
    for (uint32_t i = 0; i < names.size(); ++i) {
      const auto in = [&](const std::vector<std::string>& list) {
        return std::any_of(list.begin(), list.end(), [&](const std::string& n) { return names[i].count(n) > 0; });
      };
      const auto has = [](const auto& list, const auto& x) {
        return std::find(list.begin(), list.end(), x) != list.end();
      };
      if ((!subset.empty() && !in(subset)) || in(exclude)) continue;
      const auto isOff = [&](const scene::Light& l) {
        return has(key.off, l.node->handle) || has(key.unlisted, l.id);
      };
      const scene::Light* dome = domeShownBy(*sourceOf[i], domes);
      if (!isOff(*sourceOf[i]) && !(dome && isOff(*dome))) sets[index].push_back(i);
    }
  }
  return sets;
}

// Numbers the links of the lights' filters and says which of them are on the objects of each link set: objects that name
// groups of filters (lightfilter:subset) are without those whose linkingGroups have none of them.
std::vector<uint64_t> linkFilters(std::vector<light::LightEntry>& entries, std::vector<light::MarkEntry>& marks,
                                  const LinkSets& links, const scene::Scene& scene, Diagnostics& diagnostics) {
  if (std::all_of(links.begin(), links.end(), [](const auto& l) { return l.first.filters.empty(); })) return {};
  std::map<std::string, uint32_t> numbers;
  std::set<std::string> known, missed;
  bool areTooMany = false;
  std::vector<std::vector<light::LightFilterEntry>*> lists;
  for (light::LightEntry& e : entries) lists.push_back(&e.filters);
  for (light::MarkEntry& m : marks) lists.push_back(&m.filters);
  for (auto* list : lists)
    for (light::LightFilterEntry& f : *list) {
      const std::vector<std::string> groups = groupNames(f.linkingGroups);
      if (groups.empty()) continue;
      known.insert(groups.begin(), groups.end());
      const uint32_t link = numbers.try_emplace(f.linkingGroups, uint32_t(numbers.size())).first->second;
      areTooMany = areTooMany || link >= f.kNoLink;
      f.link = std::min(link, f.kNoLink);
    }
  if (areTooMany)
    diagnostics.warning("LIGHT-LINK", scene.pos,
                        "the scene's light filters have more than 64 different linkingGroups",
                        "those beyond are on all objects");
  std::vector<uint64_t> on(links.size(), ~0ull);
  for (const auto& [key, index] : links) {
    const std::vector<std::string> subset = groupNames(key.filters);
    for (const std::string& n : subset)
      if (!known.count(n) && missed.insert(n).second)
        diagnostics.warning("LIGHT-LINK", scene.pos,
                            "lightfilter:subset names '" + n + "', which no light filter has among its linkingGroups",
                            "the name selects nothing");
    for (const auto& [text, link] : numbers) {
      const std::vector<std::string> groups = groupNames(text);
      const bool isOn = subset.empty() || std::any_of(groups.begin(), groups.end(), [&](const std::string& g) {
                          return std::find(subset.begin(), subset.end(), g) != subset.end();
                        });
      if (!isOn && link < light::LightFilterEntry::kNoLink) on[index] &= ~(1ull << link);
    }
  }
  return on;
}

bool declares(const Descriptor& plugin, const char* name) {
  return std::any_of(plugin.params, plugin.params + plugin.paramCount,
                     [&](const Param& p) { return std::string_view(p.name) == name; });
}

// What media emit is sampled as the lights are.
void addMediumLights(shade::ShadingWorld& world, const film::LightPaths& paths, std::vector<light::LightKind>& kinds,
                     std::vector<light::LightEntry>& entries) {
  world.firstMediumLight = uint32_t(entries.size());
  world.mediumLights.clear();
  world.lightOfMedium.clear();
  if (!world.space) return;
  for (uint32_t i = 0; i < world.space->media.size(); ++i) {
    const shade::SpaceMedium& m = world.space->media[i];
    if (!m.emission) continue;
    if (world.mediumLights.empty()) {
      kinds.push_back(shade::mediumLightKind());
      world.lightOfMedium.assign(world.space->media.size(), kNoLight);
    }
    const auto data = std::make_shared<shade::MediumLight>(world, m, m.emission);
    light::LightEntry e;
    e.kind = uint32_t(kinds.size() - 1);
    e.owner = data;
    e.instance = data.get();
    data->describe(m.power, e.description);
    e.visibility = 0;
    e.group = paths.end("");
    world.lightOfMedium[i] = uint32_t(entries.size());
    world.mediumLights.push_back(i);
    entries.push_back(std::move(e));
  }
}

}  // namespace

struct Lights::Chosen {
  std::vector<light::LightKind> kinds;
  std::vector<light::LightEntry> entries;
  std::vector<uint64_t> serials;
  std::vector<std::set<std::string>> names;
  std::vector<const scene::Light*> sources;
  // lights that only mark, apart
  std::vector<light::MarkEntry> marks;
  std::vector<std::set<std::string>> markNames;
  std::vector<const scene::Light*> markSources;
};

std::shared_ptr<const Lights::Made> Lights::madeOf(const scene::Light& l, const scene::Light* dome,
                                                   const Descriptor& plugin, const scene::Scene& scene,
                                                   const Tools& tools, Rebuilt& made) {
  const auto surface = tools.surfaces.find(&l);
  const geometry::Mesh* displaced = surface == tools.surfaces.end() ? nullptr : surface->second.get();
  Hasher own;
  own.digest(digestOf(l, dome, plugin, scene, tools.camera));
  if (displaced) own.bytes(displaced->points.data(), displaced->points.size() * sizeof(displaced->points[0]));
  const Digest digest = own.result();
  if (const auto it = now_.find(digest); it != now_.end()) return it->second;
  if (const auto it = before_.find(digest); it != before_.end()) {
    tools.contents.again(it->second->files);
    return now_[digest] = it->second;
  }
  auto m = std::make_shared<Made>();
  const FileContents::Listening listening(tools.contents, m->files);
  const Placement placement = placementOf(l.toWorld, tools.camera);
  EmittingMesh emitting;
  if (l.geometry) emitting = emittingMesh(l, displaced, tools.camera, tools.diagnostics);
  const LightMesh lightMesh = emitting.mesh();
  Instance instance;
  if (!instance.create(plugin, l.node.get(), &placement, &lightMesh, tools.host, tools.diagnostics)) return nullptr;
  for (const scene::Parameter& p : l.node->params)
    if (p.isReference && declares(plugin, p.name.c_str()))
      tools.diagnostics.warning("LIGHT-CONNECTION", p.pos,
                                std::string(plugin.name) + "." + p.name + " of '" + l.node->handle +
                                    "' is connected to a pattern, and lights run none",
                                "its default is used",
                                "give the value itself, or a picture where the light takes one");
  light::LightEntry& e = m->entry;
  e.owner = instance.owner();
  e.instance = instance.data();
  e.description.visibleToCamera = 1;
  e.description.diffuse = e.description.specular = 1;
  if (const auto* traits = static_cast<const LightTraits*>(plugin.traits); traits && traits->describe)
    traits->describe(instance.data(), &e.description);
  if (const auto* traits = static_cast<const LightTraits*>(plugin.traits); traits && traits->mark)
    traits->mark(instance.data(), &m->mark);
  float largestFactor = 1;
  scene::Light filtered;
  const scene::NodePtr profile = declares(plugin, "iesProfile")
                                     ? iesFilterOf(*l.node, tools.searchPath, tools.contents, tools.diagnostics)
                                     : nullptr;
  if (profile) {
    filtered = l;
    filtered.filters.push_back(profile);
  }
  e.filters = makeLightFilters(profile ? filtered : l, scene, tools.camera, tools.registry, tools.host,
                               tools.diagnostics, largestFactor);
  if (dome) {  // its filters stand where it does; groups of both multiply
    float ofDome = 1;
    const uint32_t group = e.filters.empty() ? 0 : e.filters.back().group + 1;
    for (light::LightFilterEntry& f :
         makeLightFilters(*dome, scene, tools.camera, tools.registry, tools.host, tools.diagnostics, ofDome)) {
      f.group += group;
      e.filters.push_back(std::move(f));
    }
    largestFactor *= ofDome;
  }
  e.motion = motionOf(l, tools.camera, tools.diagnostics);
  if (declares(plugin, "intensityNearDist")) {
    const float nearest = l.node->params.getFloat("intensityNearDist", 0);
    if (nearest > 0 && std::isfinite(nearest))
      e.filters.push_back(light::nearDistanceFilter(nearest));
    else if (nearest != 0)
      tools.diagnostics.warning(
          "LIGHT-NEAR", l.node->pos,
          l.node->plugin + " '" + l.node->handle + "' has an intensityNearDist that is no distance",
          "the light's brightness rises up to it");
  }
  e.description.power *= largestFactor;
  m->serial = ++lastSerial_;
  ++made.lights;
  return now_[digest] = m;
}

// Exporters of RenderMan write visibility:indirect 0 for every light, with its transmission beside it, and chrome shows
// these lights there (rigs for looking at materials are made so): said so it is no wish. Said without transmission it is.
static bool isHiddenFromMirrors(const scene::Light& l, Diagnostics& diagnostics) {
  if (!l.attributes || l.attributes->getInt("visibility:indirect", 1)) return false;
  if (!l.attributes->named.find("visibility:transmission")) return true;
  diagnostics.info(
      "LIGHT-INDIRECT", l.node->pos,
      "light '" + l.node->handle +
          "' has visibility:indirect 0 beside a transmission, as exporters write it for all: mirrors and "
          "clear glass show it");
  return false;
}

Lights::Chosen Lights::choose(const scene::Scene& scene, const LightsToRender& sources, const Tools& tools,
                              Rebuilt& made) {
  const auto isMute = [](const scene::Light& l) { return l.attributes && l.attributes->getInt("lighting:mute", 0); };
  Chosen c;
  std::map<const Descriptor*, uint32_t> kindOf;
  for (const scene::Light& l : sources.lights) {
    if (!l.node) continue;
    const scene::Light* dome = domeShownBy(l, sources.domes);
    if (isMute(l) || (dome && isMute(*dome))) continue;
    const Descriptor* d = tools.registry.find(Kind::Light, l.node->plugin, tools.diagnostics, l.node->pos);
    if (!d) {
      tools.diagnostics.warning("PLUGIN-MISSING", l.node->pos,
                                "no light '" + l.node->plugin + "' (node '" + l.node->handle + "')", "it is left out",
                                adviceOnMissing(Kind::Light, l.node->plugin));
      continue;
    }
    const std::shared_ptr<const Made> m = madeOf(l, dome, *d, scene, tools, made);
    if (!m) continue;
    if (const auto* traits = static_cast<const LightTraits*>(d->traits); traits && traits->mark) {
      light::MarkEntry mark;
      mark.channel = m->mark.channel ? m->mark.channel : "";
      mark.mark = m->mark;
      const Placement place = placementOf(l.toWorld, tools.camera);
      for (int k = 0; k < 3; ++k) mark.center[k] = float(place.localToRender[12 + k]);
      mark.filters = m->entry.filters;
      mark.owners = {m->entry.owner};
      c.marks.push_back(std::move(mark));
      c.markNames.push_back(namesOf(l));
      c.markSources.push_back(&l);
      continue;
    }
    light::LightEntry e = m->entry;
    const auto [kind, isNewKind] = kindOf.try_emplace(d, uint32_t(c.kinds.size()));
    if (isNewKind) {
      c.kinds.emplace_back();
      for (uint32_t width : {1u, 4u, 8u, 16u})
        c.kinds.back().byWidth[width] = static_cast<const LightFunctions*>(functionsFor(*d, width));
    }
    e.kind = kind->second;
    e.group = tools.paths.end(l.node->params.getString("lightGroup", ""));
    e.visibility = 0;
    if (!l.attributes || l.attributes->getInt("visibility:camera", 1)) e.visibility |= light::kLightSeenByCamera;
    if (!isHiddenFromMirrors(l, tools.diagnostics)) e.visibility |= light::kLightSeenByMirrors;
    if (l.node->params.getInt("visibleInRefractionPath", 1)) e.visibility |= light::kLightSeenByLenses;
    setShadows(*l.node, tools.shadowSets, tools.diagnostics, e);
    e.shadows.areOthers = e.castsShadow && tools.areShadowsOthers;
    e.isWalkedTo = l.node->params.getInt("cheapCaustics", 0) != 0 && declares(*d, "cheapCaustics");
    if (declares(*d, "fixedSampleCount"))
      e.ownSamples = uint32_t(std::clamp(l.node->params.getInt("fixedSampleCount", 0), 0, 64));
    e.isIndirectToo = l.node->params.getInt("__indirect", 1) != 0;
    c.names.push_back(namesOf(l, sources.domes));
    c.sources.push_back(&l);
    c.serials.push_back(m->serial);
    c.entries.push_back(std::move(e));
  }
  return c;
}

// By the integrator that is meant for scenes without lights.
static bool isLitFromTheEye(const scene::Scene& scene) {
  return sameName(scene.integrator ? scene.integrator->plugin.c_str() : defaultIntegrator(scene), "PxrDefault");
}

std::shared_ptr<const light::LightSet> Lights::make(const scene::Scene& scene, const LightsToRender& sources,
                                                    const LinkSets& links, const FlatScene& flat, const Tools& tools,
                                                    shade::ShadingWorld& world, Rebuilt& made) {
  before_ = std::move(now_);
  now_.clear();
  Chosen chosen = choose(scene, sources, tools, made);
  before_.clear();
  const bool glows = world.space && std::any_of(world.space->media.begin(), world.space->media.end(),
                                                [](const shade::SpaceMedium& m) { return m.emission != nullptr; });
  if (chosen.entries.empty() && !glows)
    tools.diagnostics.warning(
        "RENDER-NO-LIGHTS", scene.pos, "the scene has no light that is rendered",
        isLitFromTheEye(scene) ? "PxrDefault lights it from the eye" : "only glowing surfaces bring light",
        "add a Light, e.g. Light \"PxrDomeLight\" \"dome\"");
  std::set<std::string> known;  // names of lights that are not rendered too
  for (const auto* list : {&scene.classicLights, &sources.lights})
    for (const scene::Light& l : *list)
      if (l.node) known.merge(namesOf(l, sources.domes));
  for (uint32_t i = 0; glows && i < world.space->media.size(); ++i)
    if (world.space->media[i].emission) known.merge(namesOf(world.space->media[i], flat, world));
  // lights that mark are linked as the others are
  const auto lit = uint32_t(chosen.entries.size());
  std::vector<std::set<std::string>> names = chosen.names;
  names.insert(names.end(), chosen.markNames.begin(), chosen.markNames.end());
  std::vector<const scene::Light*> all = chosen.sources;
  all.insert(all.end(), chosen.markSources.begin(), chosen.markSources.end());
  std::vector<std::vector<uint32_t>> sets =
      membersOf(links, names, all, sources.domes, known, scene, tools.diagnostics);
  for (size_t k = 0; k < sets.size(); ++k)
    for (uint32_t m = 0; m < chosen.marks.size(); ++m)
      chosen.marks[m].isLinked.push_back(std::find(sets[k].begin(), sets[k].end(), lit + m) != sets[k].end());
  for (auto& set : sets) std::erase_if(set, [&](uint32_t i) { return i >= lit; });
  std::vector<uint64_t> filterLinks = linkFilters(chosen.entries, chosen.marks, links, scene, tools.diagnostics);
  for (light::MarkEntry& m : chosen.marks) m.filterLinks = filterLinks;
  world.marks =
      chosen.marks.empty() ? nullptr : std::make_shared<const std::vector<light::MarkEntry>>(std::move(chosen.marks));
  warnOfUnusedLights(sets, chosen.sources, scene, world.placements, tools.diagnostics);
  addMediumLights(world, tools.paths, chosen.kinds, chosen.entries);
  for (uint32_t i = lit; i < chosen.entries.size(); ++i) {
    chosen.serials.push_back(world.space->serial);
    linkMedium(i, namesOf(world.space->media[world.mediumLights[i - lit]], flat, world), links, sets);
  }
  world.hasPlacedLights = std::any_of(chosen.entries.begin(), chosen.entries.end(), [](const light::LightEntry& e) {
    return !e.description.isInfinite && e.description.power > 0;
  });
  if (hasUnlitColors(*world.materials) ||
      std::any_of(chosen.entries.begin(), chosen.entries.end(), [](const auto& e) { return !e.isIndirectToo; })) {
    world.indirectSets = uint32_t(links.size());
    world.hasLinks = true;
    for (size_t k = 0; k < links.size(); ++k) {
      sets.push_back(sets[k]);
      std::erase_if(sets.back(), [&](uint32_t i) { return !chosen.entries[i].isIndirectToo; });
      if (!filterLinks.empty()) filterLinks.push_back(filterLinks[k]);
    }
  }
  Hasher h;
  for (size_t i = 0; i < chosen.entries.size(); ++i) {
    const light::LightEntry& e = chosen.entries[i];
    for (const uint64_t w : {chosen.serials[i], uint64_t(e.kind), uint64_t(e.group),
                             uint64_t(e.visibility | uint32_t(e.castsShadow) << 8 | uint32_t(e.isIndirectToo) << 9 |
                                      uint32_t(e.isWalkedTo) << 10 | uint32_t(e.glassBlocks) << 11 |
                                      uint32_t(e.shadows.areOthers) << 12)})
      h.word(w);
    const light::ShadowControls& s = e.shadows;
    for (const float x : {s.color[0], s.color[1], s.color[2], s.farthest, s.fade, s.gamma}) h.bytes(&x, sizeof x);
    h.word(uint64_t(s.opaque) << 32 | s.clear);
  }
  h.word(sets.size());
  for (const auto& set : sets) h.bytes(set.data(), set.size() * sizeof(uint32_t));
  h.bytes(filterLinks.data(), filterLinks.size() * sizeof(uint64_t));
  h.bytes(world.world->center(), 3 * sizeof(float));
  const float radius = world.world->radius();
  h.bytes(&radius, sizeof radius);
  if (const Digest digest = h.result(); !set_ || digest != ofSet_) {
    set_ = std::make_shared<light::LightSet>(std::move(chosen.kinds), std::move(chosen.entries), sets,
                                             world.world->center(), radius, std::move(filterLinks));
    ofSet_ = digest;
    ++made.lightSets;
  }
  return set_;
}

}  // namespace kinora::render
