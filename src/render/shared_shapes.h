// Which of a scene's small primitives share what is made of them. Particles in old files are spheres by the hundred
// thousand: those of one kind, look and size on screen are one tessellation of size 1, placed many times. Patches by
// the hundred thousand are one mesh for some hundreds that nothing but their points tells apart. Used while a scene is
// flattened; it tessellates nothing.
#pragma once
#include <ImathVec.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "base/digest.h"
#include "scene/scene.h"

namespace kinora::render {

// How the camera sees sizes.
struct View {
  Imath::V3d eye{0, 0, 0};
  double pixelAngle = 0, pixelSize = 0, middle = 0;
  scene::Matrix worldToCamera;
  bool operator==(const View&) const = default;
};

// A quadric as one of size 1 that is scaled. Nothing where it is no quadric, deforms, has primvars that live in its
// space, or a size that is none.
struct UnitQuadric {
  scene::Quadric quadric;
  double size;
};
std::optional<UnitQuadric> unitQuadricOf(const scene::Primitive& primitive);

struct SharedShapes {
  // From so many alike on they share.
  static constexpr size_t kLeastUnits = 64, kLeastJoined = 256, kMostJoined = 1024;
  // Radius; seen larger than this they do not, which is as far as it was measured. What many rays share stays in caches.
  static constexpr double kMostPixels = 128;

  struct Group {
    bool isUnit = false;            // placed scaled; else joined
    double radiusPixels = 0;        // units: at most so large
    std::vector<uint32_t> members;  // places in the scene's list, in its order
  };
  std::vector<Group> groups;
  std::vector<uint32_t> groupOf;  // by primitive; kNone: it stands for itself. Empty: all do
  bool asksView = false;          // it would be another with another view
  static constexpr uint32_t kNone = ~0u;

  uint32_t of(size_t primitive) const { return groupOf.empty() ? kNone : groupOf[primitive]; }
};

// `look`: by attributes.
SharedShapes sharedShapesOf(const std::vector<scene::PrimitivePtr>& primitives, const View& view,
                            const std::set<uint32_t>& leaveOut,
                            const std::function<Digest(const scene::Attributes*)>& look);

}  // namespace kinora::render
