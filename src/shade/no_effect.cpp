#include "shade/no_effect.h"

#include <kinora/named_values.h>

#include <string>
#include <string_view>

#include "base/text.h"

namespace kinora::shade {

namespace {

// Whether a scene asks for something else than what happens anyway.
bool asksForMore(const Param& p, const scene::Parameter& given) {
  if (given.isReference) return true;
  if (p.type == Type::String) return !given.strings.empty() && given.strings[0] != (p.text ? p.text : "");
  const bool isArray = p.flags & kParamArray;
  const auto differs = [&](const auto& values) {
    for (size_t i = 0; i < values.size(); ++i) {
      if (isArray ? i >= p.listCount : i >= 3) return true;
      if (float(values[i]) != (isArray ? p.list[i] : p.value[i])) return true;
    }
    return false;
  };
  return differs(given.floats) || differs(given.ints);
}

}  // namespace

void NoEffect::tell(const scene::Network& network, Kind terminal, Registry& registry, Diagnostics& diagnostics) {
  const auto look = [&](const scene::Node& node, Kind kind) {
    const Descriptor* d = registry.find(kind, node.plugin, diagnostics, node.pos);
    if (!d) return;
    std::string names;
    for (uint32_t i = 0; i < d->paramCount; ++i) {
      const Param& p = d->params[i];
      if (p.flags & kParamOutput || !p.doc || !std::string_view(p.doc).starts_with(kNoEffect)) continue;
      for (const scene::Parameter& q : node.params)
        if (sameName(q.name, p.name) && asksForMore(p, q) && told_.emplace(d, i).second)
          names += (names.empty() ? "'" : ", '") + std::string(p.name) + "'";
    }
    if (!names.empty())
      diagnostics.warning(
          "PARAM-NO-EFFECT", node.pos,
          std::string(d->name) + " '" + node.handle + "': parameters without effect in this version: " + names,
          "ignored", std::string("kinora plugins ") + d->name + " says why, or what to use instead");
  };
  // materials that others are made of stand among the patterns
  for (const scene::NodePtr& p : network.patterns) look(*p, p->kind == "Bxdf" ? Kind::Bxdf : Kind::Pattern);
  if (network.terminal) look(*network.terminal, terminal);
}

}  // namespace kinora::shade
