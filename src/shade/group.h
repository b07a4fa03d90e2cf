// One group of samples with all that its thread keeps for it: rays, hits, contexts, media, counters. The services
// that integrators call (kinora/integrator.h) end here: trace with presence and media, grouping and shading, lights,
// shadows. Used by render/, one object a thread; nothing in it is shared while it runs, but the world that it reads.
#pragma once
#include <kinora/integrator.h>

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/arena.h"
#include "light/light_set.h"
#include "sampling/draw.h"
#include "shade/material.h"
#include "shade/points.h"
#include "shade/ray_listener.h"
#include "shade/shader_textures.h"
#include "trace/world.h"

namespace kinora::shade {

struct ShaderScene;

// What shading knows of a tessellated primitive, by geometry index of the world.
struct GeometryInfo {
  uint32_t flags = 0;
  float side = 1;  // -1: the mesh's normals are flipped
  const geometry::Primvar *N = nullptr, *st = nullptr, *s = nullptr, *t = nullptr;  // found once
  std::string name;
};
enum GeometryFlags : uint32_t { kHasNormals = 1, kOneSided = 2, kLiftsShadows = 4, kHasQuads = 8 };
// By placement (Instance::user): what follows from attributes.
struct PlacementInfo {
  uint32_t material = 0;
  uint32_t linkSet = 0;
  int priority = 0;                      // trace:intersectpriority
  uint32_t objectId = 0, objectId2 = 0;  // identifier:id, id2
  uint32_t traceSet = 0;                 // index into ShadingWorld::traceSets
  uint32_t tint = 0;                     // index into ShadingWorld::tints
  bool hole = false;                     // Matte, trace:holdout: black and clear where a camera ray meets it
  trace::Affine renderToObject;          // at the middle of the shutter
  std::string name;
};

// Color and Opacity, which answer as primvars Cs and Os where geometry has none.
struct Tint {
  std::array<float, 3> color{1, 1, 1}, opacity{1, 1, 1};
  bool hasColor = false, hasOpacity = false;  // some request said it
  auto operator<=>(const Tint&) const = default;
};

// What rays that leave an object ask for: masks of the world (VisibilityBits and those of named subsets).
struct TraceSet {
  uint32_t reflect = trace::kSeenByIndirect, transmit = trace::kSeenByIndirect;
  uint32_t opaqueShadow = trace::kSeenByOpaqueShadow, clearShadow = trace::kSeenByClearShadow;
};

// Everything shading reads of a scene; immutable while passes run.
struct ShadingWorld {
  std::shared_ptr<const trace::World> world;
  std::shared_ptr<const MaterialSet> materials;
  std::shared_ptr<const light::LightSet> lights;
  std::vector<GeometryInfo> geometries;
  std::vector<PlacementInfo> placements;
  SurfaceTables tables;                         // of the above, for gathers; see fillTables()
  std::map<std::string, scene::Matrix> spaces;  // name -> (that space to render)
  std::map<std::string, uint32_t, std::less<>>
      primvarWidths;        // name -> components (at most 3), the widest of all objects
  std::vector<Tint> tints;  // the first: nothing said
  TextureSystem* textures = nullptr;
  VolumeSystem* volumes = nullptr;
  double worldOrigin[3] = {0, 0, 0};
  SampleTable samples{};
  const film::LightPaths* paths = nullptr;
  Diagnostics* diagnostics = nullptr;    // of shaders that speak; null: unheard
  std::shared_ptr<ShaderScene> shaders;  // what shaders ask; null: the scene has none
  bool hasMedia = false, hasPresence = false, hasTintedShadows = false;
  bool hasLinks = false;            // some objects are lit by some lights only
  uint32_t indirectSets = 0;        // so many further on is the link set of what a diffuse bounce found; 0: the same
  std::vector<TraceSet> traceSets;  // by PlacementInfo::traceSet; empty: every ray sees everything
  bool hasHoles = false, liftsShadows = false;
  uint32_t width = 8;
  void fillTables();  // once all else is set
  uint32_t materialOf(uint32_t instance) const { return tables.materialOfInstance[instance]; }
};

// A path's media, innermost last. Small: glass in water in glass is four.
struct MediaStack {
  static constexpr uint32_t kDepth = 4;
  struct Entry {
    uint32_t object;
    int priority;
    float ior;
    float absorption[3];
  };
  uint32_t count = 0;
  Entry entries[kDepth];
};

struct GroupCounters {
  uint64_t cameraRays = 0, indirectRays = 0, shadowRays = 0, lightRays = 0, cameraHits = 0, indirectHits = 0;
  uint64_t points = 0, contexts = 0;
  uint64_t lanesFirst[2] = {0, 0}, lanesDeeper[2] = {0, 0};  // active, possible
  uint64_t mediaOverflow = 0, passThroughLimit = 0;
  uint64_t nanoseconds[16] = {};
};

// Indices of GroupCounters::nanoseconds, in the order of render/statistics.h. Taken once a call for a whole group.
enum GroupStage : uint32_t {
  kTimeTraceCamera = 1,
  kTimeTraceIndirect,
  kTimeTraceShadow,
  kTimeGrouping,
  kTimeClosures,
  kTimeLights
};

class GroupState {
 public:
  explicit GroupState(const ShadingWorld& world);
  // Readies rays for `count` samples (multiple of 16 not required); all arrays have padded length.
  void begin(uint32_t count, StageKind stage);
  Group& group() { return group_; }
  Arena& arena() { return arena_; }
  uint32_t* seeds() { return seed_; }
  uint32_t* indices() { return index_; }
  int32_t* pixelX() { return px_; }
  int32_t* pixelY() { return py_; }
  float* weights() { return weight_; }
  const ShadingWorld& world() const { return world_; }
  language::RunState& shaderState() { return shaderState_; }
  std::vector<ShaderCounts> shaderCounts;  // by ShaderUse::number
  ShaderTextures& shaderTextures() { return shaderTextures_; }

  // The services, see kinora/integrator.h.
  void trace(RayKind kind, uint32_t depth, uint32_t n, const uint32_t* slots, float* const transmittance[3]);
  uint32_t shade(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, Context* const** contexts);
  Context* pointsInSpace(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, const float* t);
  void lightSamples(const Context* c, uint32_t part, uint32_t parts, LightSamples* out);
  void lightHits(RayKind kind, uint32_t n, const uint32_t* slots, LightHits* out);
  void lightsBeyond(uint32_t n, const uint32_t* slots, LightHits* out);
  void shadow(uint32_t depth, const ShadowRays* rays);
  void cross(const Context* c, uint32_t n, const uint32_t* points);
  const void* keepPaths(uint32_t n, const uint32_t* slots);
  void restorePaths(const void* kept);

  GroupCounters counters;
  RayListener* listener = nullptr;
  std::function<void(const std::string&)> print;  // set while one sample is replayed: events go here
  // Called with each first-hit context, so that render/ can write surface channels.
  std::function<void(const Context*)> onPrimary;

 private:
  friend struct ContextHost;
  static constexpr int kMostPasses = 256;  // surfaces a ray may pass for want of presence or priority
  PointsArgs startContext(uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots, Context*& context);
  Context* makeContext(uint32_t program, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* slots,
                       bool bind);
  // trace_sets.cpp; worlds with traceSets or hasHoles only.
  uint32_t maskOf(uint32_t slot, bool clearShadow) const;
  void closestInSets(bool clearShadow, uint32_t n, const uint32_t* slots);
  // `clear`: by shapes that let part of the light through as well.
  void occludedInSets(const ShadowRays& rays, const float* radius, const float* spread, uint32_t* blocked,
                      bool clear = false);
  void endAtHoles(uint32_t n, const uint32_t* slots);
  void dropLightsBehindHoles(LightHits* l);
  // shadow_terminator.cpp; worlds with liftsShadows only.
  void findLifts(uint32_t n, const uint32_t* slots, const Context* c, float* const Ng[3]);
  void liftShadows(ShadowRays* rays);
  void reachedByLifts(const ShadowRays& rays, uint32_t* blocked);
  // The normal by which lights are chosen for a context's points, see light::LightSet::Points; null without a choice.
  void setLightNormals(Context* c, const Program* program);
  // Rays leave strands by a part of their width: their hits are only as good as Embree's iteration.
  void biasOfStrands(uint32_t n, const uint32_t* slots, float* bias) const;
  bool insideHigherPriority(uint32_t slot) const;
  struct KeptPaths;
  void passThrough(uint32_t n, const uint32_t* slots, float* passed);
  void media(uint32_t n, const uint32_t* slots, float* const transmittance[3]);

  const ShadingWorld& world_;
  Arena arena_;
  Group group_{};
  uint32_t *seed_ = nullptr, *index_ = nullptr;
  int32_t *px_ = nullptr, *py_ = nullptr;
  float* weight_ = nullptr;
  MediaStack* media_ = nullptr;
  uint32_t* linkSet_ = nullptr;                     // by slot, of the vertex last shaded
  uint32_t* traceSet_ = nullptr;                    // by slot, of the vertex last shaded; null without traceSets
  float* leftNg_[3] = {nullptr, nullptr, nullptr};  // its geometric normal; null without traceSets and lifts
  float* lift_[3] = {nullptr, nullptr, nullptr};    // from it to where its shadow rays start; null without lifts
  float* facet_[3] = {nullptr, nullptr, nullptr};   // its triangle's normal; set where lift is, null without lifts
  float* lightN_[3] = {nullptr, nullptr, nullptr};  // normal that its light was chosen by; null without a choice
  float* hole_ = nullptr;                           // by slot: where its camera ray met a hole; null without holes
  RayKind rayKind_ = RayKind::Camera;               // of the rays whose hits are shaded
  language::RunState shaderState_;
  ShaderTextures shaderTextures_;
  // scratch of grouping
  std::vector<uint32_t> countOfProgram_, touched_;
};

}  // namespace kinora::shade
