// A scene as one list of placed objects: instances opened, nested ones too, attributes inside objects as each
// instance gives them. Made by WorldBuilder for each world; kept, with all that it points into, as long as
// primitives, objects, instances and the render space stay what they are. It tessellates nothing and knows no
// material.
#pragma once
#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/digest.h"
#include "scene/scene.h"
#include "shade/group.h"
#include "trace/world.h"

namespace kinora::render {

// What of its attributes a mesh is made by.
Digest lookOf(const scene::Attributes* attributes);

// Where things are placed: the origin of render space in the world, and the middle of the shutter.
struct RenderSpace {
  std::array<double, 3> origin{0, 0, 0};
  double middle = 0;
  bool operator==(const RenderSpace&) const = default;
};

struct FlatScene {
  // A primitive with attributes of one look.
  struct Shape {
    scene::PrimitivePtr primitive;
    scene::AttributesPtr attributes;  // of its first placement
    Digest look;
    bool isMedium = false;  // some placement of it is full of a medium
  };
  std::vector<Shape> shapes;
  std::vector<trace::PartInput> parts;  // of one shape each
  // By placement. Visibility is what attributes say of the object itself.
  std::vector<trace::PlacementInput> placements;
  std::vector<shade::PlacementInfo> infos;  // without materials, link sets, trace sets and tints
  std::vector<const scene::Attributes*> attributes;
  std::vector<trace::SolidInput> solids;  // that placements are members of
  std::vector<SourcePos> solidPlaces;

  const Shape& shapeOf(const trace::PlacementInput& p) const { return shapes[parts[p.part].shapes[0]]; }
  // Whether flatten() would make the same again.
  bool isOf(const scene::Scene& scene, const RenderSpace& space, const std::set<uint32_t>& leaveOut) const;

 private:
  friend class Flattener;
  // what it was made of
  std::vector<scene::PrimitivePtr> primitives_;
  std::vector<scene::Instance> instances_;
  std::vector<scene::Prototype> prototypes_;
  std::vector<scene::Solid> solids_;
  RenderSpace space_;
  std::set<uint32_t> leaveOut_;
  // attributes inside objects as an instance gives them, for those who point to them
  std::map<std::pair<const scene::Attributes*, const scene::Attributes*>, std::pair<scene::AttributesPtr, Digest>>
      inherited_;
};

// `leaveOut`: ids of primitives in the world that are none. `isMedium`: whether objects of such attributes are full of a
// medium. `stop`: another thread may end it early.
std::shared_ptr<const FlatScene> flatten(const scene::Scene& scene, const RenderSpace& space,
                                         const std::set<uint32_t>& leaveOut,
                                         const std::function<bool(const scene::Attributes*)>& isMedium,
                                         const std::atomic<bool>* stop, Diagnostics& diagnostics);

}  // namespace kinora::render
