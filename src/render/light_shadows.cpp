#include "render/light_shadows.h"

#include <algorithm>
#include <cmath>

namespace kinora::render {

namespace {

std::string nameOf(const scene::Node& light) { return light.plugin + " '" + light.handle + "'"; }

// traceLightPaths: the light is as light paths carry it, whatever else it says.
bool isPhysical(const scene::Node& light) { return light.params.getInt("traceLightPaths", 0) != 0; }

}  // namespace

std::vector<ShadowSubset> shadowSubsets(const std::vector<scene::Light>& lights) {
  std::vector<ShadowSubset> list;
  for (const scene::Light& l : lights) {
    if (!l.node || isPhysical(*l.node)) continue;
    ShadowSubset s{l.node->params.getString("shadowSubset", ""), l.node->params.getString("shadowExcludeSubset", ""),
                   nameOf(*l.node), l.node->pos};
    if (!s.subset.empty() || !s.exclude.empty()) list.push_back(std::move(s));
  }
  return list;
}

void setShadows(const scene::Node& light, const ShadowSets& sets, Diagnostics& diagnostics,
                light::LightEntry& entry) {
  const scene::ParameterList& p = light.params;
  entry.castsShadow = p.getInt("enableShadows", 1) != 0;
  entry.glassBlocks = entry.castsShadow && (isPhysical(light) || p.getInt("thinShadow", 1) == 0);
  entry.shadows = {};
  if (!entry.castsShadow || isPhysical(light)) return;
  light::ShadowControls& s = entry.shadows;
  const auto number = [&](const char* name, float standard) {
    const float x = p.getFloat(name, standard);
    if (std::isfinite(x)) return x;
    diagnostics.warning("LIGHT-SHADOW", light.pos, nameOf(light) + " has a " + name + " that is no finite number",
                        "its default is used");
    return standard;
  };
  const std::vector<float> color = p.getFloats("shadowColor");
  const bool isColor = std::all_of(color.begin(), color.end(), [](float x) { return x >= 0 && x <= 1; });
  if (!isColor)
    diagnostics.warning("LIGHT-SHADOW", light.pos,
                        nameOf(light) + " has a shadowColor beyond 0 to 1: it is the share of light left in shadow",
                        "its channels are brought within");
  for (size_t c = 0; c < 3 && color.size() >= 3; ++c) s.color[c] = color[c] > 0 ? std::min(color[c], 1.f) : 0.f;
  if (const float distance = number("shadowDistance", -1); distance >= 0) s.farthest = distance;
  const float fade = number("shadowFalloff", -1);
  if (fade > 0 && std::isinf(s.farthest))
    diagnostics.warning("LIGHT-SHADOW", light.pos, nameOf(light) + " has a shadowFalloff without a shadowDistance",
                        "its shadows do not fade", "shadows fade before shadowDistance, over shadowFalloff");
  else if (fade > 0)
    s.fade = std::min(fade, s.farthest);
  s.gamma = number("shadowFalloffGamma", 1);
  if (!(s.gamma > 0)) {
    diagnostics.warning("LIGHT-SHADOW", light.pos, nameOf(light) + " has a shadowFalloffGamma that is not above 0",
                        "1 is used: shadows fade linearly");
    s.gamma = 1;
  }
  const auto set = sets.find({p.getString("shadowSubset", ""), p.getString("shadowExcludeSubset", "")});
  if (set == sets.end()) return;
  s.opaque = set->second.opaqueShadow;
  s.clear = set->second.clearShadow;
}

}  // namespace kinora::render
