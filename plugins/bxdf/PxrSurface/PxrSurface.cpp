// PxrSurface: the general material. Lobes, top to bottom: fuzz, clear coat, specular and rough specular, then diffuse
// (reflected and transmitted) and glass. This file binds parameters, attenuates lower lobes, and mixes the lobes into
// one density; the lobes themselves are in diffuse.h, specular.h and glass.h. It does not render subsurface and
// single scattering, iridescence and layers (their parameters are declared). How much what is above takes from what
// is below: coat and specular by their directional albedo (times the compensation parameters), the greater of the two
// directions', which is reciprocal and never gains; the coat absorbs along both refracted directions.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrSurface/PxrSurface.cpp"
#include <kinora/bxdf.h>
#include <iterator>
#include <new>
#include <kinora/simd/foreach_target.h>
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include "parameters.h"
#include "closure.h"
#include "diffuse.h"
#include "specular.h"
#include "glass.h"

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using namespace pxrSurface;

// ---- binding ----
bool isZero(const Value& v) {
  if (v.stride) return false;
  for (uint32_t i = 0; i < v.components; ++i)
    if (v.data[i][0] != 0.f) return false;
  return true;
}
bool flag(const Context& c, uint32_t index) { return c.param(index).data[0][0] != 0.f; }

int bindNormal(const Context& c, Closure& k, uint32_t index, int general) {
  const Value v = c.param(index);
  if (!isBumped(v)) return general;
  k.normals[k.normalCount] = v;
  return k.normalCount++;
}
// A bump input where it is connected, the general normal where it is 0 0 0.
template <int W>
KN_INLINE Vec3<W> lobeNormal(const Value& v, const Surface<W>& s, Vec3<W> general) {
  const Vec3<W> n = loadVec<W>(v, s.at);
  return select(dot(n, n) > Float<W>(1e-12f), bumpedNormal<W>(v, s), general);
}
void bindAnisotropy(const Context& c, AnisotropyClosure& a, uint32_t amount, uint32_t direction) {
  a.amount = c.param(amount);
  a.on = !isZero(a.amount);
  if (!a.on) return;
  a.tangent = c.builtin(Builtin::Tangent);
  a.direction = c.param(direction);
  a.directed = !isZero(a.direction);
}
void bindSpecular(const Context& c, Closure& k, uint32_t which, int bump) {
  SpecularClosure& l = k.specular[which];
  const uint32_t first = kSpecularFirst[which];
  l.physical = flag(c, first + kFresnelMode);
  l.edge = c.param(first + kEdgeColor);
  if (!l.physical) l.face = c.param(first + kFaceColor);
  if (isZero(l.edge) && (l.physical || isZero(l.face))) return;
  k.on |= 1u << (kSpecular + which);
  if (l.physical) {
    l.ior = c.param(first + kIor);
    l.extinction = c.param(first + kExtinction);
  } else {
    l.shape = c.param(first + kFresnelShape);
  }
  l.ggx = flag(c, first + kModelType);
  l.doubleSided = flag(c, first + kDoubleSided);
  l.roughness = c.param(first + kRoughness);
  bindAnisotropy(c, l.anisotropy, first + kAnisotropy, first + kAnisotropyDirection);
  l.bump = bindNormal(c, k, first + kBump, bump);
}
const GlassEnergy* glassTable(const Context& c, const Value& ior) {
  float low = 1e30f, high = 1;
  for (uint32_t i = 0; i < c.count; ++i) {
    const float inside = ior.data[0][ior.stride ? i : 0], outside = c.outerIor[i];
    const float m = inside > outside ? inside / outside : outside / inside;
    low = m < low ? m : low;
    high = m > high ? m : high;
  }
  return &glassEnergyTable(low, high);
}
void bindGlass(const Context& c, Closure& k, int bump) {
  GlassClosure& g = k.glass;
  g.reflectionGain = c.param(at("reflectionGain"));
  g.refractionGain = c.param(at("refractionGain"));
  if (!isZero(g.reflectionGain)) k.on |= 1u << kGlassReflect;
  if (!isZero(g.refractionGain)) k.on |= 1u << kGlassTransmit;
  if (!k.has(kGlassReflect) && !k.has(kGlassTransmit)) return;
  g.thin = flag(c, at("thinGlass"));
  g.refractionColor = c.param(at("refractionColor"));
  g.roughness = c.param(at("glassRoughness"));
  g.refractionRoughness = c.param(at("glassRefractionRoughness"));
  g.ior = c.param(at("glassIor"));
  bindAnisotropy(c, g.anisotropy, at("glassAnisotropy"), at("glassAnisotropyDirection"));
  g.bump = bindNormal(c, k, at("glassBumpNormal"), bump);
  if (!g.thin) k.glassEnergy = glassTable(c, g.ior);
}
void bind(const Context& c, Closure& k) {
  k.radiance = !(c.traits & kTraitLightPath);
  const int bump = bindNormal(c, k, at("bumpNormal"), -1);
  k.bumped = bump == 0;
  k.diffuseGain = c.param(at("diffuseGain"));
  k.diffuseDoubleSided = flag(c, at("diffuseDoubleSided"));
  if (!isZero(k.diffuseGain)) {
    k.on |= 1u << kDiffuse;
    k.diffuseColor = c.param(at("diffuseColor"));
    k.diffuseRoughness = c.param(at("diffuseRoughness"));
    k.diffuseExponent = c.param(at("diffuseExponent"));
    k.backHasOwnColor = k.diffuseDoubleSided && !flag(c, at("diffuseBackUseDiffuseColor"));
    if (k.backHasOwnColor) k.diffuseBackColor = c.param(at("diffuseBackColor"));
  }
  if (k.diffuseDoubleSided) {
    k.transmitGain = c.param(at("diffuseTransmitGain"));
    if (!isZero(k.transmitGain)) {
      k.on |= 1u << kDiffuseTransmit;
      k.transmitColor = c.param(at("diffuseTransmitColor"));
    }
  }
  if (k.has(kDiffuse) || k.has(kDiffuseTransmit)) k.diffuseBump = bindNormal(c, k, at("diffuseBumpNormal"), bump);
  for (uint32_t i = 0; i < 3; ++i) bindSpecular(c, k, i, bump);
  k.fuzzGain = c.param(at("fuzzGain"));
  if (!isZero(k.fuzzGain)) {
    k.on |= 1u << kFuzz;
    k.fuzzColor = c.param(at("fuzzColor"));
    k.fuzzConeAngle = c.param(at("fuzzConeAngle"));
    k.fuzzDoubleSided = flag(c, at("fuzzDoubleSided"));
    k.fuzzBump = bindNormal(c, k, at("fuzzBumpNormal"), bump);
  }
  bindGlass(c, k, bump);
  const bool specular = k.has(kSpecular) || k.has(kRoughSpecular);
  if (specular || k.has(kClearcoat) || k.glass.thin) k.reflectionEnergy = &reflectionEnergyTable();
  if (k.has(kClearcoat)) {
    k.coatThickness = c.param(at("clearcoatThickness"));
    k.coatTint = c.param(at("clearcoatAbsorptionTint"));
    k.coatCompensation = c.param(at("clearcoatEnergyCompensation"));
    k.coatAttenuates = (!isZero(k.coatThickness) && !isZero(k.coatTint)) || !isZero(k.coatCompensation);
  }
  if (specular) {
    k.specularCompensation = c.param(at("specularEnergyCompensation"));
    k.specularAttenuates = !isZero(k.specularCompensation);
  }
  k.glowGain = c.param(at("glowGain"));
  k.glows = !isZero(k.glowGain);
  if (k.glows) k.glowColor = c.param(at("glowColor"));
}

// Ways to make a direction. Each lobe that is rough has one for its single scattering and one for what that loses.
enum Technique : uint32_t {
  kMakeDiffuse,
  kMakeTransmit,
  kMakeSpecular,
  kMakeMultiple = kMakeSpecular + 3,
  kMakeFuzz = kMakeMultiple + 3,
  kMakeGlassReflect,
  kMakeGlassTransmit,
  kMakeGlassMultipleReflect,
  kMakeGlassMultipleTransmit,
  kTechniques
};

// What the lobes need to know of one direction, whichever role it has.
template <int W>
struct Seen {
  Mask<W> outside;            // it is on the outer side of the surface
  Float<W> mu[3], energy[3];  // specular lobes: cosine with their normal, directional energy
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

struct PxrSurface {
  using Closure = pxrSurface::Closure;
  template <int W>
  using HasEmission = void;

  static void begin(const Context& c, Closure& k) { bind(c, k); }
  static void presence(const Context* c, float* out) { copyFloat(c->param(at("presence")), c->padded, out); }
  static void interior(const Context* c, const InteriorArgs* a) {
    copyFloat(c->param(at("glassIor")), c->padded, a->ior);
    const Value extinction = c->param(at("extinction")), albedo = c->param(at("ssAlbedo"));
    for (int channel = 0; channel < 3; ++channel)
      for (uint32_t i = 0; i < c->padded; ++i) {
        const float e = extinction.data[channel][extinction.stride ? i : 0],
                    s = albedo.data[channel][albedo.stride ? i : 0];
        const float absorbed = e * (1 - s);
        a->absorption[channel][i] = absorbed > 0 ? absorbed : 0;
      }
  }
  // Light that goes straight on through glass: its tint and what Fresnel lets pass.
  template <int W>
  static void thinShadow(const Context* c, float* const rgb[3]) {
    const Value gain = c->param(at("refractionGain")), color = c->param(at("refractionColor")),
                ior = c->param(at("glassIor"));
    const bool thin = flag(*c, at("thinGlass"));
    for (uint32_t i = 0; i < c->count; i += W) {
      const Surface<W> s(*c, At{i, false});
      const Float<W> one(1.f), inside = max(loadFloat<W>(ior, s.at), Float<W>(1e-3f)),
                               outside = max(s.outerIor, Float<W>(1e-3f));
      const Float<W> eta = thin ? outside / inside : select(s.entering, outside / inside, inside / outside);
      const Float<W> f = fresnelDielectric(min(s.cosO, one), eta), share = thin ? (one - f) / (one + f) : one - f;
      (loadRgb<W>(color, s.at) * (loadFloat<W>(gain, s.at) * share)).store(rgb, i);
    }
  }
  template <int W>
  static HWY_ATTR Rgb<W> emission(const Closure& k, At where) {
    return k.glows ? loadRgb<W>(k.glowColor, where) * loadFloat<W>(k.glowGain, where) : Rgb<W>();
  }

  template <int W>
  struct Lanes {
    using F = Float<W>;
    const Closure& k;
    Vec3<W> Ng, wo;
    // diffuse
    Vec3<W> normal;
    F muO;
    Rgb<W> front, back, reflectance, transmittance;
    F frontMean, backMean, transmitMean, exponent;
    F transmitShare[2];  // of diffuse transmission from wo's side and from behind
    RoughDiffuse<W> rough;
    Seen<W> seenO;
    Choice<W> choiceO;
    // Lobes that are off are not even cleared: an unnamed union runs no constructor.
    union {
      SpecularLobe<W> specular[3];
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

    HWY_ATTR HWY_NOINLINE Lanes(const Closure& closure, const Surface<W>& s) : k(closure), Ng(s.Ng), wo(s.wo) {
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
      for (int i = 0; i < 3; ++i)
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

    HWY_ATTR HWY_NOINLINE void evaluate(const Vec3<W>& wi, LobeSum<W>& out) const {
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
      if (k.has(kDiffuse) || k.has(kDiffuseTransmit)) {
        const F muI = dot(normal, wi);
        if (k.has(kDiffuse)) {
          const Mask<W> here = above & (muI > none);
          const F law = muI * minnaert(exponent, muO, max(muI, none));
          out.add(kDiffuse, zeroUnless(here, rough.evaluate(reflectance, muO, muI, dot(wo, wi)) * lower * law));
          add(here, choiceO, choiceI, kMakeDiffuse, muI * F(kInvPi), muO * F(kInvPi), pdf, reverse);
        }
        if (k.has(kDiffuseTransmit)) {
          const Mask<W> here = below & (muI < none);
          out.add(kDiffuseTransmit, zeroUnless(here, transmittance * lower * (-muI * F(kInvPi))));
          add(here, choiceO, choiceI, kMakeTransmit, -muI * F(kInvPi), muO * F(kInvPi), pdf, reverse);
        }
      }
      for (int i = 0; i < 3; ++i) {
        if (!k.has(kSpecular + i)) continue;
        const SpecularLobe<W>& l = specular[i];
        const Vec3<W> w = l.frame.toLocal(wi);
        const Mask<W> here = above & (w.z > none) & onSide(k.specular[i].doubleSided, seenO.outside) & !l.smooth;
        if (here.none()) continue;
        F p, r;
        const Rgb<W> f = l.evaluate(w, seenO.energy[i], seenI.energy[i], p, r);
        out.add(kSpecular + i, zeroUnless(here, i == 2 ? f : f * upper));
        add(here, choiceO, choiceI, kMakeSpecular + i, p, r, pdf, reverse);
        add(here, choiceO, choiceI, kMakeMultiple + i, F(kInvTwoPi), F(kInvTwoPi), pdf, reverse);
      }
      if (k.has(kFuzz)) {
        const F muI = dot(fuzzFrame.z, wi);
        const Mask<W> here = above & (muI > none) & onSide(k.fuzzDoubleSided, seenO.outside);
        out.add(kFuzz, zeroUnless(here, fuzzColor * (fuzz.evaluate(muFuzzO, muI) * muI)));
        add(here, choiceO, choiceI, kMakeFuzz, fuzz.pdf(muI), fuzz.pdf(muFuzzO), pdf, reverse);
      }
      if (hasGlass()) {
        const Vec3<W> w = glass.frame.toLocal(wi);
        const Mask<W> up = above & (w.z > none), down = below & (w.z < none);
        const F cosine = abs(w.z);
        GlassPdfs<W> p;
        if (k.has(kGlassReflect) && up.any()) {
          const F one = glass.evaluateReflect(w, p);
          const F f =
              fma(glass.multipleReflected(seenO.glass.lost, seenI.glass.lost), cosine, one) * glass.reflectGain;
          out.add(kGlassReflect, zeroUnless(up, lower * f));
          add(up, choiceO, choiceI, kMakeGlassReflect, p.first, p.firstReverse, pdf, reverse);
          add(up, choiceO, choiceI, kMakeGlassTransmit, p.second, p.secondReverse, pdf, reverse);
          add(up, choiceO, choiceI, kMakeGlassMultipleReflect, F(kInvTwoPi), F(kInvTwoPi), pdf, reverse);
        }
        if (k.has(kGlassTransmit) && down.any()) {
          const F one = glass.evaluateTransmit(w, p);
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

    HWY_ATTR HWY_NOINLINE void sample(const F& u, const F& v, const F& w, LobeSample<W>& out) const {
      // which technique; rounding never walks past the last that has weight
      Int<W> made(kTechniques);
      F rest = w / max(choiceO.scale, F(1e-30f)), share(0.f);
      Mask<W> open = choiceO.scale > F(0.f);
      for (uint32_t t = 0; t < kTechniques; ++t) {
        const F weight = choiceO.weight[t];
        const Mask<W> here = open & (weight > F(0.f));
        made = select(here, Int<W>(t), made);
        share = select(here, weight, share);
        const Mask<W> past = here & (rest >= weight);
        open = past | (open & (!here));
        rest = select(past, rest - weight, rest);
      }
      // its frame and shape
      const Mask<W> isFuzz = made == Int<W>(kMakeFuzz);
      const Mask<W> flips = (made == Int<W>(kMakeTransmit)) | (made == Int<W>(kMakeGlassMultipleTransmit));
      Mask<W> facets(false), smooth(false), reflects(false), refracts(false);
      Frame<W> frame(normal);
      F ax(1.f), ay(1.f);
      for (uint32_t i = 0; i < 3; ++i) {
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
      // A direction that ends on the wrong side of the geometric surface is lost, even where another lobe could have
      // made it: its maker's density is zero there.
      const F side = dot(Ng, out.wi);
      const Mask<W> through = flips | refracts;
      out.valid = valid & (choiceO.scale > F(0.f)) & ((through & (side < F(0.f))) | ((!through) & (side > F(0.f))));
      out.discrete = smooth;
      if (smooth.any()) mirror(made, share * choiceO.scale, out);
    }

    // For the denoiser: what the lobes return, macroscopically; layers above are taken off at wo alone.
    HWY_ATTR HWY_NOINLINE Rgb<W> albedo() const {
      Rgb<W> sum = transmittance;
      // what single scattering loses comes back in the colour: the whole is nearly the reflectance itself
      if (k.has(kDiffuse)) sum += reflectance * pow(muO, max(exponent, F(1.f)) - F(1.f));
      if (hasGlass()) {
        const F mirrored = glass.reflectGain * glassReflected();
        sum += Rgb<W>(mirrored, mirrored, mirrored) + glass.transmitColor * glassTransmitted();
      }
      Rgb<W> upper(1.f), lower(1.f);
      if (attenuates()) attenuation(Layers<W>(), upper, lower);
      sum = sum * lower;
      for (int i = 0; i < 3; ++i)
        if (k.has(kSpecular + i)) {
          const Rgb<W> a = zeroUnless(onSide(k.specular[i].doubleSided, seenO.outside),
                                      specular[i].albedo(seenO.mu[i], seenO.energy[i]));
          sum += i == 2 ? a : a * upper;
        }
      if (k.has(kFuzz))
        sum += zeroUnless(onSide(k.fuzzDoubleSided, seenO.outside), fuzzColor * fuzz.albedoBound(muFuzzO));
      const F none(0.f), one(1.f);
      return {clamp(sum.x, none, one), clamp(sum.y, none, one), clamp(sum.z, none, one)};
    }

   private:
    KN_INLINE bool hasGlass() const { return k.has(kGlassReflect) || k.has(kGlassTransmit); }
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
      for (int i = 0; i < 3; ++i)
        if (k.has(kSpecular + i)) {
          x.mu[i] = min(abs(dot(specular[i].frame.z, d)), F(1.f));
          x.energy[i] = specular[i].energy(x.mu[i]);
        }
      if (k.has(kFuzz)) x.muFuzz = min(abs(dot(fuzzFrame.z, d)), F(1.f));
      if (hasGlass()) x.glass = glass.shares(min(abs(dot(glass.frame.z, d)), F(1.f)), behind);
    }
    HWY_ATTR HWY_NOINLINE void choose(const Seen<W>& x, const Mask<W>& behind, Choice<W>& c) const {
      F sum(0.f);
      if (k.has(kDiffuse)) sum += c.weight[kMakeDiffuse] = select(x.outside, frontMean, backMean);
      if (k.has(kDiffuseTransmit))
        sum += c.weight[kMakeTransmit] = transmitMean * select(behind, transmitShare[1], transmitShare[0]);
      for (int i = 0; i < 3; ++i) {
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
        const Mask<W> here = onSide(k.specular[2].doubleSided, x.outside) & specular[2].present();
        const F ior = max(specular[2].ior(), F(1.f)), mu = x.mu[2];
        const F inside = sqrt(max(F(1.f) - fnma(mu, mu, F(1.f)) / (ior * ior), F(1e-4f)));
        y.depth = zeroUnless(here, coatDepth / inside);
        y.coat = zeroUnless(here, specular[2].albedo(mu, x.energy[2]) * coatCompensation);
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
    // Value and probability of the mirror that was chosen.
    HWY_ATTR HWY_NOINLINE void mirror(const Int<W>& made, const F& probability, LobeSample<W>& out) const {
      const Mask<W> through = made == Int<W>(kMakeGlassTransmit);
      Rgb<W> upper(1.f), lower(1.f), value;
      if (attenuates()) {
        Seen<W> seenI;
        seenI.outside = seenO.outside ^ through;
        see(out.wi, through, seenI);
        Layers<W> layersI;
        layer(seenI, layersI);
        attenuation(layersI, upper, lower);
      }
      Int<W> lobe(0);
      for (uint32_t i = 0; i < 3; ++i) {
        if (!k.has(kSpecular + i)) continue;
        const Mask<W> here = made == Int<W>(kMakeSpecular + i);
        if (here.none()) continue;
        const Rgb<W> f = specular[i].fresnel(specular[i].wo.z);
        value = select(here, i == 2 ? f : f * upper, value);
        lobe = select(here, Int<W>(kSpecular + i), lobe);
      }
      if (hasGlass()) {
        const Mask<W> reflected = made == Int<W>(kMakeGlassReflect);
        const F f = glass.fresnel(glass.wo.z);
        value = select(reflected, lower * (f * glass.reflectGain), value);
        value = select(through, glass.transmitColor * lower * ((F(1.f) - f) * glass.radianceScale), value);
        lobe = select(reflected, Int<W>(uint32_t(kGlassReflect)),
                      select(through, Int<W>(uint32_t(kGlassTransmit)), lobe));
      }
      out.discreteWeight = value;
      out.discreteProbability = probability;
      out.discreteLobe = lobe;
    }
  };
};

using Runner = BxdfRunner<PxrSurface>;
KINORA_WIDTH_TABLES(Runner, BxdfFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
using namespace pxrSurface;

bool mayBeOn(const ParamValue& v) {
  if (v.connected) return true;
  for (uint32_t i = 0; i < v.count; ++i)
    if (v.floats[i] != 0.f) return true;
  return false;
}
bool isSet(const ParamValue& v) { return v.count && v.floats[0] != 0.f; }

// A bit for each lobe that may be on, and one for what makes shading longer: materials of one group then take the
// same branches. Modes and switches are fixed parameters and part of the program already.
uint64_t programKey(const ParamValue* v, uint32_t) {
  uint64_t key = 0;
  if (mayBeOn(v[at("diffuseGain")])) key |= 1;
  if (isSet(v[at("diffuseDoubleSided")]) && mayBeOn(v[at("diffuseTransmitGain")])) key |= 2;
  for (uint32_t i = 0; i < 3; ++i) {
    const ParamValue* l = v + kSpecularFirst[i];
    if (!mayBeOn(l[kEdgeColor]) && (isSet(l[kFresnelMode]) || !mayBeOn(l[kFaceColor]))) continue;
    key |= uint64_t(4) << i;
    if (mayBeOn(l[kAnisotropy])) key |= uint64_t(256) << i;
  }
  if (mayBeOn(v[at("fuzzGain")])) key |= 32;
  if (mayBeOn(v[at("reflectionGain")])) key |= 64;
  if (mayBeOn(v[at("refractionGain")])) key |= 128;
  if ((key & 192) && mayBeOn(v[at("glassAnisotropy")])) key |= 2048;
  if ((key & 16) && (mayBeOn(v[at("clearcoatEnergyCompensation")]) ||
                     (mayBeOn(v[at("clearcoatThickness")]) && mayBeOn(v[at("clearcoatAbsorptionTint")]))))
    key |= 4096;
  if ((key & 12) && mayBeOn(v[at("specularEnergyCompensation")])) key |= 8192;
  if (mayBeOn(v[at("glowGain")])) key |= 16384;
  return key;
}
uint32_t enclosesMedium(const ParamValue* v, uint32_t) {
  return mayBeOn(v[at("refractionGain")]) && !isSet(v[at("thinGlass")]);
}

#define METAL "diffuseGain=0; specularFaceColor=1 1 1; specularEdgeColor=1 1 1; specularDoubleSided=1; "
#define GLASS "diffuseGain=0; reflectionGain=1; refractionGain=1; "
const char* const kLossless[] = {
    "diffuseColor=1 1 1; diffuseDoubleSided=1",
    "diffuseColor=1 1 1; diffuseDoubleSided=1; diffuseRoughness=0.5",
    "diffuseColor=1 1 1; diffuseDoubleSided=1; diffuseRoughness=1",
    "diffuseGain=0; diffuseDoubleSided=1; diffuseTransmitGain=1; diffuseTransmitColor=1 1 1",
    METAL "specularRoughness=0",
    METAL "specularRoughness=0.1; specularModelType=1",
    METAL "specularRoughness=0.4; specularModelType=1",
    METAL "specularRoughness=1; specularModelType=1",
    METAL "specularRoughness=0.1",
    METAL "specularRoughness=0.4",
    METAL "specularRoughness=1",
    "diffuseGain=0; roughSpecularFaceColor=1 1 1; roughSpecularEdgeColor=1 1 1; roughSpecularDoubleSided=1",
    "diffuseGain=0; clearcoatFaceColor=1 1 1; clearcoatEdgeColor=1 1 1; clearcoatDoubleSided=1; "
    "clearcoatRoughness=0.3",
    GLASS "glassRoughness=0",
    GLASS "glassRoughness=0.1",
    GLASS "glassRoughness=0.3; glassIor=1.33",
    GLASS "glassRoughness=0.6",
    GLASS "glassRoughness=1; glassIor=2",
    GLASS "glassRoughness=0; thinGlass=1",
    GLASS "glassRoughness=0.5; thinGlass=1",
    nullptr};
const char* const kConserving[] = {
    "diffuseColor=1 1 1; diffuseDoubleSided=1; diffuseExponent=4",
    "diffuseGain=0; fuzzGain=1; fuzzDoubleSided=1",
    "diffuseGain=0; fuzzGain=1; fuzzConeAngle=32; fuzzDoubleSided=1",
    METAL "specularFaceColor=0.9 0.6 0.3; specularRoughness=0.7; specularModelType=1",
    METAL
    "specularFresnelMode=1; specularIor=0.2 0.9 1.1; specularExtinctionCoeff=3.9 2.5 2.3; specularRoughness=0.5",
    "diffuseColor=0.9 0.9 0.9; diffuseDoubleSided=1; specularFresnelMode=1; specularEdgeColor=1 1 1; "
    "specularDoubleSided=1; "
    "specularRoughness=0.2; specularEnergyCompensation=1",
    "diffuseColor=0.9 0.9 0.9; diffuseDoubleSided=1; clearcoatFresnelMode=1; clearcoatEdgeColor=1 1 1; "
    "clearcoatDoubleSided=1; clearcoatEnergyCompensation=1; clearcoatThickness=0.5; clearcoatAbsorptionTint=0.2 0.5 "
    "0.9",
    GLASS "glassRoughness=0.3; refractionColor=0.9 0.7 0.5",
    nullptr};
#undef METAL
#undef GLASS

constexpr BxdfTraits kTraits{kLobes,          kLobeCount, int(at("presence")), &programKey,
                             &enclosesMedium, kLossless,  kConserving};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{
    kAbiVersion, sizeof(Descriptor), Kind::Bxdf,
    0,           "PxrSurface",       "General material: diffuse, three specular lobes, fuzz, glass and glow.",
    kParams,     kParamCount,        kTables,
    4,           &kTraits,           nullptr,
    nullptr};
}  // namespace
KINORA_REGISTER(PxrSurface, kDescriptor)
}  // namespace kinora
#endif
