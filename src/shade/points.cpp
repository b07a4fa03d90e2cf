// Kernels of points.h.
#define KINORA_KERNEL_FILE "shade/points.cpp"
#include "shade/points.h"
#include "simd/dispatch.h"
#include "trace/world.h"
#include <kinora/simd/foreach_target.h>
#include "simd/kernel_widths.h"

KINORA_KERNELS_BEGIN
using shade::PointsArgs;

template <int W>
void points(const PointsArgs& a) {
  using F = Float<W>;
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> slot = Slots<W>::load(a.slots + i);
    const Vec3<W> o = Vec3<W>::get(a.o, slot), d = Vec3<W>::get(a.d, slot);
    const F t = a.isRecord ? F(0.f) : slot.get(a.t);
    const Vec3<W> p = a.isRecord ? o : fma(d, t, o);
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
    Mask<W> flat(true);
    if (a.smooth[0]) {
      const Vec3<W> given = Vec3<W>::load(a.smooth, i);
      flat = dot(given, given) == F(0.f);
      n = select(flat, n, given);
    }
    n = select(behind, -n, n);
    ng = select(behind, -ng, ng);
    if (a.smooth[0]) {
      // an interpolated normal may point away from the facet's side, or from wo near silhouettes: bend it
      n = select(dot(n, ng) < F(1e-3f), ng, n);
      const F c = dot(n, wo);
      const Vec3<W> bent = fma(wo, F(1e-3f) - c, n);
      n = select((c < F(1e-3f)) & !flat, normalize(bent), n);
    }
    n.store(a.N, i);
    ng.store(a.Ng, i);
    select(behind, Int<W>(0), Int<W>(-1)).store(a.entering + i);
    const F spread = slot.get(a.spread);
    const F radius = slot.get(a.radius);
    (a.isRecord ? radius : fma(spread, t, radius)).store(a.outRadius + i);
    spread.store(a.outSpread + i);
    slot.get(a.time).store(a.outTime + i);
    slot.get(a.seed).store(a.outSeed + i);
    slot.get(a.index).store(a.outIndex + i);
    // distance by which rays start off the surface: the hit point's error is a few ulps of the numbers it came from
    const F size = max(max(abs(p.x), max(abs(p.y), abs(p.z))), F::load(a.reach + i));
    (size * F(4e-6f) + F(1e-7f)).store(a.bias + i);
  }
}

using trace::Instance;

// trace::World::infoOf() of hits.
template <int W>
KN_INLINE Int<W> infoOf(const shade::SurfaceTables& t, Int<W> instance, Int<W> geometry) {
  return gather(t.instances, instance * Int<W>(int32_t(Instance::kWords)) + Int<W>(int32_t(Instance::kInfoWord))) +
         gather(t.infoSteps, geometry);
}

template <int W>
void programs(const shade::ProgramsArgs& a) {
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> slot = Slots<W>::loadUpTo(a.slots + i, a.n - i);
    const Int<W> info = infoOf(*a.tables, slot.get(a.instance), slot.get(a.geometry));
    const Int<W> m = gather(a.tables->materialOfInfo.data(), info);
    gather(a.tables->programOfMaterial.data(), m).store(a.program + i);
  }
}

template <int W>
void surfaces(shade::SurfacesArgs& a) {
  const shade::SurfaceTables& t = *a.tables;
  Int<W> flags(0), baked(-1);
  for (uint32_t i = 0; i < a.n; i += W) {
    const Slots<W> slot = Slots<W>::load(a.slots + i);
    const Int<W> instance = slot.get(a.instance), geometry = slot.get(a.geometry);
    const Int<W> info = infoOf(t, instance, geometry);
    gather(t.blockOfMaterial.data(), gather(t.materialOfInfo.data(), info)).store(a.block + i);
    gather(t.sideOfGeometry.data(), geometry).store(a.side + i);
    Vec3<W>::get(a.ng, slot).store(a.outNg, i);
    instance.store(a.outInstance + i);
    geometry.store(a.outGeometry + i);
    slot.get(a.primitive).store(a.outPrimitive + i);
    slot.get(a.level).store(a.outLevel + i);
    slot.get(a.origin).store(a.outOrigin + i);
    slot.get(a.u).store(a.outU + i);
    slot.get(a.v).store(a.outV + i);
    slot.get(a.t).store(a.outT + i);
    slot.get(a.time).store(a.outTime + i);
    flags = flags | gather(t.flagsOfGeometry.data(), geometry);
    baked = baked &
            gather(t.instances, instance * Int<W>(int32_t(Instance::kWords)) + Int<W>(int32_t(Instance::kFlagsWord)));
    if (a.linkSet) gather(t.linkSetOfInfo.data(), info).store(a.linkSet + i);
  }
  alignas(64) uint32_t f[W], b[W];
  flags.store(f);
  baked.store(b);
  a.anyFlags = a.anyPlaced = 0;
  for (int k = 0; k < W; ++k) {
    a.anyFlags |= f[k];
    a.anyPlaced |= ~b[k] & Instance::kBakedBit;
  }
}

KN_POINTERS(kPrograms, programs)
KN_POINTERS(kSurfaces, surfaces)
KN_POINTERS(kPoints, points)
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade {
ProgramsKernel programsKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kPrograms); }
SurfacesKernel surfacesKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kSurfaces); }
PointsKernel pointsKernel(uint32_t width) { return *KN_PICK_WIDTH(width, kPoints); }
}  // namespace kinora::shade
#endif
