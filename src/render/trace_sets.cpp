// Named subsets of objects for the rays of other objects: each different one becomes a bit that rays ask for and that
// its members carry.
#include <algorithm>
#include <map>
#include <set>

#include "render/trace_stage.h"
#include "render/world_lights.h"

namespace kinora::render {

namespace {

struct SetKind {
  const char *subset, *exclude;
  uint32_t bits;  // how many a subset of this kind takes
};
constexpr SetKind kKinds[] = {{"trace:reflectsubset", "trace:reflectexcludesubset", 1},
                              {"trace:transmitsubset", "trace:transmitexcludesubset", 1},
                              {"trace:shadowsubset", "trace:shadowexcludesubset", 2}};
constexpr int kOfShadows = 2, kByText = 3;  // kinds; the last is asked for by plug-ins
constexpr uint32_t kFirstBit = 6;           // after trace::VisibilityBits
constexpr const char* kBetweenNames = ", \t\n\r\f\v";

}  // namespace

std::vector<std::string> groupNames(const std::string& list) {
  std::vector<std::string> names;
  for (size_t at = 0; (at = list.find_first_not_of(kBetweenNames, at)) != std::string::npos;) {
    const size_t end = std::min(list.find_first_of(kBetweenNames, at), list.size());
    std::string name = list.substr(at, end - at);
    if (name[0] == '+') name.erase(0, 1);
    if (!name.empty()) names.push_back(std::move(name));
    at = end;
  }
  return names;
}

namespace {

// What stops shadow rays follows from what shapes are made of, in any of their places.
std::vector<uint32_t> visibilityOfShapes(const FlatScene& flat, const shade::MaterialSet& materials,
                                         const std::vector<shade::PlacementInfo>& infos) {
  std::vector<uint32_t> visibility(flat.shapes.size(),
                                   trace::kSeenByCamera | trace::kSeenByIndirect | trace::kSeenByOpaqueShadow);
  for (size_t k = 0; k < flat.kinds.size(); ++k) {
    const shade::Program& program = materials.program(materials[infos[k].material].program);
    uint32_t& v = visibility[flat.kinds[k].shape];
    if (program.scatters) v |= trace::kAskedAlone;
    if (program.walkableLobes) v |= trace::kSeenByWalks;
    if (program.opaque && !program.tints && program.shadowColor < 0) continue;
    v = (v & ~uint32_t(trace::kSeenByOpaqueShadow)) | trace::kSeenByClearShadow;
  }
  return visibility;
}

// The groups that plug-ins name (kParamTraceSet), with the first that asks for each text.
std::map<std::string, SetAsker> setsByText(const shade::MaterialSet& materials, const std::vector<SetAsker>& askers) {
  std::map<std::string, SetAsker> sets;
  for (const SetAsker& a : askers) sets.try_emplace(a.text, a);
  for (uint32_t i = 0; i < materials.programCount(); ++i)
    for (const shade::ProgramNode& node : materials.program(i).nodes)
      for (uint32_t k = 0; node.plugin && k < node.plugin->paramCount; ++k)
        if (node.plugin->params[k].flags & kParamTraceSet && *node.params[k].text)
          sets.try_emplace(
              node.params[k].text,
              SetAsker{node.params[k].text, std::string(node.plugin->name) + " '" + node.handle + "'", node.pos});
  return sets;
}

}  // namespace

std::vector<SetAsker> setAskersOf(const Descriptor& plugin, const scene::Node* node) {
  std::vector<SetAsker> askers;
  for (uint32_t k = 0; k < plugin.paramCount; ++k) {
    const Param& p = plugin.params[k];
    if (!(p.flags & kParamTraceSet)) continue;
    const bool isOwn = node && node->plugin == plugin.name;
    std::string text = isOwn ? node->params.getString(p.name, p.text) : p.text;
    if (!text.empty()) askers.push_back({std::move(text), plugin.name, node ? node->pos : SourcePos{}});
  }
  return askers;
}

Sight sightOf(const FlatScene& flat, const shade::MaterialSet& materials, const std::vector<SetAsker>& askers,
              const std::vector<ShadowSubset>& ofLights, std::vector<shade::PlacementInfo>& infos, bool isWhole,
              Diagnostics& diagnostics) {
  Sight sight;
  sight.ofShape = visibilityOfShapes(flat, materials, infos);
  for (size_t k = 0; k < flat.kinds.size(); ++k) {
    const uint32_t attributes = flat.kinds[k].visibility;
    const bool isWalkable = (attributes & trace::kSeenByIndirect) && materials.isWalkable(infos[k].material);
    sight.ofKind.push_back(attributes | trace::kAskedAlone | (isWalkable ? uint32_t(trace::kSeenByWalks) : 0u));
  }
  struct Subset {
    int kind;
    std::vector<std::string> names, exclude;
    uint32_t bit;
  };
  std::map<std::array<std::string, 3>, uint32_t> known;  // kind and both texts -> bit
  std::vector<Subset> subsets;
  // the names that attributes give, as most objects share those of the one before
  std::vector<std::vector<std::string>> groups{{}};
  std::vector<uint32_t> groupsOf(flat.kinds.size(), 0);  // by kind
  std::set<std::string> members, missed;
  uint32_t nextBit = kFirstBit;
  bool any = false, tooMany = false;
  for (size_t i = 0; i < flat.kinds.size(); ++i) {
    const scene::Attributes* a = flat.attributes[i];
    if (!a) continue;
    if (i > 0 && a == flat.attributes[i - 1]) {
      groupsOf[i] = groupsOf[i - 1];
      continue;
    }
    std::vector<std::string> names = groupNames(a->named.getString("grouping:membership", ""));
    members.insert(names.begin(), names.end());
    if (!names.empty()) {
      groupsOf[i] = uint32_t(groups.size());
      groups.push_back(std::move(names));
    }
    for (const SetKind& k : kKinds) any |= a->named.find(k.subset) || a->named.find(k.exclude);
  }
  const std::map<std::string, SetAsker> byText = setsByText(materials, askers);
  if (!any && byText.empty() && ofLights.empty()) return sight;
  const auto isTooMany = [&](uint32_t more) {
    if (nextBit + more <= 32) return false;
    if (!tooMany)
      diagnostics.warning("RENDER-TRACE-SET", {}, "the scene has more subsets for rays than can be told apart",
                          "those beyond are ignored");
    return tooMany = true;
  };
  const auto warnOfMissing = [&](const std::string& name, const SourcePos& pos, const std::string& who) {
    if (isWhole && !members.count(name) && missed.insert(name).second)
      diagnostics.warning("RENDER-TRACE-SET", pos,
                          who + " names '" + name.substr(0, 60) + "', and no object is a member of that group",
                          "the name selects nothing");
  };
  std::map<std::array<uint32_t, 3>, uint32_t> setOf;
  sight.sets.push_back({});
  setOf[{0, 0, 0}] = 0;
  for (size_t i = 0; i < flat.kinds.size(); ++i) {
    const scene::Attributes* a = flat.attributes[i];
    infos[i].traceSet = 0;
    if (!a) continue;
    if (i > 0 && a == flat.attributes[i - 1]) {
      infos[i].traceSet = infos[i - 1].traceSet;
      continue;
    }
    std::array<uint32_t, 3> bits{};
    for (int k = 0; k < 3; ++k) {
      const std::string subset = a->named.getString(kKinds[k].subset, ""),
                        exclude = a->named.getString(kKinds[k].exclude, "");
      Subset s{k, groupNames(subset), groupNames(exclude), 0};
      if (s.names.empty() && s.exclude.empty()) continue;
      for (const auto* list : {&s.names, &s.exclude})
        for (const std::string& n : *list) {
          const char* name = list == &s.names ? kKinds[k].subset : kKinds[k].exclude;
          const scene::Parameter* p = a->named.find(name);
          warnOfMissing(n, p ? p->pos : SourcePos{}, name);
        }
      const auto [it, fresh] = known.try_emplace({std::to_string(k), subset, exclude}, nextBit);
      if (fresh) {
        if (isTooMany(kKinds[k].bits)) {
          it->second = 0;
          continue;
        }
        s.bit = nextBit;
        nextBit += kKinds[k].bits;
        subsets.push_back(std::move(s));
      }
      bits[size_t(k)] = it->second;
    }
    const auto [it, fresh] = setOf.try_emplace(bits, uint32_t(sight.sets.size()));
    if (fresh) {
      shade::TraceSet set;
      if (bits[0]) set.reflect = 1u << bits[0];
      if (bits[1]) set.transmit = 1u << bits[1];
      if (bits[2]) {
        set.opaqueShadow = 1u << bits[2];
        set.clearShadow = 2u << bits[2];
      }
      sight.sets.push_back(set);
    }
    infos[i].traceSet = it->second;
  }
  if (sight.sets.size() == 1) sight.sets.clear();
  for (const auto& [text, asker] : byText) {
    Subset s{kByText, groupNames(text), {}, nextBit};
    if (s.names.empty()) continue;
    for (const std::string& n : s.names) warnOfMissing(n, asker.pos, asker.who);
    if (isTooMany(1)) break;
    sight.byText[text] = 1u << nextBit++;
    subsets.push_back(std::move(s));
  }
  for (const ShadowSubset& l : ofLights) {
    Subset s{kOfShadows, groupNames(l.subset), groupNames(l.exclude), nextBit};
    if (s.names.empty() && s.exclude.empty()) continue;
    for (const auto* list : {&s.names, &s.exclude})
      for (const std::string& n : *list) warnOfMissing(n, l.pos, l.who);
    const auto [it, fresh] = known.try_emplace({std::to_string(kOfShadows), l.subset, l.exclude}, nextBit);
    if (fresh) {
      if (isTooMany(kKinds[kOfShadows].bits)) {
        it->second = 0;
        continue;
      }
      nextBit += kKinds[kOfShadows].bits;
      subsets.push_back(std::move(s));
    }
    if (!it->second) continue;
    shade::TraceSet& set = sight.ofLights[{l.subset, l.exclude}];
    set.opaqueShadow = 1u << it->second;
    set.clearShadow = 2u << it->second;
  }
  // shapes take part as far as their visibility lets them; placements are members
  const auto bitsOf = [](const Subset& s, uint32_t visibility) {
    if (s.kind != kOfShadows) return visibility & trace::kSeenByIndirect ? 1u << s.bit : 0u;
    return (visibility & trace::kSeenByOpaqueShadow ? 1u << s.bit : 0u) |
           (visibility & trace::kSeenByClearShadow ? 2u << s.bit : 0u);
  };
  for (uint32_t& visibility : sight.ofShape)
    for (const Subset& s : subsets) visibility |= bitsOf(s, visibility);
  sight.subsetsOfKind.assign(flat.kinds.size(), 0);
  for (size_t i = 0; i < flat.kinds.size(); ++i)
    for (const Subset& s : subsets) {
      const auto in = [&](const std::vector<std::string>& names) {
        return std::any_of(names.begin(), names.end(), [&](const std::string& n) {
          const std::vector<std::string>& own = groups[groupsOf[i]];
          return std::find(own.begin(), own.end(), n) != own.end();
        });
      };
      if (!(s.names.empty() || in(s.names)) || in(s.exclude)) continue;
      sight.ofKind[i] |= bitsOf(s, sight.ofKind[i]);
      sight.subsetsOfKind[i] |= bitsOf(s, ~0u);
    }
  return sight;
}

void compareShadows(const FlatScene& flat, const shade::MaterialSet& materials, Sight& sight,
                    std::vector<shade::PlacementInfo>& infos) {
  uint32_t opaque = trace::kSeenByOpaqueShadow;
  for (const shade::TraceSet& set : sight.sets) {
    opaque |= set.opaqueShadow;
    const shade::TraceSet plain;
    // what rays that leave the object do not see may cast shadows on it
    sight.areShadowsUnseen |= set.reflect != plain.reflect || set.transmit != plain.transmit;
    sight.areShadowsOthers |= sight.areShadowsUnseen || set.opaqueShadow != plain.opaqueShadow;
  }
  std::vector<uint32_t> seen(flat.kinds.size());
  for (size_t k = 0; k < seen.size(); ++k) {
    seen[k] = sight.ofKind[k] & sight.ofShape[flat.kinds[k].shape];
    const bool isSeen = seen[k] & trace::kSeenByIndirect,
               casts = seen[k] & (trace::kSeenByOpaqueShadow | trace::kSeenByClearShadow);
    // what stops the rays that find lights leaves some of the light in its shadow
    const bool isColored = casts && materials.colorsShadows(infos[k].material);
    sight.areShadowsUnseen |= (casts && !isSeen) || isColored;
    sight.areShadowsOthers |= casts != isSeen || isColored;
  }
  for (size_t k = 0; sight.areShadowsOthers && k < seen.size(); ++k) infos[k].shadowCast = seen[k] & opaque;
}

}  // namespace kinora::render
