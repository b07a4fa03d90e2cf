// Bumps whose heights another node gives. A pattern has no slopes of what is connected to it, but an image has, and
// shaders hand on derivatives: where PxrBump's inputBump is connected to a PxrTexture, the bump reads that file itself;
// where it is connected to a shader, it becomes one (standard_shaders). Anything else is told, and leaves normals as
// they are. Called when a material is added; knows nothing of shading.
#pragma once
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::shade {

// The network to use instead; null where it is the same.
scene::NetworkPtr withConnectedBumps(const scene::Network& network, Registry& registry, Diagnostics& diagnostics);

// What a bump that becomes a shader carries for standardShader(). Names that begin so are no parameters.
inline constexpr const char* kBumpOfShader = "__bumpOfShader";

}  // namespace kinora::shade
