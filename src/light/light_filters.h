// The filters of one light: factors on what it brings to points. Called by light_set.cpp for light, by light_marks.cpp
// for what lights mark.
#pragma once
#include <kinora/light_filter.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "base/arena.h"

namespace kinora::light {

// How the filters of a group combine, by channel; Screen is 1 - (1 - a) (1 - b) ...
enum class LightFilterMode : uint8_t { Multiply, Max, Min, Screen };

// A factor on one light; see kinora/light_filter.h.
struct LightFilterEntry {
  const LightFilterFunctions* byWidth[17] = {};
  std::shared_ptr<void> owner;
  const void* instance = nullptr;
  bool isUniform = false;  // holds for emitted light too
  // Neighbours of one group combine in its mode; groups multiply.
  LightFilterMode mode = LightFilterMode::Multiply;
  uint32_t group = 0;
};

class LightFilters {
 public:
  explicit LightFilters(Arena& arena, uint32_t most);  // points of a call
  // What the filters are told of `count` points (padded): P, wi, distance, time.
  float* in[8];
  // Multiplies value[c][list[i]], for the i-th point.
  void apply(uint32_t width, const std::vector<LightFilterEntry>& filters, uint32_t count, const uint32_t* list,
             float* const value[3], bool uniformOnly) const;

 private:
  float *factor_[3], *group_[3];
};

}  // namespace kinora::light
