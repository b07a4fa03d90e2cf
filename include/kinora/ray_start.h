// Where rays that leave surfaces start, and how wide they get. Included per target.
#include <kinora/math/sampling.h>
#include <kinora/simd/wide.h>

#if defined(KINORA_RAY_START_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_RAY_START_H_TARGET
#undef KINORA_RAY_START_H_TARGET
#else
#define KINORA_RAY_START_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Where a ray that leaves a surface starts: off the plane by the bias, on the side it goes to.
template <int W>
KN_INLINE Vec3<W> leave(Vec3<W> P, Vec3<W> Ng, Float<W> bias, Vec3<W> direction) {
  return fma(Ng, copySign(bias, dot(Ng, direction)), P);
}

// Footprint growth after a bounce: a direction of density pdf stands for the solid angle 1 / pdf; a quarter of that
// cone's radius keeps neighbouring paths' footprints overlapping (path differentials collapsed to a radius).
template <int W>
KN_INLINE Float<W> spreadAfter(Float<W> spread, Float<W> pdf) {
  const Float<W> cone = Float<W>(0.25f) / sqrt(max(pdf * Float<W>(kPi), Float<W>(0.25f)));
  return max(spread, cone);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
