// Bumps whose heights another node gives. A pattern has no slopes of what is connected to it, but an image has: where
// PxrBump's inputBump is connected to a PxrTexture, the bump reads that file itself. Anything else is told, and leaves
// normals as they are. Called when a material is added; knows nothing of shading.
#pragma once
#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::shade {

// The network to use instead; null where it is the same.
scene::NetworkPtr withBumpsOfTextures(const scene::Network& network, Diagnostics& diagnostics);

}  // namespace kinora::shade
