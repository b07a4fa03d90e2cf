// The interface of a light filter: a factor on a light's radiance at a point it lights. Called by light/ for light
// samples and for rays that meet the light, with the same numbers for the same point and direction, so that both
// halves of multiple importance sampling see one light. Densities do not change: the factor is never negative.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

// CreateInfo::placement is the filter's own space: the coordinate system that it names, or the light's.
// CreateInfo::extra points to this; null where the filter is made without a light.
struct LightFilterInfo {
  const Placement* light;
};

struct LightFilterArgs {
  uint32_t count;
  const float* P[3];      // the lit point, render space
  const float* wi[3];     // unit, towards the light
  const float* distance;  // to the point on the light; infinity for infinite lights
  const float* time;
  float* factor[3];  // out
};

struct LightFilterFunctions {
  void (*factor)(const void* filter, const LightFilterArgs*);
};

struct LightFilterTraits {
  // 1: the factor is the same everywhere, so that light paths starting at the light take it too.
  int (*isUniform)(const void* filter);
  // The largest factor over RGB, for choosing among lights; null: 1.
  float (*largest)(const void* filter);
};

// What a light filter declares.
struct LightFilterPlugin {
  using Functions = LightFilterFunctions;
  static constexpr Kind kKind = Kind::LightFilter;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  int (*isUniform)(const void* filter) = nullptr;
  float (*largest)(const void* filter) = nullptr;
  constexpr LightFilterTraits traits() const { return {isUniform, largest}; }
};

}  // namespace kinora
