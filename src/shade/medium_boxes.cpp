// Kernels of medium_boxes.h: the part of a line between three pairs of planes (Kay and Kajiya 1986).
#define KINORA_KERNEL_FILE "shade/medium_boxes.cpp"
#include "shade/medium_boxes.h"

#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"
#include <kinora/simd/wide.h>

KINORA_KERNELS_BEGIN

template <int W>
KN_INLINE void cross(const shade::BoxCrossingArgs& a) {
  using F = Float<W>;
  const F zero(0.f), none(1e30f);
  const float(&m)[3][3] = a.toBox.m;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> s = Slots<W>::loadUpTo(a.entries + i, a.n - i);
    const Vec3<W> o = Vec3<W>::get(a.o, s), d = Vec3<W>::get(a.d, s);
    F from = -none, to = none;
    for (int k = 0; k < 3; ++k) {
      const F place = fma(o.x, F(m[k][0]), fma(o.y, F(m[k][1]), fma(o.z, F(m[k][2]), F(a.toBox.t[k]))));
      const F step = fma(d.x, F(m[k][0]), fma(d.y, F(m[k][1]), d.z * F(m[k][2])));
      const F low = F(a.low[k]) - place, high = F(a.high[k]) - place;
      // along the planes a line lies between them all the way, or nowhere
      const Mask<W> isAcross = step != zero, isBetween = (low <= zero) & (high >= zero);
      const F inverse = F(1.f) / select(isAcross, step, F(1.f)), first = low * inverse, last = high * inverse;
      from = max(from, select(isAcross, min(first, last), select(isBetween, -none, none)));
      to = min(to, select(isAcross, max(first, last), select(isBetween, none, -none)));
    }
    from.store(a.from + i);
    to.store(a.to + i);
  }
}

KN_POINTERS(kCross, cross)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade {

BoxCrossingKernel boxCrossingKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kCross); }

}  // namespace kinora::shade
#endif
