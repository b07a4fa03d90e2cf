// A displaced surface that is diced where rays ask, as finely as their footprints are: patches (geometry/patches.h) whose
// grids are shaded and moved on demand, on any thread, and held by a cache of bounded size (trace/geometry_cache.h).
// What a ray sees of a patch follows from ray and patch alone: its resolution from the footprint at the patch, the
// steps along each of its edges from that at the edge, so that both patches of an edge agree. A point of the surface is
// in one place whatever the resolution: coarser grids are parts of finer ones. Of a surface that deforms a grid holds
// its points at each key; what a ray sees, and chooses by, is where these are at its time. Made by Displacement.
#pragma once
#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "film/light_paths.h"
#include "geometry/patches.h"
#include "scene/scene.h"
#include "shade/group.h"
#include "trace/geometry_cache.h"
#include "trace/grid_outline.h"
#include "trace/user_geometry.h"

namespace kinora::render {

// What surfaces with several resolutions have made, over all of them; filled from any thread.
struct LevelCounters {
  static constexpr int kLevels = 11, kKinds = 3;              // kinds of rays: camera, indirect, shadow
  std::atomic<uint64_t> micropolygons[kLevels][kKinds] = {};  // quads diced, for rays of this kind
  std::atomic<uint64_t> nanoseconds{0}, vertices{0};          // CPU time of dicing, shading for displacement with it
  std::atomic<uint64_t> found{0};                             // patches that rays found diced
  std::atomic<uint64_t> passed{0};                            // and that were not, nor had to be: the ray goes by
};

class LevelledSurface final : public trace::UserGeometry {
 public:
  struct Setup {
    std::shared_ptr<const geometry::Patches> patches;
    shade::ShadingWorld world;  // of the patches' mesh alone, for places; see Displacement::worldOf
    scene::AttributesPtr attributes;
    std::shared_ptr<const film::LightPaths> paths;
    std::string object, displacement;  // names
    SourcePos pos;
    float toRender = 1;  // by which lengths grow
    float pixels = 1;    // length of a micropolygon's edge where the camera looks
    double bound = 0;    // of the ways of points, object units; 0: not known, all patches are diced once
    const std::atomic<bool>* stop = nullptr;
    std::shared_ptr<trace::GeometryCache> cache;
    std::shared_ptr<LevelCounters> counters;
  };
  explicit LevelledSurface(Setup setup);
  ~LevelledSurface() override;

  uint32_t patchCount() const override { return patches_->count(); }
  uint32_t keyCount() const override { return keys_; }
  void bounds(uint32_t patch, uint32_t key, float lower[3], float upper[3]) const override;
  bool intersect(uint32_t patch, const trace::UserRay& ray, trace::UserHit* hit) const override;
  bool hasFacets() const override { return true; }
  void facets(uint32_t n, const uint32_t* primitive, const uint32_t* level, const float* u, const float* v,
              const float* time, trace::UserFacet* out) const override;

  const std::shared_ptr<const geometry::Patches>& patches() const { return patches_; }
  double longest() const { return longest_; }  // way of a point, of those that have been diced; object units
  uint64_t bytes() const;                      // beside the cache and the mesh

 private:
  struct Workspace;
  static constexpr uint32_t kUnit = geometry::Patches::kUnit;
  // A box whose faces all move by a distance has corners that move by 1.73 times that: what meets at an angle is moved as
  // one, and may go so many times farther than a bound says.
  static constexpr double kMostAtJoint = 2;
  struct Corners {  // of a patch, at a key
    uint32_t patch, key;
    float size;  // of a step, over the edges
    Imath::V3d point[4], normal[4];
  };
  struct Choice {  // what a ray sees
    int level;
    std::array<uint8_t, 4> steps;
  };
  // What of a patch's edges rays choose by: middles, by axis, half the ways from end to end, steps at the finest rate.
  struct Edges {
    float middle[3][4], reach[4], size[4];
    float least, largest;  // of sizes
    float across;          // from the first middle to the farthest other one
    std::array<uint8_t, 4> exponent;
  };
  Edges edgesOf(uint32_t patch, const trace::Moment& at) const;
  Choice choose(uint32_t patch, const trace::UserRay& ray) const;
  int coarser(float footprint, float size) const;
  // Whether the outline of the patch, which is known, tells that the ray goes by.
  bool goesBy(uint32_t patch, const Choice& choice, const trace::GridRay& ray) const;
  // lower, then upper
  using Box = std::array<float, 6>;
  Box boxAt(uint32_t patch, const trace::Moment& at) const;
  Box boxOf(uint32_t patch) const;  // over the shutter
  // `points`: of the finest grid, key after key.
  void keepOutline(uint32_t patch, const Imath::V3f* points) const;
  float largestStep(uint32_t patch) const;
  trace::GeometryCache::Slot& slot(uint32_t patch, int level) const {
    return slots_[firstSlot_[patch] + uint32_t(level)];
  }
  // Null: it is not there, and the renderer is stopping; see GeometryCache::wasCutShort().
  const trace::Tessellation* held(uint32_t patch, int level, int kind, trace::GeometryCache::Reading& reading) const;
  void flatFacet(uint32_t patch, float x, float y, trace::UserFacet& f) const;
  trace::Tessellation::Ptr dice(uint32_t patch, int level) const;
  // Where the points of a grid go to at the workspace's key; with the points around it, from which normals follow, where
  // `isAround`.
  void placePoints(uint32_t patch, int level, bool isAround, Workspace& w) const;
  void addPoint(Workspace& w, const geometry::Patches::Place& place) const;
  void movePoints(Workspace& w) const;
  // What was placed last joins the grid of the workspace, as its next key.
  void addPointsOfGrid(uint32_t patch, int level, Workspace& w) const;
  void addNormals(uint32_t patch, int level, Workspace& w) const;
  const Corners& cornersOf(uint32_t patch, Workspace& w) const;
  Imath::V3d cornerAt(uint32_t patch, int corner, uint32_t key) const;
  Imath::V3d normalAt(uint32_t patch, int corner, uint32_t key) const;
  void findBounds(const std::atomic<bool>* stop);
  bool hasJoint(uint32_t patch) const;
  void tell(Workspace& w, uint32_t patch) const;

  Setup setup_;
  std::shared_ptr<const geometry::Patches> patches_;
  const geometry::Primvar* normals_;
  uint32_t keys_;
  std::vector<Box> boxes_;      // by patch and key
  bool areBoxesTight_ = false;  // around the points, not what a bound allows
  std::vector<Edges> edges_;    // by patch; empty where the surface deforms
  // By patch, as the finest grid has it; its state says whether that was diced yet.
  mutable std::vector<trace::GridOutline> outlines_;
  mutable std::vector<std::atomic<uint8_t>> outlineStates_;
  std::vector<uint32_t> firstSlot_;
  mutable std::vector<trace::GeometryCache::Slot> slots_;
  bool isMovedByShader_;
  std::atomic<double> longest_{0};
  mutable std::atomic<bool> toldBound_{false}, toldNotFinite_{false};
  mutable tbb::enumerable_thread_specific<std::unique_ptr<Workspace>> workspaces_;
};

}  // namespace kinora::render
