// PxrClamp: each component clamped to min..max, or wrapped into it (modulus).
#define KINORA_KERNEL_FILE "plugins/pattern/PxrClamp/PxrClamp.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kMin, kMax, kModulus };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::color("min", 0.f).range(-1, 1).help("Smallest result."),
    param::color("max", 1.f).range(-1, 4).help("Largest result."),
    param::flag("modulus", false).help("1: values outside come in again at the other end."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrClamp {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, low, high;
    bool modulus;
    explicit Setup(const Context& c) : color(c.param(kInputRGB)), low(c.param(kMin)), high(c.param(kMax)) {
      modulus = fixedInteger(c, kModulus) != 0;
    }
    bool uniform() const { return allUniform({&color, &low, &high}); }
  };
  template <int W>
  static KN_INLINE Float<W> limit(Float<W> x, Float<W> low, Float<W> high, bool modulus) {
    using F = Float<W>;
    if (!modulus) return clamp(x, low, high);
    const F span = high - low;
    const F around = select(span > F(0.f), fma(fraction((x - low) / max(span, F(1e-20f))), span, low), low);
    return select((x >= low) & (x <= high), x, around);
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    const Rgb<W> x = loadRgb<W>(s.color, at), a = loadRgb<W>(s.low, at), b = loadRgb<W>(s.high, at);
    return {limit(x.x, a.x, b.x, s.modulus), limit(x.y, a.y, b.y, s.modulus), limit(x.z, a.z, b.z, s.modulus)};
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrClamp, .help = "Limits a colour.", .params = kParams)
