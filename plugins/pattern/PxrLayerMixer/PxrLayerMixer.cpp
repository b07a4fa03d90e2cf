// PxrLayerMixer: up to four layers of material over a base, each by its mask. Members are blended one by one, as the
// reference does: a mask of 0.5 gives a material of mean parameters. A lobe that a layer lacks stays as it is below;
// one that nothing below has comes in with the layer's own shape and a weight that the mask scales. A layer of which
// the scene says nothing is switched off before (shade/material.cpp).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrLayerMixer/PxrLayerMixer.cpp"
#include <kinora/pattern_author.h>
#include "plugins/pattern/layers/members.h"

KINORA_KERNELS_BEGIN

using namespace layers;
#define KINORA_LAYER_ALL KINORA_LAYER_LOBES(KINORA_LAYER_SWITCH) KINORA_LAYER_MEMBERS(KINORA_LAYER_MEMBER)
#define KINORA_LAYER_MASK(name, on)                                   \
  param::flag(name "Enabled", on).help("1: this layer lies on top."), \
      param::number(name "Mask", 1.f).help("Where the layer is: 0 nowhere, 1 alone."),
constexpr Param kParams[] = {
#define KINORA_LAYER_PREFIX "baselayer_"
    KINORA_LAYER_ALL
#undef KINORA_LAYER_PREFIX
#define KINORA_LAYER_PREFIX "layer1_"
        KINORA_LAYER_ALL
#undef KINORA_LAYER_PREFIX
#define KINORA_LAYER_PREFIX "layer2_"
            KINORA_LAYER_ALL
#undef KINORA_LAYER_PREFIX
#define KINORA_LAYER_PREFIX "layer3_"
                KINORA_LAYER_ALL
#undef KINORA_LAYER_PREFIX
#define KINORA_LAYER_PREFIX "layer4_"
                    KINORA_LAYER_ALL
#undef KINORA_LAYER_PREFIX
                        KINORA_LAYER_MASK("layer1", 1) KINORA_LAYER_MASK("layer2", 0) KINORA_LAYER_MASK("layer3", 0)
                            KINORA_LAYER_MASK("layer4", 0) param::structure("baselayer")
                                .help("A whole layer below, from PxrLayer or PxrLayerMixer."),
    param::structure("layer1").help("A whole layer, first over the base."),
    param::structure("layer2").help("A whole layer over layer1."),
    param::structure("layer3").help("A whole layer over layer2."),
    param::structure("layer4").help("A whole layer over layer3."),
    param::flag("enableDiffuseAlways", true).help("No effect: diffuse can be switched off."),
    KINORA_LAYER_OUTPUTS};
constexpr uint32_t kLayerSize = kLobes + kMemberCount, kLayerCount = 4;
constexpr uint32_t kEnabled = (1 + kLayerCount) * kLayerSize, kMask = kEnabled + 1;  // of layer1; then every second

inline bool isUniformly(const Value& v, float x) {
  for (uint32_t k = 0; k < v.components; ++k)
    if (!v.uniform() || v.data[k][0] != x) return false;
  return true;
}

struct PxrLayerMixer {
  // Exactly one of the two where the mask is 0 or 1, whatever it is at other points.
  template <int W, class V>
  static KN_INLINE V mixed(V below, V above, Float<W> amount) {
    const Mask<W> none = amount <= Float<W>(0.f), all = amount >= Float<W>(1.f);
    return select(none, below, select(all, above, lerp(below, above, amount)));
  }
  template <int W>
  static Value blend(const Context& c, const Member& member, const Value& below, const Value& above,
                     const Value& mask) {
    if (isUniformly(mask, 0.f)) return below;
    if (isUniformly(mask, 1.f)) return above;
    using F = Float<W>;
    Value v;
    float* out[3];
    if (member.role == Role::Normal) {
      // 0 0 0 is the surface's normal; where neither layer has one it stays 0 0 0
      if (isUniformly(below, 0.f) && isUniformly(above, 0.f)) return below;
      makeOutput(c, v, 3, false, out);
      for (uint32_t i = 0; i < c.padded; i += W) {
        const At at{i, false};
        const Vec3<W> N = loadVec<W>(c.N, at), a = loadVec<W>(below, at), b = loadVec<W>(above, at);
        const F amount = loadFloat<W>(mask, at);
        const Mask<W> hasA = dot(a, a) > F(0.f), hasB = dot(b, b) > F(0.f);
        const Mask<W> between = (amount > F(0.f)) & (amount < F(1.f)) & (hasA | hasB);
        mixed<W>(select(between & !hasA, N, a), select(between & !hasB, N, b), amount).store(out, i);
      }
      return v;
    }
    const bool one = allUniform({&below, &above, &mask});
    makeOutput(c, v, member.components, one, out);
    for (uint32_t i = 0; i < extent(c, one); i += W) {
      const At at{i, false};
      if (member.components == 3)
        mixed<W>(loadRgb<W>(below, at), loadRgb<W>(above, at), loadFloat<W>(mask, at)).store(out, i);
      else
        mixed<W>(loadFloat<W>(below, at), loadFloat<W>(above, at), loadFloat<W>(mask, at)).store(out[0] + i);
    }
    return v;
  }
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    static constexpr float kZero[3] = {0, 0, 0};
    const auto has = [&](uint32_t layer, uint32_t lobe) {
      return lobe == kAll || fixedInteger(*c, layer * kLayerSize + lobe) != 0;
    };
    for (uint32_t m = 0; m < kMemberCount; ++m) {
      if (!args->wanted[1 + m]) continue;
      const Member& member = kMembers[m];
      bool present = has(0, member.lobe);
      Value sum =
          present || member.role != Role::Weight ? c->param(kLobes + m) : constantValue(*c, member.components, kZero);
      for (uint32_t l = 1; l <= kLayerCount; ++l) {
        if (!fixedInteger(*c, kEnabled + 2 * (l - 1)) || !has(l, member.lobe)) continue;
        const Value above = c->param(l * kLayerSize + kLobes + m);
        if (!present && member.role != Role::Weight)
          sum = above;
        else
          sum = blend<W>(*c, member, sum, above, c->param(kMask + 2 * (l - 1)));
        present = true;
      }
      args->outputs[1 + m] = sum;
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrLayerMixer, .help = "Lays up to four layers of material over a base, each by its mask.",
               .params = kParams)
