// The geometry of a light (PxrMeshLight's, or an old area light's) as triangles for its plug-in. Called by
// WorldBuilder.
#pragma once
#include <kinora/light_mesh.h>

#include <cstdint>
#include <vector>

#include "base/diagnostics.h"
#include "geometry/mesh.h"
#include "render/camera.h"
#include "scene/scene.h"

namespace kinora::render {

inline constexpr uint32_t kMostTrianglesOfLight = 200'000;  // a light looks through all of them when it is made

struct EmittingMesh {
  std::vector<float> points;  // render space; of one key after the other
  std::vector<uint32_t> triangles;
  uint32_t keyCount = 1;
  LightMesh mesh() const {
    return {uint32_t(points.size() / 3) / keyCount, uint32_t(triangles.size() / 3), points.data(), triangles.data(),
            keyCount};
  }
};

// The geometry of a light that has one, over the camera's shutter; empty where it gives no surface. What lights lack (the
// cuts of solids) is told. displaced: its surface where that is known (LightSurfaces); null: a displacement is told, too.
EmittingMesh emittingMesh(const scene::Light& light, const geometry::Mesh* displaced, const CameraState& camera,
                          Diagnostics& diagnostics);

}  // namespace kinora::render
