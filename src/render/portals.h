// Portals (PxrPortalLight): rectangles through which a dome is seen. The dome of each is found among the scene's
// lights, its values go to portals that say none, and domes that have portals shine through them alone.
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

// The domes that portals show, by the node of the portal, which is that portal's alone. What is said of a dome beside its
// values holds for what comes through its portals: its light filters, that it is mute, which objects it lights.
using ShownDomes = std::map<const scene::Node*, std::shared_ptr<const scene::Light>>;

// Null: the light is no portal, or one that shows no dome of the scene.
inline const scene::Light* domeShownBy(const scene::Light& light, const ShownDomes& domes) {
  const auto it = domes.find(light.node.get());
  return it == domes.end() ? nullptr : it->second.get();
}

// `lights` are all lights of the scene as they will be rendered. A portal's dome is the PxrDomeLight whose map the
// portal names, else, for a portal that names none, the first dome. One without a dome that says nothing of what it shows is
// told: it is even and of its own colour.
ShownDomes openPortals(const scene::Scene& scene, std::vector<scene::Light>& lights, Diagnostics& diagnostics);

}  // namespace kinora::render
