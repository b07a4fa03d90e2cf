// How a stack of lobes makes a direction: a technique is chosen by its weight, then a direction by its density.
// Included per target, by stack.cpp alone.
#include "stack.h"
#include "pick.h"

#if defined(KINORA_LOBES_STACK_SAMPLE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_STACK_SAMPLE_H_TARGET
#undef KINORA_LOBES_STACK_SAMPLE_H_TARGET
#else
#define KINORA_LOBES_STACK_SAMPLE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

template <int W>
HWY_ATTR HWY_NOINLINE void LobeStack<W>::sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const {
  Pick<W> pick(w, choiceO.scale, kTechniques);
  for (uint32_t t = 0; t < kTechniques; ++t) pick.offer(t, choiceO.weight[t]);
  const Int<W> made = pick.made;
  const F share = pick.weight, rest = pick.rest;
  // its frame and shape
  const Mask<W> isFuzz = made == Int<W>(kMakeFuzz);
  const Mask<W> crosses = made == Int<W>(kMakeStraight), clears = made == Int<W>(kMakeClear);
  const Mask<W> sinks = (made == Int<W>(kMakeBelow)) | crosses, once = (made == Int<W>(kMakeSingle)) | clears;
  const Mask<W> flips = (made == Int<W>(kMakeTransmit)) | (made == Int<W>(kMakeGlassMultipleTransmit)) | sinks;
  Mask<W> facets(false), smooth(false), reflects(false), refracts(false);
  Frame<W> frame(normal);
  F ax(1.f), ay(1.f);
  for (uint32_t i = 0; i < kReflecting; ++i) {
    if (!k.has(kSpecular + i)) continue;
    const SpecularLobe<W>& l = specular[i];
    const Mask<W> one = made == Int<W>(kMakeSpecular + i);
    take(one | (made == Int<W>(kMakeMultiple + i)), l.frame, frame);
    ax = select(one, l.ax, ax);
    ay = select(one, l.ay, ay);
    facets = facets | one;
    smooth = smooth | (one & l.smooth);
  }
  if (k.has(kFuzz)) take(isFuzz, fuzzFrame, frame);
  if (k.has(kSubsurface)) {
    take(made == Int<W>(kMakeStandIn), Frame<W>(under), frame);
    take(sinks, Frame<W>(Ng), frame);
  }
  if (hasGlass()) {
    reflects = made == Int<W>(kMakeGlassReflect);
    refracts = made == Int<W>(kMakeGlassTransmit);
    take((made >= Int<W>(kMakeGlassReflect)) & (made < Int<W>(kTechniques)), glass.frame, frame);
    ax = select(reflects, glass.axReflect, select(refracts, glass.axTransmit, ax));
    ay = select(reflects, glass.ayReflect, select(refracts, glass.ayTransmit, ay));
    facets = facets | reflects | refracts;
    smooth = smooth | (reflects & glass.smoothReflect) | (refracts & glass.smoothTransmit);
  }
  // a direction in that frame
  Vec3<W> d;
  Mask<W> valid(true);
  if (!facets.all()) {
    d = cosineHemisphere(u, v);
    // What single scattering loses is mostly at grazing angles, where a cosine would seldom look: uniform, by the
    // same disk.
    const Mask<W> uniform = (made == Int<W>(kMakeGlassMultipleReflect)) |
                            (made == Int<W>(kMakeGlassMultipleTransmit)) |
                            ((made >= Int<W>(kMakeMultiple)) & (made < Int<W>(kMakeFuzz)));
    const F r2 = fma(d.x, d.x, d.y * d.y), stretch = select(uniform, sqrt(max(F(2.f) - r2, F(0.f))), F(1.f));
    d = Vec3<W>(d.x * stretch, d.y * stretch, select(uniform, max(F(1.f) - r2, F(0.f)), d.z));
    d.z = select(flips, -d.z, d.z);
    if (isFuzz.any()) d = select(isFuzz, fuzz.sample(u, v), d);
  }
  if (facets.any()) {
    const Vec3<W> local = localOut(frame, wo);
    const Vec3<W> h = select(smooth, Vec3<W>(F(0.f), F(0.f), F(1.f)), sampleVisibleNormal(local, ax, ay, u, v));
    Vec3<W> r = reflect(local, h);
    Mask<W> good = r.z > F(0.f);
    // a rough glass facet reflects or refracts by its own Fresnel; what is left of w within its share decides
    if (((reflects | refracts) & (!smooth)).any()) {
      const Mask<W> free = (reflects | refracts) & glass.chooses();
      F chance, other;
      glass.chances(glass.fresnel(dot(local, h)), chance, other);
      refracts = (refracts & (!free)) | (free & (rest >= chance * max(share, F(1e-30f))));
    }
    if (refracts.any()) {
      Vec3<W> t(r.x, r.y, -r.z);
      Mask<W> passes = good;
      if (!k.glass.thin) {
        passes = refract(local, h, glass.eta, t);
        passes = passes & (t.z < F(0.f));
      }
      r = select(refracts, t, r);
      good = (good & !refracts) | (passes & refracts);
    }
    d = select(facets, r, d);
    valid = good | !facets;
  }
  out.wi = normalize(frame.toWorld(d));
  F lets(1.f);  // of a blurred boundary, over what a clear one lets in
  if (once.any()) {
    Vec3<W> bent, facet = Ng;
    const Mask<W> blurred = once & (singleAlpha > F(0.f));
    if (blurred.any()) {
      // the visible facets of a GGX boundary (Walter et al. 2007); what they shadow or turn back is lost
      const Frame<W> plane(Ng);
      const Vec3<W> local = localOut(plane, wo), h = sampleVisibleNormal(local, singleAlpha, singleAlpha, u, v);
      facet = select(blurred, plane.toWorld(h), Ng);
      const F seen = clamp(dot(local, h), F(0.f), F(1.f)), flat = clamp(local.z, F(0.f), F(1.f));
      refract(wo, facet, singleEta, bent);
      const F own = F(1.f) + smithLambda(true, local, singleAlpha, singleAlpha);
      const F other = smithLambda(true, plane.toLocal(normalize(bent)), singleAlpha, singleAlpha);
      const F clear = max(F(1.f) - fresnelDielectric(flat, singleEta), F(1e-6f));
      lets = select(blurred, (F(1.f) - fresnelDielectric(seen, singleEta)) / clear * own / (own + other), lets);
    }
    refract(wo, facet, singleEta, bent);
    out.wi = select(once, normalize(bent), out.wi);
  }
  // A direction that ends on the wrong side of the geometric surface is lost, even where another lobe could have
  // made it: its maker's density is zero there.
  const F side = dot(Ng, out.wi);
  const Mask<W> through = flips | refracts | once;
  out.valid = valid & (choiceO.scale > F(0.f)) & ((through & (side < F(0.f))) | ((!through) & (side > F(0.f))));
  out.discrete = smooth | sinks | once;
  if (smooth.any()) mirror(made, share * choiceO.scale, out);
  if ((sinks | once).none()) return;
  // What lies above takes its part where the path goes in.
  Rgb<W> upper(1.f), lower(1.f);
  if (attenuates()) attenuation(Layers<W>(), upper, lower);
  out.below = sinks | once;
  out.once = once;
  out.straight = crosses | clears;
  out.discreteWeight = select(sinks, select(crosses, straight, below) * lower, out.discreteWeight);
  if (once.any()) {
    out.discreteWeight = select(once, select(clears, clear, single) * lower * lets, out.discreteWeight);
    out.discreteLobe = select(once, Int<W>(uint32_t(kSingleScatter)), out.discreteLobe);
  }
  out.discreteProbability = select(sinks | once, share * choiceO.scale, out.discreteProbability);
  out.discreteLobe = select(sinks, Int<W>(uint32_t(kSubsurface)), out.discreteLobe);
}

// Value and probability of the mirror that was chosen.
template <int W>
HWY_ATTR HWY_NOINLINE void LobeStack<W>::mirror(const Int<W>& made, const F& probability, LobeSample<W>& out) const {
  const Mask<W> through = made == Int<W>(kMakeGlassTransmit);
  Rgb<W> upper(1.f), lower(1.f), value;
  Seen<W> seenI;
  const bool fits = hasGlass() && glass.mayFit();
  if (attenuates() || fits) {
    seenI.outside = seenO.outside ^ through;
    see(out.wi, through, seenI);
  }
  if (attenuates()) {
    Layers<W> layersI;
    layer(seenI, layersI);
    attenuation(layersI, upper, lower);
  }
  Int<W> lobe(0);
  for (uint32_t i = 0; i < kReflecting; ++i) {
    if (!k.has(kSpecular + i)) continue;
    const Mask<W> here = made == Int<W>(kMakeSpecular + i);
    if (here.none()) continue;
    const Rgb<W> f = specular[i].fresnel(specular[i].wo.z);
    value = select(here, i == kCoat ? f : f * upper, value);
    lobe = select(here, Int<W>(kSpecular + i), lobe);
  }
  if (hasGlass()) {
    const Mask<W> reflected = made == Int<W>(kMakeGlassReflect);
    const F f = glass.fresnel(glass.wo.z);
    Rgb<W> mirrored = lower * (f * glass.reflectGain);
    if (k.glass.tinted) mirrored = mirrored * glass.reflectTint;
    value = select(reflected, mirrored, value);
    F passed = (F(1.f) - f) * glass.radianceScale;
    if (fits) passed = passed * min(seenO.glass.fit, seenI.glass.fit);
    value = select(through, glass.transmitColor * lower * passed, value);
    lobe =
        select(reflected, Int<W>(uint32_t(kGlassReflect)), select(through, Int<W>(uint32_t(kGlassTransmit)), lobe));
  }
  out.discreteWeight = value;
  out.discreteProbability = probability;
  out.discreteLobe = lobe;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
