// Looks picture.h up. Included per target.
#include "plugins/lightfilter/parts/plane_kernel.h"

#if defined(KINORA_PICTURE_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PICTURE_KERNEL_H_TARGET
#undef KINORA_PICTURE_KERNEL_H_TARGET
#else
#define KINORA_PICTURE_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// u and v in the picture as it stands, v from its top. Must have a map.
template <int W>
KN_INLINE Rgb<W> pictureAt(const filterParts::Picture& k, Mask<W> met, Float<W> u, Float<W> v) {
  using F = Float<W>;
  const F half(0.5f), big(1e6f);
  u = fma(u - half, F(k.perScaleU), half) - F(k.offsetU);
  v = fma(v - half, F(k.perScaleV), half) + F(k.offsetV);
  u = clamp(u, -big, big);
  v = clamp(v, -big, big);
  Mask<W> within = met;
  if (k.tileMode == 0) within &= (u >= F(0.f)) & (u <= F(1.f)) & (v >= F(0.f)) & (v <= F(1.f));
  Rgb<W> c;
  if (k.tileMode == 2) {
    c = lookUp<W, true>(k.map, u - floor(u), fma(v - floor(v), F(k.vScale), F(k.vOffset)));
  } else {
    c = lookUp<W, false>(k.map, clamp(u, F(0.f), F(1.f)), clamp(v, F(0.f), F(1.f)));
  }
  return select(within, c, Rgb<W>(F(k.fill[0]), F(k.fill[1]), F(k.fill[2])));
}
// The same where the light goes through the plane: its place in the picture.
template <int W>
KN_INLINE Mask<W> placeOnPlane(const filterParts::Picture& k, const OnPlane<W>& at, Float<W>& u, Float<W>& v) {
  using F = Float<W>;
  u = fma(at.x, F(k.perWidth), F(0.5f));
  v = fnma(at.y, F(k.perHeight), F(0.5f));
  return at.met & (at.behind >= F(0.f));
}
template <int W>
KN_INLINE Rgb<W> pictureOnPlane(const filterParts::Picture& k, const OnPlane<W>& at) {
  Float<W> u, v;
  const Mask<W> met = placeOnPlane<W>(k, at, u, v);
  return pictureAt<W>(k, met, u, v);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
