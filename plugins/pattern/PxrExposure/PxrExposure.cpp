// PxrExposure: inputRGB times 2^stops.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrExposure/PxrExposure.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kStops };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::number("stops", 0.f).range(-8, 8).help("Doublings of brightness."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrExposure {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, stops;
    explicit Setup(const Context& c) : color(c.param(kInputRGB)), stops(c.param(kStops)) {}
    bool uniform() const { return allUniform({&color, &stops}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    return loadRgb<W>(s.color, at) * exp2(loadFloat<W>(s.stops, at));
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrExposure, .help = "Brightens or darkens by stops.", .params = kParams)
