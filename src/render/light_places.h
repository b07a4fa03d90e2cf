// Where lights and light filters stand, and how they move while the shutter is open. Called for the lights of a world
// and for their filters.
#pragma once
#include <kinora/plugin.h>

#include <memory>

#include "base/diagnostics.h"
#include "light/light_motion.h"
#include "render/camera.h"
#include "scene/scene.h"

namespace kinora::render {

// In the middle of the shutter, in render space; the world's own space where the transform is not finite.
Placement placementOf(const scene::Transform& toWorld, const CameraState& camera);

struct LightMoves {
  std::shared_ptr<const light::LightMotion> motion;  // null: none is followed
  bool isWhole = true;  // false: it also changes its size or its shape, or has none to turn by, which is not followed
};
// Turns and shifts over the shutter, of the transform's rigid part (polar decomposition of what carries it from the
// middle of the shutter to each time).
LightMoves movesOf(const scene::Transform& toWorld, const CameraState& camera);

// Tells of a light whose size or shape is not followed.
void warnOfShape(const scene::Light& light, const LightMoves& moves, Diagnostics& diagnostics);

}  // namespace kinora::render
