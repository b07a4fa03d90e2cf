// A clear coat around a fibre, as the top of a layer over hair: one more surface that reflects, round as the fibre is, so
// that its light leaves as the fibre's own reflection does: about the mirrored inclination, at twice the azimuth of the
// normal where the ray met it. What it does not reflect reaches what it lies on. It has no scales.
//
// What is reflected and what is let through are those of the side that light is asked from (as hair::ChiangFiber's
// shares are): with white hair under a white coat all light comes back, to the letter. Included per target.
#include "plugins/bxdf/hair/fiber.h"

#ifndef KINORA_HAIR_COAT_ONCE
#define KINORA_HAIR_COAT_ONCE
namespace kinora::hair {
struct CoatClosure {
  bool adjoint = false, byReflectivity = false;
  Value color, through, roughness, ior;  // ior: or the reflectance face on
};
}  // namespace kinora::hair
#endif

#if defined(KINORA_HAIR_COAT_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_HAIR_COAT_H_TARGET
#undef KINORA_HAIR_COAT_H_TARGET
#else
#define KINORA_HAIR_COAT_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {

template <int W>
struct FiberCoat {
  using F = Float<W>;
  // What is known of the direction that light comes from, whichever of the two that is.
  struct Side {
    Inclination<W> seen;
    F centre;      // azimuth to which light leaves, from the direction it comes from
    Rgb<W> share;  // of the light
    F energy[1], total;
    KN_INLINE Side() {}
  };
  FiberFrame<W> frame;
  Vec3<W> Ng;
  AlongLobe<W> along;
  AboutLobe<W> about;
  F ior;
  Rgb<W> tint, through;
  Side own;
  bool adjoint;
  KN_INLINE FiberCoat() {}

  HWY_ATTR HWY_NOINLINE FiberCoat(const hair::CoatClosure& k, const FiberFrame<W>& f, const Surface<W>& s)
      : frame(f), Ng(s.Ng), adjoint(k.adjoint) {
    const F none(0.f), one(1.f);
    ior = loadFloat<W>(k.ior, s.at);
    if (k.byReflectivity) {
      const F r = sqrt(clamp(ior, none, F(0.9f)));
      ior = (one + r) / (one - r);
    }
    ior = clamp(ior, F(1.01f), F(40.f));
    // A facet that is tilted by an angle turns what it reflects by twice that; Beckmann's slopes of a width alpha deviate
    // by alpha / sqrt(2). A degree is the least, as of the fibre's own lobes.
    const F rough = clamp(loadFloat<W>(k.roughness, s.at), none, one);
    const F deviation = max(rough * rough * F(1.41421356f), F(kPi / 180.f));
    along = AlongLobe<W>(deviation);
    about = AboutLobe<W>(deviation);
    tint = positive(loadRgb<W>(k.color, s.at));
    through = positive(loadRgb<W>(k.through, s.at));
    own = sideOf(frame.outgoing, frame.gamma);
  }

  KN_INLINE Side sideOf(const Inclination<W>& o, F normal) const {
    Side s;
    F h, cosGamma;
    sincos(normal, h, cosGamma);
    s.seen = o;
    s.centre = normal + normal;
    s.share = tint * fresnelDielectric(o.c * max(cosGamma, F(0.f)), F(1.f) / ior);
    s.total = s.energy[0] = average(s.share);
    return s;
  }
  KN_INLINE void densities(const Side& from, const Inclination<W>& i, F phi, F out[1]) const {
    out[0] = along.density(from.seen, i) * about.density(phi - from.centre);
  }
  // What reaches the fibre below, by channel.
  KN_INLINE Rgb<W> passes(const Side& side) const {
    const F none(0.f), one(1.f);
    return through * Rgb<W>(clamp(one - side.share.x, none, one), clamp(one - side.share.y, none, one),
                            clamp(one - side.share.z, none, one));
  }
  // To the two lobes from `lobe` on: that of wo's side and that from behind.
  template <class Scale>
  KN_INLINE void add(const Side& side, const F density[1], Scale scale, Vec3<W> wi, uint32_t lobe,
                     LobeSum<W>& out) const {
    const Mask<W> above = dot(Ng, wi) >= F(0.f);
    const Rgb<W> w = side.share * (scale * density[0]);
    out.add(lobe, zeroUnless(above, w));
    out.add(lobe + 1, zeroUnless(!above, w));
  }
  KN_INLINE void sample(F u, F v, F w, LobeSample<W>& out) const {
    F turnSine, turnCosine;
    sincos(v * F(kTwoPi), turnSine, turnCosine);
    out.wi = normalize(frame.direction(along.sample(own.seen, u, turnCosine), own.centre + about.sample(w)));
    out.valid = own.total > F(0.f);
    out.discrete = Mask<W>(false);
    out.below = Mask<W>(false);
  }
  KN_INLINE Rgb<W> albedo() const { return own.share; }
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
