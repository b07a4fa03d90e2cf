// Where rays that leave surfaces start. Included per target.
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

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
