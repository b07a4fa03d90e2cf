// What getattribute() of shaders knows of the camera, by OSL's names ("camera:fov" and its kin).
#pragma once
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

// Of the scene's first camera as it is rendered: angles in degrees, clip distances in scene units, times as the scene
// gives them, the window as OSL has it {left, bottom, right, top}.
scene::ParameterList cameraAttributes(const scene::Scene& scene, const CameraState& state);

}  // namespace kinora::render
