// PxrGlass: a clear or rough dielectric that bounds a medium, the glass of ../lobes/stack.h alone. Light inside is
// absorbed after Beer and Lambert: exp(-absorptionGain * absorptionColor * distance). Real files call the colour of
// what is let through transmissionColor, lists of parameters refractionColor: both are taken.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrGlass/PxrGlass.cpp"
#include <kinora/bxdf_author.h>
#include <kinora/math/microfacet.h>
#include "plugins/bxdf/lobes/bind.h"
#include "plugins/bxdf/lobes/glass.h"
#include "plugins/bxdf/lobes/stack_functions.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kReflectionColor,
  kReflectionGain,
  kTransmissionColor,
  kRefractionColor,
  kTransmissionGain,
  kIor,
  kRoughness,
  kAbsorptionColor,
  kAbsorptionGain,
  kBumpNormal,
  kMwWalkable,
  kMwIor
};
constexpr Param kParams[] = {
    param::color("reflectionColor", 1.f).help("Tint of what is reflected."),
    param::number("reflectionGain", 1.f).help("Multiplies reflectionColor; 0: off."),
    param::color("transmissionColor", 1.f).help("Tint of what is let through, at each boundary."),
    param::color("refractionColor", 1.f).help("Another name of transmissionColor; counts where it is not white."),
    param::number("transmissionGain", 1.f).help("Multiplies transmissionColor; 0: off."),
    param::number("ior", 1.5f).range(1, 3).help("Index of refraction inside."),
    param::number("roughness", 0.f)
        .help("0 clear .. 1; the facets' alpha is its square, below 0.001 the glass is clear."),
    param::color("absorptionColor", 1.f).help("What is absorbed inside, by channel; see absorptionGain."),
    param::number("absorptionGain", 0.f)
        .range(0, 10)
        .help("Absorption inside, per unit of length, of a channel whose absorptionColor is 1."),
    param::normal("bumpNormal").help("Shading normal from a bump pattern."),
    param::onOff("mwWalkable", false)
        .help("Manifold walks go through: the caustics of lights with cheapCaustics are found by them. Not where "
              "bumpNormal is connected."),
    param::number("mwIor", -1.f)
        .range(-1, 3)
        .help("Index of refraction of manifold walks through clear glass; -1: ior. Another one moves the caustic "
              "from where the glass would throw it."),
};

// refractionColor where it is not white, else transmissionColor.
inline Value transmissionColor(const Context& c) {
  const Value first = c.param(kRefractionColor), second = c.param(kTransmissionColor);
  const auto white = [&](uint32_t point) {
    const uint32_t i = first.stride ? point : 0;
    return first.data[0][i] == 1.f && first.data[1][i] == 1.f && first.data[2][i] == 1.f;
  };
  if (!first.stride) return white(0) ? second : first;
  Value v = first;
  for (uint32_t k = 0; k < 3; ++k) {
    float* out = c.alloc<float>(c.padded);
    for (uint32_t i = 0; i < c.padded; ++i)
      out[i] = white(i) ? second.data[k][second.stride ? i : 0] : first.data[k][i];
    v.data[k] = out;
  }
  return v;
}

constexpr const char* kLossless[] = {
    "roughness=0",   "roughness=0; ior=1.33", "roughness=0.1",        "roughness=0.3; ior=1.33",
    "roughness=0.6", "roughness=1",           "roughness=0.8; ior=2", nullptr};
constexpr const char* kConserving[] = {"roughness=0.3; reflectionColor=0.9 0.7 0.5; transmissionColor=0.5 0.7 0.9",
                                       "roughness=0.7; reflectionGain=0.2; refractionColor=0.9 1 0.9; ior=2.5",
                                       nullptr};

struct PxrGlass {
  static constexpr bool kWalkable = true;
  static uint64_t programKey(const ParamValue* v, uint32_t) {
    return (v[kReflectionGain].mayBeOn() ? 1u : 0u) | (v[kTransmissionGain].mayBeOn() ? 2u : 0u);
  }
  static uint32_t enclosesMedium(const ParamValue* v, uint32_t) { return v[kTransmissionGain].mayBeOn(); }
  static uint32_t walkableLobes(const ParamValue* v, uint32_t) {
    if (!v[kMwWalkable].mayBeOn() || v[kBumpNormal].mayBeOn()) return 0;
    return (v[kReflectionGain].mayBeOn() ? 1u << lobes::kGlassReflect : 0u) |
           (v[kTransmissionGain].mayBeOn() ? 1u << lobes::kGlassTransmit : 0u);
  }

  static void begin(const Context& c, lobes::Closure& k) {
    k.radiance = !(c.traits & kTraitLightPath);
    lobes::GlassClosure& g = k.glass;
    g.reflectionGain = c.param(kReflectionGain);
    g.refractionGain = c.param(kTransmissionGain);
    if (!isZero(g.reflectionGain)) k.on |= 1u << lobes::kGlassReflect;
    if (!isZero(g.refractionGain)) k.on |= 1u << lobes::kGlassTransmit;
    if (!k.on) return;
    g.tinted = true;
    g.reflectionColor = c.param(kReflectionColor);
    g.refractionColor = transmissionColor(c);
    g.roughness = c.param(kRoughness);
    g.refractionRoughness = g.roughness;
    g.ior = c.param(kIor);
    if (c.traits & kTraitWalkable) g.walkIor = c.param(kMwIor);
    g.bump = bindNormal(c, k, kBumpNormal, -1);
    k.bumped = g.bump == 0;
    k.glassEnergy = glassTable(c, g);
  }
  static void interior(const Context* c, const InteriorArgs* a) {
    copyFloat(c->param(kIor), c->padded, a->ior);
    const Value color = c->param(kAbsorptionColor), gain = c->param(kAbsorptionGain);
    for (int channel = 0; channel < 3; ++channel)
      for (uint32_t i = 0; i < c->padded; ++i) {
        const float absorbed = color.data[channel][color.stride ? i : 0] * gain.data[0][gain.stride ? i : 0];
        a->absorption[channel][i] = absorbed > 0 ? absorbed : 0;
      }
  }
  template <int W>
  static void thinShadow(const Context* c, float* const rgb[3]) {
    glassThinShadow<W>(*c, c->param(kTransmissionGain), transmissionColor(*c), c->param(kIor), false, rgb);
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(PxrGlass, StackMaterial<PxrGlass>, BxdfPlugin, .help = "Clear or rough glass with absorption inside.",
              .params = kParams, .lobes = lobes::kLobes, .programKey = PxrGlass::programKey,
              .enclosesMedium = PxrGlass::enclosesMedium, .walkableLobes = PxrGlass::walkableLobes,
              .lossless = kLossless, .conserving = kConserving)
