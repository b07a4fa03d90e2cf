// PxrLayeredBlend: layers 0 to 7, one over the other over the background, with the blend modes of math/color.h.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrLayeredBlend/PxrLayeredBlend.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kBackgroundRGB, kBackgroundA, kClampOutput, kFirstLayer, kPerLayer = 4, kLayers = 8 };
#define LAYER(n)                                                  \
  param::flag("enable_" n, false).help("1: layer " n " counts."), \
      param::integer("operation_" n, 19)                          \
          .range(0, 26)                                           \
          .options(KINORA_BLEND_CHOICES)                          \
          .help("How layer " n " is combined."),                  \
      param::color("RGB_" n, 0.f).help("Colour of layer " n "."), \
      param::number("A_" n, 1.f).help("Coverage of layer " n ".")
constexpr Param kParams[] = {
    param::color("backgroundRGB", 0.f).help("Colour under all layers."),
    param::number("backgroundA", 1.f).help("Coverage of the background."),
    param::flag("clampOutput", true).help("1: results stay within 0..1."),
    LAYER("0"),
    LAYER("1"),
    LAYER("2"),
    LAYER("3"),
    LAYER("4"),
    LAYER("5"),
    LAYER("6"),
    LAYER("7"),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultA"),
};
#undef LAYER

struct PxrLayeredBlend {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value background = c->param(kBackgroundRGB), backgroundA = c->param(kBackgroundA);
    const bool clamped = fixedInteger(*c, kClampOutput) != 0;
    bool one = allUniform({&background, &backgroundA});
    // only what is enabled is asked for: the rest of the network need not run
    Value rgbOf[kLayers], alphaOf[kLayers];
    Blend ops[kLayers];
    uint32_t n = 0;
    for (uint32_t k = 0; k < kLayers; ++k) {
      const uint32_t first = kFirstLayer + k * kPerLayer;
      if (!fixedInteger(*c, first)) continue;
      const int code = fixedInteger(*c, first + 1);
      ops[n] = code >= 0 && code < int(Blend::Count) ? Blend(code) : Blend::Normal;
      rgbOf[n] = c->param(first + 2);
      alphaOf[n] = c->param(first + 3);
      one = one && allUniform({&rgbOf[n], &alphaOf[n]});
      ++n;
    }
    float *rgb[3], *alpha[3];
    makeOutput(*c, args->outputs[0], 3, one, rgb);
    makeOutput(*c, args->outputs[4], 1, one, alpha);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      Rgb<W> color = loadRgb<W>(background, at);
      F a = loadFloat<W>(backgroundA, at);
      for (uint32_t k = 0; k < n; ++k)
        blendOver(ops[k], color, a, loadRgb<W>(rgbOf[k], at), loadFloat<W>(alphaOf[k], at));
      (clamped ? clamp01(color) : color).store(rgb, i);
      (clamped ? clamp(a, F(0.f), F(1.f)) : a).store(alpha[0] + i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrLayeredBlend, .help = "Combines up to eight colours over a background.", .params = kParams)
