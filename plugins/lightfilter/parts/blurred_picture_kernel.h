// Looks blurred_picture.h up. Included per target.
#include "plugins/lightfilter/parts/picture_kernel.h"

#if defined(KINORA_BLURRED_PICTURE_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_BLURRED_PICTURE_KERNEL_H_TARGET
#undef KINORA_BLURRED_PICTURE_KERNEL_H_TARGET
#else
#define KINORA_BLURRED_PICTURE_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// As pictureAt(); blur: of the widest, 0 to 1.
template <int W>
KN_INLINE Rgb<W> blurredAt(const filterParts::Picture& k, const filterParts::BlurredPicture& b, Mask<W> met,
                           Float<W> u, Float<W> v, Float<W> blur) {
  using F = Float<W>;
  const F half(0.5f), one(1.f);
  const F at = clamp(blur, F(0.f), one) * F(float(b.count));
  Rgb<W> sum;
  if ((met & (at < one)).any()) sum = pictureAt<W>(k, met, u, v) * max(one - at, F(0.f));
  u = fma(u - half, F(k.perScaleU), half) - F(k.offsetU);
  v = fma(v - half, F(k.perScaleV), half) + F(k.offsetV);
  u = clamp(u, F(-1e6f), F(1e6f));
  v = clamp(v, F(-1e6f), F(1e6f));
  if (k.tileMode == 2) {
    u = u - floor(u);
    v = v - floor(v);
  }
  for (int i = 0; i < b.count; ++i) {
    const F share = max(one - abs(at - F(float(i + 1))), F(0.f));
    if ((met & (share > F(0.f))).none()) continue;
    const filterParts::BlurredPicture::Copy& c = b.copy[i];
    // the edges of a copy are beyond what the blur reaches
    const F x = clamp(fma(u, F(c.perU), F(c.fromU)), F(0.f), one),
            y = clamp(fma(v, F(c.perV), F(c.fromV)), F(0.f), one);
    sum += lookUp<W, false>(c.map, x, y) * share;
  }
  return select(met, sum, Rgb<W>(F(k.fill[0]), F(k.fill[1]), F(k.fill[2])));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
