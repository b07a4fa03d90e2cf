// The parts of PxrDisney that are no microfacets of the usual kind: diffuse with its retroreflection, the flattened
// shape that stands for subsurface scattering, sheen, and the clear coat. All after Burley, "Physically-Based Shading
// at Disney" (SIGGRAPH course 2012). Values without sampling state, but the coat's. Included per target.
#include <kinora/math/sampling.h>

#if defined(KINORA_PXRDISNEY_BASE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_PXRDISNEY_BASE_H_TARGET
#undef KINORA_PXRDISNEY_BASE_H_TARGET
#else
#define KINORA_PXRDISNEY_BASE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Schlick's weight: (1 - cos)^5.
template <int W>
KN_INLINE Float<W> schlickWeight(Float<W> cosine) {
  const Float<W> x = clamp(Float<W>(1.f) - cosine, Float<W>(0.f), Float<W>(1.f)), x2 = x * x;
  return x2 * x2 * x;
}

// Without the cosine. cosD: cosine between a direction and the half vector.
template <int W>
KN_INLINE Float<W> disneyDiffuse(Float<W> roughness, Float<W> muO, Float<W> muI, Float<W> cosD) {
  using F = Float<W>;
  const F more = fma(F(2.f) * cosD * cosD, roughness, F(-0.5f));  // F_D90 - 1
  return fma(more, schlickWeight(muO), F(1.f)) * fma(more, schlickWeight(muI), F(1.f)) * F(kInvPi);
}
// After Hanrahan and Krueger's isotropic scattering (SIGGRAPH 1993).
template <int W>
KN_INLINE Float<W> disneyFlat(Float<W> roughness, Float<W> muO, Float<W> muI, Float<W> cosD) {
  using F = Float<W>;
  const F more = fma(cosD * cosD, roughness, F(-1.f));  // F_SS90 - 1
  const F f = fma(more, schlickWeight(muO), F(1.f)) * fma(more, schlickWeight(muI), F(1.f));
  const F sum = max(muO + muI, F(1e-6f));
  return F(1.25f * kInvPi) * fma(f, F(1.f) / sum - F(0.5f), F(0.5f));
}

// The coat: normals after Trowbridge and Reitz with exponent 1, whose tail is long, masking of a fixed GGX alpha 0.25
// and a quarter of a dielectric's reflectance of 0.04. It is left without compensation: light that meets the coat
// twice is below 0.001 of what arrives (0.25 times the average reflectance squared, 0.008, times what masking takes).
template <int W>
struct CoatLobe {
  using F = Float<W>;
  F alpha2, logAlpha2, norm;
  KN_INLINE CoatLobe() {}
  KN_INLINE explicit CoatLobe(F gloss) {
    const F alpha = lerp(F(0.1f), F(0.001f), clamp(gloss, F(0.f), F(1.f)));
    alpha2 = alpha * alpha;
    logAlpha2 = log(alpha2);
    norm = (alpha2 - F(1.f)) / (F(kPi) * logAlpha2);
  }
  static KN_INLINE F fresnel(F cosine) { return fma(F(0.96f), schlickWeight(cosine), F(0.04f)); }
  // h local and unit: alpha^2 cos^2 + sin^2 keeps its digits where the highlight is narrow
  KN_INLINE F density(Vec3<W> h) const {
    const F s2 = fma(h.x, h.x, h.y * h.y);
    return norm / max(fma(alpha2, h.z * h.z, s2), F(1e-12f));
  }
  // G / (2 cos), one direction's
  static KN_INLINE F masking(F mu) {
    constexpr float a2 = 0.25f * 0.25f;
    return F(1.f) / (mu + sqrt(fma(mu * mu, F(1.f - a2), F(a2))));
  }
  // Half vector with density(h) * h.z.
  KN_INLINE Vec3<W> sample(F u, F v) const {
    const F s2 = clamp((exp((F(1.f) - u) * logAlpha2) - alpha2) / (F(1.f) - alpha2), F(0.f), F(1.f));
    const F r = sqrt(s2);
    F s, c;
    sincos(v * F(kTwoPi), s, c);
    return {r * c, r * s, sqrt(max(F(1.f) - s2, F(0.f)))};
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
