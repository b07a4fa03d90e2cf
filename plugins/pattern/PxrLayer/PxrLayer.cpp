// PxrLayer: a layer of material for PxrLayerMixer or PxrLayerSurface. It hands its parameters on, with the weights of
// lobes that are off at 0. specularGain and its like multiply the face and edge colours, as PxrSurface has no gain
// there.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrLayer/PxrLayer.cpp"
#include <kinora/pattern_author.h>
#include "plugins/pattern/layers/members.h"

KINORA_KERNELS_BEGIN

using namespace layers;
#define KINORA_LAYER_PREFIX ""
constexpr Param kParams[] = {
    KINORA_LAYER_LOBES(KINORA_LAYER_SWITCH) KINORA_LAYER_MEMBERS(KINORA_LAYER_MEMBER)
        param::number("specularGain", 1.f)
            .help("Multiplies specularFaceColor and specularEdgeColor."),
    param::number("roughSpecularGain", 1.f).help("Multiplies the colours of the rough specular lobe."),
    param::number("clearcoatGain", 1.f).help("Multiplies the colours of the clear coat."),
    param::number("rrRefractionGain", 0.f)
        .help("Older names of the glass: rr... count where a gain of them is not 0."),
    param::number("rrReflectionGain", 0.f).help("See rrRefractionGain."),
    param::color("rrRefractionColor", 1.f).help("See rrRefractionGain."),
    param::number("rrRoughness", 0.1f).help("See rrRefractionGain."),
    param::number("rrIor", 1.5f).range(1, 3).help("See rrRefractionGain."),
    param::flag("enableDiffuseAlways", true).help("No effect: diffuse can be switched off."),
    KINORA_LAYER_OUTPUTS};
#undef KINORA_LAYER_PREFIX
enum : uint32_t {
  kFirst = kLobes,  // of the members
  kSpecularGain = kFirst + kMemberCount,
  kRoughSpecularGain,
  kClearcoatGain,
  kOlder  // rrRefractionGain and those after it: as refractionGain and those after it
};

inline bool isZero(const Value& v) { return v.uniform() && v.data[0][0] == 0.f; }

struct PxrLayer {
  // Face and edge colours of a lobe take its gain.
  template <int W>
  static Value scaled(const Context& c, const Value& color, const Value& gain) {
    if (gain.uniform() && gain.data[0][0] == 1.f) return color;
    const bool one = allUniform({&color, &gain});
    Value v;
    float* out[3];
    makeOutput(c, v, 3, one, out);
    for (uint32_t i = 0; i < extent(c, one); i += W) {
      const At at{i, false};
      (loadRgb<W>(color, at) * loadFloat<W>(gain, at)).store(out, i);
    }
    return v;
  }
  // The older names' value at points where one of their gains is not 0.
  static Value older(const Context& c, const Value& plain, uint32_t index) {
    const Value through = c.param(kOlder), back = c.param(kOlder + 1);
    if (isZero(through) && isZero(back)) return plain;
    const Value old = c.param(kOlder + index);
    const bool one = allUniform({&plain, &old, &through, &back});
    Value v;
    float* out[3];
    makeOutput(c, v, plain.components, one, out);
    for (uint32_t i = 0; i < extent(c, one); ++i) {
      const bool counts = through.data[0][through.stride ? i : 0] != 0.f || back.data[0][back.stride ? i : 0] != 0.f;
      const Value& from = counts ? old : plain;
      for (uint32_t k = 0; k < plain.components; ++k) out[k][i] = from.data[k][from.stride ? i : 0];
    }
    return v;
  }
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    static constexpr float kZero[3] = {0, 0, 0};
    for (uint32_t m = 0; m < kMemberCount; ++m) {
      if (!args->wanted[1 + m]) continue;
      const Member& member = kMembers[m];
      Value& out = args->outputs[1 + m];
      const bool on = member.lobe == kAll || fixedInteger(*c, member.lobe) != 0;
      if (!on && member.role == Role::Weight) {
        out = constantValue(*c, member.components, kZero);
        continue;
      }
      out = c->param(kFirst + m);
      if (m >= kMember_refractionGain && m <= kMember_glassIor) out = older(*c, out, m - kMember_refractionGain);
      if (m == kMember_specularFaceColor || m == kMember_specularEdgeColor)
        out = scaled<W>(*c, out, c->param(kSpecularGain));
      if (m == kMember_roughSpecularFaceColor || m == kMember_roughSpecularEdgeColor)
        out = scaled<W>(*c, out, c->param(kRoughSpecularGain));
      if (m == kMember_clearcoatFaceColor || m == kMember_clearcoatEdgeColor)
        out = scaled<W>(*c, out, c->param(kClearcoatGain));
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrLayer, .help = "A layer of material for PxrLayerMixer and PxrLayerSurface.", .params = kParams)
