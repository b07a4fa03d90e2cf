// Microfacet reflection (specular, rough specular, clear coat, iridescence): one lobe at W points. It knows nothing of other
// lobes; selection, attenuation and sides are the caller's. Included per target.
#include "closure.h"
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet_anisotropy.h>
#include "film.h"

#if defined(KINORA_LOBES_SPECULAR_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_SPECULAR_H_TARGET
#undef KINORA_LOBES_SPECULAR_H_TARGET
#else
#define KINORA_LOBES_SPECULAR_H_TARGET
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

// How much anisotropy stretches: alphas are alpha / aspect and alpha * aspect (Burley, SIGGRAPH course 2012).
template <int W>
KN_INLINE Float<W> disneyAspect(Float<W> amount) {
  return sqrt(fnma(Float<W>(0.9f), abs(amount), Float<W>(1.f)));
}
// Frame about n and the two alphas. Where the amount is 0 the frame is the plain one, so that a point's bits do not
// depend on what its neighbours have.
template <int W>
KN_INLINE Frame<W> anisotropicFrame(const lobes::AnisotropyClosure& a, Vec3<W> n, At at, Float<W> alpha, Float<W>& ax,
                                    Float<W>& ay) {
  using F = Float<W>;
  Frame<W> frame(n);
  ax = ay = alpha;
  if (!a.on) return frame;
  const F amount = clamp(loadFloat<W>(a.amount, at), F(-1.f), F(1.f));
  const F aspect = disneyAspect(amount);
  const F wide = alpha / aspect, narrow = alpha * aspect;
  ax = select(amount > F(0.f), wide, narrow);
  ay = select(amount > F(0.f), narrow, wide);
  Vec3<W> t = loadVec<W>(a.tangent, at);
  if (a.directed) {
    const Vec3<W> d = loadVec<W>(a.direction, at);
    t = select(dot(d, d) > F(1e-20f), d, t);
  }
  const Frame<W> along = Frame<W>::fromTangent(n, t);
  const Mask<W> turned = amount != F(0.f);
  return Frame<W>(select(turned, along.x, frame.x), select(turned, along.y, frame.y), n);
}
// wo in a lobe's frame. Bent normals may leave it a hair below the horizon.
template <int W>
KN_INLINE Vec3<W> localOut(const Frame<W>& f, Vec3<W> wo) {
  const Vec3<W> l = f.toLocal(wo);
  return {l.x, l.y, max(l.z, Float<W>(1e-5f))};
}

template <int W>
struct SpecularLobe {
  using F = Float<W>;
  Frame<W> frame;
  Vec3<W> wo;  // local
  F ax, ay;
  Mask<W> smooth;   // a mirror: never evaluated
  Rgb<W> multiple;  // Fresnel of light that leaves after several reflections
  const lobes::SpecularClosure* k;

  KN_INLINE SpecularLobe() {}
  KN_INLINE void set(const lobes::SpecularClosure& closure, const ReflectionEnergy& energyTable, Vec3<W> normal,
                     const Surface<W>& s) {
    facets(closure, energyTable, loadFloat<W>(closure.roughness, s.at), normal, s);
    edge_ = loadRgb<W>(k->edge, s.at);
    Rgb<W> mean;
    if (k->film) {
      face_.x = max(loadRgb<W>(k->face, s.at).x, F(1.f));
      thickness_ = max(loadFloat<W>(k->shape, s.at), F(0.f));
      shape_ = F(5.f);  // of the weights that choose
      f0_ = average(fresnel(F(1.f)));
      mean = meanFresnel();
    } else if (k->physical) {
      face_ = loadRgb<W>(k->ior, s.at);
      extinction_ = loadRgb<W>(k->extinction, s.at);
      shape_ = F(5.f);
      f0_ = average(fresnel(F(1.f)));
      mean = meanFresnel();
    } else {
      face_ = loadRgb<W>(k->face, s.at);
      shape_ = max(loadFloat<W>(k->shape, s.at), F(0.01f));
      f0_ = average(face_);
      mean = k->iridescence ? iridescentMean(s.at) : schlickMean();
    }
    compensate(mean);
    if (k->iridescence) {
      f0_ = f0_ * brightest_;
      f90_ = f90_ * brightest_;
    }
  }
  KN_INLINE Rgb<W> fresnel(F cosine) const {
    if (k->film) return edge_ * filmReflectance(*k->film, cosine, face_.x, thickness_);
    if (k->physical)
      return edge_ * Rgb<W>(fresnelConductor(cosine, face_.x, extinction_.x),
                            fresnelConductor(cosine, face_.y, extinction_.y),
                            fresnelConductor(cosine, face_.z, extinction_.z));
    const Rgb<W> schlick = lerp(face_, edge_, power(cosine));
    return k->iridescence ? schlick * iridescentColor(cosine) : schlick;
  }
  // Part of the light that one scattering returns, Fresnel aside. mu: cosine with the normal; x, y: the direction's
  // other components in the frame, which count where the lobe is anisotropic.
  KN_INLINE F energyLocal(F mu, F x, F y) const {
    F e = reflectionEnergy(*table_, k->ggx, mu, rough_);
    if (k->anisotropy.on)
      e = select(
          turned_,
          anisotropicEnergy(*k->anisotropy.energy, stretch_, mu, select(wideIsX_, x, y), select(wideIsX_, y, x)), e);
    return select(smooth, F(1.f), e);
  }
  // d: the direction in the space of the frame.
  KN_INLINE F energy(F mu, Vec3<W> d) const {
    return k->anisotropy.on ? energyLocal(mu, dot(frame.x, d), dot(frame.y, d)) : energyLocal(mu, F(0.f), F(0.f));
  }
  // Where its colours are black the lobe is off, and with it what a coat absorbs.
  KN_INLINE Mask<W> present() const {
    Mask<W> any = (edge_.x != F(0.f)) | (edge_.y != F(0.f)) | (edge_.z != F(0.f));
    if (!k->physical) any = any | (face_.x != F(0.f)) | (face_.y != F(0.f)) | (face_.z != F(0.f));
    return any;
  }
  // Index of refraction light takes below the lobe: the coat's. Artistic lobes have none and count as 1.5.
  KN_INLINE F ior() const { return k->physical ? average(face_) : F(1.5f); }
  // e: energy(mu)
  KN_INLINE Rgb<W> albedo(F mu, F e) const { return lerp(multiple, fresnel(mu), e); }
  // Selection weights of the visible-normal part and of the part that returns what it loses.
  KN_INLINE F weightSingle(F mu, F e) const { return e * max(lerp(f0_, f90_, power(mu)), F(0.f)); }
  KN_INLINE F weightMultiple(F e) const { return max(F(1.f) - e, F(0.f)) * multipleMean_; }

  // wi local, above. Weight with cosine; pdfs of the visible-normal part alone.
  KN_INLINE Rgb<W> evaluate(Vec3<W> wi, F eO, F eI, F& pdf, F& pdfReverse) const {
    const Vec3<W> h = normalize(wo + wi);
    const F cosI = max(wi.z, F(1e-7f)), d = microfacetD(k->ggx, h, ax, ay);
    const F lambdaI = smithLambda(k->ggx, wi, ax, ay), quarter = F(0.25f) / wo.z;
    F dSample = d, lambdaSampleI = lambdaI;
    if (!k->ggx) {
      dSample = microfacetD(true, h, ax, ay);
      lambdaSampleI = smithLambda(true, wi, ax, ay);
    }
    pdf = dSample * quarter / (F(1.f) + lambdaSampleO_);
    pdfReverse = dSample * F(0.25f) / (cosI * (F(1.f) + lambdaSampleI));
    const F single = d * quarter / (F(1.f) + lambdaO_ + lambdaI);
    const F lost = max(F(1.f) - eO, F(0.f)) * max(F(1.f) - eI, F(0.f)) / max(F(1.f) - eMean_, F(1e-6f));
    return fma(fresnel(min(dot(wo, h), F(1.f))), single, multiple * (lost * F(kInvPi) * wi.z));
  }

 private:
  const ReflectionEnergy* table_;
  TableAxis<W> rough_;
  AnisotropicAxes<W> stretch_;  // where anisotropy is on
  Mask<W> turned_, wideIsX_;    // turned: stretched at all
  F lambdaO_, lambdaSampleO_, eMean_, shape_, f0_, f90_, multipleMean_;
  Rgb<W> face_, edge_, extinction_;  // physical and films: face_ is the index of refraction
  F thickness_;                      // of a film
  // Of iridescence: the colours that alternate, along which steps, and the most that they can be on average.
  Rgb<W> primary_, secondary_;
  F curve_, scale_, brightest_;

  KN_INLINE void facets(const lobes::SpecularClosure& closure, const ReflectionEnergy& energyTable,
                        F roughnessAsGiven, Vec3<W> normal, const Surface<W>& s) {
    k = &closure;
    table_ = &energyTable;
    const F roughness = clamp(roughnessAsGiven, F(0.f), F(1.f));
    const F alpha = roughness * roughness;
    smooth = alpha < F(kMirrorAlpha);
    rough_ = TableAxis<W>(roughness, ReflectionEnergy::kRough);
    frame = anisotropicFrame(k->anisotropy, normal, s.at, max(alpha, F(kMirrorAlpha)), ax, ay);
    wo = localOut(frame, s.wo);
    lambdaO_ = smithLambda(k->ggx, wo, ax, ay);
    lambdaSampleO_ = k->ggx ? lambdaO_ : smithLambda(true, wo, ax, ay);
    eMean_ = reflectionEnergyMean(*table_, k->ggx, rough_);
    if (k->anisotropy.on) {
      const F amount = clamp(loadFloat<W>(k->anisotropy.amount, s.at), F(-1.f), F(1.f));
      turned_ = amount != F(0.f);
      wideIsX_ = amount > F(0.f);
      stretch_ = AnisotropicAxes<W>(disneyAspect(amount), roughness);
      eMean_ = select(turned_, anisotropicEnergyMean(*k->anisotropy.energy, stretch_), eMean_);
    }
  }
  // Of a film the index is that of oil and soap's oxides, 1.5; it reflects up to 4 r / (1 + r)^2 face on.
  static constexpr float kFilmIndex = 1.5f;
  KN_INLINE Rgb<W> iridescentMean(At at) {
    const lobes::IridescenceClosure& i = *k->iridescence;
    if (i.film) {
      thickness_ = max(loadFloat<W>(i.thickness, at), F(0.f));
      brightest_ = F(0.15f);
    } else {
      const Rgb<W> first = loadRgb<W>(i.primary, at), second = loadRgb<W>(i.secondary, at);
      primary_ = i.flip ? second : first;
      secondary_ = i.flip ? first : second;
      curve_ = max(loadFloat<W>(i.curve, at), F(0.f));
      scale_ = max(loadFloat<W>(i.scale, at), F(0.f));
      brightest_ = max(average(first), average(second));
    }
    return meanFresnel();
  }
  KN_INLINE Rgb<W> iridescentColor(F cosine) const {
    if (k->iridescence->film) return filmReflectance(*k->iridescence->film, cosine, F(kFilmIndex), thickness_);
    const F x = scale_ * pow(clamp(F(1.f) - cosine, F(0.f), F(1.f)), curve_);
    // to the second colour and back
    const F along = abs(x - F(2.f) * floor(fma(x, F(0.5f), F(0.5f))));
    return lerp(primary_, secondary_, along);
  }
  KN_INLINE Rgb<W> meanFresnel() const {
    return fresnel(F(kMeanCos0)) * F(kMeanWeight0) + fresnel(F(kMeanCos1)) * F(kMeanWeight1);
  }
  KN_INLINE Rgb<W> schlickMean() const {
    return lerp(face_, edge_, F(2.f) / ((shape_ + F(1.f)) * (shape_ + F(2.f))));
  }
  KN_INLINE void compensate(Rgb<W> mean) {
    f90_ = average(edge_);
    multiple = Rgb<W>(several(mean.x), several(mean.y), several(mean.z));
    multipleMean_ = average(multiple);
  }
  KN_INLINE F power(F cosine) const {
    const F x = clamp(F(1.f) - cosine, F(0.f), F(1.f)), x2 = x * x;
    F p = x2 * x2 * x;
    const Mask<W> other = shape_ != F(5.f);
    if (other.any()) p = select(other, pow(x, shape_), p);
    return p;
  }
  // Kulla and Conty (SIGGRAPH course 2017): the geometric series of the average Fresnel over the scatterings after
  // the first.
  KN_INLINE F several(F mean) const {
    const F f = clamp(mean, F(0.f), F(1.f));
    return f * f * eMean_ / max(fnma(f, F(1.f) - eMean_, F(1.f)), F(1e-6f));
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
