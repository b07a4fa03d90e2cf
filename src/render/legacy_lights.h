// The lights of a scene as they are rendered: those of prototypes for each instance, the area lights of old RIS files
// as their modern kind, lights of the shading-language age by what their name tells, and for light plug-ins that are
// not there the nearest one that is. Each substitution is reported.
#pragma once
#include <set>
#include <vector>

#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::render {

// `shapes` gets the ids of primitives that are the shape of such a light: the light takes their place.
std::vector<scene::Light> lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics,
                                         std::set<uint32_t>& shapes);

}  // namespace kinora::render
