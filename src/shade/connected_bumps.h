// Bumps whose heights another node gives, where there is a shorter way to their slopes than differences of all that
// feeds them (moved_points): an image has slopes, and shaders hand on derivatives. Where PxrBump's inputBump is
// connected to a PxrTexture, the bump reads that file itself; where heights come of shaders alone, it becomes one
// (standard_shaders). Called when a material is added; knows nothing of shading.
#pragma once
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::shade {

// The network to use instead; null where it is the same.
scene::NetworkPtr withConnectedBumps(const scene::Network& network, Registry& registry, Diagnostics& diagnostics);

// What a bump that becomes a shader carries for standardShader(). Names that begin so are no parameters.
inline constexpr const char* kBumpOfShader = "__bumpOfShader";

}  // namespace kinora::shade
