// PxrThreshold: 0 below, 1 above, with a transition of a given width about the threshold.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrThreshold/PxrThreshold.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kChannel, kThreshold, kTransitionWidth, kTransitionProfile };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to judge."),
    param::integer("channel", 3).range(0, 3).options("0 red, 1 green, 2 blue, 3 luminance").help("What is compared."),
    param::number("threshold", 0.5f).help("Value at the middle of the transition."),
    param::number("transitionWidth", 0.05f).help("Width of the transition."),
    param::integer("transitionProfile", 1).options("0 linear, 1 smooth").help("Shape of the transition."),
    param::output(Type::Float, "resultF"),
    KINORA_COLOR_OUTPUTS,
};

struct PxrThreshold {
  static constexpr uint32_t kComponents = 1;
  struct Setup {
    Value color, threshold, width;
    int channel;
    bool smooth;
    explicit Setup(const Context& c)
        : color(c.param(kInputRGB)), threshold(c.param(kThreshold)), width(c.param(kTransitionWidth)) {
      channel = fixedInteger(c, kChannel);
      smooth = fixedInteger(c, kTransitionProfile) != 0;
    }
    bool uniform() const { return allUniform({&color, &threshold, &width}); }
  };
  template <int W>
  static KN_INLINE Vec3<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Rgb<W> c = loadRgb<W>(s.color, at);
    const F x = s.channel == 0 ? c.x : s.channel == 1 ? c.y : s.channel == 2 ? c.z : luminance(c);
    const F w = max(abs(loadFloat<W>(s.width, at)), F(1e-6f)), d = x - loadFloat<W>(s.threshold, at);
    F t = clamp(fma(d, F(1.f) / w, F(0.5f)), F(0.f), F(1.f));
    if (s.smooth) t = t * t * fnma(F(2.f), t, F(3.f));
    return grey(t);
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrThreshold, .help = "Cuts a colour or one of its channels to 0 or 1.", .params = kParams)
