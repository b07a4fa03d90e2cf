// Lights of the shading-language age (LightSource, AreaLightSource) as lights of stock plug-ins: the standard ones of
// RISpec 3.2, appendix A.2, all others by words in their names and by the parameters that many of them share
// (intensity, lightcolor, from, to, coneangle, falloff ...). Called by legacy_lights.cpp. It runs no shader and reads
// no shadow map: shadows are traced where a light had any.
#pragma once
#include <string>

#include "scene/scene.h"

namespace kinora::render {

// False, and `why` says why, where nothing stands in for it. isPathTraced: the scene names an integrator, so that all
// its lights cast shadows. Else a light does by Attribute "light" "shadows", or where its name or a parameter tells of
// shadows, and shapes and domes do. The standard lights had none: whoever wanted shadows made maps of them.
bool classicLight(const scene::Light& light, bool isPathTraced, scene::Light& out, std::string& why);

}  // namespace kinora::render
