// PxrVary: changes a colour at random, in one way for each object or for each value of a primitive variable.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrVary/PxrVary.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/variation/vary.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kVarySource, kVarName, kVarType, kHue, kProbability = kHue + 4, kHueMode };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.5f).help("Colour to vary."),
    param::integer("varySource", 0)
        .range(0, 2)
        .options("0 object id, 1 object name, 2 primitive variable")
        .help("What has a variation of its own. Names count by the object's id."),
    param::string("varName", "")
        .help("Primitive variable of varySource 2; objects that lack it share one variation."),
    param::integer("varType", 0).range(0, 3).help("Accepted; the variable's own type counts."),
    KINORA_VARY_AMOUNTS("hue", "saturation", "luminance", "gamma"),
    param::number("probability", 1.f).help("Share of the objects that are changed at all."),
    KINORA_VARY_SIDES,
    param::integer("verbosity", 0).range(0, 2).help("Accepted."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrVary {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, source, probability;
    Variation change;
    explicit Setup(const Context& c)
        : color(c.param(kInputRGB)), probability(c.param(kProbability)), change(c, kHue, kHueMode) {
      const char* name = c.fn->text(&c, kVarName);
      const float none = 0.f;
      if (fixedInteger(c, kVarySource) != 2)
        source = c.builtin(Builtin::ObjectId);
      else if (name && *name)
        source = c.fn->primvar(&c, name, nullptr);
      if (!source.components) source = constantValue(c, 1, &none);
    }
    bool uniform() const { return allUniform({&color, &source, &probability}) && change.uniform(); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using I = Int<W>;
    I seed(0x3c6ef372u);
    for (uint32_t k = 0; k < s.source.components; ++k)
      seed = hashWords(seed, seedOf(loadComponent<W>(s.source, k, at)));
    const Rgb<W> c = loadRgb<W>(s.color, at);
    const Mask<W> changed = toUnitFloat(hashWords(seed, I(0x7f4a7c15u))) < loadFloat<W>(s.probability, at);
    return select(changed, s.change.apply(c, seed, at), c);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrVary, .help = "Varies a colour from object to object.", .params = kParams)
