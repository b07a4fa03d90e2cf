// Where a direction stands in a dome's latitude-longitude map; see PxrDomeLight for the orientation. Included per
// target, behind light_author.h.
#include <kinora/math/sampling.h>

#if defined(KINORA_DOME_MAP_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_DOME_MAP_H_TARGET
#undef KINORA_DOME_MAP_H_TARGET
#else
#define KINORA_DOME_MAP_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Place in the map of a unit direction in the dome's frame; the polar angle by atan2, since acos loses digits at the
// poles.
template <int W>
KN_INLINE void toDomeMap(Vec3<W> l, Float<W>& u, Float<W>& v) {
  using F = Float<W>;
  u = atan2(l.y, l.x) * F(-kInvTwoPi);
  u = select(u < F(0.f), u + F(1.f), u);
  v = atan2(sqrt(fma(l.x, l.x, l.y * l.y)), l.z) * F(kInvPi);
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
