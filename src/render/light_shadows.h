// What the parameters of lights say of their shadows: which objects cast them (named groups, which become masks of the
// world), how far, and what they leave. Called by WorldBuilder before the world is made, and by world_lights.cpp.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "light/light_set.h"
#include "scene/scene.h"
#include "shade/group.h"

namespace kinora::render {

// The groups of objects that cast a light's shadows (shadowSubset, shadowExcludeSubset), as its node says them.
struct ShadowSubset {
  std::string subset, exclude, who;
  SourcePos pos;
};
// By both texts: what shadow rays to the light ask for.
using ShadowSets = std::map<std::pair<std::string, std::string>, shade::TraceSet>;

// Of the lights that name some.
std::vector<ShadowSubset> shadowSubsets(const std::vector<scene::Light>& lights);
// Sets what an entry says of shadows (castsShadow, shadows, glassBlocks). Values that mean nothing are told of.
void setShadows(const scene::Node& light, const ShadowSets& sets, Diagnostics& diagnostics, light::LightEntry& entry);

}  // namespace kinora::render
