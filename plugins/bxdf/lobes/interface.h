// A stack of lobes as a boundary that manifold walks go through: its glass, or where there is none its first specular
// lobe. Included per target, by stack.cpp alone.
#include "stack.h"

#if defined(KINORA_LOBES_INTERFACE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LOBES_INTERFACE_H_TARGET
#undef KINORA_LOBES_INTERFACE_H_TARGET
#else
#define KINORA_LOBES_INTERFACE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

// The closure with the index of walks; which is the true one where facets are rough, since what they pass on is theirs.
inline const Closure* closureOfWalk(const Context& c, const Closure& k) {
  const Value& w = k.glass.walkIor;
  bool any = false;
  for (uint32_t i = 0; w.components && i < (w.stride ? c.count : 1u); ++i) any = any || w.data[0][i] > 0.f;
  if (!any) return &k;
  Closure* own = new (c.alloc<Closure>(1)) Closure(k);
  float* ior = c.alloc<float>(c.padded);
  for (uint32_t i = 0; i < c.padded; ++i) {
    const auto at = [&](const Value& v) { return v.data[0][v.stride ? i : 0]; };
    const float x = at(w), r = at(k.glass.roughness), t = at(k.glass.refractionRoughness), own2 = t < 0 ? r : t;
    ior[i] = x > 0.f && r * r < kMirrorAlpha && own2 * own2 < kMirrorAlpha ? x : at(k.glass.ior);
  }
  own->glass.ior = Value();
  own->glass.ior.data[0] = ior;
  own->glass.ior.stride = own->glass.ior.components = 1;
  return own;
}

template <int W>
struct StackInterface {
  using F = Float<W>;

  static void describe(const Context* c, const void* closure, const InterfaceArgs* a) {
    const Closure& k = *closureOfWalk(*c, *static_cast<const Closure*>(closure));
    for (uint32_t i = 0; i < c->count; i += W) {
      const Surface<W> s(*c, At{i, false});
      const LobeStack<W> lanes(k, s);
      const Mask<W> through = Int<W>::load(a->through + i) != Int<W>(0);
      F eta(1.f), alpha(0.f);
      Int<W> lobe(kNoLobe);
      if (lanes.hasGlass()) {
        const Mask<W> smooth = (through & lanes.glass.smoothTransmit) | ((!through) & lanes.glass.smoothReflect);
        eta = lanes.glass.eta;
        alpha = select(smooth, F(0.f),
                       select(through, sqrt(lanes.glass.axTransmit * lanes.glass.ayTransmit),
                              sqrt(lanes.glass.axReflect * lanes.glass.ayReflect)));
        if (k.has(kGlassTransmit)) lobe = select(through, Int<W>(uint32_t(kGlassTransmit)), lobe);
        if (k.has(kGlassReflect)) lobe = select(through, lobe, Int<W>(uint32_t(kGlassReflect)));
      } else if (k.has(kSpecular)) {
        const SpecularLobe<W>& l = lanes.specular[0];
        alpha = select(l.smooth, F(0.f), sqrt(l.ax * l.ay));
        const Mask<W> here = (!through) & (k.specular[0].doubleSided ? Mask<W>(true) : s.entering);
        lobe = select(here, Int<W>(uint32_t(kSpecular)), lobe);
      }
      eta.store(a->eta + i);
      alpha.store(a->alpha + i);
      lobe.store(a->lobe + i);
    }
  }

  static void value(const Context* c, const void* closure, const InterfaceValueArgs* a) {
    const Closure& k = *closureOfWalk(*c, *static_cast<const Closure*>(closure));
    for (uint32_t i = 0; i < c->count; i += W) {
      const Surface<W> s(*c, At{i, false});
      const LobeStack<W> lanes(k, s);
      const Mask<W> through = Int<W>::load(a->through + i) != Int<W>(0);
      const Vec3<W> wi = Vec3<W>::load(a->wi, i);
      Mask<W> smooth(false), some(false);
      Int<W> made(kTechniques);
      uint32_t reflects = kSpecular, refracts = kSpecular;
      if (lanes.hasGlass()) {
        smooth = (through & lanes.glass.smoothTransmit) | ((!through) & lanes.glass.smoothReflect);
        made = select(through, Int<W>(uint32_t(kMakeGlassTransmit)), Int<W>(uint32_t(kMakeGlassReflect)));
        some = (through & Mask<W>(k.has(kGlassTransmit))) | ((!through) & Mask<W>(k.has(kGlassReflect)));
        reflects = kGlassReflect;
        refracts = kGlassTransmit;
      } else if (k.has(kSpecular)) {
        smooth = lanes.specular[0].smooth;
        made = Int<W>(uint32_t(kMakeSpecular));
        some = (!through) & (k.specular[0].doubleSided ? Mask<W>(true) : s.entering);
      }
      Rgb<W> out;
      if ((some & smooth).any()) {
        LobeSample<W> sample;
        sample.wi = wi;
        lanes.mirror(made, F(1.f), sample);
        out = select(smooth, sample.discreteWeight, out);
      }
      if ((some & !smooth).any()) {
        // each lobe has a slot of its own here, whatever expressions tell apart
        alignas(64) uint8_t slotOfLobe[kLobeCount];
        for (uint32_t l = 0; l < kLobeCount; ++l) slotOfLobe[l] = l == reflects ? 0 : l == refracts ? 1 : 2;
        LobeSum<W> sum;
        sum.slotOfLobe = slotOfLobe;
        lanes.evaluate(wi, sum);
        out = select(smooth, out, select(through, sum.slot[1], sum.slot[0]));
      }
      zeroUnless(some & isFinite(out), out).store(a->value, i);
    }
  }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
