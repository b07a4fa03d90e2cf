// A stack of lobes at W points: the lobes of a closure mixed into one density, lower ones attenuated by what lies
// above. Top to bottom: fuzz, clear coat, specular, rough specular and iridescence, then diffuse (reflected and transmitted),
// subsurface and glass. How much what is above takes from what is below: coat and specular by their directional albedo (times the
// compensation parameters), the greater of the two directions', which is reciprocal and never gains; the coat absorbs
// along both refracted directions. The lobes themselves are in diffuse.h, specular.h and glass.h; materials fill the
// closure and call what stack_functions.h declares. Included per target, by stack.cpp alone.
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include <iterator>
#include "bump_shadowing.h"
#include "closure.h"
#include "diffuse.h"
#include "specular.h"
#include "glass.h"

#if defined(KINORA_LOBES_STACK_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_STACK_H_TARGET
#undef KINORA_LOBES_STACK_H_TARGET
#else
#define KINORA_LOBES_STACK_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

using namespace lobes;

// Ways to make a direction. Each lobe that is rough has one for its single scattering and one for what that loses.
enum Technique : uint32_t {
  kMakeDiffuse,
  kMakeTransmit,
  kMakeBelow,     // a path that goes below the surface
  kMakeStandIn,   // where there is none: diffuse reflection for what would come out
  kMakeStraight,  // a path that crosses the body without scattering, by a cosine's law
  kMakeSingle,    // a path that scatters once below the surface
  kMakeClear,     // one that goes straight through instead
  kMakeSpecular,
  kMakeMultiple = kMakeSpecular + kReflecting,
  kMakeFuzz = kMakeMultiple + kReflecting,
  kMakeGlassReflect,
  kMakeGlassTransmit,
  kMakeGlassMultipleReflect,
  kMakeGlassMultipleTransmit,
  kTechniques
};

// What the lobes need to know of one direction, whichever role it has.
template <int W>
struct Seen {
  Mask<W> outside;                                // it is on the outer side of the surface
  Float<W> mu[kReflecting], energy[kReflecting];  // specular lobes: cosine with their normal, directional energy
  Float<W> muFuzz;
  GlassShares<W> glass;
  KN_INLINE Seen() {}
};
// Selection weights of the techniques for paths that arrive from a direction; scale brings their sum to 1.
template <int W>
struct Choice {
  Float<W> weight[kTechniques], scale;
  KN_INLINE Choice() {}
};
// What the upper lobes take, by direction.
template <int W>
struct Layers {
  Rgb<W> depth, coat, specular;  // optical depth of the coat; albedos times their compensation
  KN_INLINE Layers() {}
};

// A bump input where it is connected, the general normal where it is 0 0 0.
template <int W>
KN_INLINE Vec3<W> lobeNormal(const Value& v, const Surface<W>& s, Vec3<W> general) {
  const Vec3<W> n = loadVec<W>(v, s.at);
  return select(dot(n, n) > Float<W>(1e-12f), bumpedNormal<W>(v, s), general);
}

// A closure's lobes at W points: the Lanes of bxdf_author.h.
template <int W>
struct LobeStack {
  using F = Float<W>;
  const lobes::Closure& k;
  Vec3<W> Ng, wo, smooth;  // smooth: the surface's own normal
  // diffuse
  Vec3<W> normal;
  F muO;
  Rgb<W> front, back, reflectance, transmittance;
  F frontMean, backMean, transmitMean, exponent;
  F transmitShare[2];  // of diffuse transmission from wo's side and from behind
  RoughDiffuse<W> rough;
  // subsurface: factor on paths that go below, and reflectance where they do not
  Vec3<W> under;
  F muUnder, belowMean, standInMean;
  Rgb<W> below, belowColor, standIn, straight;
  F straightMean;
  // single scattering: what goes in times what one scattering keeps, and what passes unscattered
  Rgb<W> single, clear;
  F singleMean, clearMean, singleEta, singleAlpha;
  Seen<W> seenO;
  Choice<W> choiceO;
  // Lobes that are off are not even cleared: an unnamed union runs no constructor.
  union {
    SpecularLobe<W> specular[kReflecting];
  };
  union {
    GlassLobe<W> glass;
  };
  union {
    Frame<W> fuzzFrame;
  };
  union {
    FuzzLobe<W> fuzz;
  };
  Rgb<W> fuzzColor;
  F fuzzMean, muFuzzO;
  F coatCompensation, specularCompensation;
  Rgb<W> coatDepth;
  Layers<W> layersO;

  HWY_ATTR HWY_NOINLINE LobeStack(const lobes::Closure& closure, const Surface<W>& s)
      : k(closure), Ng(s.Ng), wo(s.wo), smooth(s.N) {
    Vec3<W> normals[std::size(decltype(k.normals){})];
    // the first is bumpNormal itself where that is in use
    for (int i = 0; i < k.normalCount; ++i)
      normals[i] = lobeNormal<W>(k.normals[i], s, i > 0 && k.bumped ? normals[0] : s.N);
    normal = k.diffuseBump < 0 ? s.N : normals[k.diffuseBump];
    seenO.outside = s.entering;
    if (k.has(kDiffuse) || k.has(kDiffuseTransmit)) muO = max(dot(normal, wo), F(0.f));
    if (k.has(kDiffuse)) {
      const F gain = loadFloat<W>(k.diffuseGain, s.at);
      front = loadRgb<W>(k.diffuseColor, s.at) * gain;
      if (k.diffuseDoubleSided) back = k.backHasOwnColor ? loadRgb<W>(k.diffuseBackColor, s.at) * gain : front;
      reflectance = select(seenO.outside, front, back);
      frontMean = max(average(front), F(0.f));
      backMean = max(average(back), F(0.f));
      rough = RoughDiffuse<W>(loadFloat<W>(k.diffuseRoughness, s.at));
      exponent = loadFloat<W>(k.diffuseExponent, s.at);
    }
    if (k.has(kDiffuseTransmit)) {
      transmittance = loadRgb<W>(k.transmitColor, s.at) * loadFloat<W>(k.transmitGain, s.at);
      transmitMean = max(average(transmittance), F(0.f));
    }
    if (k.has(kSubsurface)) setSubsurface(s, k.bumped ? normals[0] : s.N);
    if (k.has(kSingleScatter)) setSingle(s);
    for (uint32_t i = 0; i < kReflecting; ++i)
      if (k.has(kSpecular + i)) {
        const int bump = k.specular[i].bump;
        specular[i].set(k.specular[i], *k.reflectionEnergy, bump < 0 ? s.N : normals[bump], s);
      }
    if (k.has(kFuzz)) {
      fuzzFrame = Frame<W>(k.fuzzBump < 0 ? s.N : normals[k.fuzzBump]);
      fuzz = FuzzLobe<W>(loadFloat<W>(k.fuzzConeAngle, s.at));
      fuzzColor = loadRgb<W>(k.fuzzColor, s.at) * loadFloat<W>(k.fuzzGain, s.at);
      fuzzMean = max(average(fuzzColor), F(0.f));
      muFuzzO = max(dot(fuzzFrame.z, wo), F(0.f));
    }
    if (hasGlass())
      glass.set(k.glass, k.glassEnergy, k.reflectionEnergy, k.radiance,
                k.glass.bump < 0 ? s.N : normals[k.glass.bump], s);
    if (k.has(kDiffuseTransmit)) {
      transmitShare[0] = transmitShare[1] = F(1.f);
      if (k.has(kGlassTransmit) && !k.glass.thin) {
        // Where the surface bounds a medium: as n^2 times the share is the same from both sides, less leaves the
        // denser.
        const F e2 = glass.eta * glass.eta, one(1.f);
        transmitShare[0] = select(glass.encloses, min(one / e2, one), one);
        transmitShare[1] = select(glass.encloses, min(e2, one), one);
        transmittance = transmittance * (transmitShare[0] * select(glass.encloses, glass.radianceScale, one));
      }
    }
    if (k.coatAttenuates) {
      coatCompensation = loadFloat<W>(k.coatCompensation, s.at);
      coatDepth = loadRgb<W>(k.coatTint, s.at) * loadFloat<W>(k.coatThickness, s.at);
    }
    if (k.specularAttenuates) specularCompensation = loadFloat<W>(k.specularCompensation, s.at);
    see(wo, Mask<W>(false), seenO);
    choose(seenO, Mask<W>(false), choiceO);
    if (attenuates()) layer(seenO, layersO);
  }

  // stack_evaluate.h and stack_sample.h
  HWY_ATTR HWY_NOINLINE void evaluate(const Vec3<W>& wi, LobeSum<W>& out) const;
  HWY_ATTR HWY_NOINLINE void sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const;
  HWY_ATTR HWY_NOINLINE void mirror(const Int<W>& made, const F& probability, LobeSample<W>& out) const;
  KN_INLINE bool hasGlass() const { return k.has(kGlassReflect) || k.has(kGlassTransmit); }

  // For the denoiser: what the lobes return, macroscopically; layers above are taken off at wo alone.
  HWY_ATTR HWY_NOINLINE Rgb<W> albedo() const {
    Rgb<W> sum = transmittance;
    // what single scattering loses comes back in the colour: the whole is nearly the reflectance itself
    if (k.has(kDiffuse)) sum += reflectance * pow(muO, max(exponent, F(1.f)) - F(1.f));
    if (k.has(kSubsurface)) sum += zeroUnless(onSide(k.subsurface.doubleSided, seenO.outside), standIn + belowColor);
    if (hasGlass()) {
      const F mirrored = glass.reflectGain * glassReflected();
      sum += Rgb<W>(mirrored, mirrored, mirrored) * glass.reflectTint + glass.transmitColor * glassTransmitted();
    }
    Rgb<W> upper(1.f), lower(1.f);
    if (attenuates()) attenuation(Layers<W>(), upper, lower);
    sum = sum * lower;
    for (uint32_t i = 0; i < kReflecting; ++i)
      if (k.has(kSpecular + i)) {
        const Rgb<W> a = zeroUnless(onSide(k.specular[i].doubleSided, seenO.outside),
                                    specular[i].albedo(seenO.mu[i], seenO.energy[i]));
        sum += i == kCoat ? a : a * upper;
      }
    if (k.has(kFuzz))
      sum += zeroUnless(onSide(k.fuzzDoubleSided, seenO.outside), fuzzColor * fuzz.albedoBound(muFuzzO));
    const F none(0.f), one(1.f);
    return {clamp(sum.x, none, one), clamp(sum.y, none, one), clamp(sum.z, none, one)};
  }

 private:
  // Paths go below where the integrator follows them and what they reach can be seen apart; else, and in the blend,
  // what would come out is reflected.
  KN_INLINE void setSubsurface(const Surface<W>& s, Vec3<W> bumped) {
    const lobes::SubsurfaceClosure& x = k.subsurface;
    const F none(0.f), one(1.f);
    under = bumped;
    muUnder = max(dot(under, wo), none);
    Rgb<W> tint = loadRgb<W>(x.tint, s.at) * loadRgb<W>(x.entryTint, s.at);
    Rgb<W> color = positive(loadRgb<W>(x.color, s.at));
    F reach = loadFloat<W>(x.reach, s.at);
    const F gain = max(loadFloat<W>(x.gain, s.at), none);
    if (x.shortGain.components) {
      // a part that gives nothing reaches nowhere
      const auto add = [&](const Value& c, const Value& g, const Value& r) {
        const F amount = max(loadFloat<W>(g, s.at), none);
        color += positive(loadRgb<W>(c, s.at)) * amount;
        reach = max(reach, zeroUnless(amount > none, loadFloat<W>(r, s.at)));
      };
      color = color * gain;
      reach = zeroUnless(gain > none, reach);
      add(x.shortColor, x.shortGain, x.shortReach);
      add(x.longColor, x.longGain, x.longReach);
    } else {
      tint = tint * gain;
    }
    reach = reach * maxComponent(positive(loadRgb<W>(x.reachColor, s.at))) * F(x.unit);
    const Mask<W> sinks = s.sinks(reach, loadFloat<W>(x.diffuseSwitch, s.at));
    const F blend = select(sinks, clamp(loadFloat<W>(x.diffuseBlend, s.at), none, one), one);
    below = positive(tint) * (one - blend);
    belowColor = below * color;
    standIn = positive(tint) * color * blend;
    // thin parts of dark bodies let through more than they would return
    const F least(0.1f);
    belowMean = average(below * Rgb<W>(max(color.x, least), max(color.y, least), max(color.z, least)));
    standInMean = average(standIn);
    straight = Rgb<W>();
    if (x.straight.components)
      straight = positive(loadRgb<W>(x.tint, s.at) * loadRgb<W>(x.entryTint, s.at)) *
                 positive(loadRgb<W>(x.color, s.at)) * zeroUnless(sinks, max(loadFloat<W>(x.straight, s.at), none));
    straightMean = average(straight);
  }
  // By Fresnel at the geometric surface, where the path is refracted; radiance is n^2 denser inside.
  KN_INLINE void setSingle(const Surface<W>& s) {
    const lobes::SingleClosure& x = k.single;
    const F none(0.f), one(1.f), ior = max(loadFloat<W>(x.ior, s.at), one);
    singleEta = one / ior;
    const F reach = loadFloat<W>(x.reach, s.at) * maxComponent(positive(loadRgb<W>(x.reachColor, s.at))) * F(x.unit);
    const Mask<W> sinks = s.sinks(reach, none);
    const F lets = (one - fresnelDielectric(clamp(dot(Ng, wo), none, one), singleEta)) * singleEta * singleEta;
    single = positive(loadRgb<W>(x.color, s.at)) * (max(loadFloat<W>(x.gain, s.at), none) * zeroUnless(sinks, lets));
    singleMean = average(single);
    clear = positive(loadRgb<W>(x.straightColor, s.at)) *
            (max(loadFloat<W>(x.straight, s.at), none) * zeroUnless(sinks, lets));
    clearMean = average(clear);
    const F blur = clamp(loadFloat<W>(x.blur, s.at), none, one);
    singleAlpha = blur * blur;
  }
  // Negative numbers and NaN are 0.
  static KN_INLINE Rgb<W> positive(Rgb<W> a) {
    const F none(0.f);
    return {zeroUnless(a.x > none, a.x), zeroUnless(a.y > none, a.y), zeroUnless(a.z > none, a.z)};
  }
  KN_INLINE bool attenuates() const { return k.coatAttenuates || k.specularAttenuates; }
  static KN_INLINE Mask<W> onSide(bool both, Mask<W> outside) { return both ? Mask<W>(true) : outside; }
  static KN_INLINE void take(Mask<W> m, const Frame<W>& from, Frame<W>& to) {
    to = Frame<W>(select(m, from.x, to.x), select(m, from.y, to.y), select(m, from.z, to.z));
  }
  static KN_INLINE void add(Mask<W> here, const Choice<W>& o, const Choice<W>& i, uint32_t technique, F pdf,
                            F pdfReverse, F& sum, F& sumReverse) {
    sum += zeroUnless(here, o.weight[technique] * pdf);
    sumReverse += zeroUnless(here, i.weight[technique] * pdfReverse);
  }
  KN_INLINE F glassReflected() const {
    return fma(seenO.glass.lost, F(1.f) - glass.multipleTransmit[0], seenO.glass.reflect);
  }
  KN_INLINE F glassTransmitted() const {
    return fma(seenO.glass.lost, glass.multipleTransmit[0], seenO.glass.transmit);
  }

  // d: away from the surface; behind: not on wo's side of it.
  HWY_ATTR HWY_NOINLINE void see(const Vec3<W>& d, const Mask<W>& behind, Seen<W>& x) const {
    for (uint32_t i = 0; i < kReflecting; ++i)
      if (k.has(kSpecular + i)) {
        x.mu[i] = min(abs(dot(specular[i].frame.z, d)), F(1.f));
        x.energy[i] = specular[i].energy(x.mu[i], d);
      }
    if (k.has(kFuzz)) x.muFuzz = min(abs(dot(fuzzFrame.z, d)), F(1.f));
    if (hasGlass()) x.glass = glass.shares(min(abs(dot(glass.frame.z, d)), F(1.f)), behind);
  }
  HWY_ATTR HWY_NOINLINE void choose(const Seen<W>& x, const Mask<W>& behind, Choice<W>& c) const {
    F sum(0.f);
    if (k.has(kDiffuse)) sum += c.weight[kMakeDiffuse] = select(x.outside, frontMean, backMean);
    if (k.has(kDiffuseTransmit))
      sum += c.weight[kMakeTransmit] = transmitMean * select(behind, transmitShare[1], transmitShare[0]);
    if (k.has(kSubsurface)) {
      const Mask<W> here = onSide(k.subsurface.doubleSided, x.outside);
      c.weight[kMakeBelow] = zeroUnless(here, belowMean);
      c.weight[kMakeStandIn] = zeroUnless(here, standInMean);
      c.weight[kMakeStraight] = zeroUnless(here, straightMean);
      sum += c.weight[kMakeBelow] + c.weight[kMakeStandIn] + c.weight[kMakeStraight];
    }
    if (k.has(kSingleScatter)) {
      const Mask<W> here = onSide(k.single.doubleSided, x.outside);
      c.weight[kMakeSingle] = zeroUnless(here, singleMean);
      c.weight[kMakeClear] = zeroUnless(here, clearMean);
      sum += c.weight[kMakeSingle] + c.weight[kMakeClear];
    }
    for (uint32_t i = 0; i < kReflecting; ++i) {
      if (!k.has(kSpecular + i)) continue;
      const Mask<W> here = onSide(k.specular[i].doubleSided, x.outside);
      c.weight[kMakeSpecular + i] = zeroUnless(here, specular[i].weightSingle(x.mu[i], x.energy[i]));
      c.weight[kMakeMultiple + i] = zeroUnless(here, specular[i].weightMultiple(x.energy[i]));
      sum += c.weight[kMakeSpecular + i] + c.weight[kMakeMultiple + i];
    }
    if (k.has(kFuzz))
      sum += c.weight[kMakeFuzz] =
          zeroUnless(onSide(k.fuzzDoubleSided, x.outside), fuzzMean * fuzz.albedoBound(x.muFuzz));
    if (hasGlass()) {
      const F through = select(behind, glass.multipleTransmit[1], glass.multipleTransmit[0]);
      c.weight[kMakeGlassReflect] = x.glass.reflect * glass.reflectGain;
      c.weight[kMakeGlassTransmit] = x.glass.transmit * glass.transmitMean;
      c.weight[kMakeGlassMultipleReflect] = x.glass.lost * (F(1.f) - through) * glass.reflectGain;
      c.weight[kMakeGlassMultipleTransmit] = x.glass.lost * through * glass.transmitMean;
      sum += c.weight[kMakeGlassReflect] + c.weight[kMakeGlassTransmit] + c.weight[kMakeGlassMultipleReflect] +
             c.weight[kMakeGlassMultipleTransmit];
    }
    c.scale = zeroUnless(sum > F(0.f), F(1.f) / max(sum, F(1e-30f)));
  }
  HWY_ATTR HWY_NOINLINE void layer(const Seen<W>& x, Layers<W>& y) const {
    if (k.coatAttenuates) {
      const Mask<W> here = onSide(k.specular[kCoat].doubleSided, x.outside) & specular[kCoat].present();
      const F ior = max(specular[kCoat].ior(), F(1.f)), mu = x.mu[kCoat];
      const F inside = sqrt(max(F(1.f) - fnma(mu, mu, F(1.f)) / (ior * ior), F(1e-4f)));
      y.depth = zeroUnless(here, coatDepth / inside);
      y.coat = zeroUnless(here, specular[kCoat].albedo(mu, x.energy[kCoat]) * coatCompensation);
    }
    if (k.specularAttenuates) {
      Rgb<W> sum;
      for (int i = 0; i < 2; ++i)
        if (k.has(kSpecular + i))
          sum += zeroUnless(onSide(k.specular[i].doubleSided, x.outside), specular[i].albedo(x.mu[i], x.energy[i]));
      y.specular = sum * specularCompensation;
    }
  }
  // upper: of specular and rough specular; lower: of diffuse and glass.
  KN_INLINE void attenuation(const Layers<W>& i, Rgb<W>& upper, Rgb<W>& lower) const {
    if (k.coatAttenuates) {
      const Rgb<W> depth = layersO.depth + i.depth;
      upper = Rgb<W>(exp(-depth.x), exp(-depth.y), exp(-depth.z)) * remaining(layersO.coat, i.coat);
    }
    lower = k.specularAttenuates ? upper * remaining(layersO.specular, i.specular) : upper;
  }
  static KN_INLINE Rgb<W> remaining(Rgb<W> a, Rgb<W> b) {
    const F none(0.f), one(1.f);
    return {clamp(one - max(a.x, b.x), none, one), clamp(one - max(a.y, b.y), none, one),
            clamp(one - max(a.z, b.z), none, one)};
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
