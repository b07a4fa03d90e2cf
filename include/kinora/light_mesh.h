// The geometry that emits as a light (CreateInfo::extra of PxrMeshLight): triangles in render space. Corners that move
// while the shutter is open are known at keys; where the light moves as a whole besides, it rests where it is at the
// middle of the shutter. Made by the host from the primitive that the light's attributes hold; lives as long as create().
#pragma once
#include <cstdint>

namespace kinora {

struct LightMesh {
  uint32_t vertexCount = 0, triangleCount = 0;
  const float* P = nullptr;             // 3 a vertex, of one key after the other
  const uint32_t* triangles = nullptr;  // 3 indices each; (P1 - P0) x (P2 - P0) points to the side that emits
  uint32_t keyCount = 1;                // even over the shutter, times 0 to 1; straight on in between
};

}  // namespace kinora
