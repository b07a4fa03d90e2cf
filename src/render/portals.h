// Portals (PxrPortalLight): rectangles through which a dome is seen. The dome of each is found among the scene's
// lights, its values go to portals that say none, and domes that have portals shine through them alone.
#pragma once
#include <vector>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

// `lights` are all lights of the scene as they will be rendered. A portal's dome is the PxrDomeLight whose map the
// portal names, else, for a portal that names none, the first dome. One without a dome that says nothing of what it shows is
// told: it is even and of its own colour.
void openPortals(std::vector<scene::Light>& lights, Diagnostics& diagnostics);

}  // namespace kinora::render
