// Materials of renderers' earlier releases that no plug-in of their name is there for, as nodes of the stock ones:
// PxrLM* and PxrSkin. What they say of colour, roughness and refraction is kept, layers and subsurface lengths are
// not.
#pragma once
#include <optional>

#include "scene/scene.h"

namespace kinora::shade {

// The node to use instead, or nothing where none comes near. The handle and position stay.
std::optional<scene::Node> modernBxdfFor(const scene::Node& node);

// A diffuse material that takes its colour from the primitive variable Cs: what geometry without a material shows.
scene::NetworkPtr colorPrimvarNetwork(const scene::Attributes* attributes);

}  // namespace kinora::shade
