// Kernel of points.h.
#define KINORA_KERNEL_FILE "shade/points.cpp"
#include "shade/points.h"
#include <kinora/simd/foreach_target.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using shade::PointsArgs;

template <int W>
void points(const PointsArgs& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Int<W> slot = Int<W>::load(a.slots + i);
    const Vec3<W> o = Vec3<W>::gather(a.o, slot), d = Vec3<W>::gather(a.d, slot);
    const F t = gather(a.t, slot);
    const Vec3<W> p = fma(d, t, o);
    p.store(a.P, i);
    const Vec3<W> wo = -d;
    wo.store(a.wo, i);
    const F side = F::load(a.side + i);
    Vec3<W> ng = Vec3<W>::load(a.ng, i);
    const F l2 = dot(ng, ng);
    ng = select(l2 > F(0.f), ng * (side / sqrt(max(l2, F(1e-38f)))), wo);
    // both normals follow the side that wo is on; `entering` keeps the original side
    const Mask<W> behind = dot(ng, wo) < F(0.f);
    Vec3<W> n = ng;
    if (a.smooth[0]) n = Vec3<W>::load(a.smooth, i);
    n = select(behind, -n, n);
    ng = select(behind, -ng, ng);
    if (a.smooth[0]) {
      // an interpolated normal may point away from the facet's side, or from wo near silhouettes: bend it
      n = select(dot(n, ng) < F(1e-3f), ng, n);
      const F c = dot(n, wo);
      const Vec3<W> bent = fma(wo, F(1e-3f) - c, n);
      n = select(c < F(1e-3f), normalize(bent), n);
    }
    n.store(a.N, i);
    ng.store(a.Ng, i);
    select(behind, Int<W>(0), Int<W>(-1)).store(a.entering + i);
    const F spread = gather(a.spread, slot);
    fma(spread, t, gather(a.radius, slot)).store(a.outRadius + i);
    spread.store(a.outSpread + i);
    gather(a.time, slot).store(a.outTime + i);
    gather(a.seed, slot).store(a.outSeed + i);
    gather(a.index, slot).store(a.outIndex + i);
    // distance by which rays start off the surface: the hit point's error is a few ulps of the numbers it came from
    const F size = max(max(abs(p.x), max(abs(p.y), abs(p.z))), t);
    (size * F(4e-6f) + F(1e-7f)).store(a.bias + i);
  }
}

#if HWY_TARGET == HWY_AVX2
[[maybe_unused]] void points1(const PointsArgs& a) { points<1>(a); }
[[maybe_unused]] void points4(const PointsArgs& a) { points<4>(a); }
[[maybe_unused]] void points8(const PointsArgs& a) { points<8>(a); }
#else
[[maybe_unused]] void points16(const PointsArgs& a) { points<16>(a); }
#endif
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora::shade {
PointsKernel pointsKernel(uint32_t width) {
  switch (width) {
    case 1: return &N_AVX2::points1;
    case 4: return &N_AVX2::points4;
    case 16: return &N_AVX3::points16;
    default: return &N_AVX2::points8;
  }
}
}  // namespace kinora::shade
#endif
