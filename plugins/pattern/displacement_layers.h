// Layers of displacement on a base, as PxrDispScalarLayer and PxrDispVectorLayer have them: the parameters' order, and
// what is done with them. Included per target by both.
#include <kinora/pattern_author.h>

#if defined(KINORA_DISPLACEMENT_LAYERS_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_DISPLACEMENT_LAYERS_TARGET
#undef KINORA_DISPLACEMENT_LAYERS_TARGET
#else
#define KINORA_DISPLACEMENT_LAYERS_TARGET
#endif

#define KINORA_DISPLACEMENT_BASE(value)                                           \
  param::number("overallAmount", 1.f).range(-2, 2).help("Factor on the result."), \
      param::onOff("baseLayerEnabled", true).help("1: the base counts."),         \
      param::number("baseLayerAmount", 1.f).range(-2, 2).help("Factor on the base."), value
#define KINORA_DISPLACEMENT_LAYER(n, on, value)                                                  \
  param::onOff("layer" n "Enabled", on).help("1: layer " n " counts."),                          \
      param::number("layer" n "Amount", 1.f).range(-2, 2).help("Factor on layer " n "."), value, \
      param::number("layer" n "Mask", 1.f).help("How much of layer " n " there is."),            \
      param::integer("layer" n "Comp", 1)                                                        \
          .range(1, 3)                                                                           \
          .options("1 add, 2 over, 3 max")                                                       \
          .help("How layer " n " joins what is below: added, in its place, or where it goes farther.")
// All of a pattern whose values are called so; VALUE(name, of) is the parameter of one, of "layer 1" for example.
#define KINORA_DISPLACEMENT_LAYERS(called, VALUE)                               \
  KINORA_DISPLACEMENT_BASE(VALUE("baseLayer" called, "the base")),              \
      KINORA_DISPLACEMENT_LAYER("1", true, VALUE("layer1" called, "layer 1")),  \
      KINORA_DISPLACEMENT_LAYER("2", false, VALUE("layer2" called, "layer 2")), \
      KINORA_DISPLACEMENT_LAYER("3", false, VALUE("layer3" called, "layer 3")), \
      KINORA_DISPLACEMENT_LAYER("4", false, VALUE("layer4" called, "layer 4"))

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Of one component (distances) or three (vectors).
template <uint32_t kComponents>
struct DisplacementLayers {
  enum : uint32_t { kOverall, kBaseEnabled, kBaseAmount, kBase, kFirstLayer, kPerLayer = 5, kLayers = 4 };

  struct Layer {
    Value amount, value, mask;
    int comp;
  };
  template <int W>
  static KN_INLINE Vec3<W> load(const Value& v, At at) {
    if constexpr (kComponents == 1)
      return {loadFloat<W>(v, at), Float<W>(0.f), Float<W>(0.f)};
    else
      return loadVec<W>(v, at);
  }
  template <int W>
  static KN_INLINE Vec3<W> join(int comp, Vec3<W> below, Vec3<W> own, Float<W> mask) {
    if (comp == 2) return below + (own - below) * mask;
    own = own * mask;
    if (comp != 3) return below + own;
    const Mask<W> farther = kComponents == 1 ? own.x > below.x : dot(own, own) > dot(below, below);
    return select(farther, own, below);
  }

  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Value overall = c->param(kOverall), baseAmount = c->param(kBaseAmount);
    const bool hasBase = fixedInteger(*c, kBaseEnabled) != 0;
    // what is off is not asked for: its network need not run
    const Value base = hasBase ? c->param(kBase) : Value();
    bool one = allUniform({&overall, &baseAmount, &base});
    Layer layers[kLayers];
    uint32_t n = 0;
    for (uint32_t k = 0; k < kLayers; ++k) {
      const uint32_t first = kFirstLayer + k * kPerLayer;
      if (!fixedInteger(*c, first)) continue;
      Layer& l = layers[n++];
      l = {c->param(first + 1), c->param(first + 2), c->param(first + 3), fixedInteger(*c, first + 4)};
      one = one && allUniform({&l.amount, &l.value, &l.mask});
    }
    float* out[3];
    makeOutput(*c, args->outputs[0], kComponents, one, out);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      Vec3<W> sum(0.f);
      if (hasBase) sum = load<W>(base, at) * loadFloat<W>(baseAmount, at);
      for (uint32_t k = 0; k < n; ++k)
        sum = join<W>(layers[k].comp, sum, load<W>(layers[k].value, at) * loadFloat<W>(layers[k].amount, at),
                      loadFloat<W>(layers[k].mask, at));
      sum = sum * loadFloat<W>(overall, at);
      if constexpr (kComponents == 1) {
        sum.x.store(out[0] + i);
      } else {
        sum.store(out, i);
      }
    }
    if constexpr (kComponents == 3) shareComponents(*args, 0);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
