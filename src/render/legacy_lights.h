// The lights of a scene as they are rendered: those of prototypes for each instance, the area lights of old RIS files
// as their modern kind, lights of the shading-language age by what their name tells, and for light plug-ins that are
// not there the nearest one that is. Each substitution is reported.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::render {

// `shapes` gets the ids of primitives that are the shape of such a light: the light takes their place.
std::vector<scene::Light> lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics,
                                         std::set<uint32_t>& shapes);

// Whether one of those is an ambient light: it lights what the camera and mirrors see, and no more. Surface shaders get
// it by themselves.
bool isAmbient(const scene::Light& light);

// Whether all lights are of the shading-language age, and objects list those that shine on them.
bool areLightsClassic(const scene::Scene& scene);

// Whether something stands in for a LightSource or AreaLightSource.
bool hasStandIn(const scene::Light& light);

// The names of those that are not rendered, each once, in quotes with commas between; empty: all are.
std::string lightsLeftOut(const scene::Scene& scene, Registry& registry);

// The Surface shader of an object without a Bxdf; null: none.
const scene::Node* surfaceOf(const scene::Attributes* attributes);

}  // namespace kinora::render
