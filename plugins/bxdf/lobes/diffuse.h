// Diffuse reflection and fuzz: values without sampling state. Included per target.
#include <kinora/math/sampling.h>

#if defined(KINORA_LOBES_DIFFUSE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_DIFFUSE_H_TARGET
#undef KINORA_LOBES_DIFFUSE_H_TARGET
#else
#define KINORA_LOBES_DIFFUSE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Energy-preserving Oren-Nayar: Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF"
// (JCGT 2025): Fujii's form of single scattering plus a lobe that returns what it loses, in the colour of two and
// more reflections. The albedo is the colour where that is 0 or 1, at every angle; roughness 0 is exactly Lambert's.
template <int W>
struct RoughDiffuse {
  using F = Float<W>;
  F roughness, scale, mean;  // scale: A of the paper; mean: average directional albedo of the single-scattering part
  KN_INLINE RoughDiffuse() {}
  KN_INLINE explicit RoughDiffuse(F r) : roughness(clamp(r, F(0.f), F(1.f))) {
    scale = F(1.f) / fma(roughness, F(0.5f - 2.f / (3.f * kPi)), F(1.f));
    mean = scale * fma(roughness, F(2.f / 3.f - 28.f / (15.f * kPi)), F(1.f));
  }
  // Directional albedo of the single-scattering part: the paper's polynomial, within 0.1 %.
  KN_INLINE F energy(F mu) const {
    const F c = F(1.f) - mu;
    F g = fma(c, F(0.0714429953f), F(-0.332181442f));
    g = fma(c, g, F(0.491881867f));
    g = c * fma(c, g, F(0.0571085289f));
    return scale * fma(roughness, g, F(1.f));
  }
  // Without the cosine.
  KN_INLINE Rgb<W> evaluate(Rgb<W> color, F muO, F muI, F cosBetween) const {
    const F s = fnma(muI, muO, cosBetween);
    const F t = select(s > F(0.f), s / max(max(muI, muO), F(1e-7f)), s);
    const F single = scale * fma(roughness, t, F(1.f)) * F(kInvPi);
    const F lost = F(1.f) - mean;
    const F more =
        max(F(1.f) - energy(muO), F(0.f)) * max(F(1.f) - energy(muI), F(0.f)) / max(lost, F(1e-7f)) * F(kInvPi);
    return color * single + Rgb<W>(tint(color.x, lost), tint(color.y, lost), tint(color.z, lost)) * more;
  }

 private:
  KN_INLINE F tint(F c, F lost) const { return c * c * mean / max(fnma(c, lost, F(1.f)), F(1e-6f)); }
};

// Minnaert's law (1941), times what keeps the albedo seen face on: 1 for exponent 1. Reciprocal, never gains energy.
template <int W>
KN_INLINE Float<W> minnaert(Float<W> exponent, Float<W> muO, Float<W> muI) {
  using F = Float<W>;
  const F e = max(exponent, F(1.f));
  if ((e > F(1.f)).none()) return F(1.f);  // what the formula gives there, bit for bit
  return pow(muO * muI, e - F(1.f)) * F(0.5f) * (e + F(1.f));
}

// Fuzz: fibres standing along the normal reflect like Marschner's R lobe (SIGGRAPH 2003) with its inclinations
// measured from the surface: bright where both directions graze it, f ~ exp(-(cosO + cosI)^2 / (2 sigma^2)), sigma
// the cone angle. Scaled so that the albedo reaches 1 at grazing cosO and stays below elsewhere; reciprocal.
template <int W>
struct FuzzLobe {
  using F = Float<W>;
  F inverse2s2, range, scale;  // 1 / (2 sigma^2); 1 - exp(-that); 1 / (2 pi sigma^2 range)
  KN_INLINE FuzzLobe() {}
  KN_INLINE explicit FuzzLobe(F coneDegrees) {
    const F sigma = clamp(coneDegrees, F(0.5f), F(90.f)) * F(kPi / 180.f);
    inverse2s2 = F(0.5f) / (sigma * sigma);
    range = F(1.f) - exp(-inverse2s2);
    scale = inverse2s2 / (F(kPi) * range);
  }
  KN_INLINE F evaluate(F muO, F muI) const {  // without the cosine
    const F c = muO + muI;
    return scale * exp(-(c * c * inverse2s2));
  }
  KN_INLINE F pdf(F mu) const { return scale * mu * exp(-(mu * mu * inverse2s2)); }
  KN_INLINE Vec3<W> sample(F u, F v) const {
    const F z2 = min(-log(max(fnma(u, range, F(1.f)), F(1e-37f))) / inverse2s2, F(1.f));
    const F r = safeSqrt(F(1.f) - z2);
    F s, c;
    sincos(v * F(kTwoPi), s, c);
    return {r * c, r * s, sqrt(max(z2, F(0.f)))};
  }
  // Above the albedo at every angle, near it at small ones.
  KN_INLINE F albedoBound(F mu) const { return exp(-(mu * mu * inverse2s2)); }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
