// Bumps that lean towards a light are lit brightly until the surface under them sees it no more: the light ends on a line
// across them. What they return is faded towards that line (Chiang, Li and Burley, "Taming the Shadow Terminator", SIGGRAPH
// Talks 2019). The surface is the smooth one, of its own normals: what polygons do to those is another matter, of shadow
// rays. Included per target.
#include <kinora/bxdf_author.h>

#if defined(KINORA_LOBES_BUMP_SHADOWING_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_BUMP_SHADOWING_H_TARGET
#undef KINORA_LOBES_BUMP_SHADOWING_H_TARGET
#else
#define KINORA_LOBES_BUMP_SHADOWING_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Factor on what is reflected: 1 where the bump does not lean towards the light, 0 where the surface does not see it.
// All unit vectors; the light's is where light comes from, whichever way the path goes.
template <int W>
KN_INLINE Float<W> bumpShadowing(const Vec3<W>& smooth, const Vec3<W>& bumped, const Vec3<W>& light) {
  using F = Float<W>;
  const F one(1.f), cosine = dot(bumped, light) * dot(smooth, bumped);
  const F g = clamp(dot(smooth, light) / max(cosine, F(1e-6f)), F(0.f), one);
  return g * fma(g, one - g, one);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
