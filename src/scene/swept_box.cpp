#include "scene/swept_box.h"

namespace kinora::scene {

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
