// PxrInvert: 1 - x of chosen channels, in a chosen colour model. Hue turns by half a turn.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrInvert/PxrInvert.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kColorModel, kInvertChannel0, kInvertChannel1, kInvertChannel2 };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::integer("colorModel", 0).range(0, 2).options("0 RGB, 1 HSL, 2 HSV").help("What the channels are."),
    param::flag("invertChannel0", true).help("1: inverts red or hue."),
    param::flag("invertChannel1", true).help("1: inverts green or saturation."),
    param::flag("invertChannel2", true).help("1: inverts blue, lightness or value."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrInvert {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color;
    int model;
    bool invert[3];
    explicit Setup(const Context& c) : color(c.param(kInputRGB)) {
      model = fixedInteger(c, kColorModel);
      for (uint32_t k = 0; k < 3; ++k) invert[k] = fixedInteger(c, kInvertChannel0 + k) != 0;
    }
    bool uniform() const { return allUniform({&color}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    Rgb<W> v = loadRgb<W>(s.color, at);
    // lightness is a model of 0..1: brighter colours are scaled into it and back
    const F scale = s.model == 1 ? max(maxComponent(v), F(1.f)) : F(1.f);
    if (s.model == 1) v = rgbToHsl(v * (F(1.f) / scale));
    if (s.model == 2) v = rgbToHsv(v);
    if (s.invert[0]) v.x = s.model == 0 ? F(1.f) - v.x : v.x + F(0.5f);
    if (s.invert[1]) v.y = F(1.f) - v.y;
    if (s.invert[2]) v.z = F(1.f) - v.z;
    return s.model == 1 ? hslToRgb(v) * scale : s.model == 2 ? hsvToRgb(v) : v;
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrInvert, .help = "Inverts the channels of a colour.", .params = kParams)
