// The lights of a scene as they are rendered: those of prototypes for each instance, the area lights of old RIS files
// as their modern kind, lights of the shading-language age by what their name tells, and for light plug-ins that are
// not there the nearest one that is. Each substitution is reported.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "render/portals.h"
#include "scene/scene.h"

namespace kinora::render {

struct LightsToRender {
  std::vector<scene::Light> lights;
  std::set<uint32_t> shapes;  // ids of primitives that are the shape of one of them: the light takes their place
  ShownDomes domes;           // which are none of `lights`
};
LightsToRender lightsToRender(const scene::Scene& scene, Registry& registry, Diagnostics& diagnostics);

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
