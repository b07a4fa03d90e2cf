// Which primitives of an object (ObjectBegin) are one part of the world, placed once by each instance. Their own
// transforms are baked into their meshes, whose space is the object's then. Used while a scene is flattened; it
// tessellates nothing.
#pragma once
#include <ImathBox.h>

#include <optional>
#include <vector>

#include "scene/scene.h"

namespace kinora::render {

// Of a primitive that may share a part with others of its object: where about it lies in the object's space. Nothing
// where it has to be a part of its own:
// - its transform moves, is flat or nearly so, or is no affine one;
// - its attributes displace it, as the levels of such a surface are chosen in its own space, or fill it with a medium;
// - it is a strand (Curves, Points) whose widths the transform would not keep;
// - it is none of the primitives whose place follows from their arguments or "P" (blobbies, volumes).
// Surfaces of solids and levels of detail are for the caller to keep out.
std::optional<Imath::Box3d> boundsInPart(const scene::Primitive& primitive, const scene::Attributes* given);

// Whether meshes that lie in these bounds keep their precision in one space: together they do not lie much farther from
// its origin than they are large.
bool mayShareOrigin(const Imath::Box3d& bounds);

}  // namespace kinora::render
