// Boxes of a description that transforms move.
#pragma once
#include <ImathBox.h>

#include "scene/scene.h"

namespace kinora::scene {

// The box around a box that a transform moves over all its keys. Between keys a transform is linear.
Imath::Box3d sweptBox(const Imath::Box3d& box, const Transform& toWorld);

}  // namespace kinora::scene
