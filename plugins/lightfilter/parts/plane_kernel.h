// Evaluates plane.h at lit points. Included per target.
#include "plugins/lightfilter/parts/filter_kernels.h"

#if defined(KINORA_PLANE_KERNEL_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PLANE_KERNEL_H_TARGET
#undef KINORA_PLANE_KERNEL_H_TARGET
#else
#define KINORA_PLANE_KERNEL_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

template <int W>
struct OnPlane {
  Float<W> x, y;
  Float<W> behind;  // how far behind the plane the lit point lies; before it where negative
  Mask<W> met;      // the light comes to the point from the plane's other side, or would from before it
  KN_INLINE OnPlane() {}
};

template <int W>
KN_INLINE OnPlane<W> onPlane(const filterParts::Plane& k, const LitPoint<W>& p) {
  using F = Float<W>;
  const Vec3<W> at = placeIn<W>(k.space, p.P);
  OnPlane<W> r;
  r.behind = at.z;
  if (k.physical) {
    const Vec3<W> d = directionIn<W>(k.space, p.wi);
    r.met = d.z < F(-1e-12f);
    const F t = -at.z / min(d.z, F(-1e-12f));
    r.x = fma(d.x, t, at.x);
    r.y = fma(d.y, t, at.y);
  } else if (k.directional) {
    r.met = Mask<W>(true);
    r.x = fnma(at.z, F(k.along.x), at.x);
    r.y = fnma(at.z, F(k.along.y), at.y);
  } else {
    const Vec3<W> c = wide<W>(k.centre), from = at - c;
    r.met = from.z > F(1e-6f);
    const F s = -c.z / max(from.z, F(1e-6f));
    r.x = fma(from.x, s, c.x);
    r.y = fma(from.y, s, c.y);
  }
  return r;
}

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#endif
