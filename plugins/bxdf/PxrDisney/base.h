// The parts of PxrDisney: diffuse with its retroreflection, the flattened shape that stands for subsurface
// scattering, sheen, the specular lobe and the clear coat. All after Burley, "Physically-Based Shading at Disney"
// (SIGGRAPH course 2012). Included per target.
#include <kinora/math/microfacet.h>
#include "plugins/bxdf/lobes/burley.h"
#include "plugins/bxdf/lobes/specular.h"

#ifndef KINORA_PXRDISNEY_BASE_ONCE
#define KINORA_PXRDISNEY_BASE_ONCE
namespace kinora::pxrDisney {
// What the specular lobe returns of white light where Fresnel is 1, over roughness and the square root of the cosine:
// chooses techniques and tells the denoiser, so that the value for no anisotropy will do.
struct EnergyTable {
  static constexpr int kMu = 32, kRough = 32;
  float e[kRough][kMu];
};
}  // namespace kinora::pxrDisney
#endif

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

// Without the cosine. cosD: cosine between a direction and the half vector.
// After Hanrahan and Krueger's isotropic scattering (SIGGRAPH 1993).
template <int W>
KN_INLINE Float<W> disneyFlat(Float<W> roughness, Float<W> muO, Float<W> muI, Float<W> cosD) {
  using F = Float<W>;
  const F more = fma(cosD * cosD, roughness, F(-1.f));  // F_SS90 - 1
  const F f = fma(more, schlickWeight(muO), F(1.f)) * fma(more, schlickWeight(muI), F(1.f));
  const F sum = max(muO + muI, F(1e-6f));
  return F(1.25f * kInvPi) * fma(f, F(1.f) / sum - F(0.5f), F(0.5f));
}

// Smith's masking of one direction with the cosine mu, over 2 mu, for GGX normals of alpha^2 a2.
template <int W>
KN_INLINE Float<W> disneyMasking(Float<W> mu, Float<W> a2) {
  return Float<W>(1.f) / (mu + sqrt(fma(mu * mu, Float<W>(1.f) - a2, a2)));
}
// The course's masking is that of a rougher surface, without direction: alpha ((1 + roughness) / 2)^2.
template <int W>
KN_INLINE Float<W> disneyMaskingAlpha2(Float<W> roughness) {
  const Float<W> r = fma(roughness, Float<W>(0.5f), Float<W>(0.5f)), alpha = r * r;
  return alpha * alpha;
}

// The specular lobe: GGX normals, separable masking, Schlick's Fresnel from a face colour to white.
template <int W>
struct DisneySpecular {
  using F = Float<W>;
  Frame<W> frame;
  Vec3<W> wo;  // local
  F ax, ay;
  Mask<W> smooth;  // a mirror: never evaluated
  Rgb<W> face;

  KN_INLINE DisneySpecular() {}
  KN_INLINE DisneySpecular(const lobes::AnisotropyClosure& anisotropy, F roughness, Rgb<W> color, Vec3<W> normal,
                           const Surface<W>& s) {
    face = color;
    const F alpha = roughness * roughness, least(kMirrorAlpha);
    smooth = alpha < least;
    frame = anisotropicFrame(anisotropy, normal, s.at, max(alpha, least), ax, ay);
    ax = max(ax, least);
    ay = max(ay, least);
    wo = localOut(frame, s.wo);
    maskingAlpha2_ = disneyMaskingAlpha2(roughness);
    maskingO_ = disneyMasking(wo.z, maskingAlpha2_);
    lambdaO_ = smithLambda(true, wo, ax, ay);
    rough_ = TableAxis<W>(roughness, pxrDisney::EnergyTable::kRough);
  }
  KN_INLINE Rgb<W> fresnel(F cosine) const { return lerp(face, Rgb<W>(1.f), schlickWeight(cosine)); }
  // Of the mirror, which takes the course's masking too: highlights of roughness 0 and 0.05 are alike.
  KN_INLINE Rgb<W> mirror() const {
    const F g = F(2.f) * wo.z * maskingO_;
    return fresnel(wo.z) * (g * g);
  }
  // What light from a direction with the cosine mu is returned to all directions, Fresnel aside.
  KN_INLINE F energy(const pxrDisney::EnergyTable& table, F mu) const {
    const TableAxis<W> a(safeSqrt(mu), pxrDisney::EnergyTable::kMu);
    return tablePlane(&table.e[0][0], rough_.cell * Int<W>(pxrDisney::EnergyTable::kMu) + a.cell,
                      pxrDisney::EnergyTable::kMu, a.t, rough_.t);
  }
  // wi local, above; cosD: between a direction and h. Weight with cosine; pdfs of visible normals.
  KN_INLINE Rgb<W> evaluate(Vec3<W> wi, Vec3<W> h, F cosD, F& pdf, F& pdfReverse) const {
    const F muI = max(wi.z, F(1e-7f)), d = microfacetD(true, h, ax, ay);
    pdf = d * F(0.25f) / (wo.z * (F(1.f) + lambdaO_));
    pdfReverse = d * F(0.25f) / (muI * (F(1.f) + smithLambda(true, wi, ax, ay)));
    return fresnel(cosD) * (d * maskingO_ * disneyMasking(muI, maskingAlpha2_) * muI);
  }

 private:
  F maskingAlpha2_, maskingO_, lambdaO_;
  TableAxis<W> rough_;
};

// Set-up code, on 8 lanes always (microfacet.h).
inline void buildDisneyEnergy(pxrDisney::EnergyTable& table) {
  using F = Float<8>;
  constexpr int kMu = pxrDisney::EnergyTable::kMu, kRough = pxrDisney::EnergyTable::kRough;
  for (int r = 0; r < kRough; ++r)
    for (int i = 0; i < kMu; ++i) {
      const F roughness(float(r) / float(kRough - 1)), alpha = max(roughness * roughness, F(kMirrorAlpha));
      const F a2 = disneyMaskingAlpha2(roughness);
      const Vec3<8> wo = tableDirection(i, kMu);
      const F out = F(2.f) * wo.z * disneyMasking(F(wo.z), a2), seen = F(1.f) + smithLambda(true, wo, alpha, alpha);
      F sum(0.f);
      for (int k = 0; k < kLatticeSize; k += 8) {
        const LatticePoint p(k);
        const Vec3<8> wi = reflect(wo, sampleVisibleNormal(wo, alpha, alpha, p.u, p.v));
        const F mu = max(wi.z, F(1e-7f));
        sum += zeroUnless(wi.z > F(0.f), out * seen * F(2.f) * mu * disneyMasking(mu, a2));
      }
      table.e[r][i] = sumLanes(sum) / float(kLatticeSize);
    }
}
inline const pxrDisney::EnergyTable& disneyEnergyTable() {
  return builtTable<pxrDisney::EnergyTable, buildDisneyEnergy>();
}

// The coat: normals after Trowbridge and Reitz with exponent 1, whose tail is long, masking of a fixed GGX alpha 0.25
// and a quarter of a dielectric's reflectance of 0.04.
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
  static KN_INLINE F masking(F mu) { return disneyMasking(mu, F(0.25f * 0.25f)); }
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
