#include "geometry/points_in_space.h"

#include <bit>

namespace kinora::geometry {

namespace {

// -0 is 0.
uint64_t mixed(uint64_t h, float x) {
  h = (h ^ std::bit_cast<uint32_t>(x + 0.f)) * 0x9e3779b97f4a7c15ull;
  return h ^ h >> 29;
}

}  // namespace

PointsInSpace::PointsInSpace(const Mesh& mesh) : ofVertex(mesh.vertexCount) {
  const size_t n = mesh.vertexCount, keys = size_t(mesh.keyCount());
  constexpr uint32_t kFree = ~0u;
  std::vector<uint32_t> slots(std::bit_ceil(2 * n + 1), kFree);  // the first vertex of each place
  const auto isSame = [&](size_t a, size_t b) {
    for (size_t k = 0; k < keys; ++k)
      if (mesh.points[k * n + a] != mesh.points[k * n + b]) return false;
    return true;
  };
  for (size_t v = 0; v < n; ++v) {
    const Imath::V3f& p = mesh.points[v];
    size_t at = mixed(mixed(mixed(0, p.x), p.y), p.z) & (slots.size() - 1);
    while (slots[at] != kFree && !isSame(slots[at], v)) at = (at + 1) & (slots.size() - 1);
    if (slots[at] == kFree) {
      slots[at] = uint32_t(v);
      ofVertex[v] = count++;
    } else {
      ofVertex[v] = ofVertex[slots[at]];
    }
  }
}

}  // namespace kinora::geometry
