// PxrRemap: input range to 0..1, bias and gain (Perlin and Hoffert, "Hypertexture", 1989: bias is a power curve
// through (0.5, bias), gain two of them back to back), then to the output range.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrRemap/PxrRemap.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputRGB, kInputMin, kInputMax, kClampInput, kBias, kGain, kOutputMin, kOutputMax, kClampOutput };
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::number("inputMin", 0.f).help("Input that becomes outputMin."),
    param::number("inputMax", 1.f).help("Input that becomes outputMax."),
    param::flag("clampInput", true).help("1: input outside its range counts as its ends."),
    param::number("bias", 0.5f).range(0.01f, 0.99f).help("Result of the middle of the range: 0.5 changes nothing."),
    param::number("gain", 0.5f).range(0.01f, 0.99f).help("Below 0.5 flattens, above steepens the middle."),
    param::number("outputMin", 0.f).help("Result of inputMin."),
    param::number("outputMax", 1.f).help("Result of inputMax."),
    param::flag("clampOutput", true).help("1: the result stays within its range."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrRemap {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, inMin, inMax, bias, gain, outMin, outMax;
    bool clampInput, clampOutput;
    explicit Setup(const Context& c)
        : color(c.param(kInputRGB)),
          inMin(c.param(kInputMin)),
          inMax(c.param(kInputMax)),
          bias(c.param(kBias)),
          gain(c.param(kGain)),
          outMin(c.param(kOutputMin)),
          outMax(c.param(kOutputMax)) {
      clampInput = fixedInteger(c, kClampInput) != 0;
      clampOutput = fixedInteger(c, kClampOutput) != 0;
    }
    bool uniform() const { return allUniform({&color, &inMin, &inMax, &bias, &gain, &outMin, &outMax}); }
  };
  template <int W>
  static KN_INLINE Float<W> biased(Float<W> x, Float<W> b) {
    using F = Float<W>;
    const F e = log2(clamp(b, F(1e-4f), F(0.9999f))) * F(-1.f);
    return select(b == F(0.5f), x, copySign(pow(abs(x), e), x));
  }
  template <int W>
  static KN_INLINE Float<W> one(const Setup& s, Float<W> x, At at) {
    using F = Float<W>;
    const F low = loadFloat<W>(s.inMin, at), span = loadFloat<W>(s.inMax, at) - low;
    x = select(span != F(0.f), (x - low) / select(span != F(0.f), span, F(1.f)), select(x >= low, F(1.f), F(0.f)));
    if (s.clampInput) x = clamp(x, F(0.f), F(1.f));
    x = biased(x, loadFloat<W>(s.bias, at));
    const F g = loadFloat<W>(s.gain, at), h = F(1.f) - g;
    const F steep = select(x < F(0.5f), biased(x + x, h) * F(0.5f), F(1.f) - biased(F(2.f) - x - x, h) * F(0.5f));
    x = select(g == F(0.5f), x, steep);
    const F a = loadFloat<W>(s.outMin, at), b = loadFloat<W>(s.outMax, at);
    x = lerp(a, b, x);
    return s.clampOutput ? clamp(x, min(a, b), max(a, b)) : x;
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    const Rgb<W> c = loadRgb<W>(s.color, at);
    return {one(s, c.x, at), one(s, c.y, at), one(s, c.z, at)};
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrRemap, .help = "Maps a range of values to another, with bias and gain.", .params = kParams)
