// Meshes of many small primitives as one: what a mesh costs beside its triangles is then paid once. Called by render/
// for primitives in one space that nothing but their points tells apart.
#pragma once
#include <vector>

#include "geometry/mesh.h"

namespace kinora::geometry {

// Of at least one mesh, all of triangles at one key, with faces numbered one after another. The meshes are of one kind
// of primitive with the same primvars declared; where one has another rate all the same, corners hold values.
Mesh joined(const std::vector<Mesh>& meshes);

}  // namespace kinora::geometry
