// Evaluates rod.h at lit points. Included per target.
#include "plugins/lightfilter/parts/filter_kernels.h"

#if defined(KINORA_ROD_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_ROD_KERNEL_H_TARGET
#undef KINORA_ROD_KERNEL_H_TARGET
#else
#define KINORA_ROD_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Rgb<W> rodFactor(const filterParts::Rod& k, const LitPoint<W>& p) {
  using F = Float<W>;
  const Vec3<W> at = placeIn<W>(k.space, p.P);
  Vec3<W> outside, soft;
  outside.x = outsideOf<W>(at.x, k.low[0], k.high[0], k.softLow[0], k.softHigh[0], soft.x);
  outside.y = outsideOf<W>(at.y, k.low[1], k.high[1], k.softLow[1], k.softHigh[1], soft.y);
  outside.z = outsideOf<W>(at.z, k.low[2], k.high[2], k.softLow[2], k.softHigh[2], soft.z);
  const F t = intoEdge<W>(outside, soft, F(k.radius));
  const F unfiltered = clamp(rampAt<W>(k.falloff.ramp, t).x, F(0.f), F(1.f));
  F within = select(t <= F(0.f), F(1.f), select(t >= F(1.f), F(0.f), F(1.f) - unfiltered));
  if (k.inverted) within = F(1.f) - within;
  return filtered<W>(saturated<W>(rampAt<W>(k.color.ramp, t) * F(k.intensity), k.saturation), within * F(k.density));
}

// What the filters of such a region are.
struct RodFilter {
  using Data = filterParts::Rod;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    return rodFactor<W>(k, p);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
