// PxrHSL: the colour in hue, saturation and lightness; hue is shifted, the others are scaled.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrHSL/PxrHSL.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kHue, kSaturation, kLuminance };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::number("hue", 0.f).range(-180, 180).help("Added to the hue, degrees."),
    param::number("saturation", 1.f).range(0, 2).help("Factor of the saturation."),
    param::number("luminance", 1.f).range(0, 2).help("Factor of the lightness."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrHSL {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, hue, saturation, luminance;
    explicit Setup(const Context& c)
        : color(c.param(kInputRGB)),
          hue(c.param(kHue)),
          saturation(c.param(kSaturation)),
          luminance(c.param(kLuminance)) {}
    bool uniform() const { return allUniform({&color, &hue, &saturation, &luminance}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Rgb<W> c = loadRgb<W>(s.color, at);
    // lightness is a model of 0..1: brighter colours are scaled into it and back
    const F scale = max(maxComponent(c), F(1.f));
    Vec3<W> v = rgbToHsl(c * (F(1.f) / scale));
    v.x = fma(loadFloat<W>(s.hue, at), F(1.f / 360.f), v.x);
    v.y = clamp(v.y * loadFloat<W>(s.saturation, at), F(0.f), F(1.f));
    v.z = v.z * loadFloat<W>(s.luminance, at);
    return hslToRgb(v) * scale;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrHSL, .help = "Shifts hue, scales saturation and lightness.", .params = kParams)
