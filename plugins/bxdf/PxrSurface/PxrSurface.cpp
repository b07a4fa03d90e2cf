// PxrSurface: the general material, a stack of lobes (../lobes/stack.h) with glow. This file binds the parameters and
// declares the plug-in.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrSurface/PxrSurface.cpp"
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include "parameters.h"
#include "plugins/bxdf/lobes/bind.h"
#include "plugins/bxdf/lobes/film.h"
#include "plugins/bxdf/lobes/glass.h"
#include "plugins/bxdf/lobes/stack_functions.h"

KINORA_KERNELS_BEGIN

using namespace pxrSurface;
using namespace lobes;

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
  if (l.anisotropy.on) l.anisotropy.energy = &anisotropicEnergyTable(l.ggx);
  l.bump = bindNormal(c, k, first + kBump, bump);
}
void bindIridescence(const Context& c, Closure& k, int bump) {
  SpecularClosure& l = k.specular[kIridescence - kSpecular];
  l.face = c.param(at("iridescenceFaceGain"));
  l.edge = c.param(at("iridescenceEdgeGain"));
  if (isZero(l.face) && isZero(l.edge)) return;
  k.on |= 1u << kIridescence;
  l.shape = c.param(at("iridescenceFresnelShape"));
  l.doubleSided = flag(c, at("iridescenceDoubleSided"));
  l.roughness = c.param(at("iridescenceRoughness"));
  bindAnisotropy(c, l.anisotropy, at("iridescenceAnisotropy"), at("iridescenceAnisotropyDirection"));
  if (l.anisotropy.on) l.anisotropy.energy = &anisotropicEnergyTable(l.ggx);
  l.bump = bindNormal(c, k, at("iridescenceBumpNormal"), bump);
  IridescenceClosure& i = k.iridescence;
  l.iridescence = &i;
  if (flag(c, at("iridescenceMode"))) {
    i.film = &filmTable();
    i.thickness = c.param(at("iridescenceThickness"));
    return;
  }
  i.flip = flag(c, at("iridescenceFlip"));
  i.primary = c.param(at("iridescencePrimaryColor"));
  i.secondary = c.param(at("iridescenceSecondaryColor"));
  i.curve = c.param(at("iridescenceCurve"));
  i.scale = c.param(at("iridescenceScale"));
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
  if (c.traits & kTraitWalkable) g.walkIor = c.param(at("mwIor"));
  bindAnisotropy(c, g.anisotropy, at("glassAnisotropy"), at("glassAnisotropyDirection"));
  g.bump = bindNormal(c, k, at("glassBumpNormal"), bump);
  if (!g.thin) k.glassEnergy = glassTable(c, g);
}
void bindSubsurface(const Context& c, Closure& k) {
  SubsurfaceClosure& s = k.subsurface;
  const int type = int(c.param(at("subsurfaceType")).data[0][0]);
  s.gain = c.param(at("subsurfaceGain"));
  s.straight = c.param(at("subsurfaceTransmitGain"));
  const bool crosses = !isZero(s.straight);
  if (!crosses) s.straight = Value();
  if (type == 3) {
    s.shortGain = c.param(at("shortSubsurfaceGain"));
    s.longGain = c.param(at("longSubsurfaceGain"));
    if (isZero(s.gain) && isZero(s.shortGain) && isZero(s.longGain) && !crosses) return;
    s.shortColor = c.param(at("shortSubsurfaceColor"));
    s.shortReach = c.param(at("shortSubsurfaceDmfp"));
    s.longColor = c.param(at("longSubsurfaceColor"));
    s.longReach = c.param(at("longSubsurfaceDmfp"));
  } else if (isZero(s.gain) && !crosses) {
    return;
  }
  k.on |= 1u << kSubsurface;
  s.model = type >= 4   ? SubsurfaceModel::Walk
            : type == 0 ? SubsurfaceModel::JensenDipole
            : type == 1 ? SubsurfaceModel::BetterDipole
                        : SubsurfaceModel::Burley;
  s.heavyTails = type == 5;
  s.doubleSided = flag(c, at("subsurfaceDoubleSided"));
  s.traceSet = c.fn->text(&c, at("subsurfaceSubset"));
  s.joins = flag(c, at("subsurfaceResolveSelfIntersections")) || (s.traceSet && *s.traceSet) ||
            c.param(at("continuationRayMode")).data[0][0] > 0;
  s.comesOutBehind = flag(c, at("considerBackside"));
  s.color = c.param(at("subsurfaceColor"));
  s.tint = c.param(at("subsurfacePostTint"));
  s.entryTint = c.param(at("irradianceTint"));
  s.reach = c.param(at("subsurfaceDmfp"));
  s.reachColor = c.param(at("subsurfaceDmfpColor"));
  s.unit = c.param(at("unitLength")).data[0][0];
  s.directionality = c.param(at("subsurfaceDirectionality"));
  s.bleed = c.param(at("subsurfaceBleed"));
  s.diffuseSwitch = c.param(at("subsurfaceDiffuseSwitch"));
  s.diffuseBlend = c.param(at("subsurfaceDiffuseBlend"));
  if (type < 2) s.ior = c.param(at("subsurfaceIor"));
  s.topology = c.param(at("followTopology"));
}
void bindSingle(const Context& c, Closure& k) {
  SingleClosure& s = k.single;
  s.gain = c.param(at("singlescatterGain"));
  s.straight = c.param(at("singlescatterDirectGain"));
  s.scatters = !isZero(s.gain);
  if (!s.scatters && isZero(s.straight)) return;
  k.on |= 1u << kSingleScatter;
  s.straightColor = c.param(at("singlescatterDirectGainTint"));
  s.blur = c.param(at("singlescatterBlur"));
  const float passes = c.param(at("singlescatterContinuationRayMode")).data[0][0],
              most = c.param(at("singlescatterMaxContinuationHits")).data[0][0];
  if (passes > 0 && most > 0) s.mostPassed = uint32_t(most < 16 ? most : 16);
  s.skipsGaps = passes == 2;
  s.comesOutBehind = flag(c, at("singlescatterConsiderBackside"));
  s.color = c.param(at("singlescatterColor"));
  s.reach = c.param(at("singlescatterMfp"));
  s.reachColor = c.param(at("singlescatterMfpColor"));
  s.unit = c.param(at("unitLength")).data[0][0];
  s.directionality = c.param(at("singlescatterDirectionality"));
  s.ior = c.param(at("singlescatterIor"));
  s.doubleSided = flag(c, at("singlescatterDoubleSided"));
  s.traceSet = c.fn->text(&c, at("singlescatterSubset"));
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
  bindIridescence(c, k, bump);
  k.fuzzGain = c.param(at("fuzzGain"));
  if (!isZero(k.fuzzGain)) {
    k.on |= 1u << kFuzz;
    k.fuzzColor = c.param(at("fuzzColor"));
    k.fuzzConeAngle = c.param(at("fuzzConeAngle"));
    k.fuzzDoubleSided = flag(c, at("fuzzDoubleSided"));
    k.fuzzBump = bindNormal(c, k, at("fuzzBumpNormal"), bump);
  }
  bindSubsurface(c, k);
  bindSingle(c, k);
  bindGlass(c, k, bump);
  k.softens = k.normalCount > 0 && flag(c, at("shadowBumpTerminator"));
  const bool specular = k.has(kSpecular) || k.has(kRoughSpecular);
  if (specular || k.has(kClearcoat) || k.has(kIridescence) || k.glass.thin)
    k.reflectionEnergy = &reflectionEnergyTable();
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

struct PxrSurface {
  static constexpr bool kGlows = true, kScatters = true, kWalkable = true;
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
  template <int W>
  static void thinShadow(const Context* c, float* const rgb[3]) {
    glassThinShadow<W>(*c, c->param(at("refractionGain")), c->param(at("refractionColor")), c->param(at("glassIor")),
                       flag(*c, at("thinGlass")), rgb);
  }
};

KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora {
namespace {
using namespace pxrSurface;
using namespace lobes;

bool isSet(const ParamValue& v) { return v.count && v.floats[0] != 0.f; }

bool scattersOnce(const ParamValue* v) {
  return v[at("singlescatterGain")].mayBeOn() || v[at("singlescatterDirectGain")].mayBeOn();
}
uint32_t scattersBelow(const ParamValue* v, uint32_t) {
  const bool isSum = isSet(v[at("subsurfaceType")]) && v[at("subsurfaceType")].floats[0] == 3.f;
  return v[at("subsurfaceGain")].mayBeOn() || v[at("subsurfaceTransmitGain")].mayBeOn() || scattersOnce(v) ||
         (isSum && (v[at("shortSubsurfaceGain")].mayBeOn() || v[at("longSubsurfaceGain")].mayBeOn()));
}
// A bit for each lobe that may be on, and one for what makes shading longer: materials of one group then take the
// same branches. Modes and switches are fixed parameters and part of the program already.
uint64_t programKey(const ParamValue* v, uint32_t) {
  uint64_t key = 0;
  if (v[at("diffuseGain")].mayBeOn()) key |= 1;
  if (isSet(v[at("diffuseDoubleSided")]) && v[at("diffuseTransmitGain")].mayBeOn()) key |= 2;
  for (uint32_t i = 0; i < 3; ++i) {
    const ParamValue* l = v + kSpecularFirst[i];
    if (!l[kEdgeColor].mayBeOn() && (isSet(l[kFresnelMode]) || !l[kFaceColor].mayBeOn())) continue;
    key |= uint64_t(4) << i;
    if (l[kAnisotropy].mayBeOn()) key |= uint64_t(256) << i;
  }
  if (v[at("fuzzGain")].mayBeOn()) key |= 32;
  if (v[at("reflectionGain")].mayBeOn()) key |= 64;
  if (v[at("refractionGain")].mayBeOn()) key |= 128;
  if ((key & 192) && v[at("glassAnisotropy")].mayBeOn()) key |= 2048;
  if ((key & 16) && (v[at("clearcoatEnergyCompensation")].mayBeOn() ||
                     (v[at("clearcoatThickness")].mayBeOn() && v[at("clearcoatAbsorptionTint")].mayBeOn())))
    key |= 4096;
  if ((key & 12) && v[at("specularEnergyCompensation")].mayBeOn()) key |= 8192;
  if (v[at("glowGain")].mayBeOn()) key |= 16384;
  if (scattersBelow(v, 0)) key |= 131072;
  if (scattersOnce(v)) key |= 262144;
  if (v[at("iridescenceFaceGain")].mayBeOn() || v[at("iridescenceEdgeGain")].mayBeOn()) {
    key |= 32768;
    if (v[at("iridescenceAnisotropy")].mayBeOn()) key |= 65536;
  }
  return key;
}
uint32_t enclosesMedium(const ParamValue* v, uint32_t) {
  return v[at("refractionGain")].mayBeOn() && !isSet(v[at("thinGlass")]);
}

constexpr InteriorMedium::Pair kInsideParameters[] = {
    {"extinction", "densityColor"}, {"ssAlbedo", "diffuseColor"},    {"g", "anisotropy"},
    {"g0", "anisotropy"},           {"g1", "anisotropy2"},           {"blend", "blendFactor"},
    {"volumeGlow", "emitColor"},    {"maxExtinction", "maxDensity"}, {"multiScatter", "multiScatter"}};
constexpr const char* kInsideCauses[] = {"ssAlbedo", "volumeGlow"};
constexpr InteriorMedium kInteriorMedium{"PxrVolume", kInsideParameters, kInsideCauses, "extinction"};

uint32_t walkableLobes(const ParamValue* v, uint32_t) {
  if (!v[at("mwWalkable")].mayBeOn() || isSet(v[at("thinGlass")]) || v[at("bumpNormal")].mayBeOn()) return 0;
  const bool reflects = v[at("reflectionGain")].mayBeOn(), refracts = v[at("refractionGain")].mayBeOn();
  if (reflects || refracts)
    return v[at("glassBumpNormal")].mayBeOn()
               ? 0u
               : (reflects ? 1u << kGlassReflect : 0u) | (refracts ? 1u << kGlassTransmit : 0u);
  const ParamValue* l = v + kSpecularFirst[0];
  const bool shines = l[kEdgeColor].mayBeOn() || (!isSet(l[kFresnelMode]) && l[kFaceColor].mayBeOn());
  return shines && !l[kBump].mayBeOn() ? 1u << kSpecular : 0u;
}
uint32_t letsShadowsThrough(const ParamValue* v, uint32_t) { return v[at("refractionGain")].mayBeOn(); }

#define METAL "diffuseGain=0; specularFaceColor=1 1 1; specularEdgeColor=1 1 1; specularDoubleSided=1; "
#define IRIDESCENT "diffuseGain=0; iridescenceFaceGain=1 1 1; iridescenceEdgeGain=1 1 1; iridescenceDoubleSided=1; "
#define GLASS "diffuseGain=0; reflectionGain=1; refractionGain=1; "
constexpr const char* kLossless[] = {
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
    "diffuseGain=0; subsurfaceGain=1; subsurfaceColor=1 1 1; subsurfaceDoubleSided=1",
    "diffuseGain=0; subsurfaceGain=1; subsurfaceColor=1 1 1; subsurfaceDoubleSided=1; subsurfaceBleed=1",
    GLASS "glassRoughness=0",
    GLASS "glassRoughness=0.1",
    GLASS "glassRoughness=0.3; glassIor=1.33",
    GLASS "glassRoughness=0.6",
    GLASS "glassRoughness=1; glassIor=2",
    GLASS "glassRoughness=0; thinGlass=1",
    GLASS "glassRoughness=0.5; thinGlass=1",
    nullptr};
constexpr const char* kConserving[] = {
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
    GLASS "glassRoughness=0; glassRefractionRoughness=0.5",
    GLASS "glassRoughness=0.6; glassRefractionRoughness=0.2; glassIor=2",
    IRIDESCENT "iridescenceScale=3; iridescenceCurve=0.5; iridescenceRoughness=0.5",
    IRIDESCENT "iridescenceFlip=1; iridescenceAnisotropy=0.7",
    IRIDESCENT "iridescenceMode=1; iridescenceThickness=400; iridescenceRoughness=0.1",
    IRIDESCENT "iridescenceRoughness=0",
    nullptr};
#undef METAL
#undef GLASS
#undef IRIDESCENT
}  // namespace
}  // namespace kinora
#endif

KINORA_PLUGIN(PxrSurface, StackMaterial<PxrSurface>, BxdfPlugin,
              .help = "General material: diffuse, three specular lobes, iridescence, fuzz, glass and glow.",
              .params = kParams, .lobes = kLobes, .presenceParam = int(at("presence")), .programKey = programKey,
              .enclosesMedium = enclosesMedium, .letsShadowsThrough = letsShadowsThrough,
              .scattersBelow = scattersBelow, .walkableLobes = walkableLobes, .interiorMedium = &kInteriorMedium,
              .lossless = kLossless, .conserving = kConserving)
