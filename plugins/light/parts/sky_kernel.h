// Directions of a light that shines from all around, from render space to the light's own and back, by its axes
// (sky_axes.h). Included per target, behind light_author.h.
#if defined(KINORA_SKY_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_SKY_KERNEL_H_TARGET
#undef KINORA_SKY_KERNEL_H_TARGET
#else
#define KINORA_SKY_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
KN_INLINE Vec3<W> toSky(const Float3 axis[3], Vec3<W> d) {
  return {dot(d, wide<W>(axis[0])), dot(d, wide<W>(axis[1])), dot(d, wide<W>(axis[2]))};
}
template <int W>
KN_INLINE Vec3<W> fromSky(const Float3 axis[3], Vec3<W> l) {
  return fma(wide<W>(axis[0]), l.x, fma(wide<W>(axis[1]), l.y, wide<W>(axis[2]) * l.z));
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
