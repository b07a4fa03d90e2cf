// PxrDisney: Burley's principled model of 2012 ("Physically-Based Shading at Disney", SIGGRAPH course): diffuse with
// retroreflection, a flattened shape for subsurface, sheen, an anisotropic specular lobe from dielectric to metal and
// a clear coat, simply added up, as its authors do: bright dielectrics may return somewhat more than they receive,
// and rough metals less, because what scatters between facets is lost.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrDisney/PxrDisney.cpp"
#include <kinora/bxdf_author.h>
#include "parameters.h"
#include "base.h"
#include "plugins/bxdf/lobes/bind.h"
#include "plugins/bxdf/lobes/pick.h"

KINORA_KERNELS_BEGIN

using namespace pxrDisney;

enum Technique : uint32_t { kMakeCosine, kMakeSpecular, kMakeCoat, kTechniques };

// Selection weights of the techniques for paths that arrive at a cosine; scale brings their sum to 1.
template <int W>
struct Choice {
  Float<W> weight[kTechniques], scale;
  KN_INLINE Choice() {}
};

#define METAL "baseColor=1 1 1; metallic=1; "
constexpr const char* kConserving[] = {METAL "roughness=0",
                                       METAL "roughness=0.1",
                                       METAL "roughness=0.6",
                                       METAL "roughness=1",
                                       "baseColor=0.9 0.6 0.3; metallic=1; roughness=0.7",
                                       "baseColor=0.9 0.6 0.3; metallic=1; roughness=0.4; anisotropic=0.3",
                                       "baseColor=0.6 0.5 0.4; roughness=0.3; specular=1; clearcoat=1",
                                       "baseColor=0.5 0.5 0.5; roughness=0.5; subsurface=0.5",
                                       nullptr};
#undef METAL

struct PxrDisney {
  // A bit for each part that may be on: materials of one group then take the same branches.
  static uint64_t programKey(const ParamValue* v, uint32_t) {
    uint64_t key = 0;
    uint32_t bit = 0;
    for (const uint32_t i : {kSubsurface, kSheen, kClearcoat, kAnisotropic, kEmitColor})
      key |= uint64_t(v[i].mayBeOn()) << bit++;
    return key;
  }

  using Closure = pxrDisney::Closure;
  template <int W>
  using HasEmission = void;

  static void begin(const Context& c, Closure& k) {
    k.baseColor = c.param(kBaseColor);
    k.emitColor = c.param(kEmitColor);
    k.subsurface = c.param(kSubsurface);
    k.flattens = !isZero(k.subsurface);
    if (k.flattens) k.subsurfaceColor = c.param(kSubsurfaceColor);
    k.metallic = c.param(kMetallic);
    k.specular = c.param(kSpecular);
    k.specularTint = c.param(kSpecularTint);
    k.roughness = c.param(kRoughness);
    k.sheen = c.param(kSheen);
    k.sheens = !isZero(k.sheen);
    if (k.sheens) k.sheenTint = c.param(kSheenTint);
    k.clearcoat = c.param(kClearcoat);
    k.coated = !isZero(k.clearcoat);
    if (k.coated) k.clearcoatGloss = c.param(kClearcoatGloss);
    k.bump = c.param(kBumpNormal);
    k.bumped = isBumped(k.bump);
    k.anisotropy.amount = c.param(kAnisotropic);
    k.anisotropy.on = !isZero(k.anisotropy.amount);
    if (k.anisotropy.on) k.anisotropy.tangent = c.builtin(Builtin::Tangent);
    k.energy = &disneyEnergyTable();
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }
  template <int W>
  static HWY_ATTR Rgb<W> emission(const Closure& k, At at) {
    return loadRgb<W>(k.emitColor, at);
  }

  template <int W>
  struct Lanes {
    using F = Float<W>;
    const Closure& k;
    Vec3<W> Ng;
    DisneySpecular<W> specular;  // its frame is that of all lobes
    Rgb<W> diffuse, flat, sheen;
    F roughness, subsurface, cosineWeight, sheenWeight, coatGain;
    CoatLobe<W> coat;
    Choice<W> choiceO;

    HWY_ATTR HWY_NOINLINE Lanes(const Closure& closure, const Surface<W>& s) : k(closure), Ng(s.Ng) {
      const F none(0.f), one(1.f);
      const Vec3<W> normal = k.bumped ? bumpedNormal<W>(k.bump, s) : s.N;
      const Rgb<W> base = loadRgb<W>(k.baseColor, s.at);
      const F metallic = clamp(loadFloat<W>(k.metallic, s.at), none, one), dielectric = one - metallic;
      // the hue of the base colour: its luminance, as the course approximates it, is 1
      const F light = fma(base.x, F(0.3f), fma(base.y, F(0.6f), base.z * F(0.1f)));
      const Rgb<W> tint = select(light > none, base * (one / max(light, F(1e-20f))), Rgb<W>(1.f));
      roughness = clamp(loadFloat<W>(k.roughness, s.at), none, one);
      const F specularTint = clamp(loadFloat<W>(k.specularTint, s.at), none, one);
      const F f0 = max(loadFloat<W>(k.specular, s.at), none) * F(0.08f);
      specular = DisneySpecular<W>(k.anisotropy, roughness,
                                   lerp(lerp(Rgb<W>(1.f), tint, specularTint) * f0, base, metallic), normal, s);
      subsurface = k.flattens ? clamp(loadFloat<W>(k.subsurface, s.at), none, one) : none;
      diffuse = base * (dielectric * (one - subsurface));
      flat = Rgb<W>(none, none, none);
      if (k.flattens) {
        const Rgb<W> own = loadRgb<W>(k.subsurfaceColor, s.at);
        flat = select(maxComponent(own) > none, own, base) * (dielectric * subsurface);
      }
      cosineWeight = max(average(diffuse) + average(flat), none);
      sheen = Rgb<W>(none, none, none);
      if (k.sheens) {
        const F sheenTint = clamp(loadFloat<W>(k.sheenTint, s.at), none, one);
        sheen = lerp(Rgb<W>(1.f), tint, sheenTint) * (max(loadFloat<W>(k.sheen, s.at), none) * dielectric);
      }
      sheenWeight = max(average(sheen), none);
      coatGain = none;
      if (k.coated) {
        coatGain = max(loadFloat<W>(k.clearcoat, s.at), none) * F(0.25f);
        coat = CoatLobe<W>(loadFloat<W>(k.clearcoatGloss, s.at));
      }
      choose(specular.wo.z, choiceO);
    }

    HWY_ATTR HWY_NOINLINE void evaluate(const Vec3<W>& wi, LobeSum<W>& out) const {
      const F none(0.f), muO = specular.wo.z;
      const Vec3<W> w = specular.frame.toLocal(wi);
      const Mask<W> here = (dot(Ng, wi) > none) & (w.z > none);
      const F muI = max(w.z, F(1e-7f));
      Choice<W> choiceI;
      choose(min(muI, F(1.f)), choiceI);
      const Vec3<W> h = normalize(specular.wo + w);
      const F cosD = min(dot(specular.wo, h), F(1.f));
      F pdf = choiceO.weight[kMakeCosine] * muI * F(kInvPi), reverse = choiceI.weight[kMakeCosine] * muO * F(kInvPi);
      Rgb<W> base = diffuse * burleyDiffuse(roughness, muO, muI, F(2.f) * cosD * cosD);
      if (k.flattens) base = base + flat * disneyFlat(roughness, muO, muI, cosD);
      out.add(kDiffuseLobe, zeroUnless(here, base * muI));
      if (k.sheens) out.add(kSheenLobe, zeroUnless(here, sheen * (schlickWeight(cosD) * muI)));
      F p, r;
      const Rgb<W> f = specular.evaluate(w, h, cosD, p, r);
      const Mask<W> rough = !specular.smooth;
      out.add(kSpecularLobe, zeroUnless(here & rough, f));
      pdf += zeroUnless(rough, choiceO.weight[kMakeSpecular] * p);
      reverse += zeroUnless(rough, choiceI.weight[kMakeSpecular] * r);
      if (k.coated) {
        const F d = coat.density(h), g = coat.masking(muO) * coat.masking(muI);
        const F value = coatGain * d * g * coat.fresnel(cosD) * muI;
        out.add(kClearcoatLobe, zeroUnless(here, Rgb<W>(value, value, value)));
        const F made = d * h.z / (F(4.f) * max(cosD, F(1e-7f)));
        pdf = fma(choiceO.weight[kMakeCoat], made, pdf);
        reverse = fma(choiceI.weight[kMakeCoat], made, reverse);
      }
      out.pdf = zeroUnless(here, pdf * choiceO.scale);
      out.pdfReverse = zeroUnless(here, reverse * choiceI.scale);
    }

    HWY_ATTR HWY_NOINLINE void sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const {
      Pick<W> pick(w, choiceO.scale, kTechniques);
      for (uint32_t t = 0; t < kTechniques; ++t) pick.offer(t, choiceO.weight[t]);
      const Int<W> made = pick.made;
      const Mask<W> facets = made == Int<W>(uint32_t(kMakeSpecular)), coats = made == Int<W>(uint32_t(kMakeCoat));
      Vec3<W> d = cosineHemisphere(u, v);
      if ((facets | coats).any()) {
        const Vec3<W> up(F(0.f), F(0.f), F(1.f));
        Vec3<W> h = select(specular.smooth, up, sampleVisibleNormal(specular.wo, specular.ax, specular.ay, u, v));
        if (coats.any()) h = select(coats, coat.sample(u, v), h);
        d = select(facets | coats, reflect(specular.wo, h), d);
      }
      out.wi = normalize(specular.frame.toWorld(d));
      out.valid = (choiceO.scale > F(0.f)) & (d.z > F(0.f)) & (dot(Ng, out.wi) > F(0.f));
      out.discrete = facets & specular.smooth;
      out.discreteWeight = specular.mirror();
      out.discreteProbability = pick.weight * choiceO.scale;
      out.discreteLobe = Int<W>(uint32_t(kSpecularLobe));
    }

    // For the denoiser.
    HWY_ATTR HWY_NOINLINE Rgb<W> albedo() const {
      const F muO = specular.wo.z, none(0.f), one(1.f);
      const F glint = coatGain * CoatLobe<W>::fresnel(muO);
      const Rgb<W> sum = diffuse + flat + sheen * schlickWeight(muO) +
                         specular.fresnel(muO) * specular.energy(*k.energy, muO) + Rgb<W>(glint, glint, glint);
      return {clamp(sum.x, none, one), clamp(sum.y, none, one), clamp(sum.z, none, one)};
    }

   private:
    KN_INLINE void choose(F mu, Choice<W>& c) const {
      c.weight[kMakeSpecular] = specular.energy(*k.energy, mu) * max(average(specular.fresnel(mu)), F(0.f));
      // sheen looks at grazing angles for the most part; its albedo there is about a half
      const F graze = F(1.f) - mu;
      c.weight[kMakeCosine] = fma(sheenWeight, fma(graze * graze, F(0.5f), F(0.01f)), cosineWeight);
      c.weight[kMakeCoat] = coatGain * CoatLobe<W>::fresnel(mu);
      F sum(0.f);
      for (uint32_t t = 0; t < kTechniques; ++t) sum += c.weight[t];
      c.scale = zeroUnless(sum > F(0.f), F(1.f) / max(sum, F(1e-30f)));
    }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrDisney, .help = "The principled material of 2012: dielectric to metal, with sheen and clear coat.",
            .params = kParams, .lobes = kLobes, .presenceParam = int(kPresence), .programKey = PxrDisney::programKey,
            .conserving = kConserving)
