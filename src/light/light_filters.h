// The filters of one light: factors on what it brings to points. Called by light_set.cpp for light, by light_marks.cpp
// for what lights mark.
#pragma once
#include <kinora/light_filter.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/arena.h"
#include "light/light_motion.h"

namespace kinora::light {

// How the filters of a group combine, by channel; Screen is 1 - (1 - a) (1 - b) ...
enum class LightFilterMode : uint8_t { Multiply, Max, Min, Screen };

// A factor on one light; see kinora/light_filter.h.
struct LightFilterEntry {
  const LightFilterFunctions* byWidth[17] = {};
  std::shared_ptr<void> owner;
  const void* instance = nullptr;
  std::shared_ptr<const LightMotion> motion;  // of its space, as the light's (light_motion.h)
  bool isUniform = false;                     // holds for emitted light too
  // Neighbours of one group combine in its mode; groups multiply.
  LightFilterMode mode = LightFilterMode::Multiply;
  uint32_t group = 0;
  float diffuse = 1, specular = 1;  // how much of it weighs on light to such lobes; the camera sees all of it
  bool isSeen = true;               // false: the light is without it where the camera sees it
  std::string linkingGroups;        // read while lights are made; linked filters are on some objects only:
  uint32_t link = kNoLink;          // bit of what FilterUse says of the lit object
  static constexpr uint32_t kNoLink = 64;
};

// Of which of a light's filters a call asks.
struct FilterUse {
  enum By : uint8_t { LitPoints, Camera, EmittedRays } by = LitPoints;  // emitted rays know of uniform ones only
  bool forSpecular = false;                                             // lit points: the lobes that the light is for
  uint64_t links = ~0ull;
  float amountOf(const LightFilterEntry& f) const {
    return by != LitPoints ? 1.f : forSpecular ? f.specular : f.diffuse;
  }
  bool has(const LightFilterEntry& f) const {
    return (by != Camera || f.isSeen) && (f.link >= LightFilterEntry::kNoLink || links >> f.link & 1);
  }
};

// Below a distance from the light its brightness rises no more: the factor (distance / nearest)^2, at most 1.
LightFilterEntry nearDistanceFilter(float nearest);

class LightFilters {
 public:
  explicit LightFilters(Arena& arena, uint32_t most);  // points of a call
  // What the filters are told of `count` points (padded): P, wi, distance, time.
  float* in[8];
  // Multiplies value[c][list[i]], for the i-th point.
  void apply(uint32_t width, const std::vector<LightFilterEntry>& filters, uint32_t count, const uint32_t* list,
             float* const value[3], FilterUse use) const;

 private:
  void ask(uint32_t width, const LightFilterEntry& filter, uint32_t count, float* const to[3]) const;

  float *factor_[3], *group_[3], *rest_[6];
};

}  // namespace kinora::light
