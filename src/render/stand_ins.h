// The lights of a scene as they are rendered: those of prototypes for each instance, the area lights of old RIS files as
// their modern kind, and for light plug-ins that are not there the nearest one that is. Each substitution is reported.
#pragma once
#include <vector>

#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::render {

std::vector<scene::Light> lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics);

}  // namespace kinora::render
