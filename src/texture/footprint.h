// How an elliptical footprint is looked up: by several probes along its longer axis, each as wide as the shorter one
// (after McCormack, Perry, Farkas and Jouppi, Feline: Fast Elliptical Lines for Anisotropic Texture Mapping, 1999). Called by the
// store of textures for each point; it reads no texels.
#pragma once
#include <algorithm>
#include <cmath>

namespace kinora::texture {

// At most that many for a footprint. What is longer than they reach has gaps between them, which the samples of a
// pixel fill.
inline constexpr int kMostProbes = 8;
// The part of the longer axis that they cover, its middle: a pixel's other samples are spread over all of it, and blur
// soon is the larger error (tools/measure_footprints).
inline constexpr float kCovered = 0.5f;
// Where that part is less than so many times as long as wide, one lookup by the shorter axis will do.
inline constexpr float kLeastStretch = 1.5f;
// Half diameters, in units of the texture; what is larger shows the coarsest level anyway.
inline constexpr float kMostReach = 4;

struct Probes {
  int count = 1;
  float texels = 0;              // half width of each, in texels of the finest level
  float firstS = 0, firstT = 0;  // from the middle to the first of them, in units of the texture
  float stepS = 0, stepT = 0;    // from each to the next
};

// axis: s and t of two conjugate half diameters, in units of the texture. `blur` widens it on all sides. False
// where they are no ellipse: all 0 or not numbers.
inline bool findProbes(const float axis[4], float blur, int width, int height, Probes& out) {
  const float w = float(width), h = float(height);
  const auto within = [](float x) { return std::clamp(x, -kMostReach, kMostReach); };
  const float us = within(axis[0]) * w, ut = within(axis[1]) * h, vs = within(axis[2]) * w, vt = within(axis[3]) * h;
  // principal axes of u u' + v v'
  const float ss = us * us + vs * vs, tt = ut * ut + vt * vt, st = us * ut + vs * vt;
  const float sum = ss + tt;
  if (!(sum > 0)) return false;
  const float half = 0.5f * (ss - tt), root = std::sqrt(half * half + st * st);
  const float longer = std::sqrt(0.5f * sum + root), added = blur > 0 ? blur * std::min(w, h) : 0;
  // by the area: a difference of squares would lose the digits of thin ones
  const float shorter = std::fabs(us * vt - ut * vs) / longer + added, reach = kCovered * (longer + added);
  out = Probes();
  out.texels = std::min(shorter, kMostReach * std::min(w, h));
  // where texels are larger than the footprint is wide they are what a probe covers
  const float stretch = reach / std::max(shorter, 1.f);
  if (!(stretch >= kLeastStretch)) return true;
  out.count = int(std::min(stretch + 0.5f, float(kMostProbes)));
  const float x = half >= 0 ? root + half : st, y = half >= 0 ? st : root - half;
  const float step = 2 * reach / (float(out.count) * std::sqrt(x * x + y * y));
  out.stepS = step * x / w;
  out.stepT = step * y / h;
  out.firstS = -0.5f * float(out.count - 1) * out.stepS;
  out.firstT = -0.5f * float(out.count - 1) * out.stepT;
  return true;
}

}  // namespace kinora::texture
