// Which primitives of an object (ObjectBegin) are one part of the world, placed once by each instance. Their own
// transforms are baked into their meshes, whose space is the object's then. Used while a scene is flattened; it
// tessellates nothing.
#pragma once
#include "scene/scene.h"

namespace kinora::render {

// Whether a primitive may share a part with others of its object. It has to be one of its own where
// - its transform moves, is flat or nearly so, or is no affine one;
// - it is a strand (Curves, Points) whose widths the transform would not keep;
// - it lies so far from the object's origin that floats are coarse for its size (Mesh::origin is for those);
// - it is none of the primitives whose place follows from their arguments or "P" (blobbies, volumes).
// Displaced ones may: they are diced and moved in their own space, and baked then (trace/transformed_geometry.h where rays
// have them diced). Surfaces of solids, levels of detail and what is full of a medium are for the caller to keep out.
bool maySharePart(const scene::Primitive& primitive);

}  // namespace kinora::render
