// The makers of meshes, one for each family of primitives. Called by tessellate() alone, with flipNormals and
// doubleSided of the mesh already set; false (after a message) when nothing can be made.
#pragma once
#include "geometry/tessellate.h"

namespace kinora::geometry {

bool makeQuadric(const scene::Primitive&, const scene::Quadric&, const DiceRate&, Diagnostics&, Mesh&);
bool makePolygons(const scene::Primitive&, const scene::PolygonMesh&, Diagnostics&, Mesh&);
bool makeSubdivision(const scene::Primitive&, const scene::SubdivisionMesh&, const DiceRate&, Diagnostics&, Mesh&);
bool makePatches(const scene::Primitive&, const DiceRate&, Diagnostics&, Mesh&);  // Patch, PatchMesh, NuPatch
bool makeTeapot(const scene::Primitive&, const DiceRate&, Diagnostics&, Mesh&);
// The shape that a Geometry request names, made by the others.
bool makeNamedShape(const scene::Primitive&, const scene::OtherPrimitive&, const DiceRate&, Diagnostics&, Mesh&);

// The boundary of a Volume request.
bool makeVolume(const scene::Primitive&, const scene::OtherPrimitive&, Diagnostics&, Mesh&);

bool makeBlobby(const scene::Primitive&, const scene::OtherPrimitive&, const DiceRate&, Diagnostics&, Mesh&);

// Strands: tubes, ribbons, balls and discs, which are not tessellated.
bool makeCurves(const scene::Primitive&, const scene::Curves&, const DiceRate&, Diagnostics&, Mesh&);
bool makePoints(const scene::Primitive&, Diagnostics&, Mesh&);

}  // namespace kinora::geometry
