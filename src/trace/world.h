// The world that rays see: BVHs over placed shapes, an immutable snapshot made from the scene and, after an edit,
// from the previous snapshot (unchanged parts are kept). Built by render/; asked by shade/ and by the tracing stages.
// Outside trace/ a hit is (instance, geometry, primitive, u, v, level); Embree ids end here.
//
// Parts: shapes that share a BVH. A prototype is a part placed many times, of one shape or of many; a moving or large
// object is a part of its own; small static objects are baked into render space and share batch parts. The top level
// holds placements of parts; a world of one unmoved part needs none.
#pragma once
#include <embree3/rtcore.h>
#include <kinora/integrator.h>

#include <array>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "geometry/mesh.h"
#include "scene/scene.h"
#include "trace/free_space.h"
#include "trace/solids.h"
#include "trace/strands.h"
#include "trace/swarm.h"
#include "trace/unread_bounds.h"
#include "trace/user_geometry.h"

namespace kinora::trace {

// x' = m x + t for column vectors, float: object space to render space at one time.
struct Affine {
  float m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  float t[3] = {0, 0, 0};
  static Affine from(const scene::Matrix& rowVectorMatrix);
  void point(const float p[3], float out[3]) const;
  Affine inverse() const;
  float determinant() const;  // of m
};

// Bits of Embree's ray and geometry masks. A ray sees a shape if they share a visibility bit; shadow rays ask for
// opaque and for other shapes apart.
enum VisibilityBits : uint32_t {
  kSeenByCamera = 1,
  kSeenByIndirect = 2,
  kSeenByOpaqueShadow = 4,
  kSeenByClearShadow = 8,
  kAskedAlone = 16,  // closestOn() finds it
  kSeenByWalks = 32  // manifold walks go through it
};

// A tessellated primitive as the builder gets it.
struct ShapeInput {
  uint64_t key = 0;       // stable over edits: primitive id
  uint64_t revision = 0;  // of its geometry and transform; equal revision: nothing to rebuild
  std::shared_ptr<geometry::Mesh>
      mesh;                  // taken over: static objects placed once are moved into render space in place
  uint32_t visibility = 15;  // VisibilityBits
  // Instead of triangles: `mesh` then holds none (null will do), or those that the geometry's facets lie on.
  std::shared_ptr<const UserGeometry> user;
};
// Shapes in one space, placed one or more times. Where they are several, of something instanced, their meshes have
// origin 0.
struct PartInput {
  uint64_t key = 0;              // prototype: index + 1 << 32; single object: its primitive id
  std::vector<uint32_t> shapes;  // indices into the list of shapes
  bool instanced = false;        // prototype: never baked
  bool isUnit = false;  // a shape of size 1 that stands for similar ones: its space is not that of the objects
  std::vector<uint32_t> visibility = {};  // VisibilityBits by place in `shapes`; empty: the shapes' own
};
struct PlacementInput {
  uint32_t part = 0;
  uint32_t visibility = 15;
  scene::Transform toRender;  // over shutter time in scene units; see BuildOptions::toRender
  uint64_t revision = 0;      // of parts that are not instanced; see BuildOptions::revisionOf
  // Handed on to Instance::info; as given: the placement's own index. That of the part's first shape: the others have
  // those that follow it.
  uint32_t info = kOwn;
  static constexpr uint32_t kOwn = ~0u;
  Solids::Member member;  // of the solid whose boundary it is a part of
};
// Placements one by one, each time that one is asked for: millions at once would be the most of a scene's memory.
class PlacementSource {
 public:
  PlacementSource(std::vector<PlacementInput> list)
      : count_(uint32_t(list.size())), at_([l = std::move(list)](uint32_t i) { return l[i]; }) {}
  PlacementSource(std::initializer_list<PlacementInput> list) : PlacementSource(std::vector<PlacementInput>(list)) {}
  // at(): from any thread.
  PlacementSource(uint32_t count, std::function<PlacementInput(uint32_t)> at) : count_(count), at_(std::move(at)) {}
  uint32_t size() const { return count_; }
  PlacementInput operator[](uint32_t i) const { return at_(i); }

 private:
  uint32_t count_;
  std::function<PlacementInput(uint32_t)> at_;
};
// A solid that is none, since one of its surfaces has a hole: its surfaces are drawn as they are.
struct OpenSolid {
  uint32_t solid;
  uint32_t placement;  // a surface of the leaf that is open
};

// A placed part or object, as shading sees it. Kernels gather its words, see World::instanceWords().
struct Instance {
  uint32_t firstKey = 0;  // of Affine keys, uniform over the shutter
  uint32_t user = 0;      // the caller's index (placement)
  uint32_t info = 0;      // the caller's as well: what it knows of many placements alike; ask World::infoOf()
  uint16_t keyCount = 1;
  bool baked = false;   // object space is render space
  bool isUnit = false;  // see PartInput
  static constexpr uint32_t kWords = 4, kInfoWord = 2, kFlagsWord = 3, kBakedBit = 1u << 16;
};
static_assert(sizeof(Instance) == 4 * Instance::kWords && offsetof(Instance, info) == 4 * Instance::kInfoWord &&
              offsetof(Instance, baked) == 4 * Instance::kFlagsWord + 2);

struct BuildOptions {
  double shutterOpen = 0, shutterClose = 0;
  uint32_t smallShape = 20000;  // triangles below which static objects share batch parts
  // No ray passes between triangles that share an edge, also where it meets the edge exactly: for rays on a regular
  // grid, which do so by rows. Costs a fifth of the time of tracing; rays that are drawn at random miss nothing.
  bool watertight = false;
  // From so many on, unmoving placements share geometries of Embree's (trace/swarm.h): a third of the memory, for
  // somewhat slower rays.
  uint32_t swarmFrom = 10000;
  // Gives the transforms of placements that hold none, and, where they do not move, quickly. From any thread.
  std::function<scene::Transform(uint32_t placement)> toRender;
  std::function<bool(uint32_t placement, scene::Matrix& toRender)> stillToRender;  // false: it may move
  std::function<uint64_t(uint32_t placement)> revisionOf;  // instead of PlacementInput::revision
  // For points alone that no ray finds (dicing): there is no hierarchy, and nothing may be traced.
  bool placesOnly = false;
  // What has not been read yet; null: nothing. Rays of all kinds meet it but those that ask for a body or a walk.
  std::shared_ptr<const UnreadBounds> unread;
  // Boxes in render space, and the placements that stand for them whether they were read or not: center() and radius()
  // must not follow from what was.
  std::vector<UnreadBounds::Box> delayed;
  std::function<bool(uint32_t placement)> isDelayed;
};

// Moves a mesh's points, and primvars that are points, vectors or normals, into another space for good; its origin is 0
// then.
void bake(geometry::Mesh& mesh, const scene::Matrix& to);

struct BuildCounters {
  uint64_t partsBuilt = 0, partsKept = 0, topLevelBuilds = 0;
};

class World {
 public:
  static std::shared_ptr<const World> build(std::vector<ShapeInput> shapes, std::vector<PartInput> parts,
                                            const PlacementSource& placements, const BuildOptions& options,
                                            const World* previous, BuildCounters& counters,
                                            const std::vector<SolidInput>& solids = {});
  ~World();

  // Closest hits of the listed slots. Camera rays come in aligned runs of 16 slots (4x4 pixels at one sample index)
  // and are traced as such, so that a packet's answer never depends on what else is in the group.
  void closestCamera(const Rays& rays, const Hits& hits, uint32_t slots,
                     const Draws& draws = {}) const;  // all slots 0..slots-1
  void closest(const Rays& rays, const Hits& hits, uint32_t mask, uint32_t n, const uint32_t* slots,
               const Draws& draws = {}) const;
  // On one body each, by slot (see bodyOf), of surfaces that are seen by kAskedAlone, as if there were nothing else.
  void closestOn(const Rays& rays, const Hits& hits, const uint32_t* bodies, uint32_t n, const uint32_t* slots) const;
  // By place p (render space): a region around it that the surface of a placed shape does not reach into; none is known
  // next to it, and of shapes that move, of curves, user geometry and solids. What is much farther than `reach` is not
  // looked for. Answers follow from the world and the place alone.
  void freeRegions(uint32_t n, const uint32_t* instances, const uint32_t* geometries, const float* const p[3],
                   const float* reach, const FreeRegions& out) const;
  // A hit before it has a place in Hits.
  struct CollectedHit {
    uint32_t slot;  // of its ray
    float t, u, v, ng[3];
    uint32_t geomId, primId, instId;  // Embree's
  };
  static constexpr uint32_t kMostCollected = 8;
  // The nearest hits of the listed slots' rays with what lets part of a shadow ray through, kMostCollected of each, ray
  // by ray in order of distance. By listed ray: beyond: 1 where there are more behind. Not for worlds with user
  // geometry.
  void collectClear(const Rays& rays, uint32_t n, const uint32_t* slots, std::vector<CollectedHit>& hits,
                    uint32_t* beyond) const;
  // n of them into slots 0 to n - 1, which have their rays already.
  void resolve(const Rays& rays, uint32_t n, const CollectedHit* hits, const Hits& out) const;
  // Opaque occlusion of packed rays; writes 1 where something of `mask` is in the way. Footprints (by ray) matter to
  // user geometry only; null: the finest level.
  void occluded(uint32_t n, const float* const o[3], const float* const d[3], const float* tMax, const float* time,
                uint32_t mask, uint32_t* blocked, const float* radius = nullptr, const float* spread = nullptr) const;

  bool hasUserGeometry() const { return hasUser_; }
  bool hasStrands() const { return hasStrands_; }         // some mesh is curves or points
  bool hasRibbons() const { return hasRibbons_; }         // of a kind that faces its rays
  bool hasClearShadows() const { return clearShadows_; }  // some shape lets part of a shadow ray through
  bool isMoving() const { return moving_; }
  const UnreadBounds* unread() const { return unread_.get(); }  // null: all has been read
  const float* center() const { return center_; }               // bounding sphere, render space
  float radius() const { return radius_; }
  uint64_t triangleCount() const { return triangles_; }
  const geometry::Mesh& mesh(uint32_t geometry) const { return *meshes_[geometry]; }
  // Geometry that shades as its mesh does, at several resolutions (UserGeometry::hasFacets); null: the mesh as it is.
  const UserGeometry* faceted(uint32_t geometry) const { return faceted_.empty() ? nullptr : faceted_[geometry]; }
  uint32_t geometryCount() const { return uint32_t(meshes_.size()); }
  uint32_t instanceCount() const { return uint32_t(instances_->size()); }
  const Instance& instance(uint32_t i) const { return instance_[i]; }
  // What the caller knows of a geometry in one of its places: the placement's `info` and those behind it.
  uint32_t infoOf(uint32_t instance, uint32_t geometry) const {
    return instance_[instance].info + infoStep_[geometry];
  }
  // For kernels: Instance::kWords an instance, and what infoOf() adds, by geometry.
  const uint32_t* instanceWords() const { return reinterpret_cast<const uint32_t*>(instance_); }
  const uint32_t* infoSteps() const { return infoStep_.data(); }
  const Affine* keys(const Instance& i) const { return key_ + i.firstKey; }
  const std::vector<OpenSolid>& openSolids() const { return openSolids_; }
  // Embree takes no ray whose numbers are beyond 1.8e18.
  static constexpr double kMostInSpace = 1e17;
  // Placements that no ray can be brought into the spaces of, which are too small, too flat or too far away: nothing of
  // them is seen.
  const std::vector<uint32_t>& lostPlacements() const { return lost_; }
  // Moves ray times away from the moments at which something that moves has no volume, by a millionth of the shutter.
  void avoidFlatMoments(float* times, uint32_t n) const {
    if (flatMoments_.empty()) return;
    for (uint32_t i = 0; i < n; ++i) times[i] = besideFlatMoments(times[i]);
  }
  // What surfaces of one solid have in common; others are themselves. (Numbers of more than 4e9 bodies begin again.)
  uint32_t bodyOf(uint32_t instance, uint32_t geometry) const {
    if (const uint32_t step = infoStep_[geometry]) return instance + step * instanceCount();
    return bodies_.empty() ? instance : bodies_[instance];
  }
  // Object to render at shutter time 0..1.
  Affine objectToRender(uint32_t instance, float time) const;
  uint64_t meshBytes() const;
  uint64_t placementBytes() const {
    return instances_->size() * (sizeof(Instance) + sizeof(Affine)) + partOfTop_.size() * 3 * sizeof(uint32_t);
  }
  static uint64_t embreeBytes();  // what Embree holds in this process

 private:
  World() = default;
  struct Part;
  bool sameTop(const World& previous) const;
  // Fills lost_ and flatMoments_.
  void findLost();
  float besideFlatMoments(float time) const;
  // A placement of the top level, as its ids say: those of swarms follow the others.
  uint32_t partOf(uint32_t top) const {
    return top < partOfTop_.size() ? partOfTop_[top] : (*partOfInfo_)[instance_[instanceOf(top)].info];
  }
  uint32_t instanceOf(uint32_t top) const {
    return top < instanceOfTop_.size() ? instanceOfTop_[top]
                                       : firstOfSwarms_ + (top - uint32_t(instanceOfTop_.size()));
  }
  void makeSwarms();
  // Embree's instance for one placement of the top level, not committed.
  RTCGeometry makeInstance(uint32_t top) const;
  void buildSolids(const std::vector<SolidInput>& inputs, const PlacementSource& placements);
  bool isOpen(const Solids::Member& leaf, const std::vector<uint32_t>& tops) const;
  // Gives what faces its rays (ribbons, discs) the normals that it has seen from them.
  void turnToRays(const Rays& rays, const Hits& hits, uint32_t n, const uint32_t* slots) const;
  static void setRay(const Rays& rays, uint32_t slot, uint32_t mask, RTCRayHit& out);
  void resolve(const Hits& hits, uint32_t slot, uint32_t geomId, uint32_t primId, uint32_t instId) const;
  friend struct OneBody;
  bool shapeOf(uint32_t instance, uint32_t geometry, FreeSpace::Shape& out) const;
  void closest(struct QueryContext& context, const Rays& rays, const Hits& hits, uint32_t mask, uint32_t n,
               const uint32_t* slots) const;

  RTCScene top_ = nullptr;
  bool single_ = false;                             // top_ is the only part's scene
  std::vector<std::shared_ptr<const Part>> parts_;  // shared between snapshots
  struct PartPlace {
    uint32_t firstGeometry = 0, firstInstance = 0, firstTarget = 0;
  };  // batches: instance of shape i is first + i
  // Where a hit of an Embree geometry leads when it holds one shape only.
  struct Target {
    uint32_t geometry, instance;
    bool merged, writesLevel;
  };
  std::vector<Target> targets_;          // by part, then Embree geometry
  std::vector<PartPlace> places_;        // by part
  std::vector<uint32_t> partOfTop_;      // Embree instance id -> part; these three without what is in swarms
  std::vector<uint32_t> instanceOfTop_;  // Embree instance id -> instance, or none (batch)
  std::vector<uint32_t> visibilityOfTop_;
  std::vector<std::shared_ptr<geometry::Mesh>> meshes_;  // by geometry index
  std::vector<const UserGeometry*> faceted_;             // by geometry index, of parts_; empty: there are none
  std::vector<uint32_t> infoStep_;                       // by geometry index
  std::shared_ptr<std::vector<Instance>> instances_ = std::make_shared<std::vector<Instance>>();
  const Instance* instance_ = nullptr;  // the first, once all are there
  std::shared_ptr<std::vector<Affine>> keys_ = std::make_shared<std::vector<Affine>>();
  const Affine* key_ = nullptr;   // the first, once all are there
  uint32_t firstOfSwarms_ = ~0u;  // the first instance that is in a swarm: so are all behind it
  std::vector<std::pair<uint32_t, uint32_t>> seenFrom_;  // of those: where runs of one visibility begin, and it
  std::shared_ptr<std::vector<uint32_t>> partOfInfo_ = std::make_shared<std::vector<uint32_t>>();  // of theirs
  std::vector<std::shared_ptr<const Swarm>> swarms_;
  std::unique_ptr<Solids> solids_;              // null: none
  std::unique_ptr<const FreeSpace> freeSpace_;  // null: nothing can be asked for alone
  std::shared_ptr<const UnreadBounds> unread_;
  std::vector<OpenSolid> openSolids_;
  std::vector<uint32_t> lost_;
  std::vector<bool> isLost_;                          // by instance; empty: none
  std::vector<std::pair<float, float>> flatMoments_;  // rising, apart from each other
  std::vector<uint32_t> bodies_;                      // by instance; empty without solids
  float center_[3] = {0, 0, 0}, radius_ = 0;
  uint64_t triangles_ = 0;
  bool clearShadows_ = false, moving_ = false, hasUser_ = false, hasStrands_ = false, hasFacing_ = false,
       hasRibbons_ = false, watertight_ = false;
};

}  // namespace kinora::trace
