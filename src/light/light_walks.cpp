// LightSet: what manifold walks go to, and what they find there.
#include <algorithm>

#include "light/light_set_order.h"

namespace kinora::light {

void LightSet::walkTargets(uint32_t width, Arena& arena, uint32_t n, const float* const u[5], const float* time,
                           WalkTargets* out) const {
  const uint32_t room = padded(n) + kPad;
  const auto floats = [&] {
    float* x = arena.make<float>(room);
    std::fill_n(x, room, 0.f);
    return x;
  };
  out->light = arena.make<uint32_t>(room);
  out->flags = arena.make<uint32_t>(room);
  std::fill_n(out->light, room, kNoLight);
  std::fill_n(out->flags, room, 0u);
  for (int c = 0; c < 3; ++c) {
    out->to[c] = floats();
    out->N[c] = floats();
  }
  out->pdf = floats();
  if (walkedTo_.empty() || !n) return;
  uint32_t* chosen = arena.make<uint32_t>(room);
  for (uint32_t i = 0; i < padded(n); ++i) {
    const float choice = u[0][std::min(i, n - 1)];
    chosen[i] = uint32_t(
        std::min<size_t>(size_t(std::upper_bound(walkedTo_.begin(), walkedTo_.end(), choice) - walkedTo_.begin()),
                         walkedTo_.size() - 1));
  }
  float *d[3], *radiance[3], *pdfDirection = floats();
  for (int c = 0; c < 3; ++c) {
    d[c] = floats();
    radiance[c] = floats();
  }
  emitFrom(width, arena, n, chosen, u + 1, time, {out->to, d, out->N, radiance, out->pdf, pdfDirection});
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t light = chosen[i];
    out->light[i] = light;
    out->flags[i] = endFlags(light);
    const bool isInfinite = out->flags[i] & kLightIsInfinite, isDelta = out->flags[i] & kLightIsDelta;
    const float choice = walkedTo_[light] - (light ? walkedTo_[light - 1] : 0.f);
    // an emitted ray has both densities; a place has its own
    const float pdf = isInfinite ? pdfDirection[i] : out->pdf[i];
    out->pdf[i] = pdf > 0 ? choice * (isDelta ? 1.f : pdf) : 0.f;
    for (int c = 0; c < 3; ++c) {
      if (isInfinite) out->to[c][i] = -d[c][i];
      if (isInfinite || isDelta) out->N[c][i] = 0;
    }
  }
}

void LightSet::deltaLights(uint32_t width, Arena& arena, uint32_t n, const float* const P[3], const float* time,
                           const uint32_t* light, const uint32_t* linkSet, float* const radiance[3],
                           float* specular) const {
  if (!n) return;
  const uint32_t room = padded(n) + kPad;
  const auto floats = [&] { return arena.make<float>(room); };
  float* middle = floats();
  std::fill_n(middle, room, 0.5f);
  float *wi[3] = {floats(), floats(), floats()}, *distance = floats(), *pdf = floats();
  uint32_t* flags = arena.make<uint32_t>(room);
  std::fill_n(flags, room, 0u);
  float* const outputs[8] = {wi[0], wi[1], wi[2], distance, radiance[0], radiance[1], radiance[2], pdf};
  const float* const u[2] = {middle, middle};
  askSamples(width, arena, n, light, P, time, u, outputs, flags);
  if (!filters_.empty())
    filterRadiance(width, arena, n, light, P, wi, distance, time, linkSet, radiance, FilterUse::LitPoints, true);
  for (uint32_t i = 0; i < n; ++i) {
    specular[i] = recordOf(light[i]).specular;
    if (!(flags[i] & kSampleDelta) || !(pdf[i] > 0))
      for (int c = 0; c < 3; ++c) radiance[c][i] = 0;
  }
}

}  // namespace kinora::light
