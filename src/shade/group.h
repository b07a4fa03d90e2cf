// One group of samples with all that its thread keeps for it: rays, hits, contexts, media, counters. The services
// that integrators call (kinora/integrator.h) end here: trace with presence and media, grouping and shading, lights,
// shadows. Used by render/, one object a thread; nothing in it is shared while it runs, but the world that it reads.
#pragma once
#include <kinora/integrator.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/arena.h"
#include "light/light_marks.h"
#include "light/light_set.h"
#include "sampling/draw.h"
#include "shade/material.h"
#include "shade/media.h"
#include "shade/points.h"
#include "shade/ray_listener.h"
#include "shade/shader_textures.h"
#include "shade/space_media.h"
#include "trace/world.h"

namespace kinora::shade {

struct Around;
class MediumTracks;
struct ShaderScene;
struct Track;

// Of a mesh that its object's own transform is baked into, since others of a prototype share its space.
struct BakedSpace {
  scene::Matrix toMesh, toObject;
};

// What shading knows of a tessellated primitive, by geometry index of the world.
struct GeometryInfo {
  uint32_t flags = 0;
  float side = 1;  // -1: the mesh's normals are flipped
  const geometry::Primvar *N = nullptr, *st = nullptr, *s = nullptr, *t = nullptr;  // found once
  std::shared_ptr<const BakedSpace> baked;  // null: the mesh lies in its object's space
  std::string name;
  // Coordinate systems that its object's definition names (to the object's space): each instance has its own. Null: none.
  std::shared_ptr<const std::map<std::string, scene::Matrix, std::less<>>> systems;
};
enum GeometryFlags : uint32_t { kHasNormals = 1, kOneSided = 2, kMovesShadowOrigins = 4, kHasQuads = 8 };
// By kind of placement (Instance::info): what follows from attributes.
struct PlacementInfo {
  uint32_t material = 0;
  uint32_t linkSet = 0;
  int priority = 0;                      // trace:intersectpriority
  uint32_t objectId = 0, objectId2 = 0;  // identifier:id, id2
  uint32_t traceSet = 0;                 // index into ShadingWorld::traceSets
  uint32_t tint = 0;                     // index into ShadingWorld::tints
  uint32_t shadowCast = 0;               // masks of shadow rays that it blocks for good; where shadows are others
  float noiseTolerance = 1;              // shade:relativepixelvariance, (0, 1000]
  bool isHiddenFromCamera = false;       // visibility:camera
  bool hole = false;                     // Matte, trace:holdout: black and clear where a camera ray meets it
};
// By placement: what follows from where it stands.
struct ObjectSpace {
  trace::Affine fromRender;  // at the middle of the shutter
  float scale = 1;           // by which lengths grow on that way
  float unit = 1;            // length of a unit of the mesh, see trace::PartInput::isUnit
  static ObjectSpace of(const scene::Matrix& toRender, float unit = 1);
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
  bool operator==(const TraceSet&) const = default;
};

// Everything shading reads of a scene; immutable while passes run.
struct ShadingWorld {
  std::shared_ptr<const trace::World> world;
  std::shared_ptr<const MaterialSet> materials;
  std::shared_ptr<const light::LightSet> lights;
  std::shared_ptr<const SpaceMedia> space;                     // media that fill it; null: it is empty
  uint32_t firstMediumLight = 0;                               // the last of `lights` are what media emit:
  std::vector<uint32_t> mediumLights;                          // indices of those media
  std::vector<uint32_t> lightOfMedium;                         // their lights, kNoLight for others; empty: none emits
  bool hasPlacedLights = false;                                // some light is not infinitely far away
  std::shared_ptr<const std::vector<light::MarkEntry>> marks;  // lights that only mark; null: none
  std::vector<GeometryInfo> geometries;
  std::vector<PlacementInfo> placements;
  // By placement, of those that stand in the world by themselves; others follow from their instance's matrix.
  std::shared_ptr<const std::vector<ObjectSpace>> objectSpaces;
  std::function<std::string(uint32_t placement)> placementName;  // for people
  SurfaceTables tables;                                          // of the above, for gathers; see fillTables()
  std::map<std::string, scene::Matrix, std::less<>>
      spaces;  // name -> (that space to render), in the middle of the shutter
  std::map<std::string, scene::Transform, std::less<>>
      movingSpaces;                                  // those of them that move; times are those of rays
  std::set<std::string, std::less<>> objectSystems;  // names in GeometryInfo::systems
  std::map<std::string, uint32_t, std::less<>>
      primvarWidths;        // name -> components (at most 3), the widest of all objects
  std::vector<Tint> tints;  // the first: nothing said
  TextureSystem* textures = nullptr;
  VolumeSystem* volumes = nullptr;
  std::shared_ptr<MediaArchive> mediaArchive = std::make_shared<MediaArchive>();  // of records of vertices
  double worldOrigin[3] = {0, 0, 0};
  SampleTable samples{};
  const film::LightPaths* paths = nullptr;
  Diagnostics* diagnostics = nullptr;    // of shaders that speak; null: unheard
  std::shared_ptr<ShaderScene> shaders;  // what shaders ask; null: the scene has none
  bool hasMedia = false, hasPresence = false, hasTintedShadows = false;
  std::vector<WalkBound> walkBounds;  // around what manifold walks go through
  bool hasLinks = false;              // some objects are lit by some lights only
  uint32_t indirectSets = 0;        // so many further on is the link set of what a diffuse bounce found; 0: the same
  std::vector<TraceSet> traceSets;  // by PlacementInfo::traceSet; empty: every ray sees everything
  std::map<std::string, uint32_t, std::less<>> setsByText;  // masks, see Param::traceSet()
  bool hasHoles = false, movesShadowOrigins = false;
  bool areShadowsUnseen = false;  // some object casts shadows and is not seen by all rays that find lights
  bool isForPlaces = false;       // nothing can be traced, see trace::BuildOptions::placesOnly
  // Places on quads are given by their parameters: (b1 + b2, b2) on the first triangle, (b1, b1 + b2) on the second.
  bool placesByParameter = false;
  uint32_t width = 8;
  void fillTables();  // once all else is set
  // Of an instance and the geometry that it shows.
  ObjectSpace spaceOf(uint32_t instance, uint32_t geometry) const;
  uint32_t materialOf(uint32_t instance, uint32_t geometry) const {
    return tables.materialOfInfo[world->infoOf(instance, geometry)];
  }
  const PlacementInfo& placementOf(uint32_t instance, uint32_t geometry) const {
    return placements[world->infoOf(instance, geometry)];
  }
};

// What a vertex hands on to the rays that leave it: by point of a context, and by entry of a list for the vertices
// that its rays have left. Arrays that the world has no use for are null, but for link sets of lists.
struct VertexState {
  uint32_t* linkSet = nullptr;
  uint32_t* traceSet = nullptr;                // with traceSets
  uint32_t* media = nullptr;                   // stacks in the group's MediaPool; with media
  uint32_t* bounces = nullptr;                 // scatterings in media one after another; where some count them
  float* Ng[3] = {nullptr, nullptr, nullptr};  // geometric normal; with traceSets and movesShadowOrigins
  float* terminatorOffset[3] = {nullptr, nullptr,
                                nullptr};          // to where its shadow rays start; with movesShadowOrigins
  float* facet[3] = {nullptr, nullptr, nullptr};   // its triangle's normal; set where the offset is
  float* lightN[3] = {nullptr, nullptr, nullptr};  // by which its lights are chosen, see light::LightSet::Points;
                                                   // where there is a choice
  uint32_t* lightRow = nullptr;                    // of Group::lightWeights; with weighsLights
};

// The renderer's part of a list of rays.
struct ListHost {
  VertexState left;
  RayKind kind = RayKind::Camera;  // of the rays traced last
  // Lists that stand for records of vertices: rays.o is the vertex itself, `left` its own state, and this the
  // distance from where its ray began. Null: rays as they were traced.
  const float* reach = nullptr;
  // Of shadow rays of lights with controls: masks, by entry, of what lets part of their light through.
  const uint32_t* clearMask = nullptr;
  uint32_t depth = 0;  // of the rays traced last
  uint32_t seen = 0;   // mask of what the rays see; 0: what those of their kind see that leave their vertices
  // Of rays traced last, with media: the surface that would have been hit, where a medium ended the ray before, and
  // what the media behind surfaces have let through to where it ended. Null without.
  float* surfaceT = nullptr;
  float* absorbed[3] = {nullptr, nullptr, nullptr};
  static ListHost& of(const RayList& l) { return *static_cast<ListHost*>(l.host); }
};

// Which media rays know of: those that rays of these kinds do (trace::VisibilityBits), and of a ray that leaves an object
// with subsets of its own those that the mask of its entry says. ofEntry null: there are no such rays.
struct MediaSight {
  uint32_t kinds;
  const uint32_t* ofEntry = nullptr;
  uint32_t of(uint32_t entry) const { return ofEntry ? ofEntry[entry] : kinds; }
};

// SIMD lanes of contexts: those that hold a point, those that could, and the contexts.
struct LaneCounts {
  uint64_t active = 0, possible = 0, contexts = 0;
};

struct GroupCounters {
  uint64_t cameraRays = 0, indirectRays = 0, shadowRays = 0, lightRays = 0, cameraHits = 0, indirectHits = 0;
  // By depth of the vertex, the last for it and all beyond; `queries` are contexts that are asked for presence, the
  // light that a surface lets through, or the medium behind it, and then forgotten.
  static constexpr uint32_t kLaneDepths = 12;
  LaneCounts lanes[kLaneDepths], queries, walks;
  // Of manifold walks: begun, that found a path, and how often one was looked for again to be counted.
  uint64_t walksBegun = 0, walksFound = 0, walkTrials = 0;
  uint64_t endlessRays = 0;  // that would pass more than kMostPasses surfaces
  // Of tracking in media: rays that came through some, places where extinction was looked up, rays that were given up
  // after kMostCollisions of them; the largest factor by which a bound was exceeded, and the medium's index.
  uint64_t mediaRays = 0, mediaLookups = 0, endlessTracks = 0, mediaOverflows = 0;
  float excess = 1;
  uint32_t excessMedium = 0;
  // Paths below surfaces that came out where they went in, by BelowSurface, and the first object of theirs.
  uint64_t lostBelow[2] = {};
  uint32_t lostPlacement[2] = {~0u, ~0u};
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
  uint64_t* numbers() { return number_; }
  int32_t* pixelX() { return px_; }
  int32_t* pixelY() { return py_; }
  float* weights() { return weight_; }
  const ShadingWorld& world() const { return world_; }
  language::RunState& shaderState() { return shaderState_; }
  std::vector<ShaderCounts> shaderCounts;  // by ShaderUse::number
  ShaderTextures& shaderTextures() { return shaderTextures_; }

  // The services, see kinora/integrator.h.
  RayList* makeRays(uint32_t capacity);
  void leave(RayList& list, const Context* c, uint32_t n, const uint32_t* points, const uint32_t* entries,
             const uint32_t* through);
  void trace(RayList& list, RayKind kind, uint32_t depth, uint32_t n, const uint32_t* entries,
             float* const transmittance[3]);
  uint32_t shade(RayList& list, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                 Context* const** contexts);
  void keepVertices(const Context* c, uint32_t n, const uint32_t* points, VertexRecord* out);
  uint32_t shadeVertices(uint32_t n, const VertexRecord* records, Context* const** contexts);
  uint32_t makeVertices(uint32_t n, const SurfacePlaces& places, VertexRecord* out, uint32_t* which);
  // Where a displacement moves n places of one material to (program.displacement): offsets in object space, from P and
  // N there (padded). Places as for makeVertices(), all of them on the surface. True where `normal` was written too: a
  // shader says how the surface lies.
  bool displace(uint32_t n, const SurfacePlaces& places, const float* const P[3], const float* const N[3],
                float* const offset[3], float* const normal[3]);
  void freeRegions(const Context* c, uint32_t n, const uint32_t* points, const float* const P[3], const float* reach,
                   FreeRegions* out);
  void hitsOnObject(const Context* c, uint32_t n, const uint32_t* points, const Rays& rays, ObjectHits* out);
  void noteBelow(const Context* c, uint32_t n, const uint32_t* points, BelowSurface what);
  // group_walks.cpp
  void traceWalks(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries);
  void walkTargets(uint32_t n, const float* const u[5], const float* time, WalkTargets* out);
  void deltaLights(const RayList& list, uint32_t n, const uint32_t* entries, const uint32_t* light,
                   float* const radiance[3], float* specular);
  Context* pointsInSpace(RayList& list, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                         const float* t);
  void scatterTowardsLights(RayList& list, uint32_t depth, uint32_t part, uint32_t parts, uint32_t n,
                            const uint32_t* entries, TowardsLights* out);
  void mediaAt(const RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries, const float* t,
               MediaAt* out);
  void mediumIntervals(const RayList& list, uint32_t n, const uint32_t* entries, MediumIntervals* out);
  void meanTransmittance(uint32_t n, const float* const o[3], const float* const d[3], const float* length,
                         const float* time, float* out);
  // of: the light that is sampled; kNoLight: one that is chosen
  void lightSamples(const Context* c, uint32_t part, uint32_t parts, LightSamples* out, uint32_t of = kNoLight);
  void weighLights(const Context* c, const uint32_t* rows);
  void lightHits(const RayList& list, RayKind kind, uint32_t n, const uint32_t* entries, LightHits* out);
  void lightEnds(LightEnds* ends);
  void lightsBeyond(const RayList& list, uint32_t n, const uint32_t* entries, LightHits* out);
  void lightsAlong(const RayList& list, uint32_t n, const uint32_t* entries, LightHits* out);
  void shadow(uint32_t depth, const ShadowRays* rays);
  int probe(const Context* c, const ProbeRays& rays);  // see ContextFunctions
  // From render space to that of a placed object, which is a medium, at a time of the shutter.
  trace::Affine toObject(uint32_t instance, uint32_t geometry, float time) const;
  // Extinction of a medium at n points of render space, by its network, and emission (null: not wanted).
  void lookUpMedium(uint32_t medium, uint32_t n, const float* const P[3], const float* time,
                    float* const extinction[3], float* const emission[3]);

  GroupCounters counters;
  RayListener* listener = nullptr;
  bool weighsLights = false;                      // the integrator may say weighLights()
  bool scattersInMedia = false;                   // the integrator takes contexts of points in media
  std::function<void(const std::string&)> print;  // set while one sample is replayed: events go here
  // Called with each first-hit context, so that render/ can write surface channels.
  std::function<void(const Context*)> onPrimary;

 private:
  uint32_t contextsOfRecords(uint32_t n, const VertexRecord* records, bool bind, Context* const** contexts);
  static constexpr int kMostPasses = 256;  // surfaces a ray may pass for want of presence or priority
  void fillList(RayList& list, uint32_t room);
  PointsArgs startContext(const RayList& list, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                          Context*& context);
  Context* makeContext(const RayList& list, uint32_t program, uint32_t traits, uint32_t depth, uint32_t n,
                       const uint32_t* entries, bool bind);
  void countLanes(uint32_t traits, uint32_t depth, uint32_t points) {
    LaneCounts& l = traits & kTraitPresenceQuery ? counters.queries
                    : traits & kTraitWalk        ? counters.walks
                                                 : counters.lanes[std::min(depth, counters.kLaneDepths - 1)];
    l.active += points;
    l.possible += (points + world_.width - 1) / world_.width * world_.width;
    ++l.contexts;
  }
  // State of points of a context or of entries of a list, with room for n; what the world has no use for stays null.
  VertexState makeState(uint32_t n);
  // trace_sets.cpp; worlds with traceSets or hasHoles only.
  uint32_t maskOf(const RayList& list, uint32_t entry, bool clearShadow) const;
  template <class MaskOf>
  void closestByMask(const RayList& list, const MaskOf& maskOf, uint32_t n, const uint32_t* entries);
  void closestInSets(const RayList& list, bool clearShadow, uint32_t n, const uint32_t* entries);
  // `clear`: by shapes that let part of the light through as well.
  void occludedInSets(const ShadowRays& rays, const float* radius, const float* spread, uint32_t* blocked,
                      bool clear = false);
  // By ray what is asked for.
  void occludedByMask(const ShadowRays& rays, const uint32_t* mask, const float* radius, const float* spread,
                      uint32_t* blocked);
  // Footprints by which shadow rays meet geometry of several resolutions; left alone where there is none.
  void findFootprints(const ShadowRays& rays, float** radius, float** spread);
  // What surfaces let through, by ray.
  void shadowOfSurfaces(uint32_t depth, const ShadowRays& rays);
  // light_shadows.cpp; of lights with controls.
  struct ControlledShadows;
  void controlShadows(uint32_t depth, const ShadowRays& rays);
  void fadeShadows(const ShadowRays& rays, const ControlledShadows& controls, uint32_t* blocked);
  void shadowLightHits(const RayList& list, LightHits* hits);
  void endAtHoles(const RayList& list, uint32_t n, const uint32_t* entries);
  void dropLightsBehindHoles(LightHits* l);
  // shadow_terminator.cpp; worlds with movesShadowOrigins only.
  void findTerminatorOffsets(const Context* c, float* const Ng[3]);
  // The normal by which lights are chosen for a context's points; program null: points in space.
  void findLightNormals(const Context* c, const Program* program);
  void moveShadowOrigins(ShadowRays* rays);
  // Whether anything of `mask` (opaque shadows, and clear ones) is in the way of shadow rays.
  void occluded(const ShadowRays& rays, uint32_t* blocked, bool clear = false);
  // clear_shadows.cpp
  static void copyRays(const ShadowRays& rays, RayList& list);
  void walkClearShadows(uint32_t depth, const ShadowRays& rays, const uint32_t* blocked,
                        const ControlledShadows* controls = nullptr);
  struct ClearSurfaces;
  ClearSurfaces nextClearSurfaces(RayList& list, uint32_t& openCount, uint32_t* open);
  RayList& raysOfHits(const RayList& from, uint32_t n, const trace::World::CollectedHit* hits);
  static float distanceBeyond(const Rays& rays, uint32_t slot, float t);
  // Rays leave strands by a part of their width: their hits are only as good as Embree's iteration.
  // How far off strands rays start; where a fibre was met, P becomes the place on its axis.
  void leaveStrands(const Context* c, bool isFiber, bool isRecord, float* const P[3], float* bias) const;
  Context* startInSpace(const RayList& list, uint32_t traits, uint32_t depth, uint32_t n, const uint32_t* entries,
                        const float* t);
  Context* makeMediumContext(const RayList& list, uint32_t program, uint32_t traits, uint32_t depth, uint32_t n,
                             const uint32_t* entries, bool bind);
  SurfacesArgs placesOf(const RayList& list, const float* t, Context* c);
  void setProgram(Context* c, const Program& program, bool bind);
  // group_space.cpp; worlds with media that fill space only.
  // trace_sets.cpp. Of rays that were traced, and of shadow rays of the vertices that the rays have left.
  MediaSight mediaSeen(const RayList& list, uint32_t n, const uint32_t* entries);
  MediaSight mediaInShadows(const RayList& list, uint32_t n, const uint32_t* entries);
  void findCrossings(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight);
  void crossBoxes(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight);
  void crossBoundaries(const Rays& rays, uint32_t n, const uint32_t* entries, const MediaSight& sight);
  void cutOff(const uint32_t* entries, const MediaSight& sight);
  static void setPathOf(const RayList& list, Track& t);
  void absorbUntil(const RayList& list, uint32_t entry, float t, float* const transmittance[3]) const;
  const float* sharesOfGlow(const RayList& list, MediumTracks& tracks);
  // n points, padded, that choose among lights; N[0] null: they have none.
  light::LightSet::Points litPoints(uint32_t n, const float* const P[3], const float* const N[3], const float* time,
                                    const uint32_t* linkSet, const uint32_t* row) const;
  float shareOfGlow(const Track& t, const Around& a, const float* shares) const;
  void askMediumLights(const Context* c, LightSamples* samples);
  light::LightSet::RayList seenFromBegin(const RayList& list, uint32_t n, const uint32_t* entries, float* tHit,
                                         Rays& rays);
  void seenFromOrigin(const RayList& list, const light::LightSet::RayList& l, LightHits* hits);
  void noteExcess(uint32_t medium, float bound, float* const extinction[3], uint32_t at);
  void scatterInSpace(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries,
                      float* const transmittance[3]);
  void writeWays(RayList& list, uint32_t n, const uint32_t* entries);
  void thinOutEvenly(const float* ends, const uint32_t* bounces, uint32_t n, const uint32_t* entries,
                     float* const transmittance[3]);
  void thinOut(const Rays& rays, const float* ends, const MediaSight& sight, const uint32_t* seed,
               const uint32_t* index, const uint32_t* bounces, uint32_t depth, uint32_t n, const uint32_t* entries,
               float* const transmittance[3]);
  void thinOutShadows(uint32_t depth, const ShadowRays& rays);
  void thinOutLights(const RayList& list, LightHits* hits);
  // group_media.cpp; worlds with media only.
  bool insideHigherPriority(const RayList& list, uint32_t entry) const;
  void crossDisplaced(RayList& list, uint32_t depth, uint32_t n, const uint32_t* entries);
  void absorb(const RayList& list, uint32_t n, const uint32_t* entries, float* const transmittance[3]);
  void findOuterIor(const Context* c, const uint32_t* stacks, float* ior) const;
  void updateMedia(const Context* c, uint32_t n, const uint32_t* points, const uint32_t* through, uint32_t* stacks);
  float outwards(const Hits& hits, uint32_t at, const float d[3], float time) const;
  bool averted(const RayList& list, uint32_t entry) const;
  void passThrough(const RayList& list, uint32_t n, const uint32_t* entries, float* passed);
  void closest(RayList& list, uint32_t n, const uint32_t* entries);
  uint32_t maskOf(const char* traceSet) const;  // 0: no choice
  void probeSome(const Context* c, const ProbeRays& rays, uint32_t first, uint32_t count, uint32_t mask);

  const ShadingWorld& world_;
  Arena arena_;
  Group group_{};
  uint64_t* number_ = nullptr;
  int32_t *px_ = nullptr, *py_ = nullptr;
  float* weight_ = nullptr;
  float* hole_ = nullptr;  // by slot: where its camera ray met a hole; null without holes
  MediaPool media_;
  language::RunState shaderState_;
  ShaderTextures shaderTextures_;
  bool probing_ = false;  // the rays of a pattern are on their way
  std::vector<trace::World::CollectedHit> collected_;
  std::vector<MediumCrossing> crossings_, crossingsTowards_, cut_;
  struct WayStep {  // see MediumWays
    uint32_t entry;
    float from, to, factor[3];
  };
  std::vector<WayStep> waySteps_;
  // scratch of grouping
  std::vector<uint32_t> countOfProgram_, touched_;
};

}  // namespace kinora::shade
