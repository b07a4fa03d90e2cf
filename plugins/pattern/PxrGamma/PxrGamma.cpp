// PxrGamma: sign-preserving power 1 / gamma of each component.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrGamma/PxrGamma.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kGamma };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::number("gamma", 1.f).range(0.2f, 4).help("The result is inputRGB^(1 / gamma)."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrGamma {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, gamma;
    explicit Setup(const Context& c) : color(c.param(kInputRGB)), gamma(c.param(kGamma)) {}
    bool uniform() const { return allUniform({&color, &gamma}); }
  };
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    const Rgb<W> x = loadRgb<W>(s.color, at);
    const Float<W> e = Float<W>(1.f) / max(loadFloat<W>(s.gamma, at), Float<W>(1e-3f));
    return {copySign(pow(abs(x.x), e), x.x), copySign(pow(abs(x.y), e), x.y), copySign(pow(abs(x.z), e), x.z)};
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrGamma, .help = "Raises a colour to the power 1 / gamma.", .params = kParams)
