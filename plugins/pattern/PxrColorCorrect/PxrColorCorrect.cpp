// PxrColorCorrect: input range, gamma, contrast about a pivot, gain, hue/saturation/value, exposure, output range and
// clamp, in this order; then mixed with the input by the mask.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrColorCorrect/PxrColorCorrect.cpp"
#include <kinora/pattern_author.h>
#include <kinora/math/color.h>

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kInputRGB,
  kInputMask,
  kInvertMask,
  kMixMask,
  kInputMin,
  kInputMax,
  kGamma,
  kContrast,
  kContrastPivot,
  kRgbGain,
  kHsv,
  kExposure,
  kOutputMin,
  kOutputMax,
  kClampOutput,
  kClampMin,
  kClampMax
};
constexpr Param kParams[] = {
    param::color("inputRGB", 0.f).help("Colour to change."),
    param::number("inputMask", 1.f).help("Where the correction counts: 0 leaves the input."),
    param::flag("invertMask", false).help("1: one minus inputMask counts."),
    param::number("mixMask", 1.f).help("Factor of the mask."),
    param::color("inputMin", 0.f).help("Input that becomes outputMin."),
    param::color("inputMax", 1.f).help("Input that becomes outputMax."),
    param::color("gamma", 1.f).range(0.2f, 4).help("Power 1 / gamma."),
    param::color("contrast", 0.f).range(-1, 1).help("0 changes nothing, 1 doubles the distance from contrastPivot."),
    param::color("contrastPivot", 0.5f).help("Value that contrast leaves alone."),
    param::color("rgbGain", 1.f).range(0, 4).help("Factor."),
    param::color("hsv", 0, 1, 1).help("Hue shift in turns, factor of saturation, factor of value."),
    param::number("exposure", 0.f).range(-8, 8).help("Doublings of brightness."),
    param::color("outputMin", 0.f).help("Result of inputMin."),
    param::color("outputMax", 1.f).help("Result of inputMax."),
    param::flag("clampOutput", false).help("1: the result stays between clampMin and clampMax."),
    param::color("clampMin", 0.f).help("Smallest result."),
    param::color("clampMax", 1.f).help("Largest result."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrColorCorrect {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value color, mask, mix, inMin, inMax, gamma, contrast, pivot, gain, hsv, exposure, outMin, outMax, clampMin,
        clampMax;
    bool invertMask, clampOutput;
    explicit Setup(const Context& c)
        : color(c.param(kInputRGB)),
          mask(c.param(kInputMask)),
          mix(c.param(kMixMask)),
          inMin(c.param(kInputMin)),
          inMax(c.param(kInputMax)),
          gamma(c.param(kGamma)),
          contrast(c.param(kContrast)),
          pivot(c.param(kContrastPivot)),
          gain(c.param(kRgbGain)),
          hsv(c.param(kHsv)),
          exposure(c.param(kExposure)),
          outMin(c.param(kOutputMin)),
          outMax(c.param(kOutputMax)),
          clampMin(c.param(kClampMin)),
          clampMax(c.param(kClampMax)) {
      invertMask = fixedInteger(c, kInvertMask) != 0;
      clampOutput = fixedInteger(c, kClampOutput) != 0;
    }
    bool uniform() const {
      return allUniform({&color, &mask, &mix, &inMin, &inMax, &gamma, &contrast, &pivot, &gain, &hsv, &exposure,
                         &outMin, &outMax, &clampMin, &clampMax});
    }
  };
  template <int W>
  static KN_INLINE Float<W> one(Float<W> x, Float<W> low, Float<W> high, Float<W> gamma, Float<W> contrast,
                                Float<W> pivot) {
    using F = Float<W>;
    const F span = high - low;
    x = (x - low) / select(abs(span) > F(1e-12f), span, F(1e-12f));
    x = select(gamma == F(1.f), x, copySign(pow(abs(x), F(1.f) / max(gamma, F(1e-3f))), x));
    return fma(x - pivot, F(1.f) + contrast, pivot);
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    using F = Float<W>;
    const Rgb<W> in = loadRgb<W>(s.color, at), low = loadRgb<W>(s.inMin, at), high = loadRgb<W>(s.inMax, at);
    const Rgb<W> g = loadRgb<W>(s.gamma, at), k = loadRgb<W>(s.contrast, at), p = loadRgb<W>(s.pivot, at);
    Rgb<W> c(one(in.x, low.x, high.x, g.x, k.x, p.x), one(in.y, low.y, high.y, g.y, k.y, p.y),
             one(in.z, low.z, high.z, g.z, k.z, p.z));
    c = c * loadRgb<W>(s.gain, at);
    const Vec3<W> change = loadVec<W>(s.hsv, at);
    Vec3<W> v = rgbToHsv(c);
    v = Vec3<W>(v.x + change.x, v.y * change.y, v.z * change.z);
    // unchanged colours skip the trip through hue, which colours below zero would not survive
    const Mask<W> same = (change.x == F(0.f)) & (change.y == F(1.f)) & (change.z == F(1.f));
    c = select(same, c, hsvToRgb(v)) * exp2(loadFloat<W>(s.exposure, at));
    const Rgb<W> a = loadRgb<W>(s.outMin, at), b = loadRgb<W>(s.outMax, at);
    c = a + c * (b - a);
    if (s.clampOutput) {
      const Rgb<W> least = loadRgb<W>(s.clampMin, at), most = loadRgb<W>(s.clampMax, at);
      c = Rgb<W>(clamp(c.x, least.x, most.x), clamp(c.y, least.y, most.y), clamp(c.z, least.z, most.z));
    }
    F m = loadFloat<W>(s.mask, at);
    if (s.invertMask) m = F(1.f) - m;
    return lerp(in, c, m * loadFloat<W>(s.mix, at));
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrColorCorrect, .help = "Grades a colour: range, gamma, contrast, gain, hue, exposure.",
               .params = kParams)
