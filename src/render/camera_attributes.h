// What others learn of the camera: getattribute() of shaders, by OSL's names ("camera:fov" and its kin), and
// pictures.
#pragma once
#include "film/display_output.h"
#include "render/world_build.h"
#include "scene/scene.h"

namespace kinora::render {

// Of the scene's first camera as it is rendered: angles in degrees, clip distances in scene units, times as the scene
// gives them, the window as OSL has it {left, bottom, right, top}.
scene::ParameterList cameraAttributes(const scene::Scene& scene, const CameraState& state);

// The matrices and the screen window of a picture's metadata, at the middle of the shutter.
void describeCamera(const CameraState& camera, film::FrameMetadata& out);

}  // namespace kinora::render
