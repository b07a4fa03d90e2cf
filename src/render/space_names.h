// Coordinate systems that patterns, materials and displacements ask for by name and that nothing in the scene names: a
// slip there would leave a projection where the world's origin is. Called by WorldBuilder once a world is described;
// what shaders ask for while they run is told by shade::ShaderScene.
#pragma once
#include "base/diagnostics.h"
#include "render/flat_scene.h"
#include "shade/group.h"

namespace kinora::render {

void warnOfUnknownSpaces(const FlatScene& flat, const shade::ShadingWorld& w, Diagnostics& diagnostics);

}  // namespace kinora::render
