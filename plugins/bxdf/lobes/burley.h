// The diffuse reflection of Burley, "Physically-Based Shading at Disney" (SIGGRAPH course 2012): Lambert's with half of
// Schlick's Fresnel factor on the way in and out, plus retroreflection at grazing angles that grows with roughness. The
// sum of the two that "Extending the Disney BRDF to a BSDF" (2015) writes apart is the same. Included per target.
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lobes/specular.h"

#if defined(KINORA_LOBES_BURLEY_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_BURLEY_H_TARGET
#undef KINORA_LOBES_BURLEY_H_TARGET
#else
#define KINORA_LOBES_BURLEY_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Without the cosine. twiceCosD2: twice the squared cosine between a direction and the half vector.
template <int W>
KN_INLINE Float<W> burleyDiffuse(Float<W> roughness, Float<W> muO, Float<W> muI, Float<W> twiceCosD2) {
  using F = Float<W>;
  const F more = fma(twiceCosD2, roughness, F(-0.5f));  // F_D90 - 1
  return fma(more, schlickWeight(muO), F(1.f)) * fma(more, schlickWeight(muI), F(1.f)) * F(kInvPi);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
