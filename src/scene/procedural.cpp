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

}  // namespace kinora::scene
