// Curves and points for Embree: its geometry for a mesh of strands. Called by world.cpp while it builds a part.
#pragma once
#include <embree3/rtcore.h>
#include <kinora/sample_table.h>

#include "geometry/mesh.h"
#include "scene/scene.h"

namespace kinora::trace {

// Addresses of random numbers by slot. Without them what is drawn follows from the ray's own numbers.
struct Draws {
  const SampleTable* table = nullptr;
  const uint32_t* seed = nullptr;
  const uint32_t* sample = nullptr;
};

// Shares the mesh's buffers, which must outlive it. Not committed.
RTCGeometry makeStrands(RTCDevice device, geometry::Mesh& mesh);
// Strands keep round widths only under transforms that turn, mirror, move and scale evenly: others are placed, not
// baked.
bool keepsWidths(const scene::Matrix& m);
// Moves a strand's control points, widths and normals.
void bakeStrands(geometry::Mesh& mesh, const scene::Matrix& local);

}  // namespace kinora::trace
