// Cuts faces over which a DiceRate differs too much for one grid: a ground that reaches from the eye to the horizon, or
// a wall of which a camera without perspective sees a corner. Called by render/ before refined() and Patches.
#pragma once
#include <optional>

#include "geometry/mesh.h"
#include "geometry/tessellate.h"

namespace kinora::geometry {

// The same surface, its faces cut in four as often as their rates ask, neighbours at most once less: where one is cut
// more, the other is cut into triangles about its middle, and no gap opens. Primvars come by vertex, as from refined().
// Nothing where no face needs it, where rate.slope is not known, for meshes of several keys and for strands.
std::optional<Mesh> graded(const Mesh& mesh, const DiceRate& rate);

}  // namespace kinora::geometry
