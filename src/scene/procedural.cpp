#include "scene/procedural.h"

#include <cmath>

namespace kinora::scene {

std::optional<Imath::Box3d> boundOf(const Primitive& procedural) {
  constexpr float kMost = 1e15f;  // what is larger is said to have no bound
  const auto* other = std::get_if<OtherPrimitive>(&procedural.shape);
  const Parameter* bound = other ? other->args.find("bound") : nullptr;
  if (!bound || bound->floats.size() != 6) return {};
  Imath::Box3d box;
  for (size_t k = 0; k < 3; ++k) {
    const float low = bound->floats[2 * k], high = bound->floats[2 * k + 1];
    if (!(std::fabs(low) < kMost && std::fabs(high) < kMost && low <= high)) return {};
    box.min[int(k)] = double(low);
    box.max[int(k)] = double(high);
  }
  return box;
}

Imath::Box3d sweptBox(const Imath::Box3d& box, const Transform& toWorld) {
  Imath::Box3d out;
  for (const Matrix& m : toWorld.matrices)
    for (int c = 0; c < 8; ++c)
      out.extendBy(
          Imath::V3d(c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y, c & 4 ? box.max.z : box.min.z) *
          m);
  return out;
}

}  // namespace kinora::scene
