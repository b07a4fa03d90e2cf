// PxrMix: color1 + mix (color2 - color1); mix is not clamped.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrMix/PxrMix.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kColor1, kColor2, kMix };
constexpr Param kParams[] = {
    param::color("color1", 0.f).help("Result where mix is 0."),
    param::color("color2", 1.f).help("Result where mix is 1."),
    param::number("mix", 0.f).help("Share of color2; values outside 0..1 go beyond the two colours."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrMix {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Value a = c->param(kColor1), b = c->param(kColor2), mix = c->param(kMix);
    const bool one = allUniform({&a, &b, &mix});
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, one, out);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      lerp(loadRgb<W>(a, at), loadRgb<W>(b, at), loadFloat<W>(mix, at)).store(out, i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrMix, .help = "Blends two colours.", .params = kParams)
