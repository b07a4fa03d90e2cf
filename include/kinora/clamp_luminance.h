// Contributions of paths that are brighter than they may be keep their colour. Included per target.
#include <kinora/simd/wide.h>

#if defined(KINORA_CLAMP_LUMINANCE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CLAMP_LUMINANCE_H_TARGET
#undef KINORA_CLAMP_LUMINANCE_H_TARGET
#else
#define KINORA_CLAMP_LUMINANCE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// The factor that takes v to a luminance of at most `most`.
template <int W>
KN_INLINE Float<W> factorToLuminance(Vec3<W> v, Float<W> most) {
  const Float<W> l = Float<W>(0.2126f) * v.x + Float<W>(0.7152f) * v.y + Float<W>(0.0722f) * v.z;
  return select(l > most, most / max(l, Float<W>(1e-30f)), Float<W>(1.f));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
