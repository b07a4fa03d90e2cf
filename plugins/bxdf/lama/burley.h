// The diffuse reflection of Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering"
// (SIGGRAPH course 2015): Lambert's with half of Schlick's Fresnel factor on the way in and out, plus retroreflection
// at grazing angles that grows with roughness. Included per target.
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lobes/specular.h"

#if defined(KINORA_LAMA_BURLEY_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LAMA_BURLEY_H_TARGET
#undef KINORA_LAMA_BURLEY_H_TARGET
#else
#define KINORA_LAMA_BURLEY_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Without the cosine. between: cosine of the angle between the two directions; the half angle's is R_R's.
template <int W>
KN_INLINE Float<W> burleyDiffuse(Float<W> roughness, Float<W> muO, Float<W> muI, Float<W> between) {
  using F = Float<W>;
  const F o = schlickWeight(muO), i = schlickWeight(muI);
  const F retro = roughness * max(between + F(1.f), F(0.f));  // 2 r cos^2 of the half angle
  const F lambert = fnma(F(0.5f), o, F(1.f)) * fnma(F(0.5f), i, F(1.f));
  return fma(retro, o + i + o * i * (retro - F(1.f)), lambert) * F(kInvPi);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
