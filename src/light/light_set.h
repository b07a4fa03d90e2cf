// All lights of a world: which are asked, how often, and what they answer, for groups of points and rays. Built by
// render/ from the scene's lights (plug-in instances are made there); called by shade/. Linking: each object belongs
// to a link set, the lights that may light it. Nothing here takes time or memory in proportion to lights times
// points: lights are chosen by a tree (light_tree.h) and met by rays through another (light_boxes.h).
#pragma once
#include <kinora/integrator.h>
#include <kinora/light.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "base/arena.h"
#include "base/memory.h"
#include "light/light_boxes.h"
#include "light/light_filters.h"
#include "light/light_motion.h"
#include "light/light_tree.h"
#include "light/link_sets.h"

namespace kinora::light {

// A plug-in's functions.
struct LightKind {
  const LightFunctions* byWidth[17] = {};  // 1, 4, 8, 16
};

// Which rays see a light, beside those that its samples stand for.
enum LightVisibility : uint32_t {
  kLightSeenByCamera = 1,   // camera rays see it (and stop there)
  kLightSeenByMirrors = 2,  // mirrors and lenses show it
  kLightSeenByLenses = 4    // lenses do, where mirrors do
};

// How a light's shadows are other than that whatever is in the way takes its part of the light. Applied by shade/ to
// shadow rays and to rays that find the light where its samples could have: both halves of an estimate see the same.
struct ShadowControls {
  float color[3] = {0, 0, 0};      // share of what shadows take that is left, by channel
  float farthest = INFINITY;       // distance from the lit point beyond which nothing casts shadows, render units
  float fade = 0;                  // over this distance before that shadows fade,
  float gamma = 1;                 // with this exponent of the distance still to go
  uint32_t opaque = 0, clear = 0;  // what casts shadows: masks of the world; 0: what does for the lit object's rays
  // Nothing is asked for, but rays that find the light may pass what casts its shadows, or end at what casts none.
  bool areOthers = false;
  bool areAny() const { return areSaid() || areOthers; }
  bool areSaid() const {
    return color[0] != 0 || color[1] != 0 || color[2] != 0 || farthest < INFINITY || opaque != 0;
  }
  // How much of its shadow an occluder casts at a distance.
  float strengthAt(float distance) const {
    const float left = farthest - distance;
    if (!(left > 0)) return 0;
    return left < fade ? std::pow(left / fade, gamma) : 1.f;
  }
};

// One light as the set is given it. `instance` is the plug-in's own data, kept alive by `owner`.
struct LightEntry {
  uint32_t kind = 0;
  std::shared_ptr<void> owner;
  const void* instance = nullptr;
  LightDescription description{};
  uint32_t visibility = kLightSeenByCamera | kLightSeenByMirrors | kLightSeenByLenses;
  uint32_t group = 0;         // light group for path expressions
  bool castsShadow = true;    // false: its samples have distance 0
  ShadowControls shadows{};   // of a light that casts them
  bool glassBlocks = false;   // shadow rays do not go straight through glass
  bool isWalkedTo = false;    // manifold walks go to it (cheapCaustics), unless it shines from all around
  uint32_t ownSamples = 0;    // that it asks for, see OwnLightSamples
  bool isIndirectToo = true;  // false: surfaces that a diffuse bounce found are not lit (kept by link sets)
  std::vector<LightFilterEntry> filters;
  std::shared_ptr<const LightMotion> motion;  // null: it stands still, or its plug-in knows the time
};

class LightSet {
 public:
  // filterLinks: by link set, which filters with a link (its bit) are on the objects of it; empty: all are on all.
  // Throws MemoryExceeded.
  LightSet(std::vector<LightKind> kinds, std::vector<LightEntry> lights,
           const std::vector<std::vector<uint32_t>>& linkSets, const float worldCenter[3], float worldRadius,
           std::vector<uint64_t> filterLinks = {});

  uint32_t size() const { return uint32_t(lights_.size()); }
  uint32_t groupOf(uint32_t light) const { return recordOf(light).group; }
  const void* instanceOf(uint32_t light) const { return lights_[light].instance; }
  bool castsShadow(uint32_t light) const { return recordOf(light).flags & kCastsShadow; }
  bool hasShadowControls() const { return !shadows_.empty(); }
  const ShadowControls* shadowControls(uint32_t light) const {  // null: none
    return recordOf(light).shadows == kNone ? nullptr : &shadows_[recordOf(light).shadows];
  }
  bool doesGlassBlock(uint32_t light) const { return recordOf(light).flags & kGlassBlocks; }
  uint8_t exceptionsOf(uint32_t light) const;  // LightExceptions
  bool isLinked(uint32_t linkSet, uint32_t light) const;

  // Where lights are chosen for.
  struct Points {
    uint32_t count = 0, padded = 0;
    const float* P[3];
    const float* N[3];  // null: points in space. Unit: lit from this side; length 1/2: from behind as well; 0: from
                        // all sides
    const float* time;
    const uint32_t* linkSet = nullptr;  // by point; null: all in set 0
    const float* uChoice[2];            // in [0, 1); null where there is no choice
    const float* u[2];
    bool wantsSpread = false;        // LightSamples::spread is filled
    const float* weights = nullptr;  // factors on what clusters bring, see Group::lightWeights; null: none
    const uint32_t* row = nullptr;   // by point
    uint32_t besideOwn = 0;          // Group::besideOwnSamples
    uint32_t light = kNoLight;       // the only one that is sampled, by itself
  };
  // One light sample a point, into arrays of the arena.
  void sample(uint32_t width, Arena& arena, const Points& points, LightSamples* out) const;

  struct RayList {
    uint32_t count = 0;
    const uint32_t* slots;
    const Rays* rays;
    float* tHit;              // by slot: distance of the surface hit, infinity if none
    const uint32_t* linkSet;  // by slot: of the vertex the ray left
    const uint32_t* origin;   // by slot: RayOrigin bits
    const float* N[3];        // by slot: of that vertex, as in Points; null: points in space
    const float* weights = nullptr;
    const uint32_t* row = nullptr;  // by slot: of that vertex, as in Points
    uint32_t besideOwn = 0;
  };
  // Light met by rays. Camera rays stop at the nearest light they see: its entry blocks and tHit becomes infinity.
  // Rays that a light sample could have made are the other half of an estimate: they meet a light as its samples
  // do, hidden from mirrors or not, and through what is in between where the light casts no shadows.
  void hits(uint32_t width, Arena& arena, bool camera, const RayList& list, LightHits* out) const;

  // n emitted rays, light chosen by power, all else into arrays of the arena. u: choice, then four numbers.
  void emit(uint32_t width, Arena& arena, uint32_t n, const float* uChoice, const float* const u[4],
            const float* time, float* const o[3], float* const d[3], EmittedLight* out) const;
  // light_walks.cpp: what manifold walks go to, see WalkTargets; u: choice, then four numbers. All into the arena.
  bool isWalkedTo(uint32_t light) const { return recordOf(light).flags & kWalkedTo; }
  void walkTargets(uint32_t width, Arena& arena, uint32_t n, const float* const u[5], const float* time,
                   WalkTargets* out) const;
  // What arrives at n points (padded) from a delta light each, filters included; and the factor on specular lobes.
  void deltaLights(uint32_t width, Arena& arena, uint32_t n, const float* const P[3], const float* time,
                   const uint32_t* light, const uint32_t* linkSet, float* const radiance[3], float* specular) const;
  // Of rays that left the points and met a light each (end: as given, but for point and runs).
  void ends(uint32_t width, Arena& arena, const Points& points, LightEnds* end) const;

  const std::vector<OwnLightSamples>& ownSamples() const { return ownSamples_; }
  bool hasChoice() const;  // uChoice of a sample is read
  // Of a light being sampled at n points (padded; no more than P, N and linkSet are read): what sample() divides by.
  void probabilities(uint32_t width, const Points& points, const uint32_t* light, float* out) const;

  size_t bytes() const;  // held, but for the lights' own data
  const LightTree& tree() const { return tree_; }

 private:
  enum Flags : uint16_t {
    kCastsShadow = 1,  // whatever is in the way hides it: no controls
    kSeenByCamera = 2,
    kSeenByMirrors = 4,
    kDelta = 8,
    kInfinite = 16,
    kBlack = 32,
    kWalkedTo = 64,
    kShadowless = 128,
    kGlassBlocks = 256,
    kSeenByLenses = 512
  };
  static constexpr uint32_t kNone = 0xffffffffu;
  // What many lights have alike: kept once for all of them.
  struct Record {
    float diffuse, specular;
    uint32_t group, filters, shadows, motion;  // indices, or kNone; but for the group
    uint16_t kind, flags;
  };
  // Of these four share a line of the cache: among many lights each is another one's.
  struct Light {
    const void* instance;
    uint32_t record;
  };
  const Record& recordOf(uint32_t light) const { return records_[lights_[light].record]; }
  struct Sphere {
    uint32_t light;
    float center[3], radius2;
  };
  class Order;
  // Of n points or directions with a light each those of lights that move: where their lights rest, as copies (padded;
  // the given ones where none moves), and back from there in place.
  void toRest(Arena& arena, uint32_t n, const uint32_t* light, const float* time, LightVector kind,
              const float* const x[3], const float* rest[3]) const;
  void fromRest(uint32_t n, const uint32_t* light, const float* time, LightVector kind, float* const x[3]) const;
  const LightMotion* motionOf(uint32_t light) const {
    return light == kNoLight || recordOf(light).motion == kNone ? nullptr : &motions_[recordOf(light).motion];
  }
  const uint32_t* setsBesideOwn(Arena& arena, uint32_t n, const uint32_t* linkSet) const;
  // How many of a light's own samples there are for each of lightSamples().
  float ownShare(uint32_t light, uint32_t beside) const {
    return beside && !ownShares_.empty() ? ownShares_[light] / float(beside) : 0.f;
  }
  struct Found;
  void findLights(uint32_t width, Arena& arena, bool camera, const RayList& list, Found& found) const;
  void addNearRays(uint32_t width, Arena& arena, bool camera, const RayList& list, uint32_t light,
                   const Sphere* sphere, Found& found) const;
  void askWaiting(uint32_t width, Arena& arena, bool camera, const RayList& list, bool areInfinite,
                  Found& found) const;
  uint32_t endFlags(uint32_t light) const {
    return (recordOf(light).flags & kDelta ? kLightIsDelta : 0u) |
           (recordOf(light).flags & kInfinite ? kLightIsInfinite : 0u);
  }
  // Starts of light paths: n (padded) lights that are chosen, into arrays of room for kPad more.
  struct Emission {
    float *const *o, *const *d, *const *N, *const *radiance;
    float *pdfPosition, *pdfDirection;
  };
  void emitFrom(uint32_t width, Arena& arena, uint32_t n, const uint32_t* chosen, const float* const u[4],
                const float* time, const Emission& out) const;
  float emissionOf(uint32_t light) const { return emission_[light] - (light ? emission_[light - 1] : 0.f); }
  float reachOf(const Record& light, bool camera, const RayList& list, uint32_t slot) const;
  // Light samples of the lights given, by point: their kinds asked in order. outputs: wi, distance, radiance, pdf.
  void askSamples(uint32_t width, Arena& arena, uint32_t n, const uint32_t* light, const float* const P[3],
                  const float* time, const float* const u[2], float* const outputs[8], uint32_t* flags) const;
  void filterRadiance(uint32_t width, Arena& arena, uint32_t n, const uint32_t* light, const float* const P[3],
                      const float* const wi[3], const float* distance, const float* time, const uint32_t* linkSet,
                      float* const radiance[3], FilterUse::By by = FilterUse::LitPoints,
                      bool forSpecular = false) const;
  template <class Args>
  void setWorld(Args& a) const {
    for (int c = 0; c < 3; ++c) a.worldCenter[c] = center_[c];
    a.worldRadius = radius_;
  }

  MemoryHold held_{MemoryUse::Lights};
  std::vector<LightKind> kinds_;
  std::vector<Light, LineAllocator<Light>> lights_;
  std::vector<Record> records_;
  std::vector<std::shared_ptr<void>> owners_;
  std::vector<std::vector<LightFilterEntry>> filters_;
  std::vector<uint64_t> filterLinks_;
  bool splitsFilters_ = false;  // some weigh on diffuse and specular light differently
  std::vector<ShadowControls> shadows_;
  std::vector<LightMotion> motions_;
  LightTree tree_;
  LinkSets links_;
  std::vector<Sphere> near_;       // lights that rays can hit, while they are few
  LightBoxes boxes_;               // else
  std::vector<uint32_t> distant_;  // infinite lights that rays can hit, from anywhere
  LightBoxes directions_;          // those that lie within an angle, among directions
  std::vector<float> emission_;    // sums of the probabilities of emitting, by light
  std::vector<float> walkedTo_;    // the same of those that walks go to; empty: none
  std::vector<OwnLightSamples> ownSamples_;
  uint32_t setsWithoutOwn_ = 0;   // set i without them is i + this; 0: none has any
  std::vector<float> ownShares_;  // by light, how many; empty: no light has any
  std::array<float, 3> center_;
  float radius_;
  bool isCameraSeen_ = false;  // some light that rays can hit
  bool isShadowless_ = false;  // of those, some light that is met behind what is in the way
  bool hasDistances_ = false;  // some light at all that nothing hides: its distance is not a shadow ray's
};

}  // namespace kinora::light
