// Parameters of the Camera request: those about the aperture are handed to the projection, and names that nothing
// knows are told. Called by the world builder. The shutter's are shutter.h's; the reader took the clipping distances.
#pragma once
#include <kinora/projection.h>

#include "base/diagnostics.h"
#include "scene/scene.h"

namespace kinora::render {

void warnOfCameraParameters(const scene::Camera& camera, Diagnostics& diagnostics);

// The camera's own parameters, else those of the Hider, which had them before.
void setAperture(const scene::Camera& camera, const scene::NodePtr& hider, ProjectionInfo& info);

}  // namespace kinora::render
