// What a stack of lobes says lies below it: lengths and albedos by point, from the parameters of a closure. Included
// by stack.cpp alone; plain code.
#pragma once
#include <kinora/subsurface_albedo.h>
#include "closure.h"

namespace kinora::lobes {

// Of the longest channel: shorter ones are brought up to it. What is shorter by far comes out where it went in all the
// same, and would only take many steps.
inline constexpr float kShortestReach = 1.f / 256;
inline constexpr float kLongestReach = 1e15f;

// Both lengths give Burley's profile the same scale: 3.5 + 100 (A - .33)^4 of the one and 1.9 - A + 3.5 (A - .8)^2 of the
// other (Christensen and Burley 2015, for diffuse light).
inline float diffuseOverMeanFreePath(float albedo) {
  const float a = albedo - 0.33f, b = albedo - 0.8f;
  return (3.5f + 100 * a * a * a * a) / (1.9f - albedo + 3.5f * b * b);
}

// Most points have the albedos of the one before: with a boundary they take an integral.
class AlbedoInversion {
 public:
  float keeps(float albedo, float g, float tail, float ior) {
    Known& k = known_[next_];
    next_ = next_ == 2 ? 0 : next_ + 1;
    if (k.albedo != albedo || k.g != g || k.tail != tail || k.ior != ior)
      k = {albedo, g, tail, ior, singleScatteringAlbedo(albedo, g, tail, ior)};
    return k.keeps;
  }

 private:
  struct Known {
    float albedo = -1, g = 0, tail = 0, ior = 0, keeps = 0;
  };
  Known known_[3];  // by channel
  int next_ = 0;
};

inline void describeSubsurface(const Context& c, const SubsurfaceClosure& k, Subsurface& out) {
  const auto at = [](const Value& v, uint32_t channel, uint32_t i) {
    const float x = v.components ? v.data[channel][v.stride ? i : 0] : 0.f;
    return x > 0 ? x : 0.f;  // nor NaN
  };
  const auto unit = [](float x) { return x < 1 ? x : 1.f; };
  out.model = k.model;
  out.traceSet = k.traceSet;
  out.joins = k.joins;
  out.comesOutBehind = k.comesOutBehind;
  const Value* const gain[] = {&k.gain, &k.shortGain, &k.longGain};
  const Value* const color[] = {&k.color, &k.shortColor, &k.longColor};
  const Value* const reach[] = {&k.reach, &k.shortReach, &k.longReach};
  const bool isSum = k.shortGain.components;
  out.terms = isSum ? 3 : 1;
  AlbedoInversion inversion;
  for (uint32_t i = 0; i < c.padded; ++i) {
    const float scale[3] = {at(k.reachColor, 0, i), at(k.reachColor, 1, i), at(k.reachColor, 2, i)};
    const float most = scale[0] > scale[1]   ? scale[0] > scale[2] ? scale[0] : scale[2]
                         : scale[1] > scale[2] ? scale[1]
                                             : scale[2];
    for (uint32_t n = 0; n < 3; ++n) {
      float sum = 0, part[3];
      for (uint32_t t = 0; t < out.terms; ++t)
        sum += part[t] = (isSum ? at(*gain[t], 0, i) : 1.f) * at(*color[t], n, i);
      out.surface[n][i] = sum;
      for (uint32_t t = 0; t < out.terms; ++t) {
        const float s = scale[n] > kShortestReach * most ? scale[n] : kShortestReach * most;
        const float length = at(*reach[t], 0, i) * s * k.unit;
        const SubsurfaceTerm& term = out.term[t];
        term.share[n][i] = sum > 0 ? part[t] / sum : t == 0 ? 1.f : 0.f;
        term.albedo[n][i] = unit(at(*color[t], n, i));
        float& reached = term.length[n][i];
        reached = length > 1e-6f ? length < kLongestReach ? length : kLongestReach : 1e-6f;
        if (k.areFlights && k.model == SubsurfaceModel::Burley) reached *= diffuseOverMeanFreePath(term.albedo[n][i]);
      }
    }
    const float ior = at(k.ior, 0, i);
    out.ior[i] = ior > 1 ? ior : 1.f;
    out.topology[i] = unit(at(k.topology, 0, i));
    if (k.model != SubsurfaceModel::Walk) continue;
    if (out.ior[i] > float(kMostIor)) out.ior[i] = float(kMostIor);
    float g = k.directionality.data[0][k.directionality.stride ? i : 0];
    g = g > -0.95f ? g < 0.95f ? g : 0.95f : g <= -0.95f ? -0.95f : 0.f;
    const float tail = k.heavyTails ? kMostTail * unit(at(k.bleed, 0, i)) : 0.f;
    out.anisotropy[i] = g;
    out.tail[i] = tail;
    for (uint32_t n = 0; n < 3; ++n) {
      const float albedo = inversion.keeps(out.term[0].albedo[n][i], g, tail, out.ior[i]);
      out.albedo[n][i] = albedo;
      const float reached = out.term[0].length[n][i];
      out.length[n][i] = k.areFlights ? reached : meanFreePath(reached, albedo, g);
    }
  }
}

inline void describeSingle(const Context& c, const SingleClosure& k, SingleScatter& out) {
  const auto at = [](const Value& v, uint32_t channel, uint32_t i) { return v.data[channel][v.stride ? i : 0]; };
  out.traceSet = k.traceSet;
  out.mostPassed = k.mostPassed;
  out.skipsGaps = k.skipsGaps;
  for (uint32_t i = 0; i < c.padded; ++i) {
    for (uint32_t n = 0; n < 3; ++n) {
      const float length = at(k.reach, 0, i) * at(k.reachColor, n, i) * k.unit;
      out.length[n][i] = length > 1e-6f ? length < kLongestReach ? length : kLongestReach : 1e-6f;
    }
    const float g = at(k.directionality, 0, i), ior = at(k.ior, 0, i);
    out.anisotropy[i] = g > -0.95f ? g < 0.95f ? g : 0.95f : g <= -0.95f ? -0.95f : 0.f;
    out.ior[i] = ior > 1 ? ior : 1.f;
    const float blur = at(k.blur, 0, i), rough = blur > 0 ? blur < 1 ? blur : 1.f : 0.f;
    out.alpha[i] = rough * rough;
  }
}

}  // namespace kinora::lobes
