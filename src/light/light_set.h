// All lights of a world: which are asked, how often, and what they answer, for groups of points and rays. Built by
// render/ from the scene's lights (plug-in instances are made there); called by shade/. Linking: each object belongs
// to a link set, the lights that may light it.
#pragma once
#include <kinora/integrator.h>
#include <kinora/light.h>
#include <kinora/light_filter.h>

#include <array>
#include <memory>
#include <vector>

#include "base/arena.h"

namespace kinora::light {

// A factor on one light; see kinora/light_filter.h.
struct LightFilterEntry {
  const LightFilterFunctions* byWidth[17] = {};
  std::shared_ptr<void> owner;
  const void* instance = nullptr;
  bool isUniform = false;  // holds for emitted light too
};

// One light as the set holds it. `instance` is the plug-in's own data, kept alive by `owner`.
struct LightEntry {
  const LightFunctions* byWidth[17] = {};  // 1, 4, 8, 16
  std::shared_ptr<void> owner;
  const void* instance = nullptr;
  LightDescription description{};
  uint32_t visibility = 3;    // bit 0: camera rays see it (and stop there), bit 1: mirrors and lenses show it
  uint32_t group = 0;         // light group for path expressions
  bool castsShadow = true;    // false: its samples have distance 0
  bool isIndirectToo = true;  // false: surfaces that a diffuse bounce found are not lit (kept by link sets)
  std::vector<LightFilterEntry> filters;  // they multiply
};

class LightSet {
 public:
  LightSet(std::vector<LightEntry> lights, std::vector<std::vector<uint32_t>> linkSets, const float worldCenter[3],
           float worldRadius);

  uint32_t size() const { return uint32_t(lights_.size()); }
  const LightEntry& operator[](uint32_t i) const { return lights_[i]; }

  struct Points {
    uint32_t count = 0, padded = 0;
    const float* P[3];
    const float* time;
    const uint32_t* linkSet = nullptr;  // by point; null: all in set 0
    const float* uChoice;               // in [0, 1); null where there is no choice
    const float* u[2];
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
  };
  // Light met by rays. Camera rays stop at the nearest light they see: its entry blocks and tHit becomes infinity.
  // Rays that a light sample could have made are the other half of an estimate: they meet a light as its samples
  // do, hidden from mirrors or not, and through what is in between where the light casts no shadows.
  void hits(uint32_t width, Arena& arena, bool camera, const RayList& list, LightHits* out) const;

  // n emitted rays, light chosen by power. u: choice, then four numbers. Writes throughput = radiance cos / pdf.
  void emit(uint32_t width, Arena& arena, uint32_t n, const float* uChoice, const float* const u[4],
            const float* time, float* const o[3], float* const d[3], float* const throughput[3],
            uint32_t* light) const;

  bool hasChoice() const;  // uChoice of a sample is read
  float choicePdf(uint32_t linkSet, uint32_t light) const;

 private:
  struct LinkSet {
    std::vector<uint32_t> lights;
    std::vector<float> cdf;         // inclusive, ends at 1
    std::vector<float> pdfOfLight;  // by light index, 0 when not linked
  };
  uint32_t choose(const LinkSet& s, float u, float* pdf, float* rest) const;
  const float* reachOf(const LightEntry& light, Arena& arena, const RayList& list) const;
  std::vector<LightEntry> lights_;
  std::vector<LinkSet> sets_;
  std::array<float, 3> center_;
  float radius_;
};

}  // namespace kinora::light
