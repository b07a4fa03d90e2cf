#include "render/interior_media.h"

#include <kinora/bxdf.h>

#include <algorithm>
#include <string_view>

#include "shade/layered_bxdfs.h"
#include "shade/material.h"

namespace kinora::render {

namespace {

constexpr uint32_t kOfMedium = 0x80000000;  // in the ids of what fills a primitive: those of scenes count from 1

// A parameter's default, as a scene would say it.
scene::Parameter defaultOf(const Param& p, const std::string& name) {
  scene::Parameter out;
  out.name = name;
  const bool isOne = p.type == Type::Float || p.type == Type::Int;
  out.type = isOne ? scene::ValueType::Float : scene::ValueType::Color;
  out.floats.assign(p.value, p.value + (isOne ? 1 : 3));
  return out;
}

// What of a material fills its objects; null: nothing that scatters.
const InteriorMedium* interiorOf(const scene::Node& bxdf, const Descriptor* plugin) {
  const auto* traits = plugin ? static_cast<const BxdfTraits*>(plugin->traits) : nullptr;
  if (!traits || !traits->interiorMedium || !traits->enclosesMedium) return nullptr;
  Diagnostics quiet([](const std::string&, Severity) {});  // the surface's material says it all once more
  const shade::ResolvedParams values(*plugin, &bxdf, quiet);
  if (!traits->enclosesMedium(values.values(), values.count())) return nullptr;
  const InteriorMedium& in = *traits->interiorMedium;
  for (uint32_t k = 0; k < in.causes.count; ++k)
    for (uint32_t i = 0; i < plugin->paramCount; ++i)
      if (std::string_view(plugin->params[i].name) == in.causes.data[k] && values.values()[i].mayBeOn()) return &in;
  return nullptr;
}

scene::NetworkPtr with(const scene::Network& network, scene::Node terminal) {
  auto out = std::make_shared<scene::Network>(network);
  out->terminal = std::make_shared<const scene::Node>(std::move(terminal));
  return out;
}

scene::PrimitivePtr with(const scene::Primitive& primitive, const scene::NetworkPtr& bxdf, uint32_t id) {
  auto attributes = std::make_shared<scene::Attributes>(*primitive.attributes);
  attributes->bxdf = bxdf;
  auto out = std::make_shared<scene::Primitive>(primitive);
  out->attributes = std::move(attributes);
  out->id = id;
  return out;
}

}  // namespace

const InteriorMedia::Networks& InteriorMedia::networksOf(const scene::NetworkPtr& network, Registry& registry,
                                                         Diagnostics& diagnostics) {
  const auto [it, isNew] = networks_.try_emplace(network.get());
  Networks& n = it->second;
  if (!isNew) return n;
  n.whole = network;  // held: nothing else gets its address
  Diagnostics quiet(
      [](const std::string&, Severity) {});  // what is wrong with a tree is told when its material is made
  const scene::NetworkPtr flat = shade::withFlatLayers(*network, registry, quiet);
  const scene::Network& whole = flat ? *flat : *network;
  const scene::Node& node = *whole.terminal;
  const Descriptor* plugin = registry.find(Kind::Bxdf, node.plugin, diagnostics, node.pos);
  const InteriorMedium* in = interiorOf(node, plugin);
  if (!in) return n;
  if (flat) shade::withFlatLayers(*network, registry, diagnostics);  // of this one it will not be made again
  scene::Node surface = node, medium = node;
  surface.params.erase(in->moves);
  medium.plugin = in->material;
  medium.handle += "_interior";
  medium.params = {};
  for (uint32_t k = 0; k < in->parameters.count; ++k)
    if (const scene::Parameter* p = node.params.find(in->parameters.data[k].own)) {
      scene::Parameter moved = *p;
      moved.name = in->parameters.data[k].there;
      medium.params.set(std::move(moved));
    }
  // and what the scene leaves out is as this material has it, not as the medium would
  for (uint32_t k = 0; k < in->parameters.count; ++k)
    for (uint32_t i = 0; i < plugin->paramCount; ++i)
      if (std::string_view(plugin->params[i].name) == in->parameters.data[k].own &&
          !medium.params.find(in->parameters.data[k].there))
        medium.params.set(defaultOf(plugin->params[i], in->parameters.data[k].there));
  n.surface = with(whole, std::move(surface));
  n.medium = with(whole, std::move(medium));
  return n;
}

bool InteriorMedia::hasAny(const std::vector<scene::PrimitivePtr>& primitives, Registry& registry,
                           Diagnostics& diagnostics) {
  const scene::Network* last = nullptr;
  return std::any_of(primitives.begin(), primitives.end(), [&](const scene::PrimitivePtr& p) {
    const scene::NetworkPtr* network = p->attributes ? &p->attributes->bxdf : nullptr;
    if (!network || !*network || !(*network)->terminal || network->get() == last) return false;
    last = network->get();
    return networksOf(*network, registry, diagnostics).medium != nullptr;
  });
}

void InteriorMedia::split(std::vector<scene::PrimitivePtr>& primitives,
                          std::map<const scene::Primitive*, Halves>& halves, Registry& registry,
                          Diagnostics& diagnostics) {
  std::vector<scene::PrimitivePtr> media;
  for (scene::PrimitivePtr& p : primitives) {
    // of solids the surface of one part bounds no space of its own
    if (!p->attributes || !p->attributes->bxdf || !p->attributes->bxdf->terminal || p->solid) continue;
    const Networks& n = networksOf(p->attributes->bxdf, registry, diagnostics);
    if (!n.medium) continue;
    Halves h;
    if (const auto known = halves_.find(p.get()); known != halves_.end())
      h = known->second;
    else
      h = {p, with(*p, n.surface, p->id), with(*p, n.medium, p->id | kOfMedium)};
    halves[p.get()] = h;
    p = h.surface;
    media.push_back(h.medium);
  }
  primitives.insert(primitives.end(), media.begin(), media.end());
}

const scene::Scene& InteriorMedia::addTo(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics) {
  std::map<const scene::Primitive*, Halves> halves;
  const bool isAny = hasAny(scene.primitives, registry, diagnostics) ||
                     std::any_of(scene.prototypes.begin(), scene.prototypes.end(), [&](const scene::Prototype& p) {
                       return hasAny(p.primitives, registry, diagnostics);
                     });
  if (isAny) {
    scene_ = scene;
    split(scene_.primitives, halves, registry, diagnostics);
    for (scene::Prototype& p : scene_.prototypes) split(p.primitives, halves, registry, diagnostics);
  } else {
    scene_ = {};
  }
  halves_ = std::move(halves);
  // those of nodes that no primitive has any more
  std::erase_if(networks_, [](const auto& n) { return n.second.whole.use_count() == 1; });
  return isAny ? scene_ : scene;
}

}  // namespace kinora::render
