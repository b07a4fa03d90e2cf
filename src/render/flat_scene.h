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
#include "render/shared_shapes.h"
#include "scene/scene.h"
#include "shade/group.h"
#include "trace/world.h"

namespace kinora::render {

// What of its attributes a mesh is made by.
Digest lookOf(const scene::Attributes* attributes);

// Where things are placed: the origin of render space in the world, and what sees them there.
struct RenderSpace {
  std::array<double, 3> origin{0, 0, 0};
  View view;
  bool operator==(const RenderSpace&) const = default;
};

struct FlatScene {
  // A primitive with attributes of one look, or what stands for many of them.
  struct Shape {
    scene::PrimitivePtr primitive;
    scene::AttributesPtr attributes;  // of its first placement
    Digest look;
    double radiusPixels = 0;  // of one of size 1 that stands for others: how large they are seen
    std::shared_ptr<const std::vector<scene::PrimitivePtr>> more = nullptr;  // one mesh with `primitive`; null: none
    bool boundsMedia = false;  // some placement of it is full of a medium, or what media inside are cut off by
    bool isBaked = false;      // its own transform is baked into its mesh, see prototype_parts.h
  };
  // A shape of a part, in placements with the same attributes. Those of a part of many shapes follow each other.
  struct Kind {
    uint32_t part = 0;
    uint32_t shape = 0;
    uint32_t visibility = 15;  // what attributes say of the object itself
  };
  struct Placement {
    uint32_t kind = 0;         // of the part's first shape
    uint32_t opened = kWorld;  // instance; its primitive is one of the scene or of that instance's object
    uint32_t primitive = 0;    // kMany: the part is of several
  };
  static constexpr uint32_t kWorld = ~0u, kMany = ~0u;
  std::vector<Shape> shapes;
  std::vector<trace::PartInput> parts;  // of one shape each, or of what instances of an object place together
  std::vector<Placement> placements;    // first those of the scene's own primitives
  // By kind.
  std::vector<Kind> kinds;
  std::vector<shade::PlacementInfo> infos;  // without materials, link sets, trace sets and tints
  std::vector<const scene::Attributes*> attributes;
  std::shared_ptr<const std::vector<shade::ObjectSpace>> spaces;  // see shade::ShadingWorld
  std::vector<trace::SolidInput> solids;                          // that placements are members of
  std::vector<SourcePos> solidPlaces;

  uint32_t partOf(uint32_t placement) const { return kinds[placements[placement].kind].part; }
  trace::Solids::Member memberOf(uint32_t placement) const {
    return members_.empty() ? trace::Solids::Member() : members_[placement];
  }
  const Shape& shapeOf(const Kind& k) const { return shapes[k.shape]; }
  // The instance of the scene that a placement stands in; kWorld: none.
  uint32_t outermostOf(uint32_t placement) const {
    uint32_t opened = placements[placement].opened;
    while (opened != kWorld && !isInWorld(opened)) opened = nested(opened).around;
    return opened;
  }
  // From the space of the part. Worked out each time: of millions they would be most of the memory.
  scene::Transform toRender(uint32_t placement) const;
  // The same of one that does not move, quickly; false: it does.
  bool stillToRender(uint32_t placement, scene::Matrix& m) const;
  std::string nameOf(uint32_t placement) const;
  // Whether flatten() would make the same again.
  bool isOf(const scene::Scene& scene, const RenderSpace& space, const std::set<uint32_t>& leaveOut) const;

 private:
  friend class Flattener;
  const scene::Primitive& primitiveOf(const Placement& p) const;

  // An instance inside an object, opened. Where it stands follows from those that it stands in, which come before it.
  // Opened ones have numbers: first those of the scene by their places in its list, then these.
  struct Opened {
    uint32_t around;     // number of what is around it
    uint32_t place;      // in the list of instances of that one's object
    uint32_t prototype;  // it is of
  };
  std::vector<Opened> opened_;
  uint64_t serial_ = nextSerial();
  static uint64_t nextSerial();
  bool isInWorld(uint32_t opened) const { return opened < instances_.size(); }
  const Opened& nested(uint32_t opened) const { return opened_[opened - instances_.size()]; }
  uint32_t prototypeOf(uint32_t opened) const {
    return isInWorld(opened) ? instances_.prototypeOf(opened) : nested(opened).prototype;
  }
  const scene::InstanceList& listAround(const Opened& o) const {
    return prototypes_[prototypeOf(o.around)].instances;
  }
  scene::Transform toWorld(uint32_t opened) const;             // kWorld: the identity
  bool stillToWorld(uint32_t opened, scene::Matrix& m) const;  // false: it moves
  std::vector<trace::Solids::Member> members_;                 // by placement; empty: there are no solids
  scene::Transform worldToRender_;
  // what it was made of
  std::vector<scene::PrimitivePtr> primitives_;
  scene::InstanceList instances_;
  std::vector<scene::Prototype> prototypes_;
  std::vector<scene::Solid> solids_;
  RenderSpace space_;
  bool asksView_ = false;
  std::set<uint32_t> leaveOut_;
  // attributes inside objects as an instance gives them, for those who point to them
  std::map<std::pair<const scene::Attributes*, const scene::Attributes*>, std::pair<scene::AttributesPtr, Digest>>
      inherited_;
};

// `leaveOut`: ids of primitives in the world that are none. `boundsMedia`: whether the meshes of objects of such attributes
// are boundaries of media. `stop`: another thread may end it early.
std::shared_ptr<const FlatScene> flatten(const scene::Scene& scene, const RenderSpace& space,
                                         const std::set<uint32_t>& leaveOut,
                                         const std::function<bool(const scene::Attributes*)>& boundsMedia,
                                         const std::atomic<bool>* stop, Diagnostics& diagnostics);

}  // namespace kinora::render
