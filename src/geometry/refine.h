// Cuts the faces of a mesh that has been made already, so that its edges are about as long as a DiceRate asks: polygons
// on their way to displacement. The surface stays where it is. Called by render/ after tessellate(); it knows no
// primitive and displaces nothing.
#pragma once
#include "geometry/mesh.h"
#include "geometry/tessellate.h"

namespace kinora::geometry {

// The same surface in smaller pieces. Faces that share an edge have the same points on it, to the bit; vertices have
// normals of their own ("N", those of the faces where there were none), and every primvar that varies is by vertex,
// which are apart where values are. Face numbers and patch parameters stay those of the faces that were cut. At most
// rate.maxTriangles come out, but for what there was before. `mesh` is no strand.
Mesh refined(const Mesh& mesh, const DiceRate& rate);

}  // namespace kinora::geometry
