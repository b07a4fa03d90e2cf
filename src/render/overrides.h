// What the command line sets on top of a scene: --res, --crop, --integrator and --set KIND.NAME=VALUE. Called by Renderer before
// anything is built. A name that means nothing, and a value of another type than
// is declared, is an error (CLI-SET): a typo must not cost a night.
#pragma once
#include "base/diagnostics.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "scene/scene.h"

namespace kinora::render {

void applyOverrides(scene::Scene& scene, const Settings& settings, Registry& registry, Diagnostics& diagnostics);

// The integrator a scene without a word about it gets: one with a headlight where no light and no material gives off light.
const char* defaultIntegrator(const scene::Scene& scene);

}  // namespace kinora::render
