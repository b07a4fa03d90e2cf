// PxrDisneyBsdf: the principled material of 2015 (Burley, "Extending the Disney BRDF to a BSDF with Integrated
// Subsurface Scattering", SIGGRAPH course): its parameters over a tree of slabs (../lama): diffuse with
// retroreflection and sheen under a dielectric, mixed with glass by specTrans and with a metal by metallic, under a
// clear coat. Other than as published, what lies below others gets what they let through, facets lose no energy, and
// the coat's normals are GGX's. Subsurface scattering is an exponential random walk.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrDisneyBsdf/PxrDisneyBsdf.cpp"
#include <kinora/bxdf_author.h>
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kBaseColor,
  kEmitColor,
  kMetallic,
  kSpecularTint,
  kRoughness,
  kAnisotropic,
  kAnisotropicDirection,
  kIor,
  kSpecReflectScale,
  kClearcoat,
  kClearcoatGloss,
  kSheen,
  kSheenTint,
  kDiffTrans,
  kSpecTrans,
  kThin,
  kTransColor,
  kTransmittanceColor,
  kAtDistance,
  kSubsurface,
  kSubsurfaceColor,
  kPresence,
  kBumpNormal,
  kScatterDistance,
  kSubsurfaceAnisotropy,
  kSsAnisotropy,
  kTransmissionBehavior,
  kShadowBumpTerminator
};
#define LATER "No effect yet. "
constexpr Param kParams[] = {
    param::color("baseColor", 0.5f).help("Colour of the surface: diffuse, of the metal, or of glass."),
    param::color("emitColor", 0.f).help("Radiance given off, on both sides."),
    param::number("metallic", 0.f).help("0 dielectric, 1 metal: no diffuse, reflections in baseColor."),
    param::number("specularTint", 0.f).help("Tints the dielectric's reflection towards the hue of baseColor."),
    param::number("roughness", 0.5f).help("Of diffuse, specular and glass; the facets' alpha is its square."),
    param::number("anisotropic", 0.f).help("Stretches highlights along the direction."),
    param::vector("anisotropicDirection", 0, 0, 0).help("That direction; 0 0 0: the surface's tangent."),
    param::number("ior", 1.5f).range(1, 3).help("Index of refraction of dielectric and glass."),
    param::number("specReflectScale", 1.f).help("Multiplies the dielectric's reflection."),
    param::number("clearcoat", 0.f).help("A colourless coat; 1 is a quarter of a dielectric's reflection."),
    param::number("clearcoatGloss", 1.f).help("0 satin .. 1 gloss: alpha 0.1 .. 0.001."),
    param::number("sheen", 0.f).help("An additional grazing part of the diffuse, for cloth."),
    param::number("sheenTint", 0.5f).help("Tints it towards the hue of baseColor."),
    param::number("diffTrans", 0.f).range(0, 2).help("Diffuse light that passes, in halves: 2 is all."),
    param::number("specTrans", 0.f).help("From the opaque dielectric to glass."),
    param::flag("thin", false).help("1: a sheet, which does not bend what passes; 0: bounds a medium."),
    param::color("transColor", 1.f).help("Multiplies what glass lets through."),
    param::color("transmittanceColor", 1.f).help("Colour left of white light after atDistance inside glass."),
    param::number("atDistance", 1.f).range(0.1f, 10).help("The distance of transmittanceColor, render units."),
    param::number("subsurface", 0.f).help("Share of the diffuse in subsurfaceColor, scattered below the surface."),
    param::color("subsurfaceColor", 1.f).help("Colour of that share."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
    param::color("scatterDistance", 0.f)
        .help("Diffuse mean free path of that share, render units; black: it is diffuse."),
    param::number("subsurfaceAnisotropy", 0.f).range(-1, 1).help("Mean cosine of that scattering, limited to 0.95."),
    param::number("ssAnisotropy", 0.f).range(-1, 1).help("Another name of it, where that is 0."),
    param::integer("transmissionBehavior", 0).range(0, 2).help(LATER "What shadow rays do."),
    param::flag("shadowBumpTerminator", true)
        .help("1: what bumps reflect that lean towards a light fades where the surface under them sees it no more. "
              "Not of mirrors and glass."),
    param::make(Type::Int, "inputAOV", 0, 0, 0).help("Patterns that show values in display channels: PxrMatteID."),
};
#undef LATER

struct PxrDisneyBsdf {
  static constexpr bool kGlass = true, kScatters = true;

  static float unit(float x) { return x < 0 ? 0 : x > 1 ? 1 : x; }

  static void begin(const Context& c, lama::Closure& k) {
    TreeBuilder tree(c, k);
    const Value base = c.param(kBaseColor), metallic = c.param(kMetallic), roughness = c.param(kRoughness);
    const Value specTrans = c.param(kSpecTrans), diffTrans = c.param(kDiffTrans), ior = c.param(kIor);
    const Value clearcoat = c.param(kClearcoat), emit = c.param(kEmitColor);
    const bool thin = flag(c, kThin), varies = !base.uniform();
    const int bump = bindNormal(c, k, kBumpNormal, -1);
    const bool softens = bump >= 0 && flag(c, kShadowBumpTerminator);
    lobes::AnisotropyClosure anisotropy;
    bindAnisotropy(c, anisotropy, kAnisotropic, kAnisotropicDirection);
    const Value white = constant(c, 3, 1);
    const auto push = [&](char kind, const Value& color, const Value& through) -> lama::Leaf& {
      lama::Leaf& l = tree.push(kind);
      l.color = color;
      l.through = through;
      l.roughness = roughness;
      l.bump = bump;
      l.softens = softens;
      return l;
    };
    // the hue of the base colour: its luminance, as the course of 2012 approximates it, is 1
    const auto tinted = [&](uint32_t channel, uint32_t i, float amount) {
      const float light = 0.3f * valueAt(base, 0, i) + 0.6f * valueAt(base, 1, i) + 0.1f * valueAt(base, 2, i);
      const float hue = light > 0 ? valueAt(base, channel, i) / light : 1;
      return 1 + unit(amount) * (hue - 1);
    };

    Value diffuse = base;
    const Value subsurface = c.param(kSubsurface), reach = c.param(kScatterDistance);
    const bool scatters = !isZero(subsurface) && !isZero(reach);
    if (!isZero(subsurface) && !scatters) {
      const Value own = c.param(kSubsurfaceColor);
      diffuse = computedValue(c, 3, !varies && subsurface.uniform() && own.uniform(), [&](uint32_t n, uint32_t i) {
        const float a = unit(valueAt(subsurface, 0, i));
        return (1 - a) * valueAt(base, n, i) + a * valueAt(own, n, i);
      });
    }
    Value sheen = c.param(kSheen);
    if (isZero(sheen)) {
      sheen = constant(c, 3, 0);
    } else {
      const Value amount = sheen, tint = c.param(kSheenTint);
      sheen = computedValue(c, 3, !varies && amount.uniform() && tint.uniform(), [&](uint32_t n, uint32_t i) {
        const float a = valueAt(amount, 0, i);
        return (a > 0 ? a : 0) * tinted(n, i, valueAt(tint, 0, i));
      });
    }
    push(lama::kKindBurley, diffuse, sheen);
    if (scatters) {
      lobes::SubsurfaceClosure& s = k.below[0];
      s.color = c.param(kSubsurfaceColor);
      s.reach = constant(c, 1, 1);
      s.reachColor = reach;
      s.directionality = c.param(kSubsurfaceAnisotropy);
      if (isZero(s.directionality)) s.directionality = c.param(kSsAnisotropy);
      push(lama::kKindSubsurface, s.color, white);
      tree.op(lama::kOpMix, subsurface, subsurface);
    }
    if (!isZero(diffTrans)) {
      push(lama::kKindTranslucent, diffuse, white);
      const Value half = computedValue(c, 1, diffTrans.uniform(),
                                       [&](uint32_t, uint32_t i) { return 0.5f * valueAt(diffTrans, 0, i); });
      tree.op(lama::kOpMix, half, half);
    }
    const Value scale = c.param(kSpecReflectScale), specularTint = c.param(kSpecularTint);
    const bool specularUniform = scale.uniform() && (isZero(specularTint) || (!varies && specularTint.uniform()));
    const Value reflected = computedValue(c, 3, specularUniform, [&](uint32_t n, uint32_t i) {
      return valueAt(scale, 0, i) * tinted(n, i, valueAt(specularTint, 0, i));
    });
    lama::Leaf& top = push(lama::kKindDielectric, reflected, white);
    tree.dielectric(top, ior);
    tree.stretch(top, anisotropy);
    tree.op(lama::kOpLayer, 1.f);
    if (!isZero(specTrans)) {
      // a ray passes two boundaries, or one sheet: half the colour at each
      const Value trans = c.param(kTransColor);
      const Value through = computedValue(c, 3, !varies && trans.uniform(), [&](uint32_t n, uint32_t i) {
        const float b = valueAt(base, n, i);
        return valueAt(trans, n, i) * (thin ? b : root(b));
      });
      lama::Leaf& glass = push(lama::kKindGlass, reflected, through);
      tree.glass(glass, ior, thin, anisotropy);
      glass.absorption = c.param(kTransmittanceColor);
      glass.absorptionRadius = c.param(kAtDistance);
      tree.op(lama::kOpMix, specTrans, specTrans);
    }
    if (!isZero(metallic)) {
      lama::Leaf& metal = push(lama::kKindSchlick, base, white);
      tree.schlick(metal, base, white, constant(c, 1, 5));
      tree.stretch(metal, anisotropy);
      tree.op(lama::kOpMix, metallic, metallic);
    }
    if (!isZero(clearcoat)) {
      lama::Leaf& coat = push(lama::kKindSchlick, white, white);
      const Value gloss = c.param(kClearcoatGloss);
      coat.roughness = computedValue(c, 1, gloss.uniform(), [&](uint32_t, uint32_t i) {
        return root(0.1f - 0.099f * unit(valueAt(gloss, 0, i)));
      });
      const auto part = [&](float x) {
        return computedValue(c, 3, clearcoat.uniform(), [&](uint32_t, uint32_t i) {
          const float a = valueAt(clearcoat, 0, i);
          return 0.25f * x * (a > 0 ? a : 0);
        });
      };
      tree.schlick(coat, part(0.04f), part(1.f), constant(c, 1, 5));
      tree.op(lama::kOpLayer, 1.f);
    }
    if (!isZero(emit)) {
      push(lama::kKindEmission, emit, white);
      k.glows = true;
      tree.op(lama::kOpAdd, 1.f);
    }
  }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }
  static uint32_t scattersBelow(const ParamValue* v, uint32_t) {
    return v[kSubsurface].mayBeOn() && v[kScatterDistance].mayBeOn();
  }
  // A bit for each part that may be on: materials of one group then take the same branches.
  static uint64_t programKey(const ParamValue* v, uint32_t) {
    uint64_t key = 0;
    uint32_t bit = 0;
    for (const uint32_t i : {kMetallic, kSpecTrans, kDiffTrans, kClearcoat, kAnisotropic, kEmitColor, kSheen})
      key |= uint64_t(v[i].mayBeOn()) << bit++;
    key |= uint64_t(scattersBelow(v, 0)) << bit;
    return key;
  }
  static bool isThin(const ParamValue* v) { return v[kThin].count && v[kThin].floats[0] != 0.f; }
  static uint32_t enclosesMedium(const ParamValue* v, uint32_t) { return v[kSpecTrans].mayBeOn() && !isThin(v); }
  static uint32_t letsShadowsThrough(const ParamValue* v, uint32_t) { return v[kSpecTrans].mayBeOn(); }
};
#define METAL "baseColor=1 1 1; metallic=1; "
#define GLASS "baseColor=1 1 1; specTrans=1; "
constexpr const char* kLossless[] = {METAL "roughness=0",
                                     METAL "roughness=0.5",
                                     METAL "roughness=1",
                                     GLASS "roughness=0",
                                     GLASS "roughness=0.5",
                                     GLASS "roughness=0.5; thin=1",
                                     nullptr};
constexpr const char* kConserving[] = {"baseColor=0.8 0.8 0.8; roughness=0.1",
                                       "baseColor=0.8 0.8 0.8; clearcoat=1",
                                       "baseColor=0.8 0.8 0.8; diffTrans=1",
                                       "baseColor=0.8 0.8 0.8; subsurface=0.7; scatterDistance=1 0.5 0.2",
                                       METAL "clearcoat=1; roughness=0.3",
                                       "baseColor=0.9 0.5 0.2; metallic=0.5; specTrans=0.5; roughness=0.3",
                                       nullptr};
#undef METAL
#undef GLASS

KINORA_KERNELS_END

KINORA_PLUGIN(
    PxrDisneyBsdf, SlabMaterial<PxrDisneyBsdf>, BxdfPlugin,
    .help = "The principled material of 2015: dielectric, metal, glass and thin sheets, with coat and sheen.",
    .params = kParams, .lobes = lama::kLobes, .presenceParam = int(kPresence),
    .programKey = PxrDisneyBsdf::programKey, .enclosesMedium = PxrDisneyBsdf::enclosesMedium,
    .letsShadowsThrough = PxrDisneyBsdf::letsShadowsThrough, .scattersBelow = PxrDisneyBsdf::scattersBelow,
    .lossless = kLossless, .conserving = kConserving)
