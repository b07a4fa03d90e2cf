#include "render/volume_aggregates.h"

#include <kinora/bxdf.h>

#include <algorithm>

#include "render/world_lights.h"
#include "shade/material.h"
#include "trace/world.h"

namespace kinora::render {

namespace {

constexpr const char* kGlobal = "globalVolumeAggregate";  // that of objects which name none
constexpr const char* kInside = "volumeAggregateName";    // parameter of surfaces

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}
void add(std::vector<std::string>& names, const std::string& name) {
  if (!has(names, name)) names.push_back(name);
}
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "'" : ", '") + n + "'";
  return text;
}

}  // namespace

AggregateChoice aggregatesOf(const Descriptor& integrator, const scene::Node* node) {
  AggregateChoice choice;
  if (node) choice.pos = node->pos;
  const bool isOwn = node && node->plugin == integrator.name;
  const auto find = [&](const char* name, std::vector<std::string>& names) {
    for (uint32_t k = 0; k < integrator.paramCount; ++k) {
      const Param& p = integrator.params[k];
      if (p.type != Type::String || std::string(p.name) != name) continue;
      const scene::Parameter* said = isOwn ? node->params.find(p.name) : nullptr;
      if (!said) names = groupNames(p.text);
      for (size_t i = 0; said && i < said->strings.size(); ++i)
        for (const std::string& n : groupNames(said->strings[i])) add(names, n);
      return true;
    }
    return false;
  };
  std::vector<std::string> all;
  choice.isMade = find("volumeAggregate", all);
  if (!choice.isMade) return choice;
  for (auto& [name, names] :
       {std::pair("volumeAggregateCamera", &choice.camera), std::pair("volumeAggregateIndirect", &choice.indirect),
        std::pair("volumeAggregateTransmission", &choice.transmission)})
    if (!find(name, *names) || names->empty()) *names = all;
  return choice;
}

std::vector<std::string> aggregatesInside(const scene::Attributes* attributes, Registry& registry,
                                          Diagnostics& diagnostics) {
  if (!attributes || !attributes->bxdf || !attributes->bxdf->terminal) return {};
  const scene::Node& node = *attributes->bxdf->terminal;
  const Descriptor* plugin = registry.find(Kind::Bxdf, node.plugin, diagnostics, node.pos);
  const auto* traits = plugin ? static_cast<const BxdfTraits*>(plugin->traits) : nullptr;
  if (!traits || !traits->enclosesMedium) return {};
  std::vector<std::string> names;
  for (uint32_t k = 0; k < plugin->paramCount; ++k) {
    const Param& p = plugin->params[k];
    if (p.type != Type::String || std::string_view(p.name) != kInside) continue;
    const scene::Parameter* said = node.params.find(p.name);
    if (!said && p.text) names = groupNames(p.text);
    for (size_t i = 0; said && i < said->strings.size(); ++i)
      for (const std::string& n : groupNames(said->strings[i])) add(names, n);
  }
  if (names.empty()) return {};
  Diagnostics quiet([](const std::string&, Severity) {});  // the material says it all once more
  const shade::ResolvedParams values(*plugin, &node, quiet);
  return traits->enclosesMedium(values.values(), values.count()) ? names : std::vector<std::string>();
}

AggregateSight Aggregates::sightOf(const scene::Attributes* attributes, uint32_t visibility,
                                   const std::string& object) {
  if (!choice_.isMade && interiors_.empty()) return {visibility, 0, {}};
  const scene::Parameter* said = attributes ? attributes->named.find("volume:aggregate") : nullptr;
  std::vector<std::string> own;
  if (said)
    for (const std::string& text : said->strings)
      for (const std::string& name : groupNames(text)) add(own, name);
  else
    own.push_back(kGlobal);
  if (own.empty()) return {visibility, 0, {}};  // in none: a medium on its own
  for (const std::string& name : own) add(met_, name);
  const auto isIn = [&](const std::vector<std::string>& names) {
    // files of when no object was in an aggregate unless it said so ask for none
    return names.empty() ? !said
                         : std::any_of(own.begin(), own.end(), [&](const std::string& n) { return has(names, n); });
  };
  AggregateSight sight;
  for (uint32_t k = 0; k < interiors_.size(); ++k)
    if (has(own, interiors_[k])) sight.insideOf.push_back(k);
  if (!sight.insideOf.empty()) sight.inside = ~0u;
  uint32_t& asked = sight.everywhere;
  if (!choice_.isMade) {
    // who asks for nothing by name knows all but what is some surface's alone
    if (sight.insideOf.size() < own.size() || has(own, kGlobal)) asked = ~0u;
  } else {
    if (isIn(choice_.camera)) asked |= trace::kSeenByCamera;
    if (isIn(choice_.indirect)) asked |= trace::kSeenByIndirect;
    if (isIn(choice_.transmission)) asked |= trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow;
  }
  if (!asked && !sight.inside) {
    for (const std::string& name : own) add(unseen_, name);
    if (++unseenCount_ <= 3) firstUnseen_.push_back(object);
  }
  const bool respects = !attributes || attributes->getInt("volume:aggregaterespectvisibility", 1);
  if (respects) {
    sight.everywhere &= visibility;
    sight.inside &= visibility;
  }
  sight.inside &= ~sight.everywhere;
  return sight;
}

void Aggregates::tell(Diagnostics& diagnostics) const {
  if (!choice_.isMade && interiors_.empty()) return;
  std::vector<std::string> unknown;
  for (const auto* names : {&choice_.camera, &choice_.indirect, &choice_.transmission, &interiors_})
    for (const std::string& name : *names)
      if (name != kGlobal && !has(met_, name)) add(unknown, name);
  for (const std::string& name : unknown) {
    diagnostics.warning("MEDIUM-AGGREGATE", choice_.pos,
                        "no volume is in the aggregate '" + name + "' that is asked for",
                        "rays that ask for it know of none by that name",
                        met_.empty() ? "Attribute \"volume\" \"string aggregate\" puts volumes into one"
                                     : "there are " + listed(met_));
  }
  if (!unseenCount_) return;
  diagnostics.warning("MEDIUM-LEFT-OUT", choice_.pos,
                      std::to_string(unseenCount_) + (unseenCount_ == 1 ? " volume (" : " volumes (") +
                          listed(firstUnseen_) + (unseenCount_ > firstUnseen_.size() ? ", ..." : "") +
                          (unseenCount_ == 1 ? ") is" : ") are") +
                          " in aggregates that the integrator asks for in no ray: " + listed(unseen_),
                      unseenCount_ == 1 ? "it is left out" : "they are left out",
                      "volumeAggregate of the integrator names aggregates, several with blanks between them");
}

}  // namespace kinora::render
