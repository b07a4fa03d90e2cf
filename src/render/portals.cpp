#include "render/portals.h"

#include <set>

#include "base/text.h"

namespace kinora::render {

namespace {

bool isOf(const scene::Light& l, const char* plugin) { return l.node && sameName(l.node->plugin, plugin); }

const scene::Light* domeOf(const scene::Light& portal, const std::vector<scene::Light>& lights) {
  const std::string map = portal.node->params.getString("domeColorMap", "");
  for (const scene::Light& l : lights) {
    if (!isOf(l, "PxrDomeLight")) continue;
    if (map.empty() || l.node->params.getString("lightColorMap", "") == map) return &l;
  }
  return nullptr;
}

// The portal's own values stand before those of the dome, but for what the dome's are multiplied by.
scene::NodePtr shownBy(const scene::Light& portal, const scene::Light& dome) {
  auto node = std::make_shared<scene::Node>(*portal.node);
  const auto take = [&](const char* from, const char* to) {
    const scene::Parameter* p = dome.node->params.find(from);
    if (!p || node->params.find(to)) return;
    scene::Parameter q = *p;
    q.name = to;
    node->params.set(q);
  };
  take("lightColorMap", "domeColorMap");
  for (const char* same : {"intensity",
                           "exposure",
                           "lightColor",
                           "enableTemperature",
                           "temperature",
                           "specular",
                           "diffuse",
                           "colorMapGamma",
                           "colorMapSaturation",
                           "lightGroup",
                           "enableShadows",
                           "shadowColor",
                           "shadowDistance",
                           "shadowFalloff",
                           "shadowFalloffGamma",
                           "shadowSubset",
                           "shadowExcludeSubset",
                           "traceLightPaths",
                           "thinShadow",
                           "visibleInRefractionPath"})
    take(same, same);
  if (!node->params.find("portalToDome")) {
    const scene::Matrix m = portal.toWorld.at(0) * dome.toWorld.at(0).inverse();
    scene::Parameter p;
    p.name = "portalToDome";
    p.type = scene::ValueType::Matrix;
    for (int i = 0; i < 16; ++i) p.floats.push_back(float(m[i / 4][i % 4]));
    node->params.set(p);
  }
  return node;
}

}  // namespace

void openPortals(std::vector<scene::Light>& lights, Diagnostics& diagnostics) {
  std::set<const scene::Light*> closed;
  for (scene::Light& l : lights) {
    if (!isOf(l, "PxrPortalLight")) continue;
    if (const scene::Light* dome = domeOf(l, lights)) {
      closed.insert(dome);
      l.node = shownBy(l, *dome);
    } else if (l.node->params.getString("domeColorMap", "").empty()) {
      diagnostics.warning("LIGHT-PORTAL", l.node->pos, "portal '" + l.node->handle + "' has no dome to show",
                          "it is even and of its own colour", "add a PxrDomeLight, or name a map as domeColorMap");
    }
  }
  size_t kept = 0;
  for (size_t i = 0; i < lights.size(); ++i)
    if (!closed.contains(&lights[i])) {
      if (kept != i) lights[kept] = std::move(lights[i]);
      ++kept;
    }
  lights.resize(kept);
}

}  // namespace kinora::render
