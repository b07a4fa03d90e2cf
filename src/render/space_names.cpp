#include "render/space_names.h"

#include <set>

#include "base/text.h"

namespace kinora::render {

namespace {

// By what stock patterns call the parameter that names a system.
bool namesSpace(const scene::Parameter& p) {
  if (p.isReference || p.strings.size() != 1 || p.strings[0].empty()) return false;
  const std::string name = lowerCase(p.name);
  return name.ends_with("coordsys") || name == "dispscalespace" || name == "dispdirectionspace";
}

// "Vn": the direction of view, that PxrFacingRatio and its kin take.
bool isKnown(const std::string& space, const shade::ShadingWorld& w) {
  for (const char* always : {"object", "shader", "render", "current", "Vn"})
    if (space == always) return true;
  return w.spaces.contains(space) || w.objectSystems.contains(space);
}

std::string listOf(const shade::ShadingWorld& w) {
  std::set<std::string> names(w.objectSystems.begin(), w.objectSystems.end());
  for (const auto& [name, m] : w.spaces) names.insert(name);
  names.insert("object");
  constexpr size_t kMost = 12;
  std::string list;
  size_t n = 0;
  for (const std::string& name : names)
    if (++n <= kMost) list += (n > 1 ? ", " : "") + name;
  return n > kMost ? list + " and " + std::to_string(n - kMost) + " more" : list;
}

}  // namespace

void warnOfUnknownSpaces(const FlatScene& flat, const shade::ShadingWorld& w, Diagnostics& diagnostics) {
  std::set<const void*> seen;
  const auto look = [&](const scene::NodePtr& n) {
    if (!n || !seen.insert(n.get()).second) return;
    for (const scene::Parameter& p : n->params)
      if (namesSpace(p) && !isKnown(p.strings[0], w))
        diagnostics.warning("PATTERN-COORDSYS", n->pos,
                            n->plugin + " \"" + n->handle + "\" asks for the coordinate system '" +
                                p.strings[0].substr(0, 60) + "' (" + p.name + "), which nothing names",
                            "what it computes stays in the world's space", "there are " + listOf(w));
  };
  for (const scene::Attributes* a : flat.attributes)
    for (const scene::Network* network : {a ? a->bxdf.get() : nullptr, a ? a->displacement.get() : nullptr}) {
      if (!network || !seen.insert(network).second) continue;
      look(network->terminal);
      for (const scene::NodePtr& n : network->patterns) look(n);
    }
}

}  // namespace kinora::render
