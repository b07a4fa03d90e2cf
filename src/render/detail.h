// Which level of detail of an object is drawn: Detail's box as large as the camera sees it, against DetailRange. Asked
// while a scene is flattened.
#pragma once
#include "render/shared_shapes.h"
#include "scene/scene.h"

namespace kinora::render {

bool hasDetail(const scene::Attributes* attributes);
// False where the box, in pixels of area times `relative`, lies outside the range, counted from the middle of its
// transitions. `toWorld`: from the space that the box was said in. Objects of which the eye is inside the box, or beside
// it, have all the detail there is; without a box or a range an object is always drawn.
bool isDrawn(const scene::Attributes* attributes, const scene::Transform& toWorld, const View& view, double relative);

}  // namespace kinora::render
