// PxrSetRange: takes each component from one range to another, in a straight line that goes on beyond its ends unless
// it is clamped.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrSetRange/PxrSetRange.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInput, kInputMin, kInputMax, kOutputMin, kOutputMax, kClampOutput };
constexpr Param kParams[] = {
    param::color("input", 0.f).help("Colour to change."),
    param::color("inputMin", 0.f).help("Input that becomes outputMin."),
    param::color("inputMax", 1.f).help("Input that becomes outputMax."),
    param::color("outputMin", 0.f).help("Result of inputMin."),
    param::color("outputMax", 1.f).help("Result of inputMax."),
    param::flag("clampOutput", false).help("1: the result stays within its range."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrSetRange {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value in, inMin, inMax, outMin, outMax;
    bool clamped;
    explicit Setup(const Context& c)
        : in(c.param(kInput)),
          inMin(c.param(kInputMin)),
          inMax(c.param(kInputMax)),
          outMin(c.param(kOutputMin)),
          outMax(c.param(kOutputMax)),
          clamped(fixedInteger(c, kClampOutput) != 0) {}
    bool uniform() const { return allUniform({&in, &inMin, &inMax, &outMin, &outMax}); }
  };
  template <int W>
  static KN_INLINE Float<W> one(Float<W> x, Float<W> low, Float<W> high, Float<W> a, Float<W> b, bool clamped) {
    using F = Float<W>;
    const F span = high - low;
    const Mask<W> none = span == F(0.f);
    // a range without extent is a step
    F t = select(none, select(x < low, F(0.f), F(1.f)), (x - low) / select(none, F(1.f), span));
    if (clamped) t = clamp(t, F(0.f), F(1.f));
    return lerp(a, b, t);
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    const Rgb<W> x = loadRgb<W>(s.in, at), low = loadRgb<W>(s.inMin, at), high = loadRgb<W>(s.inMax, at);
    const Rgb<W> a = loadRgb<W>(s.outMin, at), b = loadRgb<W>(s.outMax, at);
    return {one(x.x, low.x, high.x, a.x, b.x, s.clamped), one(x.y, low.y, high.y, a.y, b.y, s.clamped),
            one(x.z, low.z, high.z, a.z, b.z, s.clamped)};
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrSetRange, .help = "Takes colours from one range to another.", .params = kParams)
