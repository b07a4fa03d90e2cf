// What one thread needs to dice a patch of a LevelledSurface.
#pragma once
#include "render/levels.h"

namespace kinora::render {

struct LevelledSurface::Workspace {
  explicit Workspace(const shade::ShadingWorld& world) : group(world) {}
  shade::GroupState group;
  uint32_t key = 0;  // at which the points below are
  // Points of the surface: where they lie undisplaced, and go to; what a shader says of their normal (0: nothing).
  std::vector<Imath::V3d> base, moved, given;
  std::vector<uint32_t> firstRequest;  // by point; one more at the end
  // What is shaded for them: places, where these lie undisplaced.
  std::vector<geometry::Patches::Place> request;
  std::vector<float> radius;
  std::vector<Imath::V3d> from, normal, offset, turned;
  Corners corners{~0u, 0, 0, {}, {}};  // of the patch that was asked last
  // The points around a grid: beyond its edges, by edge and step; of corners, two for each patch around.
  std::array<uint32_t, 4> beyond{};
  std::array<bool, 4> hasBeyond{};
  std::array<uint32_t, 4> atCorner{}, cornerPairs{};
  std::vector<Imath::V3d> offsets, normalsOfPoint;  // scratch
  // Of one patch, over all keys: its grid, key after key.
  std::vector<Imath::V3f> points, normals;
  double longest = 0;
  uint32_t notFinite = 0, beyondBound = 0;
  void begin() {
    points.clear();
    normals.clear();
    longest = 0;
  }
};

}  // namespace kinora::render
