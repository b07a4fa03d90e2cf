// A region of space with a soft edge, in which light is changed by where the lit point lies: what PxrRodLightFilter
// and PxrBlockerLightFilter are made of. Plain data and set-up; rod_kernel.h evaluates it.
#pragma once
#include "plugins/lightfilter/parts/filter_setup.h"

#include <memory>

namespace kinora::filterParts {

inline constexpr float kFalloffKnots[] = {0, 0, 0.3f, 0.7f, 1, 1};
inline constexpr float kFalloffFloats[] = {0, 0, 0.2f, 0.8f, 1, 1};
inline constexpr std::array kRodShape = {
    param::number("width", 0.f).range(0, 4).help("Size of the inner box in x."),
    param::number("height", 0.f).range(0, 4).help("Size of the inner box in y."),
    param::number("depth", 0.f).range(0, 4).help("Size of the inner box in z."),
    param::number("radius", 1.f).range(0, 4).help("The region reaches this far beyond the box, with round corners."),
    param::number("edge", 0.25f).range(0, 4).help("Width of the soft edge about the region."),
};
inline constexpr std::array kRodFalloff = {
    param::integer("falloff", 6).range(0, 64).help("Number of knots; the arrays' lengths count."),
    param::array(Type::Float, "falloff_Knots", kFalloffKnots, 6)
        .help("Places in the soft edge, from 0 at the region to 1 outside."),
    param::array(Type::Float, "falloff_Floats", kFalloffFloats, 6)
        .help("How much of the unfiltered light is there; 0 within the region and 1 outside, whatever the ends say."),
    param::string("falloff_Interpolation", "bspline")
        .options("linear|catmull-rom|bspline|constant")
        .help("Curve between the knots."),
};
constexpr auto kRodCommon =
    joinParams(kRodShape, intensity(0, "Factor on the light within the region."),
               invert("1: the light is changed outside of the region."), kStrength, kSaturation,
               colorRamp("Colours of the factor, from the region (0) to the outside of its edge (1)."), kRodFalloff);

struct Rod {
  FilterSpace space;  // scales are in it
  float low[3], high[3], softLow[3], softHigh[3], radius;
  float intensity, density, saturation;
  bool inverted;
  Ramp color, falloff;
};

// hasSides: each side has its own extent, edge and scale.
inline std::unique_ptr<Rod> makeRod(const NamedValues& v, bool hasSides) {
  auto k = std::make_unique<Rod>();
  k->space = FilterSpace::of(v.info());
  const char *sizes[3] = {"width", "height", "depth"}, *scales[3] = {"scaleWidth", "scaleHeight", "scaleDepth"};
  const char *lows[3] = {"left", "bottom", "front"}, *highs[3] = {"right", "top", "back"};
  const char *lowEdges[3] = {"leftEdge", "bottomEdge", "frontEdge"},
             *highEdges[3] = {"rightEdge", "topEdge", "backEdge"};
  Float3* rows[3] = {&k->space.x, &k->space.y, &k->space.z};
  const float edge = atLeast(v, "edge", 0);
  for (int c = 0; c < 3; ++c) {
    const float half = atLeast(v, sizes[c], 0) / 2;
    k->low[c] = -half;
    k->high[c] = half;
    k->softLow[c] = k->softHigh[c] = edge;
    if (!hasSides) continue;
    k->low[c] = std::min(-half - float(v.number(lows[c])), 0.f);
    k->high[c] = std::max(half + float(v.number(highs[c])), 0.f);
    k->softLow[c] *= atLeast(v, lowEdges[c], 0);
    k->softHigh[c] *= atLeast(v, highEdges[c], 0);
    const float scale = std::max(float(v.number(scales[c])), 1e-6f);
    *rows[c] = Float3(rows[c]->x / scale, rows[c]->y / scale, rows[c]->z / scale);
  }
  k->radius = atLeast(v, "radius", 0);
  k->intensity = atLeast(v, "intensity", 0);
  k->density = strength(v);
  k->saturation = saturation(v);
  k->inverted = v.integer("invert") != 0;
  k->color.set(v, "colorRamp", "_Colors", 3);
  k->falloff.set(v, "falloff", "_Floats", 1);
  v.warnNoEffect();
  return k;
}
inline float largestOfRod(const void* data) {
  const Rod& k = *static_cast<const Rod*>(data);
  return largestOf(k.intensity * k.color.bound() * std::max(k.saturation, 1.f));
}

}  // namespace kinora::filterParts
