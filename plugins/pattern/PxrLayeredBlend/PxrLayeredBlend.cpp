// PxrLayeredBlend: layers 0 to 7, one over the other over the background, with the blend modes of math/color.h.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrLayeredBlend/PxrLayeredBlend.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kBackgroundRGB, kBackgroundA, kClampOutput, kFirstLayer, kPerLayer = 4, kLayers = 8 };
constexpr Param kParams[] = {
    param::color("backgroundRGB", 0.f).help("Colour under all layers."),
    param::number("backgroundA", 1.f).help("Coverage of the background."),
    param::flag("clampOutput", true).help("1: results stay within 0..1."),
    param::flag("enable_0", false).help("1: layer 0 counts."),
    param::integer("operation_0", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 0 is combined."),
    param::color("RGB_0", 0.f).help("Colour of layer 0."),
    param::number("A_0", 1.f).help("Coverage of layer 0."),
    param::flag("enable_1", false).help("1: layer 1 counts."),
    param::integer("operation_1", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 1 is combined."),
    param::color("RGB_1", 0.f).help("Colour of layer 1."),
    param::number("A_1", 1.f).help("Coverage of layer 1."),
    param::flag("enable_2", false).help("1: layer 2 counts."),
    param::integer("operation_2", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 2 is combined."),
    param::color("RGB_2", 0.f).help("Colour of layer 2."),
    param::number("A_2", 1.f).help("Coverage of layer 2."),
    param::flag("enable_3", false).help("1: layer 3 counts."),
    param::integer("operation_3", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 3 is combined."),
    param::color("RGB_3", 0.f).help("Colour of layer 3."),
    param::number("A_3", 1.f).help("Coverage of layer 3."),
    param::flag("enable_4", false).help("1: layer 4 counts."),
    param::integer("operation_4", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 4 is combined."),
    param::color("RGB_4", 0.f).help("Colour of layer 4."),
    param::number("A_4", 1.f).help("Coverage of layer 4."),
    param::flag("enable_5", false).help("1: layer 5 counts."),
    param::integer("operation_5", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 5 is combined."),
    param::color("RGB_5", 0.f).help("Colour of layer 5."),
    param::number("A_5", 1.f).help("Coverage of layer 5."),
    param::flag("enable_6", false).help("1: layer 6 counts."),
    param::integer("operation_6", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 6 is combined."),
    param::color("RGB_6", 0.f).help("Colour of layer 6."),
    param::number("A_6", 1.f).help("Coverage of layer 6."),
    param::flag("enable_7", false).help("1: layer 7 counts."),
    param::integer("operation_7", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How layer 7 is combined."),
    param::color("RGB_7", 0.f).help("Colour of layer 7."),
    param::number("A_7", 1.f).help("Coverage of layer 7."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultA"),
};

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
