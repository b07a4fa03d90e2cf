// PxrBlend: top over bottom with one of the blend modes of math/color.h.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrBlend/PxrBlend.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kOperation, kTopRGB, kTopA, kBottomRGB, kBottomA, kClampOutput };
constexpr Param kParams[] = {
    param::integer("operation", 19).range(0, 26).options(KINORA_BLEND_CHOICES).help("How the two are combined."),
    param::color("topRGB", 0.f).help("Colour of the top layer."),
    param::number("topA", 1.f).help("Coverage of the top layer."),
    param::color("bottomRGB", 0.f).help("Colour of the bottom layer."),
    param::number("bottomA", 1.f).help("Coverage of the bottom layer."),
    param::flag("clampOutput", true).help("1: results stay within 0..1."),
    KINORA_COLOR_OUTPUTS,
    param::output(Type::Float, "resultA"),
};

struct PxrBlend {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value top = c->param(kTopRGB), topA = c->param(kTopA), bottom = c->param(kBottomRGB),
                bottomA = c->param(kBottomA);
    const int code = fixedInteger(*c, kOperation);
    const Blend op = code >= 0 && code < int(Blend::Count) ? Blend(code) : Blend::Normal;
    const bool clamped = fixedInteger(*c, kClampOutput) != 0, one = allUniform({&top, &topA, &bottom, &bottomA});
    float *rgb[3], *alpha[3];
    makeOutput(*c, args->outputs[0], 3, one, rgb);
    makeOutput(*c, args->outputs[4], 1, one, alpha);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      Rgb<W> color = loadRgb<W>(bottom, at);
      F a = loadFloat<W>(bottomA, at);
      blendOver(op, color, a, loadRgb<W>(top, at), loadFloat<W>(topA, at));
      (clamped ? clamp01(color) : color).store(rgb, i);
      (clamped ? clamp(a, F(0.f), F(1.f)) : a).store(alpha[0] + i);
    }
    shareComponents(*args, 0);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrBlend, .help = "Combines two colours like layers of an image editor.", .params = kParams)
