// Glass: a rough or clear dielectric boundary, or a thin sheet, at W points. Single scattering is
// Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007) with GGX; what it loses is
// returned by a diffuse pair of lobes after Kulla and Conty (SIGGRAPH course 2017). All values here are shares of
// power, without the factor eta^2 of radiance: the caller multiplies by radianceScale. Included per target.
#include "closure.h"
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>

#if defined(KINORA_LOBES_GLASS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_GLASS_H_TARGET
#undef KINORA_LOBES_GLASS_H_TARGET
#else
#define KINORA_LOBES_GLASS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// Shares of power that one scattering reflects, transmits and loses, for a direction.
template <int W>
struct GlassShares {
  Float<W> reflect, transmit, lost;
  Float<W> fit;  // in `transmit`; see GlassLobe::fitOf
  KN_INLINE GlassShares() {}
};

// Densities of the two techniques that make facets, and with the directions exchanged.
template <int W>
struct GlassPdfs {
  Float<W> first, second, firstReverse, secondReverse;
  KN_INLINE GlassPdfs() {}
};

template <int W>
struct GlassLobe {
  using F = Float<W>;
  Frame<W> frame;
  Vec3<W> wo;  // local
  F axReflect, ayReflect, axTransmit, ayTransmit;
  Mask<W> smoothReflect, smoothTransmit;
  F eta;  // ior on wo's side / ior behind
  F radianceScale;
  F reflectGain, transmitMean;  // transmitMean: average of transmitColor
  Rgb<W> reflectTint;           // of average 1; 1 1 1 where the closure is not tinted
  Rgb<W> transmitColor;
  Mask<W> encloses;  // there is a medium behind
  bool thin;

  KN_INLINE GlassLobe() {}
  KN_INLINE void set(const lobes::GlassClosure& k, const GlassEnergy* glass, const ReflectionEnergy* reflection,
                     bool radiance, Vec3<W> normal, const Surface<W>& s) {
    thin = k.thin;
    glass_ = glass;
    reflection_ = reflection;
    const F inside = max(loadFloat<W>(k.ior, s.at), F(1e-3f)), outside = max(s.outerIor, F(1e-3f));
    eta = thin ? outside / inside : select(s.entering, outside / inside, inside / outside);
    const F larger = max(eta, F(1.f) / eta);
    // so near the indices' match half vectors lose their digits, and light passes straight to a hundredth of a radian
    const Mask<W> matched = thin ? Mask<W>(false) : larger < F(1.01f);
    const F r = clamp(loadFloat<W>(k.roughness, s.at), F(0.f), F(1.f)),
            own = loadFloat<W>(k.refractionRoughness, s.at);
    const F t = select(own < F(0.f), r, min(own, F(1.f)));
    differs_ = thin ? Mask<W>(false) : t != r;
    smoothReflect = matched | (r * r < F(kMirrorAlpha));
    smoothTransmit = matched | (t * t < F(kMirrorAlpha));
    frame = anisotropicFrame(k.anisotropy, normal, s.at, max(r * r, F(kMirrorAlpha)), axReflect, ayReflect);
    anisotropicFrame(k.anisotropy, normal, s.at, max(t * t, F(kMirrorAlpha)), axTransmit, ayTransmit);
    wo = localOut(frame, s.wo);
    lambdaReflect_ = smithLambda(true, wo, axReflect, ayReflect);
    lambdaTransmit_ = smithLambda(true, wo, axTransmit, ayTransmit);
    reflectGain = loadFloat<W>(k.reflectionGain, s.at);
    reflectTint = Rgb<W>(1.f);
    if (k.tinted) {
      const Rgb<W> color = loadRgb<W>(k.reflectionColor, s.at);
      const F shade = max(average(color), F(0.f));
      reflectTint = color * (F(1.f) / max(shade, F(1e-20f)));
      reflectGain = reflectGain * shade;
    }
    const F refractionGain = loadFloat<W>(k.refractionGain, s.at);
    encloses = thin ? Mask<W>(false) : refractionGain != F(0.f);
    transmitColor = loadRgb<W>(k.refractionColor, s.at) * refractionGain;
    transmitMean = max(average(transmitColor), F(0.f));
    radianceScale = radiance && !thin ? eta * eta : F(1.f);

    // averages over directions, on wo's side (0) and behind (1)
    const F mean = fresnelDielectricMean(larger);
    F fresnelMean[2], lost[2];
    if (thin) {
      roughReflect_ = TableAxis<W>(r, ReflectionEnergy::kRough);
      roughTransmit_ = TableAxis<W>(t, ReflectionEnergy::kRough);
      fresnelMean[0] = fresnelMean[1] = bothFaces(mean);
      const F kept = lerp(reflectionEnergyMean(*reflection, true, roughTransmit_),
                          reflectionEnergyMean(*reflection, true, roughReflect_), fresnelMean[0]);
      lost[0] = lost[1] = max(F(1.f) - kept, F(0.f));
    } else {
      roughReflect_ = TableAxis<W>(r, GlassEnergy::kRough);
      roughTransmit_ = TableAxis<W>(t, GlassEnergy::kRough);
      axis_ = glassAxis(larger);
      side_ = select(eta > F(1.f), Int<W>(1), Int<W>(0));
      // what leaves the denser side is what enters it: (1 - F) n^2 is the same from both
      const F denser = F(1.f) - (F(1.f) - mean) / (larger * larger);
      for (int i = 0; i < 2; ++i) {
        const Int<W> side = i == 0 ? side_ : side_ ^ Int<W>(1);
        fresnelMean[i] = select(side == Int<W>(0), mean, denser);
        lost[i] = max(F(1.f) - glassEnergyMean(&glass->reflectMean[0][0][0], side, axis_, roughReflect_) -
                          glassEnergyMean(&glass->transmitMean[0][0][0], side, axis_, roughTransmit_),
                      F(0.f));
      }
      // What is lost where reflection and refraction do not add up to too much. So few angles may miss a twelfth of it,
      // which would be gained.
      constexpr int kAngles = 8;
      constexpr float kSafe = 1.2f;
      for (int i = 0; mayFit() && i < 2; ++i) {
        F sum(0.f);
        for (int m = 0; m < kAngles; ++m)
          sum += shares(F(std::sqrt((float(m) + 0.5f) / float(kAngles))), Mask<W>(i == 1)).lost;
        lost[i] = select(differs_, sum * F(kSafe / float(kAngles)), lost[i]);
      }
    }
    // Lost light is transmitted as the average Fresnel says on the side that loses more, and on the other as
    // reciprocity asks; the rest is reflected. crossing_ multiplies both sides' losses: symmetric up to n^2.
    const F most = max(max(lost[0], lost[1]), F(1e-6f));
    for (int i = 0; i < 2; ++i) {
      multipleTransmit[i] = (F(1.f) - fresnelMean[i]) * lost[1 - i] / most;
      returning_[i] = (F(1.f) - multipleTransmit[i]) / max(lost[i], F(1e-6f));
    }
    crossing_ = (F(1.f) - fresnelMean[0]) / most;
  }
  F multipleTransmit[2];  // share of lost light that is transmitted, from wo's side and from behind

  // Fresnel reflectance on wo's side, or of the sheet.
  KN_INLINE F fresnel(F cosine) const {
    const F f = fresnelDielectric(clamp(cosine, F(0.f), F(1.f)), eta);
    return thin ? bothFaces(f) : f;
  }
  // mu: cosine; behind: the direction is on the other side of the surface than wo
  KN_INLINE GlassShares<W> shares(F mu, Mask<W> behind) const {
    GlassShares<W> g;
    if (thin) {
      const F f = fresnel(mu);
      g.reflect = f * select(smoothReflect, F(1.f), reflectionEnergy(*reflection_, true, mu, roughReflect_));
      g.transmit =
          (F(1.f) - f) * select(smoothTransmit, F(1.f), reflectionEnergy(*reflection_, true, mu, roughTransmit_));
    } else {
      const Int<W> side = side_ ^ select(behind, Int<W>(1), Int<W>(0));
      const F f = fresnelDielectric(mu, select(behind, F(1.f) / eta, eta));
      g.reflect = g.transmit = F(0.f);
      if (!smoothReflect.all()) g.reflect = glassEnergy(&glass_->reflect[0][0][0][0], side, axis_, roughReflect_, mu);
      if (!smoothTransmit.all())
        g.transmit = glassEnergy(&glass_->transmit[0][0][0][0], side, axis_, roughTransmit_, mu);
      g.reflect = select(smoothReflect, f, g.reflect);
      g.transmit = select(smoothTransmit, F(1.f) - f, g.transmit);
    }
    g.fit = fitOf(g.reflect, g.transmit);
    g.transmit = g.transmit * g.fit;
    g.lost = zeroUnless(!(smoothReflect & smoothTransmit), max(F(1.f) - g.reflect - g.transmit, F(0.f)));
    return g;
  }
  // Facets that refract and facets of another roughness that reflect are not the same ones: for a direction both may
  // add up to more than there is, without bound where light is caught inside (from there clear reflection is total where
  // rough refraction passes). Then reflection is left as it is and refraction takes what remains; between two
  // directions the smaller factor counts, so that the boundary stays reciprocal.
  KN_INLINE F fitOf(F reflect, F transmit) const {
    const F one(1.f);
    return select(differs_, clamp((one - reflect) / max(transmit, F(1e-6f)), F(0.f), one), one);
  }
  KN_INLINE bool mayFit() const { return differs_.any(); }

  // Two techniques make facets: with the roughness of reflection, and with that of refraction. Where both are rough
  // either one then reflects with a probability that follows Fresnel at the facet (so that total reflection loses no
  // sample); else the first always reflects and the second always refracts. f: fresnel(wo.h)
  KN_INLINE void chances(F f, F& reflects, F& refracts) const {
    const F r = f * reflectGain, t = (F(1.f) - f) * transmitMean, inverse = F(1.f) / max(r + t, F(1e-30f));
    reflects = r * inverse;
    refracts = t * inverse;
  }
  KN_INLINE Mask<W> chooses() const { return !(smoothReflect | smoothTransmit); }

  // wi local and above: value with cosine, gain aside.
  KN_INLINE F evaluateReflect(Vec3<W> wi, GlassPdfs<W>& p) const {
    const Vec3<W> h = normalize(wo + wi);
    const F f = fresnel(dot(wo, h));
    F chance, other;
    chances(f, chance, other);
    return mirrored(wi, wi.z, h, select(chooses(), chance, F(1.f)), zeroUnless(chooses(), chance), true, p) * f;
  }
  // wi local and below.
  KN_INLINE F evaluateTransmit(Vec3<W> wi, GlassPdfs<W>& p) const {
    F chance, other;
    if (thin) {
      const Vec3<W> up(wi.x, wi.y, -wi.z), h = normalize(wo + up);
      const F f = fresnel(dot(wo, h));
      chances(f, other, chance);
      return mirrored(up, up.z, h, zeroUnless(chooses(), chance), select(chooses(), chance, F(1.f)), false, p) *
             (F(1.f) - f);
    }
    const F m = F(1.f) / eta;
    Vec3<W> h = fma(wi, m, wo);
    h = h * (copySign(F(1.f), h.z) / sqrt(max(dot(h, h), F(1e-20f))));
    const F oh = dot(wo, h), ih = dot(wi, h);
    const Mask<W> facing = (oh > F(0.f)) & (ih < F(0.f));
    const F sum = fma(m, ih, oh), f = fresnel(oh);
    chances(f, other, chance);
    // |d h / d wi| = m^2 |wi.h| / sum^2, and with roles swapped |wo.h| / sum^2 (Walter et al., eq. 17)
    const F both = zeroUnless(facing, oh * -ih / max(sum * sum, F(1e-20f)));
    const F forward = both * m * m / wo.z, backward = both / max(-wi.z, F(1e-7f));
    const F dt = zeroUnless(!smoothTransmit, microfacetD(true, h, axTransmit, ayTransmit));
    const F dr = zeroUnless(chooses(), microfacetD(true, h, axReflect, ayReflect)) * chance;
    const F lt = smithLambda(true, wi, axTransmit, ayTransmit), lr = smithLambda(true, wi, axReflect, ayReflect),
            one(1.f);
    const F second = dt * select(chooses(), chance, one);
    p.first = dr * forward / (one + lambdaReflect_);
    p.firstReverse = dr * backward / (one + lr);
    p.second = second * forward / (one + lambdaTransmit_);
    p.secondReverse = second * backward / (one + lt);
    return (one - f) * dt * forward / (one + lambdaTransmit_ + lt);
  }
  // Light returned after several scatterings, over the cosine: reflected and transmitted.
  KN_INLINE F multipleReflected(F lostO, F lostI) const { return returning_[0] * lostO * lostI * F(kInvPi); }
  KN_INLINE F multipleTransmitted(F lostO, F lostI) const { return crossing_ * lostO * lostI * F(kInvPi); }

 private:
  const GlassEnergy* glass_;
  const ReflectionEnergy* reflection_;
  TableAxis<W> axis_, roughReflect_, roughTransmit_;
  Int<W> side_;      // 1: wo is in the denser medium
  Mask<W> differs_;  // facets that refract are of another roughness than those that reflect
  F lambdaReflect_, lambdaTransmit_, returning_[2], crossing_;

  // A sheet reflects at both faces, and again what the second sends back: F + (1 - F)^2 F / (1 - F^2).
  static KN_INLINE F bothFaces(F f) { return (f + f) / (F(1.f) + f); }
  // Facets that reflect: D G / (4 cosO), of the roughness of reflection or, seen through a sheet, of refraction.
  KN_INLINE F mirrored(Vec3<W> wi, F cosI, Vec3<W> h, F chanceFirst, F chanceSecond, bool reflection,
                       GlassPdfs<W>& p) const {
    const F one(1.f), quarterO = F(0.25f) / wo.z, quarterI = F(0.25f) / max(cosI, F(1e-7f));
    const F dr = zeroUnless(!smoothReflect, microfacetD(true, h, axReflect, ayReflect));
    const F dt = zeroUnless(!smoothTransmit, microfacetD(true, h, axTransmit, ayTransmit));
    const F lr = smithLambda(true, wi, axReflect, ayReflect), lt = smithLambda(true, wi, axTransmit, ayTransmit);
    p.first = dr * chanceFirst * quarterO / (one + lambdaReflect_);
    p.firstReverse = dr * chanceFirst * quarterI / (one + lr);
    p.second = dt * chanceSecond * quarterO / (one + lambdaTransmit_);
    p.secondReverse = dt * chanceSecond * quarterI / (one + lt);
    return reflection ? dr * quarterO / (one + lambdaReflect_ + lr) : dt * quarterO / (one + lambdaTransmit_ + lt);
  }
};

// Light that goes straight on through glass, for tinted shadows: its tint and what Fresnel lets pass. A straight ray
// meets the far side of a pane at the angle that it has outside, where refracted light would meet it at the angle
// inside; both faces of a pane let the same share pass. So every face is taken from the rarer of its two media, and
// none reflects totally: a plane slab in air passes (1 - F)^2 at any angle.
template <int W>
KN_INLINE void glassThinShadow(const Context& c, const Value& gain, const Value& color, const Value& ior, bool thin,
                               float* const rgb[3]) {
  for (uint32_t i = 0; i < c.count; i += W) {
    const Surface<W> s(c, At{i, false});
    const Float<W> one(1.f), inside = max(loadFloat<W>(ior, s.at), Float<W>(1e-3f)),
                             outside = max(s.outerIor, Float<W>(1e-3f));
    const Float<W> ratio = outside / inside, eta = thin ? ratio : min(ratio, inside / outside);
    const Float<W> f = fresnelDielectric(min(s.cosO, one), eta), share = thin ? (one - f) / (one + f) : one - f;
    (loadRgb<W>(color, s.at) * (loadFloat<W>(gain, s.at) * share)).store(rgb, i);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
