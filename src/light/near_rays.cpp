// Kernel of near_rays.h.
#define KINORA_KERNEL_FILE "light/near_rays.cpp"
#include "light/near_rays.h"
#include "simd/dispatch.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"

KINORA_KERNELS_BEGIN
using light::NearRaysArgs;

template <int W>
uint32_t nearRays(const NearRaysArgs& a) {
  using F = Float<W>;
  const Rays& r = *a.rays;
  const Vec3<W> center(F(a.center[0]), F(a.center[1]), F(a.center[2]));
  uint32_t found = 0;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Mask<W> in = Mask<W>::firstN(int(a.n - i < W ? a.n - i : W));
    const Slots<W> slot = Slots<W>::loadUpTo(a.slots + i, a.n - i);
    const F hit = slot.get(a.tHit);
    Mask<W> is = in;
    if (a.infinite) is = is & (hit > F(3.4e38f));
    if (is.none()) continue;
    const Vec3<W> o = Vec3<W>::get(r.o, slot), d = Vec3<W>::get(r.d, slot);
    if (!a.infinite) {
      const Vec3<W> p = center - o;
      const F along = dot(p, d), p2 = dot(p, p);
      // difference of near numbers: widen by what rounding may take
      const Mask<W> past =
          (p2 - along * along > F(a.radius2) + F(1e-5f) * p2) | ((along < F(0.f)) & (p2 > F(a.radius2)));
      is = is & !past;
      if (is.none()) continue;
    }
    const Packer<W> pack(is);
    o.pack(pack, a.o, found);
    d.pack(pack, a.d, found);
    pack.put(slot.get(r.time), a.time + found);
    pack.put(min(hit, slot.get(r.tMax)), a.t + found);
    pack.put(Int<W>::lanes(int32_t(i)), a.which + found);
    found += uint32_t(pack.count);
  }
  return found;
}

KN_POINTERS(kNearRays, nearRays)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::light {
NearRaysKernel nearRaysKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kNearRays); }
}  // namespace kinora::light
#endif
