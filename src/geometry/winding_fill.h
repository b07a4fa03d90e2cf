// Fills outlines that cross themselves, which have no triangulation of their own corners: what the outer loop goes
// round, in whatever direction and however often (the non-zero rule), without what holes go round. The new points lie
// on edges, where they cross and at the heights of other corners. Used by polygons where the Triangulator gives up: it
// cuts between all heights, so that its triangles are more and thinner.
#pragma once
#include <ImathVec.h>
#include <cstdint>
#include <span>
#include <vector>

namespace kinora::geometry {

// On the edge between two corners: from + share * (to - from). A corner itself has both alike.
struct EdgePoint {
  uint32_t from = 0, to = 0;
  double share = 0;
};

struct WindingFill {
  std::vector<EdgePoint> points;
  std::vector<uint32_t> triangles;  // 3 places in `points` each; all face as the outer loop does in the mean
};

// `corners` holds all loops one after the other, the outer one first. False, with nothing in `out`, where nothing has
// area, and for outlines of so many corners and crossings that it would take too long.
bool fillByWinding(std::span<const Imath::V3d> corners, std::span<const int> loopSizes, WindingFill& out);

}  // namespace kinora::geometry
