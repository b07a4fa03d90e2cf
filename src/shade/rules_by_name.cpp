#include "shade/rules_by_name.h"

#include <algorithm>
#include <string>

#include "base/text.h"
#include "shade/resolved_node.h"

namespace kinora::shade {

// A layer S to which nothing is connected, and of which no member S_x is said, is none: its switch SEnabled, which is
// on by default, would lay the plug-in's usual values over what is below.
void MaterialSet::switchOffEmpty(Resolved& r) {
  const auto isSaid = [&](const std::string& prefix) {
    for (uint32_t i = 0; i < r.plugin->paramCount; ++i)
      if (std::string_view(r.plugin->params[i].name).starts_with(prefix) && r.values->given(i)) return true;
    return false;
  };
  for (uint32_t i = 0; i < r.plugin->paramCount; ++i) {
    const Param& p = r.plugin->params[i];
    if (p.type != Type::Struct || p.flags & kParamOutput || r.links[i].node >= 0) continue;
    const std::string layer = p.name;
    for (uint32_t k = 0; k < r.plugin->paramCount; ++k)
      if (r.plugin->params[k].name == layer + "Enabled" && !isSaid(layer + "_")) r.values->setNumber(k, 0);
  }
}

// A struct that is connected brings its members along: the output's companions O_x feed the parameters S_x, or x
// where the node has no S_x (a layered surface). What the scene connects by itself stays; switches S_enableX that it
// does not set are those of the producer, and on where the producer has none.
void MaterialSet::connectMembers(std::vector<Resolved>& nodes, Resolved& to, uint32_t parameter) {
  const Resolved::Link link = to.links[parameter];
  const Descriptor &from = *nodes[size_t(link.node)].plugin, &plugin = *to.plugin;
  const std::string prefix = std::string(plugin.params[parameter].name) + "_";
  const auto find = [](const Descriptor& d, const std::string& name) {
    uint32_t i = 0;
    while (i < d.paramCount && ((d.params[i].flags & kParamOutput) || !sameName(d.params[i].name, name))) ++i;
    return i;
  };
  std::string whole;
  uint32_t output = 0;
  for (uint32_t k = 0; k < from.paramCount; ++k)
    if (from.params[k].flags & kParamOutput && output++ == link.output)
      whole = std::string(from.params[k].name) + "_";
  output = 0;
  for (uint32_t k = 0; k < from.paramCount; ++k) {
    if (!(from.params[k].flags & kParamOutput)) continue;
    const uint32_t index = output++;
    const std::string name = from.params[k].name;
    if (!name.starts_with(whole) || from.params[k].type == Type::Struct) continue;
    const std::string member = name.substr(whole.size());
    uint32_t i = find(plugin, prefix + member);
    if (i == plugin.paramCount) i = find(plugin, member);
    if (i == plugin.paramCount || plugin.params[i].flags & kParamNotConnectable || to.links[i].node >= 0) continue;
    to.links[i] = {link.node, index};
    to.values->connect(i);
  }
  for (uint32_t i = 0; i < plugin.paramCount; ++i) {
    const std::string name = plugin.params[i].name;
    if (!name.starts_with(prefix + "enable") || plugin.params[i].type != Type::Int || to.values->given(i)) continue;
    const uint32_t own = find(from, name.substr(prefix.size()));
    to.values->setNumber(i, own == from.paramCount ? 1.f : nodes[size_t(link.node)].values->values()[own].floats[0]);
  }
}

// What a bxdf says of the shadows that it casts, by parameters of these names, whichever has them.
MaterialSet::ShadowsCast MaterialSet::shadowsCast(const Resolved& bxdf) {
  ShadowsCast s;
  for (uint32_t i = 0; i < bxdf.plugin->paramCount; ++i) {
    const Param& p = bxdf.plugin->params[i];
    const ParamValue& v = bxdf.values->values()[i];
    if (sameName(p.name, "shadowColor") && p.type == Type::Color &&
        (bxdf.links[i].node >= 0 || v.floats[0] > 0 || v.floats[1] > 0 || v.floats[2] > 0))
      s.color = int32_t(i);
    if (sameName(p.name, "shadowMode") && p.type == Type::Int) s.isColorAll = v.floats[0] == 1;
  }
  return s;
}

void findTees(Program& p) {
  for (uint32_t n = 0; n < p.nodes.size(); ++n) {
    const ProgramNode& node = p.nodes[n];
    for (uint32_t k = 0; node.source && sameName(node.plugin->name, "PxrMatteID") && k < node.outputParam.size();
         ++k) {
      const std::string name = node.plugin->params[node.outputParam[k]].name;
      if (!name.starts_with("MatteID")) continue;
      p.tees.push_back({name, n, k});
    }
    if (node.source || !sameName(node.plugin->name, "PxrTee")) continue;
    uint32_t output = 0, wanted = 0;
    for (uint32_t k = 0; k < node.outputParam.size(); ++k) {
      const char* name = node.plugin->params[node.outputParam[k]].name;
      if (sameName(name, "resultF"))
        output = k;
      else if (node.wanted[k])
        ++wanted;
    }
    for (uint32_t i = 0; i < node.plugin->paramCount; ++i)
      if (sameName(node.plugin->params[i].name, "aov") && node.params[i].text && *node.params[i].text)
        p.tees.push_back({node.params[i].text, n, wanted ? 0 : output});
  }
}

std::string_view lobeName(const LobeDecl& lobe, const ProgramNode& bxdf) {
  std::string_view name = lobe.name ? lobe.name : "";
  if (!name.starts_with('=')) return name;
  const size_t colon = std::min(name.find(':'), name.size());
  const std::string parameter(name.substr(1, colon - 1));
  for (uint32_t i = 0; i < bxdf.plugin->paramCount; ++i)
    if (sameName(bxdf.plugin->params[i].name, parameter) && bxdf.plugin->params[i].type == Type::String &&
        bxdf.params[i].text && *bxdf.params[i].text)
      return bxdf.params[i].text;
  return colon < name.size() ? name.substr(colon + 1) : std::string_view();
}

const scene::Parameter* colorOfMissingBxdf(const scene::Node& bxdf) {
  for (const char* name :
       {"diffuseColor", "baseColor", "frontColor", "color", "surfaceColor", "nearColor", "edgeColor", "emitColor"}) {
    const scene::Parameter* p = bxdf.params.find(name);
    if (p && (p->isReference || p->floats.size() == 3)) return p;
  }
  return nullptr;
}

}  // namespace kinora::shade
