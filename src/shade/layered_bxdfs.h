// Materials that are trees of other bxdfs: LamaLayer, LamaMix and LamaAdd over their leaves, with or without
// LamaSurface as the root. The tree becomes one node of the plug-in LamaSurface (of LamaHairSurface, where hair is among
// the leaves) whose parameters hold all leaves, so that a material is still one program over patterns. Called when a
// material is added; knows nothing of shading.
#pragma once
#include "plugin/registry.h"
#include "scene/scene.h"

namespace kinora::shade {

// The network to use instead; null where the terminal is no tree.
scene::NetworkPtr withFlatLayers(const scene::Network& network, Registry& registry, Diagnostics& diagnostics);

}  // namespace kinora::shade
