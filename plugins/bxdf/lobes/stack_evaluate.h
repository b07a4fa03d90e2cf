// What a stack of lobes returns from a direction, lobe by lobe, and the density of the mixture. Included per target,
// by stack.cpp alone.
#include "stack.h"

#if defined(KINORA_LOBES_STACK_EVALUATE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_STACK_EVALUATE_H_TARGET
#undef KINORA_LOBES_STACK_EVALUATE_H_TARGET
#else
#define KINORA_LOBES_STACK_EVALUATE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

template <int W>
HWY_ATTR HWY_NOINLINE void LobeStack<W>::evaluate(const Vec3<W>& wi, LobeSum<W>& out) const {
  const F side = dot(Ng, wi);
  const Mask<W> above = side > F(0.f), below = side < F(0.f);
  Seen<W> seenI;
  seenI.outside = seenO.outside ^ below;
  see(wi, below, seenI);
  Choice<W> choiceI;
  choose(seenI, below, choiceI);
  Rgb<W> upper(1.f), lower(1.f);
  if (attenuates()) {
    Layers<W> layersI;
    layer(seenI, layersI);
    attenuation(layersI, upper, lower);
  }
  F pdf(0.f), reverse(0.f);
  const F none(0.f);
  const auto softened = [&](const Vec3<W>& bumped, const Rgb<W>& f) HWY_ATTR {
    return k.softens ? f * bumpShadowing<W>(smooth, bumped, k.radiance ? wi : wo) : f;
  };
  if (k.has(kDiffuse) || k.has(kDiffuseTransmit)) {
    const F muI = dot(normal, wi);
    if (k.has(kDiffuse)) {
      const Mask<W> here = above & (muI > none);
      const F law = muI * minnaert(exponent, muO, max(muI, none));
      out.add(kDiffuse,
              zeroUnless(here, softened(normal, rough.evaluate(reflectance, muO, muI, dot(wo, wi)) * lower * law)));
      add(here, choiceO, choiceI, kMakeDiffuse, muI * F(kInvPi), muO * F(kInvPi), pdf, reverse);
    }
    if (k.has(kDiffuseTransmit)) {
      const Mask<W> here = below & (muI < none);
      out.add(kDiffuseTransmit, zeroUnless(here, transmittance * lower * (-muI * F(kInvPi))));
      add(here, choiceO, choiceI, kMakeTransmit, -muI * F(kInvPi), muO * F(kInvPi), pdf, reverse);
    }
  }
  if (k.has(kSubsurface)) {
    const F muI = dot(under, wi);
    const Mask<W> here = above & (muI > none) & onSide(k.subsurface.doubleSided, seenO.outside);
    out.add(kSubsurfaceReflect, zeroUnless(here, softened(under, standIn * lower * (muI * F(kInvPi)))));
    add(here, choiceO, choiceI, kMakeStandIn, muI * F(kInvPi), muUnder * F(kInvPi), pdf, reverse);
  }
  for (uint32_t i = 0; i < kReflecting; ++i) {
    if (!k.has(kSpecular + i)) continue;
    const SpecularLobe<W>& l = specular[i];
    const Vec3<W> w = l.frame.toLocal(wi);
    const Mask<W> here = above & (w.z > none) & onSide(k.specular[i].doubleSided, seenO.outside) & !l.smooth;
    if (here.none()) continue;
    F p, r;
    const Rgb<W> f = l.evaluate(w, seenO.energy[i], seenI.energy[i], p, r);
    out.add(kSpecular + i, zeroUnless(here, softened(l.frame.z, i == kCoat ? f : f * upper)));
    add(here, choiceO, choiceI, kMakeSpecular + i, p, r, pdf, reverse);
    add(here, choiceO, choiceI, kMakeMultiple + i, F(kInvTwoPi), F(kInvTwoPi), pdf, reverse);
  }
  if (k.has(kFuzz)) {
    const F muI = dot(fuzzFrame.z, wi);
    const Mask<W> here = above & (muI > none) & onSide(k.fuzzDoubleSided, seenO.outside);
    out.add(kFuzz, zeroUnless(here, softened(fuzzFrame.z, fuzzColor * (fuzz.evaluate(muFuzzO, muI) * muI))));
    add(here, choiceO, choiceI, kMakeFuzz, fuzz.pdf(muI), fuzz.pdf(muFuzzO), pdf, reverse);
  }
  if (hasGlass()) {
    const Vec3<W> w = glass.frame.toLocal(wi);
    const Mask<W> up = above & (w.z > none), down = below & (w.z < none);
    const F cosine = abs(w.z);
    GlassPdfs<W> p;
    if (k.has(kGlassReflect) && up.any()) {
      const F one = glass.evaluateReflect(w, p);
      const F f = fma(glass.multipleReflected(seenO.glass.lost, seenI.glass.lost), cosine, one) * glass.reflectGain;
      const Rgb<W> weight = zeroUnless(up, lower * f);
      out.add(kGlassReflect, k.glass.tinted ? weight * glass.reflectTint : weight);
      add(up, choiceO, choiceI, kMakeGlassReflect, p.first, p.firstReverse, pdf, reverse);
      add(up, choiceO, choiceI, kMakeGlassTransmit, p.second, p.secondReverse, pdf, reverse);
      add(up, choiceO, choiceI, kMakeGlassMultipleReflect, F(kInvTwoPi), F(kInvTwoPi), pdf, reverse);
    }
    if (k.has(kGlassTransmit) && down.any()) {
      const F one = glass.evaluateTransmit(w, p) * min(seenO.glass.fit, seenI.glass.fit);
      const F f =
          fma(glass.multipleTransmitted(seenO.glass.lost, seenI.glass.lost), cosine, one) * glass.radianceScale;
      out.add(kGlassTransmit, zeroUnless(down, glass.transmitColor * lower * f));
      add(down, choiceO, choiceI, kMakeGlassReflect, p.first, p.firstReverse, pdf, reverse);
      add(down, choiceO, choiceI, kMakeGlassTransmit, p.second, p.secondReverse, pdf, reverse);
      add(down, choiceO, choiceI, kMakeGlassMultipleTransmit, F(kInvTwoPi), F(kInvTwoPi), pdf, reverse);
    }
  }
  out.pdf = pdf * choiceO.scale;
  out.pdfReverse = reverse * choiceI.scale;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
